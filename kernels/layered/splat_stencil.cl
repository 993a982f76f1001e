// Splat sums of a tile of consecutive samples of the lattice of a parallel view.
//
// Within a layer all samples of a phase have the same position between the voxels, and so the same weights (footprints.cl). The samples of
// a row belong to the phases along u in turn. So each voxel row is first spread to the columns, once for each tap along u, and each row of
// samples is then a stencil of spread rows, with a vector of weights per tap.

#include "layered/footprint.cl"
#include "layered/patches.cl"
#include "shared/volume.cl"

#define MAX_TAPS 4
// Voxels under a row of samples, which are at most one voxel apart, and voxel rows under a tile.
#define SPAN_VECTORS ((VW + MAX_TAPS - 1 + VW - 1) / VW)
#define SPREAD_ROWS (TILE_ROWS + MAX_TAPS)

// Columns with offsets and weights, in each layer: VW from any phase on.
#define PHASE_COLUMNS(p) ((p)->per_voxel_u + VW - 1)

// A tile of the lattice: offsets and weights of the phases in all layers, and where its samples begin.
typedef struct {
    __global const LayerOffset *offsets_u, *offsets_v;
    __global const float *weights;
    int column, row, columns, rows, bands;
    int phase_u, voxel_u; // of the first column
} PhaseTile;

static inline PhaseTile make_phase_tile(const SplatLatticeParams *p, int id, __global const LayerOffset *offsets_u,
                                        __global const LayerOffset *offsets_v, __global const float *weights) {
    PhaseTile tile = {offsets_u, offsets_v, weights, id % p->tiles_u * VW, id / p->tiles_u * TILE_ROWS};
    tile.columns = min(VW, p->columns_u * p->per_voxel_u - tile.column);
    tile.rows = min(TILE_ROWS, p->columns_v * p->per_voxel_v - tile.row);
    tile.bands = (tile.rows + PATCH_ROWS - 1) / PATCH_ROWS;
    tile.phase_u = tile.column % p->per_voxel_u, tile.voxel_u = tile.column / p->per_voxel_u;
    return tile;
}

// Voxels at or below the columns of a tile in the layer with this index, counted from layer -1, and the distances from them.
static inline void column_offsets(const SplatLatticeParams *p, const PhaseTile *tile, int index, intv *below, realv *fraction) {
    __global const LayerOffset *offsets = tile->offsets_u + index * PHASE_COLUMNS(p) + tile->phase_u;
#if VW == 1
    *below = offsets->base + tile->voxel_u, *fraction = offsets->fraction;
#else
    const intv one = CAT(vload, VW)(0, (__global const int *)offsets), other = CAT(vload, VW)(1, (__global const int *)offsets);
    *below = (intv)(one.even, other.even) + tile->voxel_u, *fraction = AS_REALV((intv)(one.odd, other.odd));
#endif
}

// The same for a row of a tile.
static inline LayerOffset row_offset(const SplatLatticeParams *p, const PhaseTile *tile, int index, int row) {
    const int at = tile->row + row;
    LayerOffset offset = tile->offsets_v[index * p->per_voxel_v + at % p->per_voxel_v];
    offset.base += at / p->per_voxel_v;
    return offset;
}

// Voxels under the columns of a tile in one layer.
typedef struct {
    int first, vectors; // where spans of voxels begin, and their length
    int taps;           // most of any column
    intv offset;        // of the first tap of each column, in the span
} TapColumns;

static inline TapColumns tap_columns(const SplatLatticeParams *p, const PhaseTile *tile, int index) {
    intv below;
    realv fraction;
    column_offsets(p, tile, index, &below, &fraction);
    const float s = fabs(p->shear_u);
    const intv before = COUNT_IF(fraction < s), more = before + COUNT_IF(fraction > 1.0f - s); // as first_tap() and tap_count()
    TapColumns c;
    c.taps = ANY(more > 1) ? 4 : ANY(more > 0) ? 3 : 2;
    c.offset = below - before;
    const int *taps = (const int *)&c.offset;
    c.first = taps[0];
    // One, or all that there can be: a constant number.
    c.vectors = taps[VW - 1] + c.taps - c.first <= VW ? 1 : SPAN_VECTORS;
    c.offset -= c.first;
    return c;
}

// Offsets for central differences: (0, 0, 0) splats voxels; otherwise the differences of the next and the previous ones along an axis.
typedef struct {
    int u, v, a;
} Step;

// Spreads `rows` voxel rows from `first` on in layer k, or their differences, to the columns: MAX_TAPS vectors each. `inside`: all voxels
// are in the volume.
ALWAYS_INLINE void spread_rows(__global const VOXEL *voxels, const VolumeView *view, const TapColumns *c, int first, int rows, int k,
                               Step step, int vectors, bool inside, realv *spread) {
    const bool differs = step.u | step.v | step.a;
    const long next = step.u + step.v * view->stride_v + step.a * view->stride_a;
    __global const VOXEL *row = voxels + c->first + first * view->stride_v + (k - view->first_a) * view->stride_a;
    for (int j = first; j < first + rows; j++, row += view->stride_v, spread += MAX_TAPS) {
        float span[SPAN_VECTORS * VW];
        if (inside) {
#pragma unroll
            for (int i = 0; i < SPAN_VECTORS * VW; i += VW)
                if (i < vectors * VW)
                    STOREV(span + i, differs ? VOXEL_DIFFERENCES(view, row + next + i, row - next + i)
                                             : VOXEL_VALUES(view, LOAD_VOXELS(row + i)));
        } else {
            load_row(voxels, view, c->first + step.u, j + step.v, k + step.a, vectors, span);
            if (differs) {
                float before[SPAN_VECTORS * VW];
                load_row(voxels, view, c->first - step.u, j - step.v, k - step.a, vectors, before);
                for (int i = 0; i < vectors * VW; i += VW)
                    STOREV(span + i, LOADV(span + i) - LOADV(before + i));
            }
        }
        spread[0] = PICK(span, vectors, c->offset), spread[1] = PICK(span, vectors, c->offset + 1);
        if (c->taps > 2)
            spread[2] = PICK(span, vectors, c->offset + 2);
        if (c->taps > 3)
            spread[3] = PICK(span, vectors, c->offset + 3);
    }
}

// Contribution of one voxel row to a splat sum.
#define ROW_2(b) (w[4 * (b)] * row[4 * (b)] + w[4 * (b) + 1] * row[4 * (b) + 1])
#define ROW_3(b) (ROW_2(b) + w[4 * (b) + 2] * row[4 * (b) + 2])
#define ROW_4(b) (ROW_3(b) + w[4 * (b) + 3] * row[4 * (b) + 3])
#define ROWS_2(ROW) (ROW(0) + ROW(1))
#define ROWS_3(ROW) (ROWS_2(ROW) + ROW(2))
#define ROWS_4(ROW) (ROWS_3(ROW) + ROW(3))

// The stencil of TAPS_U x TAPS_V voxels for the rows of one phase, `stride` apart, below `rows`; `spread` begins with the first row's
// voxels. Spelled out, with the weights in registers: PoCL does not unroll loops over taps.
#define SPLAT_SUMS(TAPS_U, TAPS_V)                                                                                              \
    static inline void CAT(CAT(splat_sums_, TAPS_U), TAPS_V)(const realv *row, __global const float *weights, int columns,      \
                                                             int first, int rows, int stride, realv *sums) {                    \
        realv w[16];                                                                                                            \
        for (int b = 0; b < TAPS_V; b++)                                                                                        \
            for (int a = 0; a < TAPS_U; a++)                                                                                    \
                w[4 * b + a] = *(__global const realv_unaligned *)(weights + (4 * b + a) * columns);                            \
        for (int r = first; r < rows; r += stride, row += MAX_TAPS)                                                             \
            sums[r] = CAT(ROWS_, TAPS_V)(CAT(ROW_, TAPS_U));                                                                    \
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

// Splat sums of layer k, or of differences, in the bands from `first` to `last`, as patches.
static inline void splat_bands(__global const VOXEL *voxels, const VolumeView *view, const SplatLatticeParams *p, const PhaseTile *tile,
                               int first, int last, int k, Step step, realv *patches) {
    const int first_row = first * PATCH_ROWS, rows = (last + 1 - first) * PATCH_ROWS;
    if (!step.u && !step.v && !step.a && IS_OUTSIDE(k, view)) {
        for (int r = first_row; r < first_row + rows; r++)
            patches[r] = (realv)(view->background);
        return;
    }
    const int index = clamp(k, -1, view->dims_a) + 1;
    TapColumns c = tap_columns(p, tile, index);
    const LayerOffset low = row_offset(p, tile, index, first_row), high = row_offset(p, tile, index, first_row + rows - 1);
    const int v0 = low.base + first_tap(low.fraction, p->shear_v);
    const int voxel_rows = high.base + first_tap(high.fraction, p->shear_v) + tap_count(high.fraction, p->shear_v) - v0;
    const int width = c.vectors * VW;
    const bool inside = c.first >= step.u && ((const int *)&c.offset)[VW - 1] + c.first + c.taps + step.u <= view->dims_u &&
                        width + 2 * step.u <= view->dims_u && v0 >= step.v && v0 + voxel_rows + step.v <= view->dims_v && k >= step.a &&
                        k + step.a < view->dims_a;
    realv spread[SPREAD_ROWS * MAX_TAPS];
    if (inside) {
        // Spans of whole vectors may begin before the voxels under the tile, so that they end inside the volume.
        const int behind = max(c.first - (view->dims_u - step.u - width), 0);
        c.first -= behind, c.offset += behind;
        if (c.vectors == 1)
            spread_rows(voxels, view, &c, v0, voxel_rows, k, step, 1, true, spread);
        else
            spread_rows(voxels, view, &c, v0, voxel_rows, k, step, SPAN_VECTORS, true, spread);
    } else {
        spread_rows(voxels, view, &c, v0, voxel_rows, k, step, c.vectors, false, spread);
    }
    realv sums[TILE_ROWS];
    for (int r = 0; r < min(rows, p->per_voxel_v); r++) {
        const LayerOffset v = row_offset(p, tile, index, first_row + r);
        const realv *row = spread + (v.base + first_tap(v.fraction, p->shear_v) - v0) * MAX_TAPS;
        const int phase_v = (tile->row + first_row + r) % p->per_voxel_v;
        __global const float *weights = tile->weights + ((size_t)index * p->per_voxel_v + phase_v) * 16 * PHASE_COLUMNS(p) + tile->phase_u;
        switch (4 * c.taps + tap_count(v.fraction, p->shear_v)) {
#define STENCIL(U, V)                                                                                                  \
    case 4 * U + V:                                                                                                    \
        CAT(CAT(splat_sums_, U), V)(row, weights, PHASE_COLUMNS(p), r, rows, p->per_voxel_v, sums);                    \
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
    for (int r = 0; r < rows; r += PATCH_ROWS) {
        regroup(sums + r);
        for (int i = 0; i < PATCH_ROWS; i++)
            patches[first_row + r + i] = sums[r + i];
    }
}
