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
static inline intv shows(const SampleParams *p, realv from, realv to) {
    const ClassificationParams *c = &p->classification;
    return MAX(from, to) >= c->shown_from && MIN(from, to) <= c->shown_to;
}

// Whether gradients are derivatives of the field, which tell more of it: between two lit samples it is taken for the cubic with the values
// and the slopes of both, and a sample is made of it in the middle. Where rays are parallel to an axis it is the field itself.
#define HAS_SLOPES (KERNEL == CATMULL_ROM || KERNEL == BSPLINE)

// What is known of the light at a sample.
typedef struct {
    Lighting lighting;
#if HAS_SLOPES
    Gradient gradient;
#endif
} Lit;

static inline Lit lit_at(const SampleParams *p, Point point, realv value, Gradient gradient) {
    Lit lit;
    lit.lighting = shade(p, point, value, gradient);
#if HAS_SLOPES
    lit.gradient = gradient;
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
// falls on what lies between where gradients mix. Where ends are a layer apart gradients stay near theirs, as the field does. Gradients that
// are derivatives of the field are no noise, but directions inside plates are: they count more evenly. (Quite evenly, engine's plate has 2 dB
// less; without EVEN it has 2 dB more, and a ball 2 dB less.)
#if HAS_SLOPES
#define EVEN 0.2f
#else
#define EVEN 0.0f
#endif
static inline Lighting light_on(const SampleParams *p, const Lit *front, const Lit *back, realv t) {
    const Lighting *one = &front->lighting, *other = &back->lighting;
#if HAS_SLOPES
    const realv place = t;
#else
    const realv place = t + p->segments.curve * (SMOOTHSTEP(t) - t);
#endif
    const realv of_back = place * (EVEN + other->weight);
    const realv mixed = of_back * rough_reciprocal((1.0f - place) * (EVEN + one->weight) + of_back);
    Lighting lighting = {one->factor + mixed * (other->factor - one->factor),
                         one->highlight + mixed * (other->highlight - one->highlight)};
#ifdef THINNED
    lighting.left = left_on(front, back, t);
#endif
    return lighting;
}

#if HAS_SLOPES
// How much of what gradients lack in the middle lies along the way, and not along those at its ends, for each voxel of it, squared: the
// farther these are apart, the less they say of what lies between.
#define ALONG_THE_WAY 0.8f
// Square of a gradient, in ranges of values, below which it says nothing of a normal: weaker ones are not lit.
#define NO_NORMAL 1e-6f
#define SCALAR_PRODUCT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

// The sample in the middle of a way. Where nothing between the ends `counts` its value is one of those: it can lie beyond all that the
// kernel makes of the voxels around, and what is skipped, in whole tiles or blocks, must not depend on neighbours.
static inline Lit lit_in_the_middle(const SampleParams *p, const Way *way, intv counts, const Lit *front, const Lit *back, realv *value) {
    const realv *step = way->step;
    // In ranges of values, of which squares are numbers.
    const float unit = p->field.gradient_a, range = 1.0f / unit;
    const Gradient from = front->gradient, to = back->gradient;
    const realv one[3] = {unit * from.u, unit * from.v, unit * from.a};
    const realv other[3] = {unit * to.u, unit * to.v, unit * to.a};
    const realv slope_front = SCALAR_PRODUCT(one, step), slope_back = SCALAR_PRODUCT(other, step);
    *value = 0.5f * (way->from + way->to) + (counts ? 0.125f * range * (slope_front - slope_back) : (realv)(0.0f));
    // What the mean of both lacks for the cubic's slope lies where they do, whichever way they point: across surfaces.
    const realv lacking = 1.5f * unit * (way->to - way->from) - 0.75f * (slope_front + slope_back);
    const realv squared = SCALAR_PRODUCT(step, step), both = SCALAR_PRODUCT(one, one) + SCALAR_PRODUCT(other, other);
    const realv way_too = ALONG_THE_WAY * squared * (both + NO_NORMAL);
    const realv scale = lacking * rough_reciprocal(slope_front * slope_front + slope_back * slope_back + way_too * squared);
    const realv of_front = 0.5f + scale * slope_front, of_back = 0.5f + scale * slope_back, of_way = range * (scale * way_too);
    const Gradient gradient = {of_front * from.u + of_back * to.u + of_way * step[0], of_front * from.v + of_back * to.v + of_way * step[1],
                               of_front * from.a + of_back * to.a + of_way * step[2]};
    return lit_at(p, point_on(way, (realv)(0.5f)), *value, gradient);
}
#endif
