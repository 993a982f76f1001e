// Look-up of scattered light, in the words that kernels/light/scatter_pack.cl has packed.

#include "shared/light_volume.cl"

#ifdef STUDIO
// Mean radiance in red, green and blue, and the flux of each along u, v, a as shares of it.
typedef struct {
    realv radiance[3], flux[3][3];
} ScatteredLight;

// Exponent of a word whose five highest bits are 0, with the bits of the mantissa.
#define LEAST_EXPONENT (127 - 15 - 9)

// Interpolates linearly between eight cells.
static inline ScatteredLight scattered_light(const SampleParams *p, LightVolume volume, Point point) {
    const LightVolumeParams *v = &p->light.light_volume;
    const realv u = CLAMP(point.u * v->sky_scale_u + v->sky_origin_u, (realv)(0.0f), (realv)(v->sky_last_u));
    const realv w = CLAMP(point.v * v->sky_scale_v + v->sky_origin_v, (realv)(0.0f), (realv)(v->sky_last_v));
    const realv a = CLAMP(point.a * v->sky_scale_a + v->sky_origin_a, (realv)(0.0f), (realv)(v->sky_last_a));
    const intv i = CONVERT_INTV(u), j = CONVERT_INTV(w), k = CONVERT_INTV(a);
    const realv s = u - CONVERT_REALV(i), t = w - CONVERT_REALV(j), r = a - CONVERT_REALV(k);
    const intv first = 16 * (i * v->sky_stride_u + j * v->sky_stride_v + k * v->sky_stride_a);
    ScatteredLight light;
    for (int c = 0; c < 3; c++)
        light.radiance[c] = 0.0f, light.flux[c][0] = light.flux[c][1] = light.flux[c][2] = -511.0f;
#pragma unroll
    for (int n = 0; n < 8; n++) {
        const int to_corner = (n & 1 ? v->sky_stride_u : 0) + (n & 2 ? v->sky_stride_v : 0) + (n & 4 ? v->sky_stride_a : 0);
        const realv weight = (n & 1 ? s : 1.0f - s) * (n & 2 ? t : 1.0f - t) * (n & 4 ? r : 1.0f - r);
        const intv at = first + 16 * to_corner, radiance = WORDS_AT(volume.sky, at);
        const realv scale = weight * AS_REALV((((radiance >> 27) & 31) + LEAST_EXPONENT) << 23);
#pragma unroll
        for (int c = 0; c < 3; c++)
            light.radiance[c] += scale * CONVERT_REALV((radiance >> (9 * c)) & 511);
#pragma unroll
        for (int axis = 0; axis < 3; axis++) {
            const intv flux = WORDS_AT(volume.sky, at + 4 + 4 * ((v->sky_axes >> (2 * axis)) & 3));
#pragma unroll
            for (int c = 0; c < 3; c++)
                light.flux[c][axis] += weight * CONVERT_REALV((flux >> (10 * c)) & 1023);
        }
    }
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            light.flux[c][axis] *= 1.0f / 511.0f;
    return light;
}
#endif
