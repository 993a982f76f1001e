// Cells of eight voxels, between which what these voxels have is interpolated linearly. Corner n is behind the first one along u (1), v (2),
// a (4).

#include "shared/elementary.cl"

// Lower voxel of a cell along an axis with `dims` voxels, and the position in the cell, 0 ... 1.
static inline intv lower_voxel(int dims, realv position, realv *within) {
    const realv clamped = CLAMP(position, (realv)(0.0f), (realv)(dims - 1));
    const intv cell = CLAMP_INTV(CONVERT_INTV(clamped), 0, max(dims - 2, 0));
    *within = clamped - CONVERT_REALV(cell);
    return cell;
}

// Bytes from a voxel to the next along an axis, which has none if it has a single voxel.
static inline int to_next_voxel(int dims, int stride) { return dims > 1 ? stride : 0; }

// Share of a corner.
static inline realv corner_share(int n, const realv *within) {
    return (n & 1 ? within[0] : 1.0f - within[0]) * (n & 2 ? within[1] : 1.0f - within[1]) * (n & 4 ? within[2] : 1.0f - within[2]);
}

// A byte of words, as a number.
static inline realv byte_of_words(intv words, int n) { return CONVERT_REALV((words >> (8 * n)) & 255); }
