// Layered splatting on a lattice for any view: splat_lattice.cl and splat_perspective.cl for GPUs.
//
// One work-item per sample of the lattice: VW is 1. The splat sums of the three layers that a sample mixes are reused from one layer to
// the next; the state of a ray fits in registers. Footprints are exact (splat_sum.cl), where splat_perspective.cl uses eight nodes. All
// else, including active_samples[tile], is as in those kernels.

// True of all layouts that lattices are rendered from.
#define ROWS_ALONG_U
#include "layered/splat_sum.cl"
#include "layered/splat_gradient.cl"
#include "layered/visible_group.cl"
#include "shared/sample.cl"

// A ray of the lattice where it crosses a layer.
struct SampleSource {
    __global const VOXEL *voxels;
    const VolumeView *view;
    float u, v, shear_u, shear_v;
    int k;
    SmoothedGradients smoothed;
};

// The splat sum at (u, v) of layer k, for the shear of the ray.
ALWAYS_INLINE float splat_sum(const struct SampleSource *s, float u, float v, int k) {
    return exact_splat_sum(s->voxels, s->view, k, u, v, s->shear_u, s->shear_v);
}

static inline LightVolume sample_light(const struct SampleSource *s) { return s->smoothed.shading->light; }

static inline Point sample_point(const struct SampleSource *s) {
    const Point point = {s->u, s->v, s->k};
    return point;
}

// The splatted central differences. One sum in a loop instead of six, which takes fewer registers.
static inline Gradient sample_gradient(const struct SampleSource *s) {
#if SPLATS_GRADIENTS
    float along_u = 0.0f, along_v = 0.0f, along_a = 0.0f;
#pragma unroll 1
    for (int n = 0; n < 6; n++) {
        const float sign = n & 1 ? -1.0f : 1.0f;
        const bool is_u = n < 2, is_v = n >> 1 == 1, is_a = n >> 1 == 2;
        const float part = 0.5f * sign * splat_sum(s, s->u + (is_u ? sign : 0.0f), s->v + (is_v ? sign : 0.0f),
                                                   s->k + (is_a ? (int)sign : 0));
        along_u += is_u ? part : 0.0f;
        along_v += is_v ? part : 0.0f;
        along_a += is_a ? part : 0.0f;
    }
    const Gradient gradient = {along_u, along_v, along_a};
    return gradient;
#else
    return smoothed_gradient(&s->smoothed, sample_point(s));
#endif
}

static inline bool is_visible_to_beam(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, const Beam *beam,
                                      int k) {
    const float2 reach = splat_reach(MAX(fabs(beam->shear.lo), fabs(beam->shear.hi)));
    const Window splatted = cells_crossed(beam, k - p->centre_layer, k - p->centre_layer, reach);
    return is_layer_visible(visible, p->blocks_u, p->blocks_v, view->dims_a - view->first_a, k - view->first_a, splatted);
}

// Renders the sample at a column and row. `layers` has a bit for each of `count` layers, starting with `first`. Returns the number of
// sub-layers with opacity.
ALWAYS_INLINE uint draw_sample(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                               __global const float4 *table, __global const float4 *slabs, const RayLatticeParams *p,
                               const SampleParams *sample, const RayEnds *ends, __local const uint *layers, int first, int count,
                               int column, int row, __global float4 *out) {
    const SampleRays rays = sample_rays(p, column, row);
    Accumulator gathered = p->continues ? load_raw(sample, out, 1, 1) : empty_accumulator(sample);
    Interval interval;
#ifdef CLIPPED
    interval = clip_sample_rays(p, ends, &rays);
#endif
    LayerSpan layer_span;
    layer_span.dt = length_per_layer(sample, &rays);
    struct SampleSource source = {voxels, view, 0.0f, 0.0f, rays.shear_u, rays.shear_v, 0,
                                  {shading, &sample->field}};
    const int step = p->layer_step;
    float before = 0.0f, own = 0.0f, after = 0.0f;
    int sums_layer = INT_MIN; // layer of the current sums
    int active = 0;
    bool open = !p->continues || any_open(sample, &gathered);
    for (int word = 0; 32 * word < count && open; word++) {
        for (uint left = visible_word(layers, word, count); left && open; left &= left - 1) {
            const int k = first + lowest_in_word(word, left) * step;
            const float depth = k - p->centre_layer;
            source.u = rays.centre_u + depth * rays.shear_u, source.v = rays.centre_v + depth * rays.shear_v, source.k = k;
#ifdef CLIPPED
            layer_span.interval.from = interval.from - step * depth, layer_span.interval.to = interval.to - step * depth;
#endif
            // All three sums in one loop, or only the last if the others are known.
            for (int l = sums_layer == k - step ? k + step : k - step;; l += step) {
                before = own, own = after;
                // Computed from the layer alone: the bits must not depend on which layers were skipped, or on where a part of a volume
                // begins.
                const float to_layer = l - p->centre_layer;
                after = splat_sum(&source, rays.centre_u + to_layer * rays.shear_u, rays.centre_v + to_layer * rays.shear_v, l);
                if (l == k + step)
                    break;
            }
            sums_layer = k;
            int first_slab, slab_count;
            layer_slabs(sample, step > 0 ? k + 1 : view->dims_a - k, view->dims_a + 2, &first_slab, &slab_count);
            accumulate_layer(sample, slabs, first_slab, slab_count, table, before, own, after, &layer_span, &source, &gathered, &active);
            open = any_open(sample, &gathered);
        }
    }
    uint total = active;
    STORE_RAYS(*p, *sample, table, &gathered, &interval, 1, 1, out, total)
    return total;
}

__attribute__((reqd_work_group_size(SAMPLE_COLUMNS * SAMPLE_ROWS, 1, 1)))
__kernel void splat_samples(SHADED_FIELD, __global const uchar *visible, __global const float4 *table, __global const float4 *slabs,
                            RayLatticeParams p, SampleParams sample, RayEnds ray_ends, OUTPUT, ulong first_item) {
    __local uint active, layers[WORDS_LOOKED_UP];
    const int tile = FIRST_GROUP + get_group_id(0);
    if (tile >= p.tiles_u * p.tiles_v)
        return;
    const int lowest = max(p.first_layer, -1), highest = min(p.last_layer, view.dims_a);
    const int first = p.layer_step > 0 ? lowest : highest, count = highest - lowest + 1;
    find_visible(visible, &p, &view, tile, first, count, layers);
    const int2 place = work_item_sample(tile, p.tiles_u);
    uint own = 0;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    if (place.x < p.width && place.y < p.height)
        own = draw_sample(voxels, &view, &shading, table, slabs, &p, &sample, &ray_ends, layers, first, count, place.x, place.y,
                          target + (size_t)place.y * p.width + place.x);
    count_tile(own, &active, active_samples + tile);
}
