// Look-up of the light that reaches a point, in volumes of bytes that light_sweep.cl has filled: codes of lights, and the ambient light
// itself. 255 is all of it.

#include "shared/light_codes.cl"
#include "shared/point.cl"
#include "shared/words.cl"

// Volumes of the lights, and of the ambient light.
typedef struct {
    __global const uchar *lights, *sky;
} LightVolume;

#define NO_LIGHT_VOLUME {0, 0}

#ifdef LIGHT_VOLUME
// Interpolates linearly between the values at four neighbouring bytes.
static inline realv interpolate_plane(__global const uchar *volume, intv at, int stride, realv s, realv t) {
    const intv low = WORDS_AT(volume, at), high = WORDS_AT(volume, at + stride);
    const realv left = CONVERT_REALV(low & 255), to_left = CONVERT_REALV(high & 255);
    const realv one = left + s * (CONVERT_REALV((low >> 8) & 255) - left);
    const realv other = to_left + s * (CONVERT_REALV((high >> 8) & 255) - to_left);
    return one + t * (other - one);
}

// Interpolates linearly between eight values of a volume, in steps of 1/255. The values along one axis are neighbouring bytes, of which one
// word holds two.
static inline realv interpolate_light(__global const uchar *volume, const float *scale, const float *origin, const int *stride,
                                      const float *last, float first_layer, Point point) {
    // Along the axis with neighbouring bytes, which is u or a, then the others.
    const bool along_a = stride[2] == 1;
    const int stride_far = along_a ? stride[0] : stride[2];
    const realv u = CLAMP(point.u * scale[0] + origin[0], (realv)(0.0f), (realv)(last[0]));
    const realv y = CLAMP(point.v * scale[1] + origin[1], (realv)(0.0f), (realv)(last[1]));
    // Layers of a part are counted from its first one. The difference is exact, so parts have the bits of the whole.
    const realv a = CLAMP(point.a * scale[2] + origin[2], (realv)(0.0f), (realv)(last[2])) - first_layer;
    const realv x = along_a ? a : u, z = along_a ? u : a;
    const intv i = CONVERT_INTV(x), j = CONVERT_INTV(y), k = CONVERT_INTV(z);
    const realv s = x - CONVERT_REALV(i), t = y - CONVERT_REALV(j), r = z - CONVERT_REALV(k);
    const intv at = i + j * stride[1] + k * stride_far;
    const realv near = interpolate_plane(volume, at, stride[1], s, t);
    // Samples in the planes of voxels need one plane of values.
    if (!ANY(r > 0.0f))
        return near;
    return near + r * (interpolate_plane(volume, at + stride_far, stride[1], s, t) - near);
}

// Where the light of a sample is looked up: at its point or, for an iso-surface with this unit normal, off the surface, on the side of the
// direction whose scalar product with the normal is `side`.
static inline Point off_surface(const SampleParams *p, Point point, realv u, realv v, realv a, realv side) {
#ifdef LIFTED_LIGHT
    const LightVolumeParams *volume = &p->light.light_volume;
    const realv sign = side < 0.0f ? (realv)(-1.0f) : (realv)(1.0f);
    point.u += sign * (volume->lift_u * u), point.v += sign * (volume->lift_v * v), point.a += sign * (volume->lift_a * a);
#endif
    return point;
}

// The share of light n that reaches a point.
static inline realv reaching_light(const SampleParams *p, LightVolume volume, Point point, int n) {
    const LightVolumeParams *v = &p->light.light_volume;
    if (v->volumes[n] < 0)
        return 1.0f;
    const realv code = interpolate_light(volume.lights + (size_t)v->volumes[n] * v->volume_bytes, &v->shadow_scale_u, v->origins + 3 * n,
                                         &v->shadow_stride_u, &v->shadow_last_u, v->shadow_first, point);
    return 1.0f - v->strength + v->strength * light_of_code(code * (1.0f / 255.0f));
}

// The share of the ambient light that reaches a point.
static inline realv reaching_sky(const SampleParams *p, LightVolume volume, Point point) {
    const LightVolumeParams *v = &p->light.light_volume;
    if (!v->sky)
        return 1.0f;
    return (1.0f / 255.0f) *
           interpolate_light(volume.sky, &v->sky_scale_u, &v->sky_origin_u, &v->sky_stride_u, &v->sky_last_u, v->sky_first, point);
}
#endif
