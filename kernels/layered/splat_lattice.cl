// Layered splatting on the sheared lattice of a parallel view: splat, correct, classify, shade, composite.
//
// One work-item per tile: TILE_COLUMNS x TILE_ROWS lattice samples of one phase (p, q), one sample per voxel column and
// row, from the first layer to the last. Inside a layer all samples of a phase have the same offset from the voxels, so
// the splat sum is one small stencil (weights, from footprints.cl) over unit-stride rows. The tile keeps the splat sums
// of the three layers it is between, with a border of one sample where gradients are wanted.
// Work-item id: ((tile_v*tiles_u + tile_u)*per_voxel_v + q)*per_voxel_u + p: the phases of a tile follow each other and find its voxels
// in the cache. lattice[(j*per_voxel_v + q)*width + i*per_voxel_u + p] = RGBA.

#include "layered/footprint.cl"
#include "layered/visible_layers.cl"
#include "shared/sample.cl"
#include "shared/volume.cl"

#ifndef TILE_VECTORS
#error "TILE_VECTORS: vectors of VW samples of a tile along u"
#endif
#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

#define TILE_COLUMNS (TILE_VECTORS * VW)
// Splat sums with a border of one on each side; the patch of voxels under them with up to three taps more.
#define SUM_VECTORS ((TILE_COLUMNS + 2 + VW - 1) / VW)
#define SUM_STRIDE (SUM_VECTORS * VW)
#define SUM_ROWS (TILE_ROWS + 2)
#define PATCH_VECTORS ((TILE_COLUMNS + 5 + VW - 1) / VW)
#define PATCH_STRIDE (PATCH_VECTORS * VW)
#define PATCH_ROWS (SUM_ROWS + 3)

// One voxel row's share of a splat sum.
#define ROW_2(b) (w[4 * b] * LOADV(row + b * PATCH_STRIDE) + w[4 * b + 1] * LOADV(row + b * PATCH_STRIDE + 1))
#define ROW_3(b) (ROW_2(b) + w[4 * b + 2] * LOADV(row + b * PATCH_STRIDE + 2))
#define ROW_4(b) (ROW_3(b) + w[4 * b + 3] * LOADV(row + b * PATCH_STRIDE + 3))
#define ROWS_2(ROW) (ROW(0) + ROW(1))
#define ROWS_3(ROW) (ROWS_2(ROW) + ROW(2))
#define ROWS_4(ROW) (ROWS_3(ROW) + ROW(3))

// The stencil of TAPS_U x TAPS_V voxels over a tile. Spelled out, with the weights in registers: PoCL does not unroll
// loops over taps.
#define SPLAT_SUMS(TAPS_U, TAPS_V)                                                                                     \
    static inline void CAT(CAT(splat_sums_, TAPS_U), TAPS_V)(const float *patch, __global const float *weights, int vectors,  \
                                                      int rows, float *sums) {                                         \
        float w[16];                                                                                                   \
        for (int i = 0; i < 16; i++)                                                                                   \
            w[i] = weights[i];                                                                                         \
        for (int r = 0; r < rows; r++)                                                                                 \
            for (int c = 0; c < vectors; c++) {                                                                        \
                const float *row = patch + r * PATCH_STRIDE + c * VW;                                                  \
                STOREV(sums + r * SUM_STRIDE + c * VW, CAT(ROWS_, TAPS_V)(CAT(ROW_, TAPS_U)));                         \
            }                                                                                                          \
    }
SPLAT_SUMS(2, 2)
SPLAT_SUMS(2, 3)
SPLAT_SUMS(2, 4)
SPLAT_SUMS(3, 2)
SPLAT_SUMS(3, 3)
SPLAT_SUMS(3, 4)
SPLAT_SUMS(4, 2)
SPLAT_SUMS(4, 3)
SPLAT_SUMS(4, 4)

// Rows from v on of layer k under a tile, all of them inside the volume; or, `across`, the difference of the layers around it.
ALWAYS_INLINE void load_patch_inside(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, bool across, int rows,
                                     float *patch) {
    __global const VOXEL *row = voxels + u + v * view->stride_v + (k + across - view->first_a) * view->stride_a;
    for (int r = 0; r < rows; r++, row += view->stride_v, patch += PATCH_STRIDE)
        for (int i = 0; i < PATCH_STRIDE; i += VW) {
            const realv here = VALUES_OF(view, LOAD_VOXELS(row + i));
            STOREV(patch + i, across ? here - VALUES_OF(view, LOAD_VOXELS(row - 2 * view->stride_a + i)) : here);
        }
}

// Row v of layer k under a tile; or, `across`, the difference of the layers around it.
static inline void load_patch_row(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, bool across, float *row) {
    load_row(voxels, view, u, v, across ? k + 1 : k, PATCH_VECTORS, row);
    if (!across)
        return;
    float before[PATCH_STRIDE];
    load_row(voxels, view, u, v, k - 1, PATCH_VECTORS, before);
    for (int i = 0; i < PATCH_STRIDE; i += VW)
        STOREV(row + i, LOADV(row + i) - LOADV(before + i));
}

// The splat sums of layer k for a tile whose first sample is (column, row), with `border` samples around it; or, `across`, twice
// the splatted central differences along the layer axis.
static inline void splat_layer(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, LayerOffset u,
                        LayerOffset v, __global const float *weights, int column, int row, int k, int border, bool across,
                        float *sums) {
    const int rows = TILE_ROWS + 2 * border, vectors = border ? SUM_VECTORS : TILE_VECTORS;
    if (!across && BEYOND(k, view)) {
        for (int i = 0; i < SUM_ROWS * SUM_VECTORS; i++)
            STOREV(sums + i * VW, (realv)(view->background));
        return;
    }
    const int taps_u = tap_count(u.fraction, p->shear_u), taps_v = tap_count(v.fraction, p->shear_v);
    const int u0 = u.base + column - border + first_tap(u.fraction, p->shear_u);
    const int v0 = v.base + row - border + first_tap(v.fraction, p->shear_v);
    float patch[PATCH_ROWS * PATCH_STRIDE + 4]; // 4: the last unaligned load of the last row
    const int patch_rows = rows + taps_v - 1, reach = across ? 1 : 0;
    const bool inside = u0 >= 0 && u0 + PATCH_STRIDE <= view->dims_u && v0 >= 0 && v0 + patch_rows <= view->dims_v && k >= reach &&
                        k + reach < view->dims_a;
    if (inside)
        load_patch_inside(voxels, view, u0, v0, k, across, patch_rows, patch);
    else
        for (int r = 0; r < patch_rows; r++)
            load_patch_row(voxels, view, u0, v0 + r, k, across, patch + r * PATCH_STRIDE);
    for (int i = 0; i < 4; i++)
        patch[PATCH_ROWS * PATCH_STRIDE + i] = view->background;
    switch (4 * taps_u + taps_v) {
#define STENCIL(U, V)                                                                                                  \
    case 4 * U + V:                                                                                                    \
        CAT(CAT(splat_sums_, U), V)(patch, weights, vectors, rows, sums);                                              \
        break;
        STENCIL(2, 2)
        STENCIL(2, 3)
        STENCIL(2, 4)
        STENCIL(3, 2)
        STENCIL(3, 3)
        STENCIL(3, 4)
        STENCIL(4, 2)
        STENCIL(4, 3)
        STENCIL(4, 4)
    }
}

// Splat sums around the samples at hand, neighbours in a row one voxel apart; and twice the differences along the layer axis.
struct GradientSource {
    const float *own, *across;
};

// Exactly the splatted central differences.
static inline void layer_gradient(const struct GradientSource *s, realv *u, realv *v, realv *a) {
    *u = 0.5f * (LOADV(s->own + 1) - LOADV(s->own - 1));
    *v = 0.5f * (LOADV(s->own + SUM_STRIDE) - LOADV(s->own - SUM_STRIDE));
    *a = 0.5f * LOADV(s->across);
}

#ifdef CLIPPED
// The interval of VW samples from (column, row) on, in layers from the first one that they meet. `u`, `v`: where their phase lies in
// layer -1.
static inline Interval interval_of_samples(const VolumeView *view, const SplatLatticeParams *p, const Clipping *clip, LayerOffset u,
                                    LayerOffset v, int column, int row) {
    const float first = p->layer_step > 0 ? -1.0f : view->dims_a, layers = first + 1.0f;
    const realv origin[3] = {CONVERT_REALV(LANES + (u.base + column)) + (u.fraction + layers * p->shear_u),
                             (realv)(v.base + row + (v.fraction + layers * p->shear_v)), (realv)(first)};
    const realv direction[3] = {(realv)(p->layer_step * p->shear_u), (realv)(p->layer_step * p->shear_v), (realv)(p->layer_step)};
    return interval_of(clip, origin, direction, -INFINITY);
}
#endif

// Where a sample of a phase lies in the lattice.
static inline size_t place_of(const SplatLatticeParams *p, int phase_u, int phase_v, int column, int row) {
    return ((size_t)row * p->per_voxel_v + phase_v) * (p->columns_u * p->per_voxel_u) + (size_t)column * p->per_voxel_u + phase_u;
}

__kernel void splat_lattice(__global const VOXEL *voxels, VolumeView view, __global const LayerOffset *offsets_u,
                      __global const LayerOffset *offsets_v, __global const float *weights,
                      __global const uchar *visible, __global const float4 *table, __global const float4 *slabs,
                      SplatLatticeParams p, SampleParams sample, Clipping clip, __global float4 *lattice,
                      __global uint *active_samples) {
    int id = get_global_id(0);
    if (id >= p.per_voxel_u * p.per_voxel_v * p.tiles_u * p.tiles_v)
        return;
    voxels += view.first;
    const int tile = id;
    const int phase_u = id % p.per_voxel_u;
    id /= p.per_voxel_u;
    const int phase_v = id % p.per_voxel_v;
    id /= p.per_voxel_v;
    const int column = id % p.tiles_u * TILE_COLUMNS, row = id / p.tiles_u * TILE_ROWS;
    const int rows = min(TILE_ROWS, p.columns_v - row), columns = min(TILE_COLUMNS, p.columns_u - column);

    float sums[3][SUM_ROWS * SUM_STRIDE], across[SUM_ROWS * SUM_STRIDE];
    int held[3] = {INT_MIN, INT_MIN, INT_MIN};
    Accumulator gathered[TILE_ROWS * TILE_VECTORS];
    Interval intervals[TILE_ROWS * TILE_VECTORS];
    intv active[TILE_VECTORS];
    for (int i = 0; i < TILE_ROWS * TILE_VECTORS; i++) {
        const int c = i % TILE_VECTORS * VW, r = i / TILE_VECTORS;
        gathered[i] = p.continues && r < rows && c < columns
                          ? load_raw(&sample, lattice + place_of(&p, phase_u, phase_v, column + c, row + r), min(VW, columns - c), p.per_voxel_u)
                          : empty_accumulator(&sample);
#ifdef CLIPPED
        intervals[i] = interval_of_samples(&view, &p, &clip, offsets_u[phase_u], offsets_v[phase_v], column + i % TILE_VECTORS * VW,
                                           row + i / TILE_VECTORS);
#endif
    }
    for (int c = 0; c < TILE_VECTORS; c++)
        active[c] = 0;

#ifdef PER_RAY_STEP
    const realv sample_length = length(
        (float3)(p.shear_u * sample.step_u, p.shear_v * sample.step_v, sample.step_a));
#else
    const realv sample_length = 0.0f; // it is in the table
#endif
    const int border = GATHERS_VALUES ? 0 : sample.shading, layers = view.dims_a + 2;
    // Layer -1 is what offsets begin with.
    const float2 first = (float2)(offsets_u[phase_u].base + column, offsets_v[phase_v].base + row) +
                         (float2)(offsets_u[phase_u].fraction, offsets_v[phase_v].fraction);
    const float2 shear = {p.shear_u, p.shear_v}, reach = splat_reach(shear);
    const Beam beam = {(float4)(first, first + (float2)(columns - 1, rows - 1)), (float4)(shear, shear)};
    const int held_layers = view.dims_a - view.first_a;
    Chunk chunk = {-1, 0};
    bool finished = p.continues;
    for (int i = 0; i < rows * TILE_VECTORS && finished; i++)
        finished = !any_open_of(&sample, &gathered[i], columns - i % TILE_VECTORS * VW);
    for (int n = 0; n < layers && !finished; n++) {
        const int k = p.layer_step > 0 ? n - 1 : view.dims_a - n;
        if (k < p.first_layer || k > p.last_layer)
            continue;
        const LayerOffset u = offsets_u[(k + 1) * p.per_voxel_u + phase_u], v = offsets_v[(k + 1) * p.per_voxel_v + phase_v];
        if (p.culling && !beam_shows(visible, p.blocks_u, p.blocks_v, held_layers, &beam, reach, 1.0f + view.first_a, k - view.first_a, &chunk))
            continue;
        for (int j = k - 1; j <= k + 1; j++) {
            if (held[slot(j)] == j)
                continue;
            held[slot(j)] = j;
            const int index = clamp(j, -1, view.dims_a) + 1;
            splat_layer(voxels, &view, &p, offsets_u[index * p.per_voxel_u + phase_u], offsets_v[index * p.per_voxel_v + phase_v],
                        weights + (((size_t)index * p.per_voxel_v + phase_v) * p.per_voxel_u + phase_u) * 16, column, row, j, border,
                        false, sums[slot(j)]);
        }
        if (border)
            splat_layer(voxels, &view, &p, u, v, weights + (((size_t)(k + 1) * p.per_voxel_v + phase_v) * p.per_voxel_u + phase_u) * 16,
                        column, row, k, 0, true, across);
        int first, count;
        layer_slabs(&sample, n, layers, &first, &count);
        for (int r = 0; r < rows; r++)
            for (int c = 0; c < TILE_VECTORS; c++) {
                const int at = (r + border) * SUM_STRIDE + c * VW + border;
                LayerWay way;
                way.dt = sample_length;
#ifdef CLIPPED
                way.interval.from = intervals[r * TILE_VECTORS + c].from - n;
                way.interval.to = intervals[r * TILE_VECTORS + c].to - n;
#endif
                const float *before = sums[slot(k - p.layer_step)] + at, *after = sums[slot(k + p.layer_step)] + at;
                const struct GradientSource source = {sums[slot(k)] + at, across + r * SUM_STRIDE + c * VW};
                take_layer(&sample, slabs, first, count, table, LOADV(before), LOADV(source.own), LOADV(after), &way, &source,
                           &gathered[r * TILE_VECTORS + c], &active[c]);
            }
        finished = true;
        for (int i = 0; i < rows * TILE_VECTORS && finished; i++)
            finished = !any_open_of(&sample, &gathered[i], columns - i % TILE_VECTORS * VW);
    }

    uint total = 0;
    for (int c = 0; c < TILE_VECTORS; c++)
        total += counted(active[c], clamp(columns - c * VW, 0, VW));
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < TILE_VECTORS && c * VW < columns; c++)
            END_RAYS(p, sample, table, &gathered[r * TILE_VECTORS + c], &intervals[r * TILE_VECTORS + c], min(VW, columns - c * VW),
                     p.per_voxel_u, lattice + place_of(&p, phase_u, phase_v, column + c * VW, row + r), total)
    active_samples[tile] = total;
}
