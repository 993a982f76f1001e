// Lighting of the studio: matter scatters light, surfaces reflect it. Colours are reflectances in linear light.

#include "shared/light_field.cl"
#include "shared/linear_light.cl"

#ifdef STUDIO
// Adds light n from a direction: what surfaces with this unit normal reflect per reflectance (`diffuse`), and as a mirror does
// (`highlight`), and what matter scatters per albedo (`scattered`).
ALWAYS_INLINE void add_light(const SampleParams *p, LightVolume volume, Point point, int n, const realv *normal, const float *to_light,
                             const float *half_way, float strength, float specular, realv *diffuse, realv *highlight, realv *scattered) {
    const realv arriving = strength * reaching_light(p, volume, point, n);
    const realv facing = normal[0] * to_light[0] + normal[1] * to_light[1] + normal[2] * to_light[2];
    const realv along = normal[0] * half_way[0] + normal[1] * half_way[1] + normal[2] * half_way[2];
    const realv mirror = facing > 0.0f ? power(CLAMP(along, (realv)(0.0f), (realv)(1.0f)), p->light.power) : (realv)(0.0f);
    const realv reflected = arriving * MAX(facing, (realv)(0.0f)), mirrored = specular * arriving * mirror;
#pragma unroll
    for (int c = 0; c < 3; c++) {
        const float color = p->light.colors[3 * n + c];
        diffuse[c] += color * reflected, highlight[c] += color * mirrored;
        // Irradiances are pi times the strength; matter scatters them into all directions.
        scattered[c] += (0.25f * color) * arriving;
    }
}

// Lighting of a point with a gradient along the axes of the lights. `lit`: share of the surface.
static inline void studio_lighting(const SampleParams *p, LightVolume volume, Point point, realv u, realv v, realv a, realv inverse,
                                   realv lit, Lighting *lighting) {
    const LightVolumeParams *light = &p->light.light_volume;
    const realv to_eye = (u * light->eye_u + v * light->eye_v + a * light->eye_a) * inverse;
    const realv sign = to_eye < 0.0f ? -inverse : inverse;
    const realv normal[3] = {sign * u, sign * v, sign * a};
    const Point off = {point.u + lit * normal[0] * light->lift_u, point.v + lit * normal[1] * light->lift_v,
                       point.a + lit * normal[2] * light->lift_a};
    const ScatteredLight around = scattered_light(p, volume, off, normal);
    realv diffuse[3], highlight[3], scattered[3];
    for (int c = 0; c < 3; c++) {
        const realv shine = 1.0f + 2.0f * lit * around.along[c];
        diffuse[c] = around.radiance[c] * MAX(shine, (realv)(0.0f));
        highlight[c] = 0.0f, scattered[c] = around.radiance[c];
    }
    // Behind a surface is no light.
    point.u += light->shadow_lift * (off.u - point.u), point.v += light->shadow_lift * (off.v - point.v);
    point.a += light->shadow_lift * (off.a - point.a);
    add_light(p, volume, point, 0, normal, &p->light.direction_u, &p->light.half_u, p->light.diffuse, p->light.specular, diffuse, highlight,
              scattered);
#ifdef SEVERAL_LIGHTS
    // Unrolled: GPUs would keep lights indexed by a variable in memory.
#if VW == 1
#pragma unroll
#endif
    for (int i = 0; i < (int)(sizeof p->light.lights / sizeof(float)) / 8; i++) {
        if (i >= p->light.more_lights)
            break;
        const float *other = p->light.lights + 8 * i;
        add_light(p, volume, point, i + 1, normal, other, other + 3, other[6], other[7], diffuse, highlight, scattered);
    }
#endif
    for (int c = 0; c < 3; c++) {
        lighting->factor[c] = lit * diffuse[c], lighting->highlight[c] = lit * highlight[c];
        lighting->unlit[c] = (1.0f - lit) * scattered[c];
#ifdef LABELS
        lighting->beside[c] = scattered[c];
#endif
    }
}
#endif
