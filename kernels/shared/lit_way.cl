// How light falls on what lies between two samples of a ray, from what is known at these.

#include "shared/accumulator.cl"
#include "shared/way.cl"

// Whether the samples are lit, and what lies between by these: not where values are gathered, nor where a surface is found on the field
// itself.
#if GATHERS_VALUES || defined(REFINED)
#define LIT_AT_ENDS false
#else
#define LIT_AT_ENDS true
#endif

// Whether anything between two values does.
static inline intv shows(const SampleParams *p, realv from, realv to) { return MAX(from, to) >= p->shown_from && MIN(from, to) <= p->shown_to; }

// Whether gradients are derivatives of the field, which tell more of it: between two lit samples it is taken for the cubic with the values
// and the slopes of both, and a sample is made of it in the middle. Where rays are parallel to an axis it is the field itself.
#define HAS_SLOPES (KERNEL == CATMULL_ROM || KERNEL == BSPLINE)

// What is known of the light at a sample.
typedef struct {
    Lighting lighting;
#if HAS_SLOPES
    realv u, v, a; // gradient
#endif
} Lit;

static inline Lit lit_by(const SampleParams *p, realv u, realv v, realv a) {
    Lit lit;
    lit.lighting = light_gradient(p, u, v, a);
#if HAS_SLOPES
    lit.u = u, lit.v = v, lit.a = a;
#endif
    return lit;
}

#ifdef THINNED
// What is left of the extinction between two ends.
static inline realv left_on(const Lit *front, const Lit *back, realv t) {
    const realv from = front->lighting.left;
    return from + t * (back->lighting.left - from);
}
#endif

// Light between that of two ends. Central differences are weak in noise: the end with the stronger gradient counts for more, so that light
// falls on what lies between where gradients mix. Where ends are a layer apart gradients stay near theirs, as the field does.
static inline Lighting light_on(const SampleParams *p, const Lit *front, const Lit *back, realv t) {
    const Lighting *one = &front->lighting, *other = &back->lighting;
#if HAS_SLOPES
    const realv mixed = t;
#else
    const realv even = t + p->curve * (SMOOTHSTEP(t) - t);
    const realv of_back = even * other->weight;
    const realv mixed = of_back * rough_reciprocal((1.0f - even) * one->weight + of_back);
#endif
    Lighting lighting = {one->factor + mixed * (other->factor - one->factor),
                         one->highlight + mixed * (other->highlight - one->highlight)};
#ifdef THINNED
    lighting.left = left_on(front, back, t);
#endif
    return lighting;
}

#if HAS_SLOPES
// The sample in the middle of a way. Where nothing between the ends `counts` its value is one of those: it can lie beyond all that the
// kernel makes of the voxels around, and what is skipped, in whole tiles or blocks, must not depend on neighbours.
static inline Lit lit_in_the_middle(const SampleParams *p, const Way *way, intv counts, const Lit *front, const Lit *back, realv *value) {
    const realv *step = way->step;
    const realv slope_front = front->u * step[0] + front->v * step[1] + front->a * step[2];
    const realv slope_back = back->u * step[0] + back->v * step[1] + back->a * step[2];
    *value = 0.5f * (way->from + way->to) + (counts ? 0.125f * (slope_front - slope_back) : (realv)(0.0f));
    // Across the way gradients mix evenly; along it they are the cubic's slope.
    const realv more = 1.5f * (way->to - way->from) - 0.75f * (slope_front + slope_back);
    const realv along = more * reciprocal(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]);
    return lit_by(p, 0.5f * (front->u + back->u) + along * step[0], 0.5f * (front->v + back->v) + along * step[1],
                  0.5f * (front->a + back->a) + along * step[2]);
}
#endif
