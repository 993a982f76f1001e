// The rows of a tile of a lattice between those of the voxels, and what is known of these, mixed for them.
//
// A row of samples lies between two rows of voxels: all its columns mix these alike. Not where columns are staggered
// (src/layers/lattice/stagger.rs): each lies behind the row by some of its own, up to FARTHEST voxel rows farther.

#include "layered/patches.cl"
#include "shared/reconstruction.cl"

#ifndef FARTHEST
#error "FARTHEST: 0 where columns are not staggered, 1 where rows are at most a voxel row apart, else 2"
#endif
#if FARTHEST > 2
#error "rows of samples more than two voxel rows apart"
#endif

// Padded to whole vectors.
#define PADDED_ROWS ((TILE_ROWS + VW - 1) / VW * VW)

// Where a tile's rows cross the middle layer, and how far its columns lie behind them, in voxels.
typedef struct {
    float centre[PADDED_ROWS], shear[PADDED_ROWS];
    realv stagger;
} TileRows;

// What voxel rows -1 ... 2 count, per row.
typedef struct {
    float of[4][PADDED_ROWS];
} RowWeights;

// Where they are in a layer: the voxel row below each row, and how far it lies from that one, 0, to the next, 1.
typedef struct {
    int below[PADDED_ROWS] __attribute__((aligned(64)));
    float between[PADDED_ROWS];
#if FARTHEST
    realv stagger;
#else
    RowWeights value, slope; // slopes where they are asked for
#endif
} RowPlaces;

#if FARTHEST

// Of a row: how many voxel rows farther each column lies, and what those around it count.
typedef struct {
    intv farther;
    Weights value, slope;
} RowMix;

ALWAYS_INLINE RowMix mix_of(const RowPlaces *places, int row) {
    RowMix mix;
    const realv behind = places->between[row] + places->stagger;
    mix.farther = COUNT_IF(behind >= 1.0f);
    realv between = behind >= 1.0f ? behind - 1.0f : behind;
#if FARTHEST > 1
    mix.farther += COUNT_IF(behind >= 2.0f);
    between = behind >= 2.0f ? behind - 2.0f : between;
#endif
    mix.value = value_weights(between), mix.slope = slope_weights(between);
    return mix;
}

#define WEIGHTS_OF(mix, kind) ((mix).kind.of)
// A third to choose from costs engine 9 %.
#if FARTHEST > 1
#define FARTHER(mix, number, n) ((mix).farther == 0 ? (number)[n] : (mix).farther == 1 ? (number)[(n) + 1] : (number)[(n) + 2])
#else
#define FARTHER(mix, number, n) ((mix).farther == 0 ? (number)[n] : (number)[(n) + 1])
#endif

#else

// Of a row. Its weights stay where they are: copied, they cost a tenth of the time.
typedef struct {
    const RowPlaces *places;
    int row;
} RowMix;

ALWAYS_INLINE RowMix mix_of(const RowPlaces *places, int row) {
    const RowMix mix = {places, row};
    return mix;
}

#define WEIGHT_OF(mix, kind, n) ((mix).places->kind.of[n][(mix).row])
#define WEIGHTS_OF(mix, kind) \
    ((const float[4]){WEIGHT_OF(mix, kind, 0), 0.0f, WEIGHT_OF(mix, kind, 2), WEIGHT_OF(mix, kind, 3)})
#define FARTHER(mix, number, n) ((number)[n])

static inline void store_weights(const Weights *w, int row, RowWeights *rows) {
    for (int n = 0; n < 4; n++)
        STOREV(rows->of[n] + row, w->of[n]);
}

#endif

// A number of voxel rows, from the one before the one below a row of samples on, mixed for it, and its slope.
#define OF_ROWS(TAKE, kind, mix, number) \
    TAKE(WEIGHTS_OF(mix, kind), FARTHER(mix, number, 0), FARTHER(mix, number, 1), FARTHER(mix, number, 2), FARTHER(mix, number, 3))
#define MIXED_ROWS(mix, number) OF_ROWS(MIXED, value, mix, number)
#define SLOPE_OF_ROWS(mix, number) OF_ROWS(SLOPE, slope, mix, number)

// `depth`: of the layer, from the middle one.
static inline void place_rows(const TileRows *rows, float depth, RowPlaces *places) {
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const realv v = LOADV(rows->centre + r) + depth * LOADV(rows->shear + r);
        const intv below = wholes_below(v);
        *(intv *)(places->below + r) = below;
        const realv between = v - CONVERT_REALV(below);
        STOREV(places->between + r, between);
#if !FARTHEST
        const Weights value = value_weights(between);
        store_weights(&value, r, &places->value);
#endif
    }
#if FARTHEST
    places->stagger = rows->stagger;
#endif
}

// Before slopes are asked for.
static inline void prepare_slopes(RowPlaces *places) {
#if !FARTHEST
    for (int r = 0; r < TILE_ROWS; r += VW) {
        const Weights slope = slope_weights(LOADV(places->between + r));
        store_weights(&slope, r, &places->slope);
    }
#endif
}
