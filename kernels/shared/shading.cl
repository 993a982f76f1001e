// A sample's place in the table, and how it is lit.

#include "shared/elementary.cl"
#include "shared/point.cl"

// The table entry nearest to a value.
static inline intv table_index(const SampleParams *p, realv value) {
    const realv x = (value - p->classification.table_first) * p->classification.table_per_value + 0.5f;
    return CONVERT_INTV(CLAMP(x, (realv)(0.0f), (realv)(p->classification.table_last)));
}

// What a colour is multiplied by, and what highlight is added to it; what it counts where it is mixed with another. THINNED: and what is
// left of the extinction.
typedef struct {
    realv factor, highlight, weight;
#ifdef THINNED
    realv left;
#endif
} Lighting;

#ifdef THINNED
// What a gradient's length leaves of the extinction: src/settings/gradient_opacity.rs.
static inline realv left_by(const SampleParams *p, realv length) {
    realv left = p->light.least_thinned;
    for (int i = 0; i < (int)(sizeof p->light.rises / sizeof(float)) / 3; i++) {
        const float *rise = p->light.rises + 3 * i;
        left += rise[1] * (CLAMP(length, (realv)(rise[0]), (realv)(rise[2])) - rise[0]);
    }
    return CLAMP(left, (realv)(0.0f), (realv)(1.0f));
}
#endif

// The lighting of a point with this value and gradient: Blinn-Phong, two-sided, with white lights, which are the same everywhere and for all
// values. Where the gradient is below 1e-3 of the value range per voxel the colour stays as it is, with a smooth fade up to 2e-3: rounding
// must not flip it.
static inline Lighting shade(const SampleParams *p, Point point, realv value, Gradient gradient) {
    const realv u = gradient.u * p->field.gradient_u, v = gradient.v * p->field.gradient_v, a = gradient.a * p->field.gradient_a;
    const realv squared = u * u + v * v + a * a;
    const realv inverse = inverse_sqrt(MAX(squared, (realv)(1e-20f)));
    const realv faded = CLAMP((squared * inverse - 1e-3f) * 1e3f, (realv)(0.0f), (realv)(1.0f));
    const realv lit = SMOOTHSTEP(faded);
    const realv facing = fabs(u * p->light.direction_u + v * p->light.direction_v + a * p->light.direction_a) * inverse;
    // A light at the camera has one direction for both. One lane computes it in less time than it asks.
#if VW == 1
    const bool headlight = false;
#else
    const bool headlight = p->light.half_u == p->light.direction_u && p->light.half_v == p->light.direction_v &&
                           p->light.half_a == p->light.direction_a;
#endif
    const realv mirror = headlight ? facing : fabs(u * p->light.half_u + v * p->light.half_v + a * p->light.half_a) * inverse;
    Lighting lighting;
    // The root of the gradient's length: a weak one's direction is mostly noise, but a surface has weak ones too.
    lighting.weight = rough_inverse_sqrt(inverse);
    realv factor = p->light.ambient + p->light.diffuse * facing;
    lighting.highlight = lit * p->light.specular * power(mirror, p->light.power);
#ifdef SEVERAL_LIGHTS
    // Looked up by a number, graphics processors would have lights in memory.
#if VW == 1
#pragma unroll
#endif
    for (int i = 0; i < (int)(sizeof p->light.lights / sizeof(float)) / 8; i++) {
        if (i >= p->light.more_lights)
            break;
        const float *light = p->light.lights + 8 * i, *half_way = light + 3;
        factor += light[6] * fabs(u * light[0] + v * light[1] + a * light[2]) * inverse;
        lighting.highlight += lit * light[7] * power(fabs(u * half_way[0] + v * half_way[1] + a * half_way[2]) * inverse, p->light.power);
    }
#endif
    lighting.factor = 1.0f + lit * (factor - 1.0f);
#ifdef THINNED
    lighting.left = p->light.thinned ? left_by(p, squared * inverse) : (realv)(1.0f);
#endif
    return lighting;
}

// Opacity of an optical depth, or of alpha times length.
static inline realv opacity_of_depth(const SampleParams *p, realv depth) {
    return p->classification.linear ? MIN(depth, (realv)(1.0f)) : absorbed(depth);
}

#ifdef THINNED
// An opacity of which the gradient leaves a part: of the extinction. All of it to the bit.
static inline realv thinned(const SampleParams *p, realv opacity, realv left) {
    const realv less = p->classification.linear ? opacity * left : 1.0f - raised(1.0f - opacity, left);
    return left < 1.0f ? less : opacity;
}
#endif
