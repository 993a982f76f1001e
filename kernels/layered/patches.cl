// The samples of a tile in vectors of what lies together.
//
// Rows of VW samples are what resampled rows of voxels are mixed to. But a row meets little of a thin surface, and all its lanes are looked
// up, lit and composited for it: patches of two half rows are fewer. There are PATCH_ROWS of them in a band of as many rows, from left to
// right. Where PATCH_ROWS is 1 a patch is a row. (Squares of 4 x 4 are fewer still, but to regroup rows into these costs what they save.)

#include "shared/bit_sets.cl"
#include "shared/vector.cl"

#ifndef TILE_ROWS
#error "TILE_ROWS: samples of a tile along v"
#endif

#if VW > 1 && TILE_ROWS % 2 == 0
#define PATCH_ROWS 2
#else
#define PATCH_ROWS 1
#endif

// Turns the rows of a band into its patches, and these into rows.
ALWAYS_INLINE void regroup(realv band[PATCH_ROWS]) {
#if PATCH_ROWS == 2
    const realv left = (realv)(band[0].lo, band[1].lo), right = (realv)(band[0].hi, band[1].hi);
    band[0] = left, band[1] = right;
#endif
}

// The same of every number of `size` vectors, in the first `bands` bands.
static inline void regroup_all(realv *vectors, int size, int bands) {
    for (int band = 0; band < bands; band++)
        for (int n = 0; n < size; n++) {
            realv *first = vectors + band * PATCH_ROWS * size + n, one[PATCH_ROWS];
            for (int i = 0; i < PATCH_ROWS; i++)
                one[i] = first[i * size];
            regroup(one);
            for (int i = 0; i < PATCH_ROWS; i++)
                first[i * size] = one[i];
        }
}

// Columns and rows of a patch's samples in its tile.
static inline intv patch_columns(int patch) {
#if PATCH_ROWS == 2
    return (LANES & (VW / 2 - 1)) + patch % 2 * (VW / 2);
#else
    return LANES;
#endif
}
static inline intv patch_sample_rows(int patch) {
#if PATCH_ROWS == 2
    return COUNT_IF(LANES >= VW / 2) + patch / 2 * 2;
#else
    return (intv)(patch);
#endif
}
