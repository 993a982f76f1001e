// A tile of lattice samples of one phase of a parallel view: its splat sums, its samples, and where they are (splat_stencil.cl).
//
// The work-item of a tile keeps the splat sums of three layers, in rows that can be visible, and computes gradients in visible rows only.

#include "layered/splat_stencil.cl"
#include "layered/splat_gradient.cl"
#include "layered/visible_layers.cl"
#include "shared/sample.cl"
#include "shared/bit_sets.cl"

// A tile of one phase: the offsets of the phase in all layers, its weights, and the first sample.
typedef struct {
    __global const LayerOffset *offsets_u, *offsets_v;
    __global const float *weights;
    int phase_u, phase_v, column, row;
} PhaseTile;

// Splat sums of layer k, or of differences, in `rows` rows of a tile starting with row `first`.
static inline void splat_tile(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile,
                              int first, int rows, int k, Step step, float *sums) {
    const int index = clamp(k, -1, view->dims_a) + 1;
    const size_t phase = ((size_t)index * p->per_voxel_v + tile->phase_v) * p->per_voxel_u + tile->phase_u;
    splat_rows(voxels, view, p, tile->offsets_u[index * p->per_voxel_u + tile->phase_u],
               tile->offsets_v[index * p->per_voxel_v + tile->phase_v], tile->weights + phase * 16, tile->column, tile->row + first, rows,
               k, step, sums);
}

// Splat sums of a layer in the rows of a tile, with one more on each side.
#define SUM_ROWS (TILE_ROWS + 2)
typedef struct {
    int index, first, last; // layer, and range of rows within -1 ... TILE_ROWS
    float sums[SUM_ROWS * TILE_COLUMNS];
} SplatLayer;

#define SUM_ROW(layer, row) ((layer)->sums + ((row) + 1) * TILE_COLUMNS)

// Computes rows of a layer unless they are present.
static inline void ensure_rows(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile,
                               int first, int last, int k, SplatLayer *layer) {
    if (layer->index == k && first >= layer->first && last <= layer->last)
        return;
    layer->index = k, layer->first = first, layer->last = last;
    splat_tile(voxels, view, p, tile, first, last - first + 1, k, (Step){0, 0}, SUM_ROW(layer, first));
}

// Splat sums at the current samples, with neighbours one row apart, and of differences along u and the layer axis.
struct SampleSource {
    const float *own, *along_u, *across;
    Point point;
    SmoothedGradients smoothed;
};

static inline LightVolume sample_light(const struct SampleSource *s) { return s->smoothed.shading->light; }

static inline Point sample_point(const struct SampleSource *s) { return s->point; }

// Exactly the splatted central differences.
static inline Gradient sample_gradient(const struct SampleSource *s) {
#if SPLATS_GRADIENTS
    const Gradient gradient = {0.5f * LOADV(s->along_u), 0.5f * (LOADV(s->own + TILE_COLUMNS) - LOADV(s->own - TILE_COLUMNS)),
                               0.5f * LOADV(s->across)};
    return gradient;
#else
    return smoothed_gradient(&s->smoothed, s->point);
#endif
}

// Positions of VW samples of a tile in layer k, starting at (column, row) of the tile.
static inline Point phase_points(const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile, int column, int row, int k) {
    const LayerOffset u = tile->offsets_u[(k + 1) * p->per_voxel_u + tile->phase_u];
    const LayerOffset v = tile->offsets_v[(k + 1) * p->per_voxel_v + tile->phase_v];
    const Point point = {CONVERT_REALV(LANES + (u.base + tile->column + column)) + u.fraction,
                         (realv)(v.base + tile->row + row + v.fraction), (realv)(k)};
    return point;
}

#ifdef CLIPPED
// Clip interval of VW samples starting at (column, row), in layers from the first one along the rays. `u`, `v`: offsets of the phase in
// layer -1.
static inline Interval clip_phase_samples(const VolumeView *view, const SplatLatticeParams *p, const Clipping *clip, LayerOffset u,
                                          LayerOffset v, int column, int row) {
    const float first = p->layer_step > 0 ? -1.0f : view->dims_a, layers = first + 1.0f;
    const realv origin[3] = {CONVERT_REALV(LANES + (u.base + column)) + (u.fraction + layers * p->shear_u),
                             (realv)(v.base + row + (v.fraction + layers * p->shear_v)), (realv)(first)};
    const realv direction[3] = {(realv)(p->layer_step * p->shear_u), (realv)(p->layer_step * p->shear_v), (realv)(p->layer_step)};
    return clip_rays(clip, origin, direction, -INFINITY);
}
#endif

// The subset of rows that further samples can still change.
static inline int open_rows(const SampleParams *p, const Accumulator *gathered, int rows, int columns) {
    int open = 0;
    for (int left = rows; left; left &= left - 1) {
        const int r = LOWEST_BIT(left);
        bool any = false;
        for (int c = 0; c < TILE_VECTORS; c++)
            any = any || any_open_lanes(p, &gathered[r * TILE_VECTORS + c], columns - c * VW);
        open |= any << r;
    }
    return open;
}

// Index, in the lattice, of a sample of a phase.
static inline size_t lattice_index(const SplatLatticeParams *p, int phase_u, int phase_v, int column, int row) {
    return ((size_t)row * p->per_voxel_v + phase_v) * (p->columns_u * p->per_voxel_u) + (size_t)column * p->per_voxel_u + phase_u;
}
