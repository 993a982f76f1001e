// Positions of a tile's rows between the voxel rows, and their weights.
//
// All columns of a sample row share the weights of the voxel rows around it, unless columns are staggered
// (src/host/layers/lattice/stagger.rs): then each column is shifted along v by a fraction of a row. The shift is the same in all rows and layers.
// With PIXEL_RAYS, it differs from row to row and is proportional to the layer's distance from the eye. `farthest` is the largest shift in
// whole voxel rows: 0 without stagger, 1 where rows are at most a voxel row apart, else 2. It is a kernel argument, but a constant in loops
// over rows: ON_STAGGERED.

#include "layered/patches.cl"
#include "shared/reconstruction.cl"

// Largest value of `farthest`.
#define FARTHEST 2

// Runs WORK(farthest) with a constant argument. A third row to select from costs engine 9 %, and two cost more than one.
#define ON_STAGGERED(WORK, farthest) \
    if ((farthest) == 0)             \
        WORK(0);                     \
    else if ((farthest) == 1)        \
        WORK(1);                     \
    else                             \
        WORK(2)

// Padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)

// Where the rows of a tile cross the centre layer, their shears, and the shifts of its columns, in voxels.
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
#ifdef PIXEL_RAYS
    realv stagger[TILE_ROWS]; // times the spread of the rays in a layer
    float spread_at_centre, spread_per_layer;
#else
    realv stagger;
#endif
    int farthest;
} TileRows;

// Weights of voxel rows -1 ... 2, for each row of the tile.
typedef struct {
    float tap[4][PADDED_ROWS];
} RowWeights;

// Rows of the tile in one layer: the voxel row below each, and the distance from that row, 0, to the next, 1.
typedef struct {
    int below[PADDED_ROWS] __attribute__((aligned(64)));
    float between[PADDED_ROWS];
#ifdef PIXEL_RAYS
    const realv *stagger;
    float spread;
#else
    realv stagger;
#endif
    int farthest;
    RowWeights value; // without stagger
#if GRADIENTS_AT_VOXELS
    RowWeights across; // on demand, like slopes
#endif
    RowWeights slope;
    float smoothing; // of gradients across the rows
} RowPlaces;

// One row: how many voxel rows each column is shifted by, and the weights of the rows around it: of values, of gradients across the rows,
// and of slopes.
typedef struct {
    intv farther;
    Weights value, across, slope;
} RowMix;

static inline Weights row_weights(const RowWeights *rows, int row) {
    const Weights w = {{rows->tap[0][row], 0.0f, rows->tap[2][row], rows->tap[3][row]}};
    return w;
}

ALWAYS_INLINE RowMix row_mix(const RowPlaces *places, int row, int farthest) {
    RowMix mix;
    if (farthest == 0) {
        mix.farther = 0;
        mix.value = row_weights(&places->value, row), mix.slope = row_weights(&places->slope, row);
#if GRADIENTS_AT_VOXELS
        mix.across = row_weights(&places->across, row);
#else
        mix.across = mix.value;
#endif
        return mix;
    }
#ifdef PIXEL_RAYS
    const realv behind = places->between[row] + places->spread * places->stagger[row];
#else
    const realv behind = places->between[row] + places->stagger;
#endif
    mix.farther = COUNT_IF(behind >= 1.0f);
    realv between = behind >= 1.0f ? behind - 1.0f : behind;
    if (farthest > 1) {
        mix.farther += COUNT_IF(behind >= 2.0f);
        between = behind >= 2.0f ? behind - 2.0f : between;
    }
    mix.value = value_weights(between), mix.slope = slope_weights(between);
    mix.across = across_weights(between, places->smoothing);
    return mix;
}

// The voxel row for each column: `row` and the next ones are the candidates, by shift.
ALWAYS_INLINE realv select_row(const RowMix *mix, const realv *row, int farthest) {
    if (farthest == 0)
        return row[0];
    if (farthest == 1)
        return mix->farther == 0 ? row[0] : row[1];
    return mix->farther == 0 ? row[0] : mix->farther == 1 ? row[1] : row[2];
}

// APPLY_TO_ROWS applies TAKE to the four voxel rows around a sample row, of which `first` points to the one before the row below.
// MIXED_ROWS is their value, ACROSS_ROWS that of a gradient across them, SLOPE_ROWS their slope.
#define APPLY_TO_ROWS(TAKE, kind, mix, first, farthest)                                                   \
    TAKE((mix).kind.tap, select_row(&(mix), first, farthest), select_row(&(mix), (first) + 1, farthest), \
         select_row(&(mix), (first) + 2, farthest), select_row(&(mix), (first) + 3, farthest))
#define MIXED_ROWS(mix, first, farthest) APPLY_TO_ROWS(MIXED, value, mix, first, farthest)
#define ACROSS_ROWS(mix, first, farthest) APPLY_TO_ROWS(ACROSS, across, mix, first, farthest)
#define SLOPE_ROWS(mix, first, farthest) APPLY_TO_ROWS(SLOPE, slope, mix, first, farthest)

static inline void store_weights(const Weights *w, int row, RowWeights *rows) {
    for (int n = 0; n < 4; n++)
        STOREV(rows->tap[n] + row, w->tap[n]);
}

// `depth`: distance of the layer from the centre layer.
static inline void place_rows(const TileRows *rows, float depth, RowPlaces *places) {
    places->stagger = rows->stagger, places->farthest = rows->farthest;
#ifdef PIXEL_RAYS
    places->spread = rows->spread_at_centre + depth * rows->spread_per_layer;
#endif
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(rows->centre + r) + depth * LOADV(rows->shear + r);
        const intv below = floor_ints(v);
        *(intv *)(places->below + r) = below;
        const realv between = v - CONVERT_REALV(below);
        STOREV(places->between + r, between);
        if (!rows->farthest) {
            const Weights value = value_weights(between);
            store_weights(&value, r, &places->value);
        }
    }
}

// Must precede the use of gradients. `smoothing`: of gradients across the rows.
static inline void prepare_slopes(RowPlaces *places, float smoothing) {
    places->smoothing = smoothing;
    if (places->farthest)
        return;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv between = LOADV(places->between + r);
        const Weights slope = slope_weights(between);
        store_weights(&slope, r, &places->slope);
#if GRADIENTS_AT_VOXELS
        const Weights across = across_weights(between, smoothing);
        store_weights(&across, r, &places->across);
#endif
    }
}
