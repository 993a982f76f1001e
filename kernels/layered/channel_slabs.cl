// Sub-slabs of a splatted layer of the fields of a scene. Several are composited with the sum of extinctions (emission.cl). One field, and
// fields of which each gathers values of its own, are accumulated by accumulate_layer().
//
// Included where samples are known (struct SampleSource).

#include "shared/channel.cl"
#include "shared/emission.cl"

#define SUMS_EXTINCTIONS (CHANNELS > 1 && !GATHERS_VALUES)

// Number of accumulators of this many fields, and which one is that of a field.
#define ACCUMULATED(fields) (SUMS_EXTINCTIONS ? 1 : (fields))
#define ACCUMULATOR(field) (SUMS_EXTINCTIONS ? 0 : (field))

#if SUMS_EXTINCTIONS

// A field where rays cross a layer: splat sums of the previous layer along the rays, the layer itself and the next one.
typedef struct {
    const SampleParams *params;
    __global const float4 *table;
    realv before, own, after;
    struct SampleSource source;
    // Of the layer, from the first visible sample on.
    bool lit;
    Lighting lighting;
} LayerOfField;

// Adds a field to those whose samples in a layer can be visible.
ALWAYS_INLINE void add_field(const SampleParams *params, __global const float4 *table, realv before, realv own, realv after,
                             const struct SampleSource *source, LayerOfField *fields, int *count) {
    if (!layer_may_contribute(params, before, own, after))
        return;
    LayerOfField *f = &fields[*count];
    f->params = params, f->table = table;
    f->before = before, f->own = own, f->after = after;
    f->source = *source, f->lit = false;
    *count += 1;
}

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

// Accumulates all sub-slabs of a layer. `first`, `slab_count`: of the layer, see layer_slabs().
ALWAYS_INLINE void accumulate_fields(LayerOfField *fields, int count, __global const float4 *slabs, int first, int slab_count,
                                     const LayerSpan *layer_span, Accumulator *gathered, intv *active) {
    if (!count)
        return;
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
        accumulate_emission(sum, depth, opacity, gathered);
    }
}

#endif

// Stores rays n of a tile: of one field as `p` requests, of several the colours.
#if CHANNELS == 1
#define STORE_CHANNELS(p, channels, fields, gathered, n, interval, columns, out, total) \
    STORE_RAYS(p, (channels)[0].field.sample, (channels)[0].table, &(gathered)[0][n], interval, columns, 1, out, total)
#elif GATHERS_VALUES
#define STORE_CHANNELS(p, channels, fields, gathered, n, interval, columns, out, total)                                        \
    {                                                                                                                          \
        realv color[4] = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(0.0f)};                                         \
        for (int c = 0; c < (fields); c++)                                                                                     \
            add_resolved(&(channels)[c].field.sample, (channels)[c].table, &(gathered)[c][n], interval, color);                \
        total += count_visible(color, columns);                                                                                \
        store_colors(color, columns, 1, out);                                                                                  \
    }
#else
#define STORE_CHANNELS(p, channels, fields, gathered, n, interval, columns, out, total)                                  \
    {                                                                                                                    \
        realv color[4];                                                                                                  \
        resolve(&(channels)[0].field.sample, (channels)[0].table, &(gathered)[0][n], interval, color);                   \
        store_colors(color, columns, 1, out);                                                                            \
    }
#endif
