// Layered rendering with point-sampled layers of a volume of colours, on a lattice for any view. What is said about tiles, segments and
// clipping in point_lattice.cl applies here.
//
// Four fields are interpolated, by kernels without negative weights: extinction times colour (red, green, blue), and extinction. Their ratio
// is the colour, so that transparent voxels do not bleed theirs. All four are linear between two samples. Lighting follows the gradient of
// the extinction.
//
// LABELS: the opacity is found after interpolation (label_segment.cl).

#include "layered/point_tile.cl"
#include "shared/color_absorption.cl"

#if BLEND != COMPOSITE
#error "BLEND: volumes of colours are composited"
#endif

// The fields, and their samples in a tile.
typedef struct {
    __global const VOXEL *voxels[FIELDS];
    Layer layers[2][FIELDS];
} Fields;

// Sub-layer l of a field, with samples in some patches.
static inline Layer *sampled_layer(Fields *fields, int field, const VolumeView *view, const RayLatticeParams *p, const Tile *tile, int s,
                                   int l, int patches) {
    Layer *layer = &fields->layers[l & 1][field];
    if (layer->index != l || patches & ~layer->sampled)
        sample_layer(fields->voxels[field], view, p->centre_layer, s, l, tile, patches, layer);
    return layer;
}

#ifdef LABELS
#include "layered/label_segment.cl"
#define COMPOSITE_SEGMENT composite_labels
#else
#include "layered/color_segment.cl"
#define COMPOSITE_SEGMENT composite_colors
#endif

__kernel void color_lattice(COLOR_FIELDS, __global const int *shown_slabs, RayLatticeParams p, ulong first_item) {
    const int order = first_item + get_global_id(0);
    if (order >= p.tiles_u * p.tiles_v)
        return;
    const int id = scheduled_tile(&p, order);
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const Tile tile = make_tile(&p, id);
    Fields fields = {FIELD_VOXELS};
    for (int i = 0; i < FIELDS; i++)
        fields.layers[0][i].index = fields.layers[1][i].index = INT_MIN;
    Accumulator gathered[TILE_ROWS];
    Interval intervals[TILE_ROWS];
    intv has_ray[TILE_ROWS];
    realv lengths[TILE_ROWS];
    intv active = 0;
    const int patches = tile.bands * PATCH_ROWS;
    int open = 0; // patches that further samples can change
    for (int n = 0; n < patches; n++) {
        const SampleRays rays = patch_rays(&p, &tile, n);
        gathered[n] = empty_accumulator(&sample);
        has_ray[n] = lanes_with_rays(&p, &tile, n);
        lengths[n] = length_per_layer(&sample, &rays);
#ifdef CLIPPED
        intervals[n] = clip_sample_rays(&p, &ray_ends, &rays);
#endif
        open |= (ANY(has_ray[n]) ? 1 : 0) << n;
    }
#ifdef CUT_RAYS
    cut_intervals(&p, &tile, cuts, intervals);
#endif
#ifdef CLIPPED
    const TileBounds bounds = tile_bounds(intervals, patches);
#ifdef CUT_RAYS
    // Nothing reads these samples.
    if (bounds.from >= bounds.to) {
        active_samples[id] = 0;
        return;
    }
#endif
#endif

    const int s = SAMPLES_PER_LAYER(&sample), enters = p.layer_step > 0 ? 0 : 1;
    int lowest = p.first_layer, highest = p.last_layer;
    if (p.culling)
        lowest = max(lowest, shown_slabs[0] + view.first_a), highest = min(highest, shown_slabs[1] + view.first_a);
    Chunk chunk = {-1, 0};
    for (int passed = 0; passed <= highest - lowest && open; passed++) {
        const int q = enters ? highest - passed : lowest + passed;
#ifdef CLIPPED
        const int within = patches_in_slab(&bounds, patches, p.layer_step * (q - RADIUS + enters - p.centre_layer));
        if (!within)
            continue;
#endif
        int over = LOW_BITS(patches);
        const int skip =
            p.culling ? slabs_to_skip(visible, &p, view.first_a, &tile, q, enters ? lowest : highest, enters, &chunk, &over) : 0;
        if (skip) {
            passed += skip - 1;
            continue;
        }
#ifdef CUT_RAYS
        over &= within;
        if (!(open & over))
            continue;
#endif
        for (int i = 0; i < s; i++) {
            const int l0 = enters ? (q + 1) * s - i : q * s + i, l1 = l0 + p.layer_step;
            Layer *front = sampled_layer(&fields, SHADED, &view, &p, &tile, s, l0, over);
            Layer *behind = sampled_layer(&fields, SHADED, &view, &p, &tile, s, l1, over);
            int shown = open & over;
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_BIT(left);
                if (!ANY(is_visible_between(&sample, front->at.field[n], behind->at.field[n])))
                    shown &= ~(1 << n);
            }
            if (!shown)
                continue;
            for (int field = 0; field < FIELDS; field++) {
                if (field == SHADED || (field == SMOOTHED_OPACITY && !sample.light.shading))
                    continue;
                const VolumeView *own = field == SMOOTHED_OPACITY ? shading.view : &view;
                sampled_layer(&fields, field, own, &p, &tile, s, l0, over);
                sampled_layer(&fields, field, own, &p, &tile, s, l1, over);
            }
            if (sample.light.shading) {
                light_layer(&shading, &p, &sample, &tile, s, shown, front);
                light_layer(&shading, &p, &sample, &tile, s, shown, behind);
            }
            const float2 ends = end_weights(&sample, l0, l1);
            for (int left = shown; left; left &= left - 1) {
                const int n = LOWEST_BIT(left);
                Part part;
#ifdef CLIPPED
                const float enters_at = p.layer_step * ((float)l0 / s - RADIUS - p.centre_layer);
                part = part_of(&intervals[n], (realv)(enters_at), (realv)(enters_at + 1.0f / s));
#endif
                intv counts = 0;
                COMPOSITE_SEGMENT(&sample, &labels, fields.layers[l0 & 1], fields.layers[l1 & 1], n, &part, ends,
                                  CLIPPED_LENGTH(lengths[n], &part), &gathered[n], &counts);
                active += counts & has_ray[n];
                if (!ANY(has_ray[n] && open_rays(&sample, &gathered[n])))
                    open &= ~(1 << n);
            }
        }
    }

    regroup_all((realv *)gathered, RAW_FLOATS, tile.bands);
    uint total = sum_lanes(active, VW);
    for (int r = 0; r < tile.rows; r++) {
        realv color[4];
        resolve(&sample, 0, &gathered[r], &intervals[r], color);
        STORE_ROW_COLORS(&p, color, target, &tile, r);
    }
    active_samples[id] = total;
}
