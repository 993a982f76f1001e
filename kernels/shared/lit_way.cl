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
// falls on what lies between where gradients mix. Where ends are a layer apart gradients stay near theirs, as the field does. Gradients that
// are derivatives of the field are no noise, but directions inside plates are: they count more evenly. (Evenly, engine has 2 dB less, without
// EVEN 1.5 dB more, and balls 2 dB less.)
#if HAS_SLOPES
#define EVEN 0.2f
#define CURVED_PLACE(p, t) (t)
#else
#define EVEN 0.0f
#define CURVED_PLACE(p, t) ((t) + (p)->curve * (SMOOTHSTEP(t) - (t)))
#endif
static inline Lighting light_on(const SampleParams *p, const Lit *front, const Lit *back, realv t) {
    const Lighting *one = &front->lighting, *other = &back->lighting;
    const realv place = CURVED_PLACE(p, t), of_back = place * (EVEN + other->weight);
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
#define SCALAR_PRODUCT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

// The sample in the middle of a way. Where nothing between the ends `counts` its value is one of those: it can lie beyond all that the
// kernel makes of the voxels around, and what is skipped, in whole tiles or blocks, must not depend on neighbours.
static inline Lit lit_in_the_middle(const SampleParams *p, const Way *way, intv counts, const Lit *front, const Lit *back, realv *value) {
    const realv *step = way->step;
    // Means of both gradients and of their slopes on the way, and halves of what they differ by; in ranges of values, whose squares are
    // numbers.
    const float range = 1.0f / p->gradient_a, per_range = 0.5f * p->gradient_a;
    const realv mean[3] = {per_range * (front->u + back->u), per_range * (front->v + back->v), per_range * (front->a + back->a)};
    const realv apart[3] = {per_range * (front->u - back->u), per_range * (front->v - back->v), per_range * (front->a - back->a)};
    const realv mean_slope = SCALAR_PRODUCT(mean, step), slopes_apart = SCALAR_PRODUCT(apart, step);
    *value = 0.5f * (way->from + way->to) + (counts ? 0.25f * range * slopes_apart : (realv)(0.0f));
    // What the mean lacks for the cubic's slope lies along the normal of a surface: that of both its sides, which are the longer of these.
    const realv lacking = 1.5f * (p->gradient_a * (way->to - way->from) - mean_slope);
    const realv mean_squared = SCALAR_PRODUCT(mean, mean), apart_squared = SCALAR_PRODUCT(apart, apart);
    const intv opposite = apart_squared > mean_squared;
    const realv slope = opposite ? slopes_apart : mean_slope;
    const realv squared = SCALAR_PRODUCT(step, step), way_too = ALONG_THE_WAY * squared * MAX(mean_squared, apart_squared);
    const realv scale = lacking * rough_reciprocal(MAX(slope * slope + way_too * squared, (realv)(1e-20f)));
    const realv of_normal = range * scale * slope, of_way = range * scale * way_too;
    const realv of_mean = opposite ? (realv)(range) : range + of_normal, of_apart = opposite ? of_normal : (realv)(0.0f);
    return lit_by(p, of_mean * mean[0] + of_apart * apart[0] + of_way * step[0],
                  of_mean * mean[1] + of_apart * apart[1] + of_way * step[1],
                  of_mean * mean[2] + of_apart * apart[2] + of_way * step[2]);
}
#endif
