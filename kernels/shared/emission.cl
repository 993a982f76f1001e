// Colours of several fields: at one place sum(tau_c C_c) / tau, with tau = sum of tau_c, and of rays that gather values their sum.

#include "shared/accumulator.cl"

#if BLEND == COMPOSITE

// Share of a field in the extinction of a segment, and its lighting.
typedef struct {
    realv depth;
    Lighting lighting;
} Emission;

// A lit colour, weighted by its extinction.
static inline void add_emission(const SampleParams *p, realv r, realv g, realv b, const Emission *e, realv *sum) {
    if (p->light.shading) {
        r = lit_red(p, r, &e->lighting);
        g = lit_green(p, g, &e->lighting);
        b = lit_blue(p, b, &e->lighting);
    }
    sum[0] += e->depth * r, sum[1] += e->depth * g, sum[2] += e->depth * b;
}

static inline void accumulate_emission(const realv *sum, realv depth, realv opacity, Accumulator *a) {
    const realv per_depth = reciprocal(depth == 0.0f ? (realv)(1.0f) : depth);
    accumulate(sum[0] * per_depth, sum[1] * per_depth, sum[2] * per_depth, opacity, a);
}

#elif GATHERS_VALUES

// Adds the colour of a field's ray, at most to 1.
static inline void add_resolved(const SampleParams *p, __global const float4 *table, const Accumulator *a, const Interval *interval,
                                realv *color) {
    realv own[4];
    resolve(p, table, a, interval, own);
    for (int i = 0; i < 4; i++)
        color[i] = MIN(color[i] + own[i], (realv)(1.0f));
}

#endif
