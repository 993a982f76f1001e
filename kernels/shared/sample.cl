// One sample by itself: classify, shade, accumulate.
//
// Here splatted layers, image-aligned sheets and cast rays end; segments between two samples in preintegration.cl and slicing.cl, and
// axis-aligned sheets are classified in sorted_splats.cl.

#include "shared/accumulator.cl"

// Each kernel defines where its samples lie and how their gradients are found. The samples of a layer share both.
struct SampleSource;
static inline Point sample_point(const struct SampleSource *source);
static inline Gradient sample_gradient(const struct SampleSource *source);

// What of a sample counts, in sub-slab thicknesses. PER_RAY_STEP: of each ray.
#ifdef PER_RAY_STEP
typedef realv Share;
#else
typedef float Share;
#endif

#if !GATHERS_VALUES
// Opacity of a sample. PER_RAY_STEP: the table holds tau (or alpha), and dt, the length of a sub-slab along each ray, comes with the
// sample. Otherwise dt is one number per frame, and in the table.
static inline realv opacity_of(const SampleParams *p, realv w, Share share, realv dt) {
#ifdef PER_RAY_STEP
    return p->classification.linear ? MIN(w * dt, (realv)(1.0f)) * share : absorbed(w * (dt * share));
#else
    if (share == 1.0f)
        return w;
    // The outer layers' half sub-slabs; no other share occurs.
    return p->classification.linear ? w * share : 1.0f - sqrt(1.0f - w);
#endif
}
#endif

// Of a sample that lies across the end of an interval, what a maximum or minimum takes notice of: less is rounding.
#define LEAST_SHARE 1e-3f

// Takes one sample (of VW rays). The lighting of the layer is found when its first visible sample needs it. `length` of a whole sample
// in ray parameters.
ALWAYS_INLINE void take_sample(const SampleParams *p, __global const float4 *table, realv value, Share share, realv dt, realv length,
                               const struct SampleSource *source, bool *lit, Lighting *lighting, Accumulator *a, intv *active) {
#if BLEND == MAXIMUM || BLEND == MINIMUM
    accumulate_values(value, value, share > LEAST_SHARE ? length * share : 0.0f, a, active);
#elif GATHERS_VALUES
    accumulate_values(value, value, length * share, a, active);
#else
    const intv index = table_index(p, value);
    if (!ANY(index >= p->classification.first_visible && index <= p->classification.last_visible))
        return;
    realv r, g, b, w;
    table_entries(table, index, &r, &g, &b, &w);
    const realv opacity = opacity_of(p, w, share, dt);
    *active += COUNT_IF(opacity > 0.0f);
    if (p->light.shading && !*lit) {
        *lighting = shade(p, sample_point(source), value, sample_gradient(source));
        *lit = true;
    }
    accumulate_lit(p, r, g, b, opacity, lighting, a);
#endif
}

// A layer on its way: half a layer before and behind its plane.
typedef struct {
    realv dt;           // length of a sub-slab, in unit distances
    Interval interval;  // that counts, in layers from this one along the ray
} LayerWay;

// Whether any sample of one layer can show anything: all lie between the three splat sums.
static inline bool layer_can_show(const SampleParams *p, realv before, realv own, realv after) {
#if GATHERS_VALUES
    return true;
#else
    const intv largest = table_index(p, MAX(MAX(before, after), own));
    const intv smallest = table_index(p, MIN(MIN(before, after), own));
    return ANY(largest >= p->classification.first_visible && smallest <= p->classification.last_visible);
#endif
}

// All samples of one layer, from the splat sums of the layer met before, the layer itself and the one met next. Slabs
// are (weight before, own, after, share), front to back: inner, front and back ones after each other.
ALWAYS_INLINE void take_slabs(const SampleParams *p, __global const float4 *slabs, int first, int count,
                              __global const float4 *table, realv before, realv own, realv after, const LayerWay *way,
                              const struct SampleSource *source, Accumulator *a, intv *active) {
    bool lit = false;
    Lighting lighting;
#ifdef CLIPPED
    // The front layer's slabs begin in its middle.
    float start = first == p->segments.inner_slabs ? 0.0f : -0.5f;
#endif
    for (int i = first; i < first + count; i++) {
        const float4 slab = slabs[i];
        Share share = slab.w;
#ifdef CLIPPED
        const float end = start + slab.w / p->segments.inner_slabs;
        const realv inside = MIN(way->interval.to, (realv)(end)) - MAX(way->interval.from, (realv)(start));
        share *= MAX(inside, (realv)(0.0f)) / (end - start);
        start = end;
        if (!ANY(share > 0.0f))
            continue;
#endif
        const realv value = slab.x * before + slab.y * own + slab.z * after;
        take_sample(p, table, value, share, way->dt, (realv)(1.0f / p->segments.inner_slabs), source, &lit, &lighting, a, active);
    }
}

// The same where none of them may show anything.
ALWAYS_INLINE void take_layer(const SampleParams *p, __global const float4 *slabs, int first, int count, __global const float4 *table,
                              realv before, realv own, realv after, const LayerWay *way, const struct SampleSource *source, Accumulator *a,
                              intv *active) {
    if (layer_can_show(p, before, own, after))
        take_slabs(p, slabs, first, count, table, before, own, after, way, source, a, active);
}

// First slab and number of slabs of the n-th layer (0 ... layers-1) along the ray.
static inline void layer_slabs(const SampleParams *p, int n, int layers, int *first, int *count) {
    const bool is_front = n == 0, is_back = n == layers - 1;
    // Read first: read where they are chosen, all parameters would be in memory (AMD's compiler).
    const int inner = p->segments.inner_slabs, front = p->segments.front_slabs, back = p->segments.back_slabs;
    *first = is_front ? inner : is_back ? inner + front : 0;
    *count = is_front ? front : is_back ? back : inner;
}
