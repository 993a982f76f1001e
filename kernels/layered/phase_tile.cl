// A tile of consecutive samples of a parallel view in patches: its splat sums and its samples (splat_stencil.cl).
//
// The work-item of a tile keeps the splat sums of three layers, in patches that can be visible, and computes gradients in visible patches
// only.

#include "layered/splat_stencil.cl"
#include "layered/splat_gradient.cl"
#include "layered/visible_layers.cl"
#include "shared/sample.cl"

// Splat sums of a layer under a tile.
typedef struct {
    int index, summed; // layer, and patches with a known sum
    realv sums[TILE_ROWS];
} SplatLayer;

// Computes the missing ones of some patches of a layer: all bands from the first to the last that lacks one.
static inline void ensure_sums(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile,
                               int patches, int k, SplatLayer *layer) {
    if (layer->index != k)
        layer->index = k, layer->summed = 0;
    patches &= ~layer->summed;
    if (!patches)
        return;
    layer->summed |= patches;
    splat_bands(voxels, view, p, tile, LOWEST_BIT(patches) / PATCH_ROWS, HIGHEST_BIT(patches) / PATCH_ROWS, k, (Step){0, 0, 0},
                layer->sums);
}

// Differences of splat sums along the axes, in patches.
typedef struct {
    realv along_u[TILE_ROWS], along_v[TILE_ROWS], along_a[TILE_ROWS];
} SplatSlopes;

static inline void splat_slopes(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile,
                                int patches, int k, SplatSlopes *slopes) {
    const int first = LOWEST_BIT(patches) / PATCH_ROWS, last = HIGHEST_BIT(patches) / PATCH_ROWS;
    splat_bands(voxels, view, p, tile, first, last, k, (Step){1, 0, 0}, slopes->along_u);
    splat_bands(voxels, view, p, tile, first, last, k, (Step){0, 1, 0}, slopes->along_v);
    splat_bands(voxels, view, p, tile, first, last, k, (Step){0, 0, 1}, slopes->along_a);
}

// Differences of splat sums, or the source of smoothed gradients, at the samples of a patch.
struct SampleSource {
    const SplatSlopes *slopes;
    int patch;
    Point point;
    SmoothedGradients smoothed;
};

static inline LightVolume sample_light(const struct SampleSource *s) { return s->smoothed.shading->light; }

static inline Point sample_point(const struct SampleSource *s) { return s->point; }

// Exactly the splatted central differences.
static inline Gradient sample_gradient(const struct SampleSource *s) {
#if SPLATS_GRADIENTS
    const Gradient gradient = {0.5f * s->slopes->along_u[s->patch], 0.5f * s->slopes->along_v[s->patch],
                               0.5f * s->slopes->along_a[s->patch]};
    return gradient;
#else
    return smoothed_gradient(&s->smoothed, s->point);
#endif
}

// Positions of the samples of a patch in layer k.
static inline Point patch_points(const SplatLatticeParams *p, const PhaseTile *tile, int patch, int k) {
    intv below;
    realv fraction;
    column_offsets(p, tile, k + 1, &below, &fraction);
    realv u[PATCH_ROWS], v[PATCH_ROWS];
    for (int i = 0; i < PATCH_ROWS; i++) {
        const LayerOffset offset = row_offset(p, tile, k + 1, patch / PATCH_ROWS * PATCH_ROWS + i);
        u[i] = CONVERT_REALV(below) + fraction, v[i] = (realv)(offset.base + offset.fraction);
    }
    regroup(u), regroup(v);
    const Point point = {u[patch % PATCH_ROWS], v[patch % PATCH_ROWS], (realv)(k)};
    return point;
}

// Lanes of a patch that have a ray: none beyond the lattice.
static inline intv lanes_with_rays(const PhaseTile *tile, int patch) {
    return patch_columns(patch) < tile->columns && patch_sample_rows(patch) < tile->rows;
}

#ifdef CLIPPED
// Clip interval of the samples of a patch, in layers from the first one along the rays.
static inline Interval clip_patch(const VolumeView *view, const SplatLatticeParams *p, const RayEnds *ends, const PhaseTile *tile,
                                  int patch) {
    const float first = p->layer_step > 0 ? -1.0f : view->dims_a, layers = first + 1.0f;
    const Point point = patch_points(p, tile, patch, -1);
    const realv origin[3] = {point.u + layers * p->shear_u, point.v + layers * p->shear_v, (realv)(first)};
    const realv direction[3] = {(realv)(p->layer_step * p->shear_u), (realv)(p->layer_step * p->shear_v), (realv)(p->layer_step)};
    return clip_rays(ends, origin, direction);
}
#endif

// Rays of a tile, from layer -1.
static inline Beam phase_beam(const SplatLatticeParams *p, const PhaseTile *tile) {
    __global const LayerOffset *first_u = tile->offsets_u + tile->phase_u, *last_u = first_u + tile->columns - 1;
    const LayerOffset first_v = row_offset(p, tile, 0, 0), last_v = row_offset(p, tile, 0, tile->rows - 1);
    const float4 crossing = {tile->voxel_u + first_u->base + first_u->fraction, first_v.base + first_v.fraction,
                             tile->voxel_u + last_u->base + last_u->fraction, last_v.base + last_v.fraction};
    const Beam beam = {crossing, (float4)(p->shear_u, p->shear_v, p->shear_u, p->shear_v)};
    return beam;
}

// Patches in some rows of a tile, from the first to the last.
static inline int patches_in_rows(int2 rows) {
    return rows.x > rows.y ? 0 : LOW_BITS(rows.y / PATCH_ROWS * PATCH_ROWS + PATCH_ROWS) & ~LOW_BITS(rows.x / PATCH_ROWS * PATCH_ROWS);
}

// The subset of patches that further samples can still change.
static inline int open_patches(const SampleParams *p, const PhaseTile *tile, const Accumulator *gathered, int patches) {
    int open = 0;
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        open |= (ANY(lanes_with_rays(tile, n) && open_rays(p, &gathered[n])) ? 1 : 0) << n;
    }
    return open;
}

// The subset of patches in which any sample of a layer can be visible.
static inline int contributing_patches(const SampleParams *p, const SplatLayer *before, const SplatLayer *own, const SplatLayer *after,
                                       int patches) {
    int shown = 0;
    for (int left = patches; left; left &= left - 1) {
        const int n = LOWEST_BIT(left);
        shown |= (layer_may_contribute(p, before->sums[n], own->sums[n], after->sums[n]) ? 1 : 0) << n;
    }
    return shown;
}
