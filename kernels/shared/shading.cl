// Table look-up and lighting of samples.

#include "shared/elementary.cl"
#include "shared/light_volume.cl"
#include "shared/point.cl"

// Position of a value in the table, whose n-th entry covers n to n + 1; and the entry.
static inline realv table_position(const SampleParams *p, realv value) {
    return (value - p->classification.table_first) * p->classification.table_per_value + 0.5f;
}
static inline intv table_index(const SampleParams *p, realv value) {
    return CONVERT_INTV(CLAMP(table_position(p, value), (realv)(0.0f), (realv)(p->classification.table_last)));
}

// COLORED_LIGHTS: lights have colours, so red, green and blue are lit apart. Otherwise one factor and one highlight serve all three.
#if defined(STUDIO) && !defined(COLORED_LIGHTS)
#error "COLORED_LIGHTS: scattered light has colours"
#endif
#ifdef COLORED_LIGHTS
#define LIT_COMPONENTS 3
#define COMPONENT(i) (i)
#define OF_LIGHT(p, number, i, amount) ((p)->light.colors[3 * (number) + (i)] * (amount))
#define OF_AMBIENT(p, i, amount) ((p)->light.ambient_color[i] * (amount))
#else
#define LIT_COMPONENTS 1
#define COMPONENT(i) 0
#define OF_LIGHT(p, number, i, amount) (amount)
#define OF_AMBIENT(p, i, amount) (amount)
#endif
// Unrolled: GPUs would keep components indexed by a variable in memory.
#define FOR_LIT_COMPONENTS(i) _Pragma("unroll") for (int i = 0; i < LIT_COMPONENTS; i++)

// Factors of a colour, added highlights, and weight in interpolation with other lighting. THINNED: also the factor of the extinction.
// DEPTH_CUED: also the share of the background that the lit colour fades to, before it is clamped. LABELS: also the factors
// without a normal, and beside a surface whose normal is unknown. STUDIO: `unlit` is the light that matter scatters per albedo; that of all
// matter, which is the mean light over all normals, is `beside`.
typedef struct {
    realv factor[LIT_COMPONENTS], highlight[LIT_COMPONENTS], weight;
#if defined(LABELS) || defined(STUDIO)
    realv unlit[LIT_COMPONENTS];
#endif
#ifdef LABELS
    realv beside[LIT_COMPONENTS];
#endif
#ifdef THINNED
    realv extinction_scale;
#endif
#ifdef DEPTH_CUED
    realv cue;
#endif
} Lighting;

#ifdef LABELS
// The mean of |n.l| over the normals of a surface that is seen and lit from one side is 2/3; nearer to its middle it is larger.
#define MEAN_FACING 0.75f
#endif

#ifdef THINNED
// Factor of the extinction by gradient magnitude: src/host/settings/gradient_opacity.rs.
static inline realv gradient_extinction_scale(const SampleParams *p, realv length) {
    realv extinction_scale = p->light.least_thinned;
    for (int i = 0; i < (int)(sizeof p->light.rises / sizeof(float)) / 3; i++) {
        const float *rise = p->light.rises + 3 * i;
        extinction_scale += rise[1] * (CLAMP(length, (realv)(rise[0]), (realv)(rise[2])) - rise[0]);
    }
    return CLAMP(extinction_scale, (realv)(0.0f), (realv)(1.0f));
}
#endif

// The magnitude of a gradient, in value ranges per voxel of the smallest spacing.
static inline realv gradient_length(const SampleParams *p, Gradient gradient) {
    const realv u = gradient.u * p->field.gradient_u, v = gradient.v * p->field.gradient_v, a = gradient.a * p->field.gradient_a;
    const realv squared = u * u + v * v + a * a;
    return squared * inverse_sqrt(MAX(squared, (realv)(1e-20f)));
}

#include "shared/studio.cl"

// Lighting of a point with a value and gradient: two-sided Blinn-Phong with directional lights. Gradients below 1e-3 of the value
// range per voxel leave the colour unlit, with a smooth fade up to 2e-3, so that rounding cannot toggle the lighting. LIGHT_VOLUME: each
// light and the ambient light are dimmed by what reaches the point; the colour of weak gradients, too.
static inline Lighting shade(const SampleParams *p, LightVolume volume, Point point, realv value, Gradient gradient) {
    const realv u = gradient.u * p->field.gradient_u, v = gradient.v * p->field.gradient_v, a = gradient.a * p->field.gradient_a;
    const realv squared = u * u + v * v + a * a;
    const realv inverse = inverse_sqrt(MAX(squared, (realv)(1e-20f)));
    const realv faded = CLAMP((squared * inverse - 1e-3f) * 1e3f, (realv)(0.0f), (realv)(1.0f));
    const realv lit = SMOOTHSTEP(faded);
    Lighting lighting;
    // Root of the gradient magnitude: the direction of a weak gradient is mostly noise, but surfaces have weak gradients too.
    lighting.weight = rough_inverse_sqrt(inverse);
#ifdef STUDIO
    studio_lighting(p, volume, point, u, v, a, inverse, lit, &lighting);
#else
    const realv facing = fabs(u * p->light.direction_u + v * p->light.direction_v + a * p->light.direction_a) * inverse;
    // For a light at the camera both directions are equal. In one lane the check costs more than the computation.
#if VW == 1
    const bool headlight = false;
#else
    const bool headlight = p->light.half_u == p->light.direction_u && p->light.half_v == p->light.direction_v &&
                           p->light.half_a == p->light.direction_a;
#endif
    const realv mirror = headlight ? facing : fabs(u * p->light.half_u + v * p->light.half_v + a * p->light.half_a) * inverse;
#ifdef LIGHT_VOLUME
    const realv normal_u = u * inverse, normal_v = v * inverse, normal_a = a * inverse;
    const realv to_light = normal_u * p->light.direction_u + normal_v * p->light.direction_v + normal_a * p->light.direction_a;
    const realv to_eye = normal_u * p->light.light_volume.eye_u + normal_v * p->light.light_volume.eye_v +
                         normal_a * p->light.light_volume.eye_a;
    const realv sky = reaching_sky(p, volume, off_surface(p, point, normal_u, normal_v, normal_a, to_eye));
    const realv reaching = reaching_light(p, volume, off_surface(p, point, normal_u, normal_v, normal_a, to_light), 0);
    realv unshaded[LIT_COMPONENTS];
    FOR_LIT_COMPONENTS(i) {
        unshaded[i] = p->light.light_volume.unshaded + OF_AMBIENT(p, i, p->light.light_volume.unshaded_ambient) * sky +
                      OF_LIGHT(p, 0, i, p->light.light_volume.unshaded_lights[0]) * reaching;
        lighting.factor[i] = OF_AMBIENT(p, i, p->light.ambient) * sky + OF_LIGHT(p, 0, i, p->light.diffuse) * reaching * facing;
        lighting.highlight[i] = lit * OF_LIGHT(p, 0, i, p->light.specular) * reaching * power(mirror, p->light.power);
#ifdef LABELS
        lighting.beside[i] = OF_AMBIENT(p, i, p->light.ambient) * sky + OF_LIGHT(p, 0, i, p->light.diffuse) * reaching * MEAN_FACING;
#endif
    }
#else
    FOR_LIT_COMPONENTS(i) {
        lighting.factor[i] = OF_AMBIENT(p, i, p->light.ambient) + OF_LIGHT(p, 0, i, p->light.diffuse) * facing;
        lighting.highlight[i] = lit * OF_LIGHT(p, 0, i, p->light.specular) * power(mirror, p->light.power);
#ifdef LABELS
        lighting.beside[i] = OF_AMBIENT(p, i, p->light.ambient) + OF_LIGHT(p, 0, i, p->light.diffuse) * MEAN_FACING;
#endif
    }
#endif
#ifdef SEVERAL_LIGHTS
    // Unrolled: GPUs would keep lights indexed by a variable in memory.
#if VW == 1
#pragma unroll
#endif
    for (int i = 0; i < (int)(sizeof p->light.lights / sizeof(float)) / 8; i++) {
        if (i >= p->light.more_lights)
            break;
        const float *light = p->light.lights + 8 * i, *half_way = light + 3;
#ifdef LIGHT_VOLUME
        const realv to_other = normal_u * light[0] + normal_v * light[1] + normal_a * light[2];
        const realv other = reaching_light(p, volume, off_surface(p, point, normal_u, normal_v, normal_a, to_other), i + 1);
        FOR_LIT_COMPONENTS(n) {
            unshaded[n] += OF_LIGHT(p, i + 1, n, p->light.light_volume.unshaded_lights[i + 1]) * other;
            lighting.factor[n] += OF_LIGHT(p, i + 1, n, light[6]) * other * fabs(u * light[0] + v * light[1] + a * light[2]) * inverse;
            lighting.highlight[n] += lit * OF_LIGHT(p, i + 1, n, light[7]) * other *
                                     power(fabs(u * half_way[0] + v * half_way[1] + a * half_way[2]) * inverse, p->light.power);
#ifdef LABELS
            lighting.beside[n] += OF_LIGHT(p, i + 1, n, light[6]) * other * MEAN_FACING;
#endif
        }
#else
        FOR_LIT_COMPONENTS(n) {
            lighting.factor[n] += OF_LIGHT(p, i + 1, n, light[6]) * fabs(u * light[0] + v * light[1] + a * light[2]) * inverse;
            lighting.highlight[n] += lit * OF_LIGHT(p, i + 1, n, light[7]) *
                                     power(fabs(u * half_way[0] + v * half_way[1] + a * half_way[2]) * inverse, p->light.power);
#ifdef LABELS
            lighting.beside[n] += OF_LIGHT(p, i + 1, n, light[6]) * MEAN_FACING;
#endif
        }
#endif
    }
#endif
    FOR_LIT_COMPONENTS(i) {
#ifdef LIGHT_VOLUME
        const realv base = unshaded[i];
#elif defined(COLORED_LIGHTS)
        const float base = p->light.unshaded_color[i];
#else
        const float base = 1.0f;
#endif
        lighting.factor[i] = base + lit * (lighting.factor[i] - base);
#ifdef LABELS
        lighting.unlit[i] = base;
        lighting.beside[i] = base + lit * (lighting.beside[i] - base);
#endif
    }
#endif
#ifdef THINNED
    lighting.extinction_scale = p->light.thinned ? gradient_extinction_scale(p, squared * inverse) : (realv)(1.0f);
#endif
#ifdef DEPTH_CUED
    lighting.cue = point.u * p->light.cue_u + point.v * p->light.cue_v + point.a * p->light.cue_a + p->light.cue_at_origin;
#endif
    return lighting;
}

// One component of a lit colour: times the factor, plus the highlight, at most 1. STUDIO: plus the light that matter scatters, without
// limit. DEPTH_CUED: then faded to `background`. A cue of 0 keeps the colour exact to the bit.
static inline realv lit_component(const SampleParams *p, realv component, int i, const Lighting *lighting, float background) {
#ifdef STUDIO
    realv lit = component * lighting->factor[i] + lighting->highlight[i];
    if (ANY(lighting->unlit[i] > 0.0f))
        lit += albedo(component) * lighting->unlit[i];
#else
    const realv lit = MIN(component * lighting->factor[i] + lighting->highlight[i], (realv)(1.0f));
#endif
#ifdef DEPTH_CUED
    return lit + CLAMP(lighting->cue, (realv)(0.0f), (realv)(p->light.cue_strength)) * (background - lit);
#else
    return lit;
#endif
}

static inline realv lit_red(const SampleParams *p, realv red, const Lighting *l) {
    return lit_component(p, red, 0, l, p->light.cue_r);
}

static inline realv lit_green(const SampleParams *p, realv green, const Lighting *l) {
    return lit_component(p, green, COMPONENT(1), l, p->light.cue_g);
}

static inline realv lit_blue(const SampleParams *p, realv blue, const Lighting *l) {
    return lit_component(p, blue, COMPONENT(2), l, p->light.cue_b);
}

// Opacity of an optical depth, or of alpha times length.
static inline realv opacity_of_depth(const SampleParams *p, realv depth) {
    return p->classification.linear ? MIN(depth, (realv)(1.0f)) : absorbed(depth);
}

#ifdef THINNED
// Applies gradient opacity: scales the extinction behind an opacity. A factor of 1 keeps the opacity exact to the bit.
static inline realv scale_opacity(const SampleParams *p, realv opacity, realv extinction_scale) {
    const realv scaled = p->classification.linear ? opacity * extinction_scale : 1.0f - general_power(1.0f - opacity, extinction_scale);
    return extinction_scale < 1.0f ? scaled : opacity;
}
#endif
