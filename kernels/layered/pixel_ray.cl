// Rays through screen pixels, for kernels that render without a lattice. VW is 1.

#include "shared/clipping.cl"

// Arguments of a kernel: the field, for layer axis z, and the output.
#define PIXEL_FIELD                                                                                                                  \
    __global const VOXEL *voxels, VolumeView view_of_z, __global const GRADIENT_VOXEL *gradient_voxels, VolumeView gradient_view_of_z, \
        LIGHT_BUFFERS, __global const uchar *visible_x, __global const uchar *visible_y, __global const uchar *visible_z,             \
        DirectParams p, SampleParams sample_of_z, RayEnds ray_ends, OUTPUT

// The layer axis by the 45 degree rule: the largest component; on a tie the lowest index.
static inline int most_parallel(const float *d) {
    const float x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

// The i-th of three numbers. Indexing by a variable would put the array in memory.
#define SELECT_3(numbers, i) ((i) == 0 ? (numbers)[0] : (i) == 1 ? (numbers)[1] : (numbers)[2])

// A ray in the coordinates of its layer axis.
typedef struct {
    VolumeView view;
    int axis, layer_step;
    int blocks_u, blocks_v;
    float origin[3], direction[3]; // along x, y, z
    float o_u, o_v, o_a; // a point on the ray, in voxels
    float d_a;           // layers per unit of the ray parameter
    float s_u, s_v;
    float dt;            // length of a sample, in unit distances
} PixelRay;

// Permutes a vector (x, y, z) to (u, v, a).
static inline void permute_axes(float *x, float *y, float *z, int iu, int iv, int a) {
    const float v[3] = {*x, *y, *z};
    *x = SELECT_3(v, iu), *y = SELECT_3(v, iv), *z = SELECT_3(v, a);
}

#ifdef LIGHT_VOLUME
static inline void permute_light_volume(LightVolumeParams *p, int iu, int iv, int a) {
    float *const vectors[] = {&p->sky_scale_u, &p->sky_origin_u, &p->shadow_last_u, &p->sky_last_u, &p->lift_u, &p->eye_u};
#pragma unroll
    for (int n = 0; n < 6; n++)
        permute_axes(vectors[n], vectors[n] + 1, vectors[n] + 2, iu, iv, a);
#pragma unroll
    for (int n = 0; n < 4; n++)
        permute_axes(p->origins + 3 * n, p->origins + 3 * n + 1, p->origins + 3 * n + 2, iu, iv, a);
    const int shadow[3] = {p->shadow_stride_u, p->shadow_stride_v, p->shadow_stride_a};
    const int sky[3] = {p->sky_stride_u, p->sky_stride_v, p->sky_stride_a};
    p->shadow_stride_u = SELECT_3(shadow, iu), p->shadow_stride_v = SELECT_3(shadow, iv), p->shadow_stride_a = SELECT_3(shadow, a);
    p->sky_stride_u = SELECT_3(sky, iu), p->sky_stride_v = SELECT_3(sky, iv), p->sky_stride_a = SELECT_3(sky, a);
    p->sky_axes = iu | iv << 2 | a << 4;
}
#endif

// The view of layer axis z, permuted to axis a.
static inline VolumeView permuted_view(const VolumeView *z, int a) {
    const int iu = a == 0 ? 2 : 0, iv = a == 1 ? 2 : 1;
    const long stride[3] = {z->stride_u, z->stride_v, z->stride_a};
    const int dims[3] = {z->dims_u, z->dims_v, z->dims_a};
    const VolumeView view = {SELECT_3(stride, iu), SELECT_3(stride, iv), SELECT_3(stride, a), z->first,
                             SELECT_3(dims, iu),   SELECT_3(dims, iv),   SELECT_3(dims, a),   z->background, z->offset, 0};
    return view;
}

// The ray through pixel coordinates (x, y). Also permutes the sample parameters from layer axis z to the ray's own.
static inline PixelRay make_pixel_ray(const DirectParams *p, float x, float y, const VolumeView *view_of_z,
                                      const SampleParams *sample_of_z, SampleParams *sample) {
    *sample = *sample_of_z;
    float o[3], d[3];
    for (int i = 0; i < 3; i++) {
        o[i] = p->origin[i] + x * p->origin[4 + i] + y * p->origin[8 + i];
        d[i] = p->direction[i] + x * p->direction[4 + i] + y * p->direction[8 + i];
    }
    const int a = p->axis < 0 ? most_parallel(d) : p->axis;
    const int iu = a == 0 ? 2 : 0, iv = a == 1 ? 2 : 1;
    permute_axes(&sample->field.gradient_u, &sample->field.gradient_v, &sample->field.gradient_a, iu, iv, a);
    permute_axes(&sample->field.smoothing_u, &sample->field.smoothing_v, &sample->field.smoothing_a, iu, iv, a);
    permute_axes(&sample->segments.step_u, &sample->segments.step_v, &sample->segments.step_a, iu, iv, a);
    permute_axes(&sample->light.direction_u, &sample->light.direction_v, &sample->light.direction_a, iu, iv, a);
    permute_axes(&sample->light.half_u, &sample->light.half_v, &sample->light.half_a, iu, iv, a);
#ifdef DEPTH_CUED
    permute_axes(&sample->light.cue_u, &sample->light.cue_v, &sample->light.cue_a, iu, iv, a);
#endif
#ifdef LIGHT_VOLUME
    permute_light_volume(&sample->light.light_volume, iu, iv, a);
#endif
#ifdef SEVERAL_LIGHTS
    for (int i = 0; i < sample->light.more_lights; i++) {
        float *light = sample->light.lights + 8 * i, *half_way = light + 3;
        permute_axes(light, light + 1, light + 2, iu, iv, a);
        permute_axes(half_way, half_way + 1, half_way + 2, iu, iv, a);
    }
#endif
    const float d_a = SELECT_3(d, a), s_u = SELECT_3(d, iu) / d_a, s_v = SELECT_3(d, iv) / d_a;
    const float step_u = s_u * sample->segments.step_u, step_v = s_v * sample->segments.step_v, step_a = sample->segments.step_a;
    const VolumeView view = permuted_view(view_of_z, a);
    const int blocks_u[3] = {p->blocks[0], p->blocks[2], p->blocks[4]}, blocks_v[3] = {p->blocks[1], p->blocks[3], p->blocks[5]};
    const PixelRay ray = {view, a, d_a > 0.0f ? 1 : -1, SELECT_3(blocks_u, a), SELECT_3(blocks_v, a),
                          {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, SELECT_3(o, iu), SELECT_3(o, iv), SELECT_3(o, a), d_a, s_u, s_v,
                          sqrt(step_u * step_u + step_v * step_v + step_a * step_a)};
    return ray;
}

// Clip interval of a ray, in layers from o_a along it.
static inline Interval interval_in_layers(const DirectParams *p, const RayEnds *ends, const PixelRay *ray) {
    Interval interval = clip_rays(ends, ray->origin, ray->direction);
    const float layers = fabs(ray->d_a);
    interval.from *= layers, interval.to *= layers;
    return interval;
}
