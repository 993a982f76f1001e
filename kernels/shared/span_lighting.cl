// Lighting between two samples of a ray, interpolated from the lighting at the samples.

#include "shared/accumulator.cl"
#include "shared/ray_span.cl"

// Whether lighting is computed at the samples and interpolated in between. Not needed where values are accumulated, nor where a surface
// is located on the field itself.
#if GATHERS_VALUES || defined(REFINED)
#define LIT_AT_ENDS false
#else
#define LIT_AT_ENDS true
#endif

// Whether any value between two is visible.
static inline intv is_visible_between(const SampleParams *p, realv from, realv to) {
    const ClassificationParams *c = &p->classification;
    return MAX(from, to) >= c->shown_from && MIN(from, to) <= c->shown_to;
}

// Whether gradients are derivatives of the field. These allow a cubic between two lit samples, from the values and slopes at both. It
// yields an additional sample in the middle. For rays parallel to an axis the cubic is the field itself.
#define ANALYTIC_GRADIENTS (GRADIENT == OWN)

// Lighting of a sample, and the gradient if it is needed in between.
typedef struct {
    Lighting lighting;
#if ANALYTIC_GRADIENTS
    Gradient gradient;
#endif
} LitSample;

static inline LitSample light_sample(const SampleParams *p, LightVolume volume, Point point, realv value, Gradient gradient) {
    LitSample lit;
    lit.lighting = shade(p, volume, point, value, gradient);
#if ANALYTIC_GRADIENTS
    lit.gradient = gradient;
#endif
    return lit;
}

#ifdef THINNED
// Factor of the extinction, interpolated between two samples.
static inline realv extinction_scale_on_span(const LitSample *front, const LitSample *back, realv t) {
    const realv from = front->lighting.extinction_scale;
    return from + t * (back->lighting.extinction_scale - from);
}
#endif

// Lighting interpolated between two samples. Central differences are unreliable in noise, so the end with the stronger gradient has the
// larger weight: this lights regions where gradients mix. Ends a layer apart follow the curve of the field, which stays near its end
// values. Analytic gradients are not noisy, but their directions inside thin plates are unreliable: their weights are more even. (Fully
// even weights cost engine's plate 2 dB; EVEN gains it 2 dB and costs a ball 2 dB.)
#if ANALYTIC_GRADIENTS
#define EVEN 0.2f
#else
#define EVEN 0.0f
#endif
static inline Lighting interpolate_lighting(const SampleParams *p, const LitSample *front, const LitSample *back, realv t) {
    const Lighting *one = &front->lighting, *other = &back->lighting;
#if ANALYTIC_GRADIENTS
    const realv place = t;
#else
    const realv place = t + p->segments.curve * (SMOOTHSTEP(t) - t);
#endif
    const realv weight_back = place * (EVEN + other->weight);
    const realv mixed = weight_back * rough_reciprocal((1.0f - place) * (EVEN + one->weight) + weight_back);
    Lighting lighting;
    lighting.weight = 0.0f;
    FOR_LIT_COMPONENTS(i) {
        lighting.factor[i] = one->factor[i] + mixed * (other->factor[i] - one->factor[i]);
        lighting.highlight[i] = one->highlight[i] + mixed * (other->highlight[i] - one->highlight[i]);
#if defined(LABELS) || defined(STUDIO)
        lighting.unlit[i] = one->unlit[i] + place * (other->unlit[i] - one->unlit[i]);
#endif
#ifdef LABELS
        lighting.beside[i] = one->beside[i] + place * (other->beside[i] - one->beside[i]);
#endif
    }
#ifdef THINNED
    lighting.extinction_scale = extinction_scale_on_span(front, back, t);
#endif
#ifdef DEPTH_CUED
    // Not weighted by gradients: it is linear along the ray.
    lighting.cue = one->cue + t * (other->cue - one->cue);
#endif
    return lighting;
}

#if ANALYTIC_GRADIENTS
// Fraction of the gradient correction at the middle that is applied along the step, and not along the end gradients, per squared voxel.
// The longer the step, the less the end gradients say about the middle.
#define ALONG_STEP 0.8f
// Square of the gradient magnitude, relative to the range of values, below which a gradient has no meaningful normal: it is not lit.
#define NO_NORMAL 1e-6f
#define SCALAR_PRODUCT(a, b) ((a)[0] * (b)[0] + (a)[1] * (b)[1] + (a)[2] * (b)[2])

// The additional sample in the middle of a span. Where no value between the ends `contributes`, the value is the mean of theirs: the cubic
// can exceed all values that the kernel can reconstruct there, and skipping of tiles and blocks must not depend on neighbours.
static inline LitSample light_midpoint(const SampleParams *p, LightVolume volume, const RaySpan *span, intv contributes,
                                       const LitSample *front, const LitSample *back, realv *value) {
    const realv *step = span->step;
    // Relative to the range of values, so that squares stay in the range of floats.
    const float unit = p->field.gradient_a, range = 1.0f / unit;
    const Gradient from = front->gradient, to = back->gradient;
    const realv one[3] = {unit * from.u, unit * from.v, unit * from.a};
    const realv other[3] = {unit * to.u, unit * to.v, unit * to.a};
    const realv slope_front = SCALAR_PRODUCT(one, step), slope_back = SCALAR_PRODUCT(other, step);
    *value = 0.5f * (span->from + span->to) + (contributes ? 0.125f * range * (slope_front - slope_back) : (realv)(0.0f));
    // The correction of the mean gradient to the cubic's slope is applied along the end gradients, whatever their sign: across surfaces.
    const realv missing_slope = 1.5f * unit * (span->to - span->from) - 0.75f * (slope_front + slope_back);
    const realv squared = SCALAR_PRODUCT(step, step), both = SCALAR_PRODUCT(one, one) + SCALAR_PRODUCT(other, other);
    const realv along_step = ALONG_STEP * squared * (both + NO_NORMAL);
    const realv scale = missing_slope * rough_reciprocal(slope_front * slope_front + slope_back * slope_back + along_step * squared);
    const realv weight_front = 0.5f + scale * slope_front, weight_back = 0.5f + scale * slope_back,
        weight_step = range * (scale * along_step);
    const Gradient gradient = {weight_front * from.u + weight_back * to.u + weight_step * step[0],
                               weight_front * from.v + weight_back * to.v + weight_step * step[1],
                               weight_front * from.a + weight_back * to.a + weight_step * step[2]};
    return light_sample(p, volume, point_on_span(span, (realv)(0.5f)), *value, gradient);
}
#endif
