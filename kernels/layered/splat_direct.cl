// Layered splatting per screen pixel: each pixel gathers the voxels whose footprints cover it. Draws views with evaluation per pixel, which
// alone has the paper's set of footprints, and those of a forced layer axis that no lattice covers. Other views without a lattice are cast
// (raycast.cl). Tests compare lattices with it.
//
// One work-item per pixel, row by row; VW is 1. FOOTPRINT_SET: weights are interpolated bilinearly in the image of the nearest direction
// (footprint_set.cl); |s| <= 1. Splat sums are divided by the sum of weights, which is near 1, so that constant fields stay exact.
// Otherwise footprints are exact (splat_sum.cl).

#include "layered/pixel_ray.cl"
#include "layered/splat_sum.cl"
#include "layered/splat_gradient.cl"
#include "layered/visible_cells.cl"
#include "shared/sample.cl"

#ifdef FOOTPRINT_SET
// Mirrors layers/footprint_set.rs: 28 rows of equal angle in v; 30 columns, 31 in the 16 middle rows.
static inline int nearest_image(float s_u, float s_v) {
    const int row = clamp((int)((atanpi(s_v) * 2.0f + 0.5f) * 28.0f), 0, 27);
    const int columns = row >= 6 && row < 22 ? 31 : 30;
    return row * 30 + clamp(row - 6, 0, 16) + clamp((int)((atanpi(s_u) * 2.0f + 0.5f) * columns), 0, columns - 1);
}

static inline float texel(__global const uchar *image, int column, int row) {
    return column < 0 || column > 63 || row < 0 || row > 63 ? 0.0f : convert_float(image[row * 64 + column]);
}

static inline float footprint_from_set(__global const uchar *image, float2 shear, float x, float y) {
    const float column = (x / (1.0f + fabs(shear.x)) + 1.0f) * 32.0f - 0.5f;
    const float row = (y / (1.0f + fabs(shear.y)) + 1.0f) * 32.0f - 0.5f;
    const float i = floor(column), j = floor(row), a = column - i, b = row - j;
    const float top = mix(texel(image, i, j), texel(image, i + 1, j), a);
    return mix(top, mix(texel(image, i, j + 1), texel(image, i + 1, j + 1), a), b) * (1.0f / 255.0f);
}

static inline float splat_sum(__global const VOXEL *voxels, const VolumeView *view, __global const uchar *images,
                              __global const float2 *shears, int k, float u, float v, float s_u, float s_v) {
    if (IS_OUTSIDE(k, view))
        return view->background;
    const int index = nearest_image(s_u, s_v), i0 = floor(u), j0 = floor(v);
    __global const uchar *image = images + index * 64 * 64;
    float sum = 0.0f, weights = 0.0f;
    for (int j = j0 - 1; j <= j0 + 2; j++)
        for (int i = i0 - 1; i <= i0 + 2; i++) {
            const float weight = footprint_from_set(image, shears[index], u - i, v - j);
            sum += (voxel_at(voxels, view, i, j, k) - view->background) * weight;
            weights += weight;
        }
    return view->background + sum / weights;
}
#else
static inline float splat_sum(__global const VOXEL *voxels, const VolumeView *view, __global const uchar *images,
                              __global const float2 *shears, int k, float u, float v, float s_u, float s_v) {
    return exact_splat_sum(voxels, view, k, u, v, s_u, s_v);
}
#endif

struct SampleSource {
    __global const VOXEL *voxels;
    const VolumeView *view;
    __global const uchar *images;
    __global const float2 *shears;
    int k;
    float u, v, s_u, s_v;
    SmoothedGradients smoothed;
};

// Splat sum of layer k + dk, with the voxels shifted to the positions in layer k.
static inline float shifted_sum(const struct SampleSource *s, float du, float dv, int dk) {
    return splat_sum(s->voxels, s->view, s->images, s->shears, s->k + dk, s->u + du, s->v + dv, s->s_u, s->s_v);
}

static inline LightVolume sample_light(const struct SampleSource *s) { return s->smoothed.shading->light; }

static inline Point sample_point(const struct SampleSource *s) {
    const Point point = {s->u, s->v, s->k};
    return point;
}

static inline Gradient sample_gradient(const struct SampleSource *s) {
#if SPLATS_GRADIENTS
    const Gradient gradient = {0.5f * (shifted_sum(s, 1.0f, 0.0f, 0) - shifted_sum(s, -1.0f, 0.0f, 0)),
                               0.5f * (shifted_sum(s, 0.0f, 1.0f, 0) - shifted_sum(s, 0.0f, -1.0f, 0)),
                               0.5f * (shifted_sum(s, 0.0f, 0.0f, 1) - shifted_sum(s, 0.0f, 0.0f, -1))};
    return gradient;
#else
    return smoothed_gradient(&s->smoothed, sample_point(s));
#endif
}

__kernel void splat_direct(PIXEL_FIELD, __global const float4 *table, __global const float4 *slabs, __global const uchar *images,
                           __global const float2 *shears, ulong first_item) {
    const size_t pixel = first_item + get_global_id(0);
    if (pixel >= (size_t)p.width * p.height)
        return;
    SampleParams sample;
    const PixelRay ray = make_pixel_ray(&p, pixel % p.width + 0.5f, pixel / p.width + 0.5f, &view_of_z, &sample_of_z, &sample);
    const VolumeView view = ray.view;
    voxels += view.first;
    const VolumeView gradient_view = permuted_view(&gradient_view_of_z, ray.axis);
    const ShadingSource shading = SHADING_SOURCE;
    __global const uchar *visible = ray.axis == 0 ? visible_x : ray.axis == 1 ? visible_y : visible_z;
    const float s_u = ray.s_u, s_v = ray.s_v;
    const int layer_step = ray.layer_step;
    const int layers = view.dims_a + 2;
    const float2 reach = splat_reach((float2)(s_u, s_v));

    Accumulator gathered = empty_accumulator(&sample);
    Interval interval;
#ifdef CLIPPED
    interval = interval_in_layers(&p, &ray_ends, &ray);
#endif
    int active = 0;
    float before = 0.0f, own = 0.0f, after = 0.0f;
    int sums_layer = INT_MIN; // layer of the current sums
    for (int n = 0; n < layers; n++) {
        const int k = layer_step > 0 ? n - 1 : view.dims_a - n;
        const float depth = k - ray.o_a;
#ifdef CLIPPED
        LayerSpan layer_span = {ray.dt, {interval.from - layer_step * depth, interval.to - layer_step * depth}};
        if (layer_span.interval.from >= 0.5f || layer_span.interval.to <= -0.5f)
            continue;
#else
        const LayerSpan layer_span = {ray.dt};
#endif
        const float u = ray.o_u + depth * s_u, v = ray.o_v + depth * s_v;
        if (u < -1.0f - reach.x || u > view.dims_u + reach.x || v < -1.0f - reach.y || v > view.dims_v + reach.y)
            continue;
        const Window splatted = cells_between((float2)(u, v) - reach, (float2)(u, v) + reach);
        if (p.culling && !is_layer_visible(visible, ray.blocks_u, ray.blocks_v, view.dims_a, k, splatted))
            continue;
        // All three sums, or only the last if the others are known.
        for (int l = sums_layer == k - layer_step ? k + layer_step : k - layer_step;; l += layer_step) {
            before = own, own = after;
            after = splat_sum(voxels, &view, images, shears, l, u + (l - k) * s_u, v + (l - k) * s_v, s_u, s_v);
            if (l == k + layer_step)
                break;
        }
        sums_layer = k;
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        const struct SampleSource source = {voxels, &view, images, shears, k, u, v, s_u, s_v,
                                             {&shading, &sample.field}};
        accumulate_layer(&sample, slabs, first, count, table, before, own, after, &layer_span, &source, &gathered, &active);
        if (!any_open(&sample, &gathered))
            break;
    }
    float color[4];
    resolve(&sample, table, &gathered, &interval, color);
    store_colors(color, 1, 1, target + pixel);
    active_samples[pixel] = active;
}
