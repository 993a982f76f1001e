// Point samples: classify, shade, accumulate. Used by splatted layers, image-aligned sheets and ray casting. Segments between two samples
// are in preintegration.cl and slicing.cl; axis-aligned sheets classify in sorted_splats.cl.

#include "shared/accumulator.cl"
#include "shared/tint.cl"

// Each kernel defines the position and the gradient of its samples. All samples of a layer share both.
struct SampleSource;
static inline Point sample_point(const struct SampleSource *source);
static inline Gradient sample_gradient(const struct SampleSource *source);
static inline LightVolume sample_light(const struct SampleSource *source);
#ifdef TINTED
static inline const Tint *sample_tint(const struct SampleSource *source);
#endif

// Share of a sample that counts, in sub-slab thicknesses. PER_RAY_STEP: one share per ray.
#ifdef PER_RAY_STEP
typedef realv Share;
#else
typedef float Share;
#endif

#if !GATHERS_VALUES
// Opacity of a sample. PER_RAY_STEP: the table holds tau (or alpha), and dt is the length of a sub-slab along each ray. Otherwise dt is
// constant in a frame and included in the table.
static inline realv sample_opacity(const SampleParams *p, realv w, Share share, realv dt) {
#ifdef PER_RAY_STEP
    return p->classification.linear ? MIN(w * dt, (realv)(1.0f)) * share : absorbed(w * (dt * share));
#else
    if (share == 1.0f)
        return w;
    // Half sub-slabs of the outer layers; no other share occurs.
    return p->classification.linear ? w * share : 1.0f - sqrt(1.0f - w);
#endif
}
#endif

// Smallest share, at the end of a clip interval, that a maximum or minimum takes into account: less is rounding.
#define MIN_SHARE 1e-3f

// Accumulates one sample of VW rays. The lighting of a layer is computed for its first visible sample. `length`: of a whole sample, in
// ray parameters.
ALWAYS_INLINE void accumulate_sample(const SampleParams *p, __global const float4 *table, realv value, Share share, realv dt,
                                     realv length, const struct SampleSource *source, bool *lit, Lighting *lighting, Accumulator *a,
                                     intv *active) {
#if BLEND == MAXIMUM || BLEND == MINIMUM
    accumulate_values(value, value, share > MIN_SHARE ? length * share : 0.0f, a, active);
#elif GATHERS_VALUES
    accumulate_values(value, value, length * share, a, active);
#else
    const intv index = table_index(p, value);
    if (!ANY(index >= p->classification.first_visible && index <= p->classification.last_visible))
        return;
    realv r, g, b, w;
    table_entries(table, index, &r, &g, &b, &w);
    const realv opacity = sample_opacity(p, w, share, dt);
    *active += COUNT_IF(opacity > 0.0f);
#ifdef TINTED
    mix_color(sample_tint(source), sample_point(source), &r, &g, &b);
#endif
    if (p->light.shading && !*lit) {
        *lighting = shade(p, sample_light(source), sample_point(source), value, sample_gradient(source));
        *lit = true;
    }
    accumulate_lit(p, r, g, b, opacity, lighting, a);
#endif
}

// Half a layer on each side of a layer's plane, along the ray.
typedef struct {
    realv dt;           // length of a sub-slab, in unit distances
    Interval interval;  // clip interval, in layers from this one along the ray
} LayerSpan;

// Whether any sample of a layer can be visible: all of their values lie between the three splat sums.
static inline bool layer_may_contribute(const SampleParams *p, realv before, realv own, realv after) {
#if GATHERS_VALUES
    return true;
#else
    const intv largest = table_index(p, MAX(MAX(before, after), own));
    const intv smallest = table_index(p, MIN(MIN(before, after), own));
    return ANY(largest >= p->classification.first_visible && smallest <= p->classification.last_visible);
#endif
}

// Accumulates all samples of one layer, from the splat sums of the previous layer along the ray, the layer itself and the next one. Each
// slab is (weight before, own, after, share), front to back; slabs of inner, front and back layers are stored one after another.
ALWAYS_INLINE void accumulate_slabs(const SampleParams *p, __global const float4 *slabs, int first, int count,
                                    __global const float4 *table, realv before, realv own, realv after, const LayerSpan *layer_span,
                                    const struct SampleSource *source, Accumulator *a, intv *active) {
    bool lit = false;
    Lighting lighting;
#ifdef CLIPPED
    // The slabs of the front layer begin in its middle.
    float start = first == p->segments.inner_slabs ? 0.0f : -0.5f;
#endif
    for (int i = first; i < first + count; i++) {
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
        const realv value = slab.x * before + slab.y * own + slab.z * after;
        accumulate_sample(p, table, value, share, layer_span->dt, (realv)(1.0f / p->segments.inner_slabs), source, &lit, &lighting, a,
                          active);
    }
}

// The same, skipping layers that are not visible.
ALWAYS_INLINE void accumulate_layer(const SampleParams *p, __global const float4 *slabs, int first, int count,
                                    __global const float4 *table, realv before, realv own, realv after, const LayerSpan *layer_span,
                                    const struct SampleSource *source, Accumulator *a, intv *active) {
    if (layer_may_contribute(p, before, own, after))
        accumulate_slabs(p, slabs, first, count, table, before, own, after, layer_span, source, a, active);
}

// First slab and number of slabs of the n-th layer (0 ... layers-1) along the ray.
static inline void layer_slabs(const SampleParams *p, int n, int layers, int *first, int *count) {
    const bool is_front = n == 0, is_back = n == layers - 1;
    // Read unconditionally: conditional reads make AMD's compiler copy all parameters to memory.
    const int inner = p->segments.inner_slabs, front = p->segments.front_slabs, back = p->segments.back_slabs;
    *first = is_front ? inner : is_back ? inner + front : 0;
    *count = is_front ? front : is_back ? back : inner;
}
