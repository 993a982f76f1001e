// What a ray gathers, and what becomes of it, by the blend mode that a program is built for (BLEND). Another blend mode is another
// accumulator: how it starts, what it takes, which rays are still open, and what colour it ends as.

#include "shared/clipping.cl"
#include "shared/shading.cl"
#include "shared/table_entries.cl"

#define COMPOSITE 0
#define MAXIMUM 1
#define MINIMUM 2
#define AVERAGE 3
#define ISO 4
#ifndef BLEND
#error "BLEND: COMPOSITE, MAXIMUM, MINIMUM, AVERAGE or ISO"
#endif
// Whether values are gathered, to be shown as colours in the end; colours are gathered otherwise, or, with DEPTHS, where these are.
#define GATHERS_VALUES (BLEND == MAXIMUM || BLEND == MINIMUM || BLEND == AVERAGE)

#if GATHERS_VALUES

// The largest or smallest value so far, or the sum of values times the way through them, in ray parameters.
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

// The rays that anything more can change.
static inline intv open_rays(const SampleParams *p, const Accumulator *a) {
#if BLEND == MAXIMUM
    return a->value < p->field.largest;
#elif BLEND == MINIMUM
    return a->value > p->field.least;
#else
    return LANES >= 0;
#endif
}

// Takes a segment between two values; `length` in ray parameters, 0 where it does not count.
static inline void accumulate_values(realv from, realv to, realv length, Accumulator *a, intv *active) {
    const intv counts = length > 0.0f;
    *active += COUNT_IF(counts);
#if BLEND == MAXIMUM
    a->value = counts ? MAX(a->value, MAX(from, to)) : a->value;
#elif BLEND == MINIMUM
    a->value = counts ? MIN(a->value, MIN(from, to)) : a->value;
#else
    a->value += counts ? 0.5f * (from + to) * length : (realv)(0.0f);
#endif
}

// The colour of a ray that counts in an interval: r, g, b, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                    realv *color) {
    const intv met = interval->from < interval->to;
    realv value = a->value;
#if BLEND == AVERAGE
    value = value / (met ? interval->to - interval->from : (realv)(1.0f));
#endif
    // Kernels with negative weights overshoot: what is gathered stays among the voxels.
    value = CLAMP(value, (realv)(p->field.least), (realv)(p->field.largest));
    realv extinction;
    table_entries(table, table_index(p, value), &color[0], &color[1], &color[2], &extinction);
    color[3] = CONVERT_REALV(COUNT_IF(met));
    for (int i = 0; i < 3; i++)
        color[i] *= color[3];
}

#else

#ifdef DEPTHS

// Transmittance where something is seen first: a step of an 8-bit picture is gone.
#define FIRST_SEEN (1.0f - 1.0f / 256.0f)

// Where rays meet what shows, in ray parameters: first, and on the average, times the opacity; the transmittance left; and where the
// rays are, from a place on for a way.
typedef struct {
    realv first, weighted, t, from, way;
} Accumulator;

static inline Accumulator empty_accumulator(const SampleParams *p) {
    const Accumulator a = {(realv)(INFINITY), (realv)(0.0f), (realv)(1.0f), (realv)(0.0f), (realv)(0.0f)};
    return a;
}

static inline void is_between(realv from, realv to, Accumulator *a) { a->from = from, a->way = to - from; }

// Takes the opacity between these places.
ALWAYS_INLINE void accumulate(realv r, realv g, realv b, realv opacity, Accumulator *a) {
    const realv weight = a->t * opacity;
    const intv seen = a->t > FIRST_SEEN && a->t - weight <= FIRST_SEEN;
    a->first = seen ? a->from + a->way * ((a->t - FIRST_SEEN) / weight) : a->first;
    a->weighted += weight * (a->from + 0.5f * a->way);
    a->t -= weight;
}

// Of a ray: first, weighted, 0, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                    realv *color) {
    color[0] = a->first, color[1] = a->weighted, color[2] = (realv)(0.0f), color[3] = 1.0f - a->t;
}

#else

// Premultiplied colour and the transmittance left.
typedef struct {
    realv r, g, b, t;
} Accumulator;

static inline Accumulator empty_accumulator(const SampleParams *p) {
    const Accumulator a = {(realv)(0.0f), (realv)(0.0f), (realv)(0.0f), (realv)(1.0f)};
    return a;
}

// Composites a colour behind what a ray has gathered.
ALWAYS_INLINE void accumulate(realv r, realv g, realv b, realv opacity, Accumulator *a) {
    const realv weight = a->t * opacity;
    a->r += weight * r;
    a->g += weight * g;
    a->b += weight * b;
    a->t -= weight;
}

// The colour of a ray: r, g, b, alpha.
static inline void resolve(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                    realv *color) {
    color[0] = a->r, color[1] = a->g, color[2] = a->b, color[3] = 1.0f - a->t;
}

#endif

// The rays that let enough light pass to go on.
static inline intv open_rays(const SampleParams *p, const Accumulator *a) { return a->t > p->segments.opaque; }

// Lights a colour before, and thins it.
ALWAYS_INLINE void accumulate_lit(const SampleParams *p, realv r, realv g, realv b, realv opacity, const Lighting *lighting,
                                  Accumulator *a) {
    if (p->light.shading) {
        r = MIN(r * lighting->factor + lighting->highlight, (realv)(1.0f));
        g = MIN(g * lighting->factor + lighting->highlight, (realv)(1.0f));
        b = MIN(b * lighting->factor + lighting->highlight, (realv)(1.0f));
#ifdef THINNED
        opacity = thinned(p, opacity, lighting->left);
#endif
    }
    accumulate(r, g, b, opacity, a);
}

#endif

// Whether anything more can change any of VW rays; or of the first `count` of them.
static inline bool any_open(const SampleParams *p, const Accumulator *a) { return ANY(open_rays(p, a)); }
static inline bool any_open_of(const SampleParams *p, const Accumulator *a, int count) { return ANY(open_rays(p, a) && LANES < count); }

// The first `count` of VW colours, to places `stride` apart.
static inline void store_colors(const realv *color, int count, int stride, __global float4 *out) {
#if VW == 1
    // Looked up by a number, a colour would be in memory.
    if (count > 0)
        *out = (float4)(color[0], color[1], color[2], color[3]);
#else
    if (count == VW && stride == 1) {
        // Every fourth sample of one vector.
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

// Sum of the first `count` lanes.
static inline uint counted(intv active, int count) {
    uint total = 0;
    for (int i = 0; i < count; i++)
        total += ((const int *)&active)[i];
    return total;
}

// The raw state of `count` of VW rays, from or to places `stride` apart.
#define RAW_NUMBERS ((int)(sizeof(Accumulator) / sizeof(realv)))
static inline Accumulator load_raw(const SampleParams *p, __global const float4 *state, int count, int stride) {
    Accumulator a = empty_accumulator(p);
    float *lanes = (float *)&a;
    for (int i = 0; i < count; i++) {
        const float4 raw = state[(size_t)i * stride];
        for (int n = 0; n < RAW_NUMBERS; n++)
            lanes[n * VW + i] = ((const float *)&raw)[n];
    }
    return a;
}
static inline void store_raw(const Accumulator *a, int count, int stride, __global float4 *out) {
    const float *lanes = (const float *)a;
    for (int i = 0; i < count; i++) {
        float4 raw = 0.0f;
        for (int n = 0; n < RAW_NUMBERS; n++)
            ((float *)&raw)[n] = lanes[n * VW + i];
        out[(size_t)i * stride] = raw;
    }
}

// How many of `count` colours are not nothing.
static inline uint shown(const realv *color, int count) {
    return counted(COUNT_IF(color[0] != 0.0f || color[1] != 0.0f || color[2] != 0.0f || color[3] != 0.0f), count);
}

// Ends a lattice's rays as `p` says: raw, or resolved to colours. Counts those that show anything where what was taken here does not tell:
// others were before, or rays start with a value that shows.
#define END_RAYS(p, sample, table, gathered, interval, count, stride, out, total) \
    if ((p).raw) {                                                                \
        store_raw(gathered, count, stride, out);                                  \
    } else {                                                                      \
        realv color[4];                                                           \
        resolve(&(sample), table, gathered, interval, color);                     \
        store_colors(color, count, stride, out);                                  \
        if ((p).continues || GATHERS_VALUES)                                      \
            total += shown(color, count);                                         \
    }
