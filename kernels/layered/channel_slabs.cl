// Sub-slabs of a splatted layer of several fields: as accumulate_slabs() for one (sample.cl), with the sum of extinctions (emission.cl), or
// with values that each field gathers on its own.
//
// Included where samples are known (struct SampleSource).

#include "shared/channel.cl"
#include "shared/emission.cl"

// A field where rays cross a layer: splat sums of the previous layer along the rays, the layer itself and the next one.
typedef struct {
    const SampleParams *params;
    __global const float4 *table;
    realv before, own, after;
    struct SampleSource source;
#if GATHERS_VALUES
    Accumulator *gathered;
#else
    // Of the layer, from the first visible sample on.
    bool lit;
    Lighting lighting;
#endif
} LayerOfField;

#if GATHERS_VALUES

// Accumulates all sub-slabs of a layer, of each field in values of its own.
ALWAYS_INLINE void accumulate_channel_slabs(LayerOfField *fields, int count, __global const float4 *slabs, int first, int slab_count,
                                            const LayerSpan *layer_span, intv *active) {
    for (int c = 0; c < count; c++) {
        const LayerOfField *f = &fields[c];
        accumulate_slabs(f->params, slabs, first, slab_count, f->table, f->before, f->own, f->after, layer_span, &f->source, f->gathered,
                         active);
    }
}

#else

// Adds what a field emits in a whole sub-slab of this thickness along the rays.
ALWAYS_INLINE void add_slab(LayerOfField *f, float4 slab, realv dt, realv *sum, realv *depth) {
    const SampleParams *p = f->params;
    const realv value = slab.x * f->before + slab.y * f->own + slab.z * f->after;
    const intv index = table_index(p, value);
    if (!ANY(index >= p->classification.first_visible && index <= p->classification.last_visible))
        return;
    realv r, g, b, extinction;
    table_entries(f->table, index, &r, &g, &b, &extinction);
    Emission e;
    e.depth = extinction * (dt * p->classification.table_unit);
    if (p->light.shading) {
        if (!f->lit)
            f->lighting = shade(p, sample_light(&f->source), sample_point(&f->source), value, sample_gradient(&f->source));
        f->lit = true;
        e.lighting = f->lighting;
#ifdef THINNED
        e.depth *= e.lighting.extinction_scale;
#endif
    }
    add_emission(p, r, g, b, &e, sum);
    *depth += e.depth;
}

// Accumulates all sub-slabs of a layer, of at least one field. `first`, `slab_count`: of the layer, see layer_slabs().
ALWAYS_INLINE void accumulate_channel_slabs(LayerOfField *fields, int count, __global const float4 *slabs, int first, int slab_count,
                                            const LayerSpan *layer_span, Accumulator *a, intv *active) {
    const SampleParams *p = fields[0].params;
#ifdef CLIPPED
    // The slabs of the front layer begin in its middle.
    float start = first == p->segments.inner_slabs ? 0.0f : -0.5f;
#endif
    for (int i = first; i < first + slab_count; i++) {
        const float4 slab = slabs[i];
        Share share = slab.w;
#ifdef CLIPPED
        const float end = start + slab.w / p->segments.inner_slabs;
        const realv inside = MIN(layer_span->interval.to, (realv)(end)) - MAX(layer_span->interval.from, (realv)(start));
        share *= MAX(inside, (realv)(0.0f)) / (end - start);
        start = end;
        if (!ANY(share > 0.0f))
            continue;
#endif
        realv sum[3] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f)}, depth = 0.0f;
        for (int c = 0; c < count; c++)
            add_slab(&fields[c], slab, layer_span->dt, sum, &depth);
        if (!ANY(depth > 0.0f))
            continue;
        const realv opacity = p->classification.linear ? MIN(depth, (realv)(1.0f)) * share : absorbed(depth * share);
        *active += COUNT_IF(opacity > 0.0f);
        accumulate_emission(sum, depth, opacity, a);
    }
}

#endif
