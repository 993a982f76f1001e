// What the kernels of point-sampled layers do for a tile (point_lattice.cl, channel_lattice.cl): its clip intervals, voxels fetched ahead,
// and the spans and midpoints of its patches.

#include "layered/point_layer.cl"
#include "layered/visible_tile.cl"
#include "shared/segment.cl"

#ifdef CLIPPED
// Union of the clip intervals of a tile. CUT_RAYS: also that of each patch.
typedef struct {
    float from, to;
#ifdef CUT_RAYS
    float patches_from[TILE_ROWS], patches_to[TILE_ROWS];
#endif
} TileBounds;

static inline TileBounds tile_bounds(const Interval *intervals, int patches) {
    TileBounds bounds = {INFINITY, -INFINITY};
    for (int n = 0; n < patches; n++) {
        const intv hit = intervals[n].from < intervals[n].to;
        const float from = smallest_lane(hit ? intervals[n].from : (realv)(INFINITY));
        const float to = largest_lane(hit ? intervals[n].to : (realv)(-INFINITY));
        bounds.from = MIN(bounds.from, from), bounds.to = MAX(bounds.to, to);
#ifdef CUT_RAYS
        bounds.patches_from[n] = from, bounds.patches_to[n] = to;
#endif
    }
    return bounds;
}

// Patches that can have rays in the slab that begins at a position along rays.
static inline int patches_in_slab(const TileBounds *bounds, int patches, float entry) {
    if (entry >= bounds->to || entry + 1.0f <= bounds->from)
        return 0;
    int within = LOW_BITS(patches);
#ifdef CUT_RAYS
    for (int n = 0; n < patches; n++)
        within &= entry >= bounds->patches_to[n] || entry + 1.0f <= bounds->patches_from[n] ? ~(1 << n) : -1;
#endif
    return within;
}
#endif

#ifdef CUT_RAYS
// Cuts the intervals of the patches of a tile to the parts of its rays that are to be drawn.
static inline void cut_intervals(const RayLatticeParams *p, const Tile *tile, __global const float2 *cuts, Interval *intervals) {
    Interval rows[TILE_ROWS];
    for (int r = 0; r < tile->bands * PATCH_ROWS; r++) {
        rows[r].from = INFINITY, rows[r].to = -INFINITY;
        if (r >= tile->rows)
            continue;
        const intv at = samples_of_row(p, tile, r), present = LANES_IN_ROW(p, tile, r);
        for (int i = 0; i < VW; i++)
            if (((const int *)&present)[i]) {
                const float2 cut = cuts[((const int *)&at)[i]];
                ((float *)&rows[r].from)[i] = cut.x, ((float *)&rows[r].to)[i] = cut.y;
            }
    }
    regroup_all((realv *)rows, sizeof(Interval) / sizeof(realv), tile->bands);
    for (int n = 0; n < tile->bands * PATCH_ROWS; n++)
        intervals[n].from = MAX(intervals[n].from, rows[n].from), intervals[n].to = MIN(intervals[n].to, rows[n].to);
}
#endif

// Bytes of a cache line.
#define LINE 64

// Prefetches the voxels of a layer under a tile, for the slab after the next: layers wait for memory. In a part of a volume the layer may
// be missing; such a prefetch has no effect.
static inline void fetch_ahead(__global const VOXEL *voxels, const VolumeView *view, const RayLatticeParams *p, const Tile *tile, int k) {
    if (k < 0 || k >= view->dims_a)
        return;
    const Window w = cells_crossed(&tile->beam, k - p->centre_layer, k - p->centre_layer, 0.0f);
    const int first_u = clamp(w.x - 1, 0, view->dims_u - 1), last_u = clamp(w.z + 2, 0, view->dims_u - 1);
    const int first = max(w.y - 1, 0), last = min(w.w + 2, view->dims_v - 1);
    __global const VOXEL *row = voxels + (k - view->first_a) * view->stride_a + first * view->stride_v;
    // If rows are whole cache lines apart, their voxels are all in one line each, or all in two.
    const bool in_one = view->stride_v * sizeof(VOXEL) % LINE == 0 && (ulong)(row + first_u) / LINE == (ulong)(row + last_u) / LINE;
    for (int j = first; j <= last; j++, row += view->stride_v) {
        PREFETCH(row + first_u);
        if (!in_one)
            PREFETCH(row + last_u);
    }
}

// The span of a patch's rays that starts in plane k.
static inline RaySpan patch_span(const RayLatticeParams *p, const Tile *tile, int patch, float k, float step, realv from, realv to) {
    const SampleRays rays = patch_rays(p, tile, patch);
    return span_at_plane(rays.centre_u, rays.shear_u, rays.centre_v, rays.shear_v, p->centre_layer, k, step, from, to);
}

#if ANALYTIC_GRADIENTS && LIT_AT_ENDS
// Computes the samples in the middle between two planes, for some patches.
static inline void find_middle(const RayLatticeParams *p, const SampleParams *sample, LightVolume volume,
                               __global const int4 *integrals, const Tile *tile, float k, float step, int patches,
                               const Samples *const *ends, Samples *middle) {
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        const RaySpan span = patch_span(p, tile, n, k, step, ends[0]->field[n], ends[1]->field[n]);
        const intv contributes = contributes_between(sample, integrals, span.from, span.to);
        middle->lit[n] = light_midpoint(sample, volume, &span, contributes, &ends[0]->lit[n], &ends[1]->lit[n], &middle->field[n]);
    }
}
#endif
