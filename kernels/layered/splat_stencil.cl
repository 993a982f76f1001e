// Splat sums of a tile of samples one voxel apart, as one small stencil.
//
// Within a layer all samples of a phase have the same position between the voxels, and so the same weights (footprints.cl).

#include "layered/footprint.cl"
#include "shared/volume.cl"

#ifndef TILE_VECTORS
#error "TILE_VECTORS: vectors of VW samples of a tile along u"
#endif
#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

#define TILE_COLUMNS (TILE_VECTORS * VW)
// Voxels under a tile and one more row on each side, with up to three additional taps. Rows are whole vectors.
#define MAX_TAPS 4
#define UNDER_VECTORS ((TILE_COLUMNS + MAX_TAPS - 1 + VW - 1) / VW)
#define UNDER_STRIDE (UNDER_VECTORS * VW)
#define UNDER_ROWS (TILE_ROWS + 2 + MAX_TAPS - 1)

// Contribution of one voxel row to a splat sum.
#define ROW_2(b) (w[4 * b] * LOADV(row + b * UNDER_STRIDE) + w[4 * b + 1] * LOADV(row + b * UNDER_STRIDE + 1))
#define ROW_3(b) (ROW_2(b) + w[4 * b + 2] * LOADV(row + b * UNDER_STRIDE + 2))
#define ROW_4(b) (ROW_3(b) + w[4 * b + 3] * LOADV(row + b * UNDER_STRIDE + 3))
#define ROWS_2(ROW) (ROW(0) + ROW(1))
#define ROWS_3(ROW) (ROWS_2(ROW) + ROW(2))
#define ROWS_4(ROW) (ROWS_3(ROW) + ROW(3))

// The stencil of TAPS_U x TAPS_V voxels over rows of a tile. Spelled out, with the weights in registers: PoCL does not unroll loops over
// taps.
#define SPLAT_SUMS(TAPS_U, TAPS_V)                                                                                        \
    static inline void CAT(CAT(splat_sums_, TAPS_U), TAPS_V)(const float *under, __global const float *weights, int rows, \
                                                             float *sums) {                                               \
        float w[16];                                                                                                      \
        for (int i = 0; i < 16; i++)                                                                                      \
            w[i] = weights[i];                                                                                            \
        for (int r = 0; r < rows; r++)                                                                                    \
            for (int c = 0; c < TILE_COLUMNS; c += VW) {                                                                  \
                const float *row = under + r * UNDER_STRIDE + c;                                                          \
                STOREV(sums + r * TILE_COLUMNS + c, CAT(ROWS_, TAPS_V)(CAT(ROW_, TAPS_U)));                               \
            }                                                                                                             \
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

// Offsets for central differences: (0, 0) splats voxels; otherwise the difference of the next and the previous ones along u or the layer
// axis.
typedef struct {
    int u, a;
} Step;

// Loads rows of voxels starting at (u, v) in layer k, or their differences, where all of them are inside the volume.
static inline void load_under_inside(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, Step step, int rows,
                                     float *under) {
    __global const VOXEL *row = voxels + u + v * view->stride_v + (k - view->first_a) * view->stride_a;
    const long next = step.u + step.a * view->stride_a;
#define FILL_UNDER(numbers)                                                                                            \
    for (int r = 0; r < rows; r++, row += view->stride_v)                                                              \
        for (int i = 0; i < UNDER_STRIDE; i += VW)                                                                     \
            STOREV(under + r * UNDER_STRIDE + i, numbers)
    if (next)
        FILL_UNDER(VOXEL_DIFFERENCES(view, row + next + i, row - next + i));
    else
        FILL_UNDER(VOXEL_VALUES(view, LOAD_VOXELS(row + i)));
}

// The same without that restriction.
static inline void load_under(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, Step step, int rows,
                              float *under) {
    for (int r = 0; r < rows; r++, under += UNDER_STRIDE) {
        load_row(voxels, view, u + step.u, v + r, k + step.a, UNDER_VECTORS, under);
        if (!step.u && !step.a)
            continue;
        float before[UNDER_STRIDE];
        load_row(voxels, view, u - step.u, v + r, k - step.a, UNDER_VECTORS, before);
        for (int i = 0; i < UNDER_STRIDE; i += VW)
            STOREV(under + i, LOADV(under + i) - LOADV(before + i));
    }
}

// Splat sums of layer k, or of differences, in rows of a tile whose first sample is (column, row). `u` and `v`: offsets of the phase in
// layer k.
static inline void splat_rows(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, LayerOffset u,
                              LayerOffset v, __global const float *weights, int column, int row, int rows, int k, Step step,
                              float *sums) {
    if (!step.u && !step.a && IS_OUTSIDE(k, view)) {
        for (int i = 0; i < rows * TILE_COLUMNS; i += VW)
            STOREV(sums + i, (realv)(view->background));
        return;
    }
    const int taps_u = tap_count(u.fraction, p->shear_u), taps_v = tap_count(v.fraction, p->shear_v);
    const int v0 = v.base + row + first_tap(v.fraction, p->shear_v), voxel_rows = rows + taps_v - 1;
    int u0 = u.base + column + first_tap(u.fraction, p->shear_u);
    const bool inside = u0 - step.u >= 0 && u0 + TILE_COLUMNS + taps_u - 1 + step.u <= view->dims_u &&
                        UNDER_STRIDE + 2 * step.u <= view->dims_u && v0 >= 0 && v0 + voxel_rows <= view->dims_v &&
                        k - step.a >= 0 && k + step.a < view->dims_a;
    float under[UNDER_ROWS * UNDER_STRIDE];
    int behind = 0;
    if (inside) {
        // Rows of whole vectors may begin before the voxels under the tile, so that they end inside the volume.
        behind = max(u0 - (view->dims_u - step.u - UNDER_STRIDE), 0), u0 -= behind;
        load_under_inside(voxels, view, u0, v0, k, step, voxel_rows, under);
    } else {
        load_under(voxels, view, u0, v0, k, step, voxel_rows, under);
    }
    switch (4 * taps_u + taps_v) {
#define STENCIL(U, V)                                                                                                  \
    case 4 * U + V:                                                                                                    \
        CAT(CAT(splat_sums_, U), V)(under + behind, weights, rows, sums);                                              \
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
