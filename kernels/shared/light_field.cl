// Look-up of scattered light, in the words that kernels/light/scatter_pack.cl has packed.

#include "shared/light_volume.cl"

#ifdef STUDIO
// Mean radiance in red, green and blue, and the flux of each along a normal as a share of it.
typedef struct {
    realv radiance[3], along[3];
} ScatteredLight;

// Exponent of a word whose five highest bits are 0, with the bits of the mantissa.
#define LEAST_EXPONENT (127 - 15 - 9)

// Interpolates linearly between eight cells. `normal`: along u, v, a.
static inline ScatteredLight scattered_light(const SampleParams *p, LightVolume volume, Point point, const realv *normal) {
    const LightVolumeParams *v = &p->light.light_volume;
    const realv u = CLAMP(point.u * v->sky_scale_u + v->sky_origin_u, (realv)(0.0f), (realv)(v->sky_last_u));
    const realv w = CLAMP(point.v * v->sky_scale_v + v->sky_origin_v, (realv)(0.0f), (realv)(v->sky_last_v));
    const realv a = CLAMP(point.a * v->sky_scale_a + v->sky_origin_a, (realv)(0.0f), (realv)(v->sky_last_a));
    const intv i = CONVERT_INTV(u), j = CONVERT_INTV(w), k = CONVERT_INTV(a);
    const realv s = u - CONVERT_REALV(i), t = w - CONVERT_REALV(j), r = a - CONVERT_REALV(k);
    const intv first = 16 * (i * v->sky_stride_u + j * v->sky_stride_v + k * v->sky_stride_a);
    // Along x, y, z, of which words have the flux.
    realv of_grid[3];
    ScatteredLight light;
#pragma unroll
    for (int c = 0; c < 3; c++) {
        of_grid[c] = (v->sky_axes & 3) == c ? normal[0] : ((v->sky_axes >> 2) & 3) == c ? normal[1] : normal[2];
        light.radiance[c] = 0.0f, light.along[c] = 0.0f;
    }
    // Unrolled on CPUs, programs would take twice as long to compile.
#if VW == 1
#pragma unroll
#else
#pragma unroll 1
#endif
    for (int n = 0; n < 8; n++) {
        const int to_corner = (n & 1 ? v->sky_stride_u : 0) + (n & 2 ? v->sky_stride_v : 0) + (n & 4 ? v->sky_stride_a : 0);
        const realv weight = (n & 1 ? s : 1.0f - s) * (n & 2 ? t : 1.0f - t) * (n & 4 ? r : 1.0f - r);
        intv words[4];
        four_words_at(volume.sky, first + 16 * to_corner, words);
        const realv scale = weight * AS_REALV((((words[0] >> 27) & 31) + LEAST_EXPONENT) << 23);
#pragma unroll
        for (int c = 0; c < 3; c++)
            light.radiance[c] += scale * CONVERT_REALV((words[0] >> (9 * c)) & 511);
#pragma unroll
        for (int axis = 0; axis < 3; axis++) {
            const realv facing = weight * of_grid[axis];
#pragma unroll
            for (int c = 0; c < 3; c++)
                light.along[c] += facing * CONVERT_REALV((words[1 + axis] >> (10 * c)) & 1023);
        }
    }
    const realv middle = of_grid[0] + of_grid[1] + of_grid[2];
#pragma unroll
    for (int c = 0; c < 3; c++)
        light.along[c] = light.along[c] * (1.0f / 511.0f) - middle;
    return light;
}
#endif
