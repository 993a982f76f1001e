// Layered splatting on the sheared lattice of a parallel view: splat, correct, classify, shade, composite.
//
// One work-item per tile: TILE_COLUMNS x TILE_ROWS lattice samples of one phase (p, q), one sample per voxel column and row, from the
// first layer to the last (splat_stencil.cl). It keeps the splat sums of three layers, in rows that can be visible, and computes
// gradients in visible rows only.
//
// Work-item id: ((tile_v*tiles_u + tile_u)*per_voxel_v + q)*per_voxel_u + p. The phases of a tile are consecutive and share its voxels in
// the cache. lattice[(j*per_voxel_v + q)*width + i*per_voxel_u + p] = RGBA.

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

__kernel void splat_lattice(__global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels,
                            VolumeView gradient_view, __global const uchar *light, __global const uchar *sky,
                            __global const LayerOffset *offsets_u, __global const LayerOffset *offsets_v, __global const float *weights,
                            __global const uchar *visible, __global const float4 *table, __global const float4 *slabs, SplatLatticeParams p,
                            SampleParams sample, Clipping clip, __global float4 *lattice, __global uint *active_samples, ulong first_item) {
    int id = first_item + get_global_id(0);
    if (id >= p.per_voxel_u * p.per_voxel_v * p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const ShadingSource shading = SHADING_SOURCE;
    const int tile = id;
    const int phase_u = id % p.per_voxel_u;
    id /= p.per_voxel_u;
    const int phase_v = id % p.per_voxel_v;
    id /= p.per_voxel_v;
    const int column = id % p.tiles_u * TILE_COLUMNS, row = id / p.tiles_u * TILE_ROWS;
    const int rows = min(TILE_ROWS, p.columns_v - row), columns = min(TILE_COLUMNS, p.columns_u - column);
    const PhaseTile place = {offsets_u, offsets_v, weights, phase_u, phase_v, column, row};

    SplatLayer ring[3];
    for (int i = 0; i < 3; i++)
        ring[i].index = INT_MIN;
    float along_u[TILE_ROWS * TILE_COLUMNS], across[TILE_ROWS * TILE_COLUMNS];
    Accumulator gathered[TILE_ROWS * TILE_VECTORS];
    Interval intervals[TILE_ROWS * TILE_VECTORS];
    intv active[TILE_VECTORS];
    for (int i = 0; i < TILE_ROWS * TILE_VECTORS; i++) {
        const int c = i % TILE_VECTORS * VW, r = i / TILE_VECTORS;
        gathered[i] = p.continues && r < rows && c < columns
                          ? load_raw(&sample, lattice + lattice_index(&p, phase_u, phase_v, column + c, row + r), min(VW, columns - c),
                                     p.per_voxel_u)
                          : empty_accumulator(&sample);
#ifdef CLIPPED
        intervals[i] = clip_phase_samples(&view, &p, &clip, offsets_u[phase_u], offsets_v[phase_v], column + i % TILE_VECTORS * VW,
                                          row + i / TILE_VECTORS);
#endif
    }
    for (int c = 0; c < TILE_VECTORS; c++)
        active[c] = 0;

#ifdef PER_RAY_STEP
    const realv sample_length = length(
        (float3)(p.shear_u * sample.segments.step_u, p.shear_v * sample.segments.step_v, sample.segments.step_a));
#else
    const realv sample_length = 0.0f; // included in the table
#endif
    const int border = GATHERS_VALUES ? 0 : SPLATS_GRADIENTS ? sample.light.shading : 0, layers = view.dims_a + 2;
    // Offsets begin with layer -1.
    const float2 crossing = (float2)(offsets_u[phase_u].base + column, offsets_v[phase_v].base + row) +
                            (float2)(offsets_u[phase_u].fraction, offsets_v[phase_v].fraction);
    const float2 shear = {p.shear_u, p.shear_v}, reach = splat_reach(shear);
    const Beam beam = {(float4)(crossing, crossing + (float2)(columns - 1, rows - 1)), (float4)(shear, shear)};
    const int last_slab = min(p.last_layer + 1, view.dims_a) - view.first_a; // a part of a volume may lack further slabs
    LayerChunk layer_chunk = {-1, 0};
    int open = LOW_BITS(rows); // rows that further samples can change
    if (p.continues)
        open = open_rows(&sample, gathered, open, columns);
    for (int n = 0; n < layers && open; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        int2 over = {0, rows - 1};
        if (p.culling)
            over = visible_rows(visible, p.blocks_u, p.blocks_v, last_slab, &beam, rows, reach, 1.0f + view.first_a, k - view.first_a,
                                &layer_chunk);
        int shown = open & LOW_BITS(over.y + 1) & ~LOW_BITS(over.x);
        if (!shown)
            continue;
        for (int j = k - 1; j <= k + 1; j++)
            ensure_rows(voxels, &view, &p, &place, LOWEST_BIT(shown) - border, HIGHEST_BIT(shown) + border, j, &ring[slot(j)]);
        const SplatLayer *before = &ring[slot(k - p.layer_step)], *own = &ring[slot(k)], *after = &ring[slot(k + p.layer_step)];
        for (int left = shown; left; left &= left - 1) {
            const int r = LOWEST_BIT(left);
            bool any = false;
            for (int c = 0; c < TILE_COLUMNS; c += VW)
                any = any || layer_may_contribute(&sample, LOADV(SUM_ROW(before, r) + c), LOADV(SUM_ROW(own, r) + c),
                                                  LOADV(SUM_ROW(after, r) + c));
            if (!any)
                shown &= ~(1 << r);
        }
        if (!shown)
            continue;
        if (border) {
            const int first = LOWEST_BIT(shown), lit = HIGHEST_BIT(shown) - first + 1;
            splat_tile(voxels, &view, &p, &place, first, lit, k, (Step){1, 0}, along_u + first * TILE_COLUMNS);
            splat_tile(voxels, &view, &p, &place, first, lit, k, (Step){0, 1}, across + first * TILE_COLUMNS);
        }
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        for (int left = shown; left; left &= left - 1) {
            const int r = LOWEST_BIT(left);
            for (int c = 0; c < TILE_VECTORS; c++) {
                LayerSpan layer_span;
                layer_span.dt = sample_length;
#ifdef CLIPPED
                layer_span.interval.from = intervals[r * TILE_VECTORS + c].from - n;
                layer_span.interval.to = intervals[r * TILE_VECTORS + c].to - n;
#endif
                const int at = r * TILE_COLUMNS + c * VW;
                const Point point = phase_points(&view, &p, &place, c * VW, r, k);
                const struct SampleSource source = {SUM_ROW(own, r) + c * VW, along_u + at, across + at, point,
                                                    {&shading, &sample.field}};
                accumulate_slabs(&sample, slabs, first, count, table, LOADV(SUM_ROW(before, r) + c * VW), LOADV(source.own),
                                 LOADV(SUM_ROW(after, r) + c * VW), &layer_span, &source, &gathered[r * TILE_VECTORS + c], &active[c]);
            }
        }
        open = open_rows(&sample, gathered, open, columns);
    }

    uint total = 0;
    for (int c = 0; c < TILE_VECTORS; c++)
        total += sum_lanes(active[c], clamp(columns - c * VW, 0, VW));
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < TILE_VECTORS && c * VW < columns; c++)
            STORE_RAYS(p, sample, table, &gathered[r * TILE_VECTORS + c], &intervals[r * TILE_VECTORS + c], min(VW, columns - c * VW),
                       p.per_voxel_u, lattice + lattice_index(&p, phase_u, phase_v, column + c * VW, row + r), total)
    active_samples[tile] = total;
}
