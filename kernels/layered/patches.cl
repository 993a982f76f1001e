// Patches: the samples of a tile, regrouped into compact vectors.
//
// Resampling produces rows of VW samples. A thin surface covers little of a row, but look-ups, lighting and compositing process all of
// its lanes. Fewer patches of two half rows contain the surface. A band of PATCH_ROWS rows holds as many patches, from left to right;
// where PATCH_ROWS is 1, a patch is a row. (Squares of 4 x 4 would be fewer still, but regrouping rows into them costs what they save.)

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

// Converts the rows of a band to its patches, and back.
ALWAYS_INLINE void regroup(realv band[PATCH_ROWS]) {
#if PATCH_ROWS == 2
    const realv left = (realv)(band[0].lo, band[1].lo), right = (realv)(band[0].hi, band[1].hi);
    band[0] = left, band[1] = right;
#endif
}

// The same for arrays of structures of `size` vectors each, in the first `bands` bands.
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

// Columns and rows, within the tile, of the samples of a patch.
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
