// Ray accumulators, one for each blend mode that a program can be built for (BLEND). A blend mode defines the initial state, the
// accumulation, which rays are still open, and the final colour.

#include "shared/blend_modes.cl"
#include "shared/clipping.cl"
#include "shared/first_hit.cl"
#include "shared/shading.cl"
#include "shared/table_entries.cl"

// Arguments of a kernel: RGBA of the samples of a lattice, or of pixels, and the number of those with opacity in each tile.
// CUT_RAYS: also the parts of rays to draw, of each pixel in ray parameters, or of each sample in layers from that of the centre along it.
#ifdef CUT_RAYS
#define OUTPUT __global float4 *target, __global uint *active_samples, __global const float2 *cuts
#else
#define OUTPUT __global float4 *target, __global uint *active_samples
#endif

#if GATHERS_VALUES

// The largest or smallest value so far, or the integral of the value over the ray parameter.
typedef struct {
    realv value;
} Accumulator;

static inline Accumulator empty_accumulator(const SampleParams *p) {
#if BLEND == MAXIMUM
    const Accumulator a = {(realv)(p->field.least)};
#elif BLEND == MINIMUM
    const Accumulator a = {(realv)(p->field.largest)};
#else
    const Accumulator a = {(realv)(0.0f)};
#endif
    return a;
}

// Rays that further samples can still change.
static inline intv open_rays(const SampleParams *p, const Accumulator *a) {
#if BLEND == MAXIMUM
    return a->value < p->field.largest;
#elif BLEND == MINIMUM
    return a->value > p->field.least;
#else
    return LANES >= 0;
#endif
}

// Accumulates a segment between two values. `length`, in ray parameters, is 0 where the segment does not contribute. Neutral values are
// selected there: if `a` were, PoCL 6 would abort (docs/dev/portability.md).
static inline void accumulate_values(realv from, realv to, realv length, Accumulator *a, intv *active) {
    const intv contributes = length > 0.0f;
    *active += COUNT_IF(contributes);
#if BLEND == MAXIMUM
    a->value = MAX(a->value, contributes ? MAX(from, to) : (realv)(-INFINITY));
#elif BLEND == MINIMUM
    a->value = MIN(a->value, contributes ? MIN(from, to) : (realv)(INFINITY));
#else
    a->value += contributes ? 0.5f * (from + to) * length : (realv)(0.0f);
#endif
}

// Colour of a ray with a clip interval: r, g, b, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                           realv *color) {
    const intv hit = interval->from < interval->to;
    realv value = a->value;
#if BLEND == AVERAGE
    value = value / (hit ? interval->to - interval->from : (realv)(1.0f));
#endif
    // Kernels with negative weights overshoot: the result is clamped to the range of the voxels.
    value = CLAMP(value, (realv)(p->field.least), (realv)(p->field.largest));
    realv extinction;
    table_entries(table, table_index(p, value), &color[0], &color[1], &color[2], &extinction);
    color[3] = CONVERT_REALV(COUNT_IF(hit));
    for (int i = 0; i < 3; i++)
        color[i] = MIN(color[i] * (color[3] * p->classification.brightness), (realv)(1.0f));
}

#else

#ifdef DEPTHS

// Depths in ray parameters: of the first hit, and the mean weighted by opacity. `t` is the transmittance left. `from` and `span` are the
// position and the length of the current segment.
typedef struct {
    realv first, weighted, t, from, span;
} Accumulator;

static inline Accumulator empty_accumulator(const SampleParams *p) {
    const Accumulator a = {(realv)(INFINITY), (realv)(0.0f), (realv)(1.0f), (realv)(0.0f), (realv)(0.0f)};
    return a;
}

static inline void set_depth_range(realv from, realv to, Accumulator *a) { a->from = from, a->span = to - from; }

// Accumulates the depth of the current segment, weighted by its opacity.
ALWAYS_INLINE void accumulate(realv r, realv g, realv b, realv opacity, Accumulator *a) {
    const realv weight = a->t * opacity;
    const intv is_first_hit = a->t > FIRST_HIT_TRANSMITTANCE && a->t - weight <= FIRST_HIT_TRANSMITTANCE;
    a->first = is_first_hit ? a->from + a->span * ((a->t - FIRST_HIT_TRANSMITTANCE) / weight) : a->first;
    a->weighted += weight * (a->from + 0.5f * a->span);
    a->t -= weight;
}

// Depths of a ray: first, weighted, 0, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                           realv *color) {
    color[0] = a->first, color[1] = a->weighted, color[2] = (realv)(0.0f), color[3] = 1.0f - a->t;
}

#else

// Premultiplied colour, and the transmittance left.
typedef struct {
    realv r, g, b, t;
} Accumulator;

static inline Accumulator empty_accumulator(const SampleParams *p) {
    const Accumulator a = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(1.0f)};
    return a;
}

// Composites a colour behind the accumulated ones.
ALWAYS_INLINE void accumulate(realv r, realv g, realv b, realv opacity, Accumulator *a) {
    const realv weight = a->t * opacity;
    a->r += weight * r;
    a->g += weight * g;
    a->b += weight * b;
    a->t -= weight;
}

// Colour of a ray: r, g, b, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                           realv *color) {
    color[0] = a->r, color[1] = a->g, color[2] = a->b, color[3] = 1.0f - a->t;
}

#endif

// Rays whose transmittance is above the threshold of early ray termination.
static inline intv open_rays(const SampleParams *p, const Accumulator *a) { return a->t > p->segments.opaque; }

// Lights a colour, applies gradient opacity, and accumulates it.
ALWAYS_INLINE void accumulate_lit(const SampleParams *p, realv r, realv g, realv b, realv opacity, const Lighting *lighting,
                                  Accumulator *a) {
    if (p->light.shading) {
        r = lit_red(p, r, lighting);
        g = lit_green(p, g, lighting);
        b = lit_blue(p, b, lighting);
#ifdef THINNED
        opacity = scale_opacity(p, opacity, lighting->extinction_scale);
#endif
    }
    accumulate(r, g, b, opacity, a);
}

#endif

// Whether further samples can change any of VW rays, or any of the first `count`.
static inline bool any_open(const SampleParams *p, const Accumulator *a) { return ANY(open_rays(p, a)); }
static inline bool any_open_lanes(const SampleParams *p, const Accumulator *a, int count) { return ANY(open_rays(p, a) && LANES < count); }

// Stores the first `count` of VW colours, `stride` apart.
static inline void store_colors(const realv *color, int count, int stride, __global float4 *out) {
#if VW == 1
    // Not indexed by a variable: that would put the colour in memory.
    if (count > 0)
        *out = (float4)(color[0], color[1], color[2], color[3]);
#else
    if (count == VW && stride == 1) {
        // Vectors interleaved by sample: each holds every fourth one.
        realv samples[4];
        transpose_fours(color[0], color[1], color[2], color[3], &samples[0], &samples[1], &samples[2], &samples[3]);
#ifdef PERMUTE
        realv ordered[4];
        transpose_quarters(samples, ordered);
        for (int i = 0; i < 4; i++)
            vstore16(ordered[i], i, (__global float *)out);
#else
        const float4 *fours = (const float4 *)samples;
        for (int i = 0; i < VW; i++)
            out[i] = fours[i % 4 * (VW / 4) + i / 4];
#endif
        return;
    }
    const float *lanes = (const float *)color;
    for (int i = 0; i < count; i++)
        out[(size_t)i * stride] = (float4)(lanes[i], lanes[VW + i], lanes[2 * VW + i], lanes[3 * VW + i]);
#endif
}

// Stores the colours of some lanes, each at its own place.
static inline void store_colors_at(const realv *color, intv at, intv present, __global float4 *out) {
#if VW == 1
    if (present)
        out[at] = (float4)(color[0], color[1], color[2], color[3]);
#else
    realv samples[4];
    transpose_fours(color[0], color[1], color[2], color[3], &samples[0], &samples[1], &samples[2], &samples[3]);
    const float4 *fours = (const float4 *)samples;
    const int *place = (const int *)&at, *is_present = (const int *)&present;
    for (int i = 0; i < VW; i++)
        if (is_present[i])
            out[place[i]] = fours[i % 4 * (VW / 4) + i / 4];
#endif
}

// Sum of the first `count` lanes.
static inline uint sum_lanes(intv active, int count) {
    uint total = 0;
    for (int i = 0; i < count; i++)
        total += ((const int *)&active)[i];
    return total;
}

// Raw state of `count` of VW rays, loaded from or stored to elements `stride` apart.
#define RAW_FLOATS ((int)(sizeof(Accumulator) / sizeof(realv)))
static inline void load_raw_ray(__global const float4 *state, int lane, Accumulator *a) {
    const float4 raw = *state;
    for (int n = 0; n < RAW_FLOATS; n++)
        ((float *)a)[n * VW + lane] = ((const float *)&raw)[n];
}
static inline void store_raw_ray(const Accumulator *a, int lane, __global float4 *out) {
    float4 raw = 0.0f;
    for (int n = 0; n < RAW_FLOATS; n++)
        ((float *)&raw)[n] = ((const float *)a)[n * VW + lane];
    *out = raw;
}
static inline Accumulator load_raw(const SampleParams *p, __global const float4 *state, int count, int stride) {
    Accumulator a = empty_accumulator(p);
    for (int i = 0; i < count; i++)
        load_raw_ray(state + (size_t)i * stride, i, &a);
    return a;
}
static inline void store_raw(const Accumulator *a, int count, int stride, __global float4 *out) {
    for (int i = 0; i < count; i++)
        store_raw_ray(a, i, out + (size_t)i * stride);
}

// The same for some lanes, each at its own place.
static inline Accumulator load_raw_at(const SampleParams *p, __global const float4 *state, intv at, intv present) {
    Accumulator a = empty_accumulator(p);
    for (int i = 0; i < VW; i++)
        if (((const int *)&present)[i])
            load_raw_ray(state + ((const int *)&at)[i], i, &a);
    return a;
}
static inline void store_raw_at(const Accumulator *a, intv at, intv present, __global float4 *out) {
    for (int i = 0; i < VW; i++)
        if (((const int *)&present)[i])
            store_raw_ray(a, i, out + ((const int *)&at)[i]);
}

// Number of colours, among some lanes, that are not entirely zero.
static inline uint count_visible_lanes(const realv *color, intv present) {
    return sum_lanes(COUNT_IF((color[0] != 0.0f || color[1] != 0.0f || color[2] != 0.0f || color[3] != 0.0f) && present), VW);
}
static inline uint count_visible(const realv *color, int count) { return count_visible_lanes(color, LANES < count); }

// Stores the rays of a lattice as `p` requests: as raw state, or resolved to `color`. Counts non-zero colours where the samples taken here
// are not enough to tell: earlier parts contributed, or the initial value is visible.
#define STORE_RAYS_BY(p, sample, table, gathered, interval, total, STORED_RAW, STORED_COLORS, VISIBLE) \
    if ((p).raw) {                                                                                     \
        STORED_RAW;                                                                                    \
    } else {                                                                                           \
        realv color[4];                                                                                \
        resolve(&(sample), table, gathered, interval, color);                                          \
        STORED_COLORS;                                                                                 \
        if ((p).continues || GATHERS_VALUES)                                                           \
            total += VISIBLE;                                                                          \
    }
#define STORE_RAYS(p, sample, table, gathered, interval, count, stride, out, total)                           \
    STORE_RAYS_BY(p, sample, table, gathered, interval, total, store_raw(gathered, count, stride, out),       \
                  store_colors(color, count, stride, out), count_visible(color, count))
// For some lanes, each at its own place.
#define STORE_RAYS_AT(p, sample, table, gathered, interval, at, present, out, total)                          \
    STORE_RAYS_BY(p, sample, table, gathered, interval, total, store_raw_at(gathered, at, present, out),      \
                  store_colors_at(color, at, present, out), count_visible_lanes(color, present))
