// The rows of a tile of a lattice between those of the voxels, and what is known of these, mixed for them.
//
// A row of samples lies between two rows of voxels: all its columns mix these alike. Not where columns are staggered
// (src/layers/lattice/stagger.rs): each lies behind the row by some of its own, up to `farthest` voxel rows farther: 0 where they are not staggered,
// 1 where rows are at most a voxel row apart, else 2. It is a variable of a program, but a constant in loops over rows: ON_STAGGERED.

#include "layered/patches.cl"
#include "shared/reconstruction.cl"

// The largest.
#define FARTHEST 2

// Runs WORK(farthest) with a constant. A third row to choose from costs engine 9 %, two rows more than one.
#define ON_STAGGERED(WORK, farthest) \
    if ((farthest) == 0)             \
        WORK(0);                     \
    else if ((farthest) == 1)        \
        WORK(1);                     \
    else                             \
        WORK(2)

// Padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)

// Where a tile's rows cross the middle layer, and how far its columns lie behind them, in voxels.
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
    realv stagger;
    int farthest;
} TileRows;

// What voxel rows -1 ... 2 count, per row.
typedef struct {
    float tap[4][PADDED_ROWS];
} RowWeights;

// Where they are in a layer: the voxel row below each row, and how far it lies from that one, 0, to the next, 1.
typedef struct {
    int below[PADDED_ROWS] __attribute__((aligned(64)));
    float between[PADDED_ROWS];
    realv stagger;
    int farthest;
    RowWeights value, slope; // where columns are not staggered, slopes where they are asked for
} RowPlaces;

// Of a row: how many voxel rows farther each column lies, and what those around it count.
typedef struct {
    intv farther;
    Weights value, slope;
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
        return mix;
    }
    const realv behind = places->between[row] + places->stagger;
    mix.farther = COUNT_IF(behind >= 1.0f);
    realv between = behind >= 1.0f ? behind - 1.0f : behind;
    if (farthest > 1) {
        mix.farther += COUNT_IF(behind >= 2.0f);
        between = behind >= 2.0f ? behind - 2.0f : between;
    }
    mix.value = value_weights(between), mix.slope = slope_weights(between);
    return mix;
}

// A voxel row, `number` rows from the one before the one below a row of samples.
ALWAYS_INLINE realv select_row(const RowMix *mix, const realv *row, int farthest) {
    if (farthest == 0)
        return row[0];
    if (farthest == 1)
        return mix->farther == 0 ? row[0] : row[1];
    return mix->farther == 0 ? row[0] : mix->farther == 1 ? row[1] : row[2];
}

// A number of voxel rows, from the one before the one below a row of samples on, mixed for it, and its slope.
#define APPLY_TO_ROWS(TAKE, kind, mix, number, farthest)                                                             \
    TAKE((mix).kind.tap, select_row(&(mix), number, farthest), select_row(&(mix), (number) + 1, farthest),      \
         select_row(&(mix), (number) + 2, farthest), select_row(&(mix), (number) + 3, farthest))
#define MIXED_ROWS(mix, number, farthest) APPLY_TO_ROWS(MIXED, value, mix, number, farthest)
#define SLOPE_ROWS(mix, number, farthest) APPLY_TO_ROWS(SLOPE, slope, mix, number, farthest)

static inline void store_weights(const Weights *w, int row, RowWeights *rows) {
    for (int n = 0; n < 4; n++)
        STOREV(rows->tap[n] + row, w->tap[n]);
}

// `depth`: of the layer, from the middle one.
static inline void place_rows(const TileRows *rows, float depth, RowPlaces *places) {
    places->stagger = rows->stagger, places->farthest = rows->farthest;
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

// Before slopes are asked for.
static inline void prepare_slopes(RowPlaces *places) {
    if (places->farthest)
        return;
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const Weights slope = slope_weights(LOADV(places->between + r));
        store_weights(&slope, r, &places->slope);
    }
}
