// The layout for layer axis x: from (x fastest, then y, then z) to (z fastest, then y, then x).
//
// One work-item per TRANSPOSED_ROWS rows of the result, with neighbouring x and the same y. For several rows, id = x / TRANSPOSED_ROWS *
// dims_y + y. The work-item advances along z in steps of one cache line, so that each line is read and written once. Voxels are first
// copied to a compact block, since lines a power of two apart evict each other from the cache. For one row, id = y * dims_x + x:
// neighbouring work-items read neighbouring voxels, and no block is needed. Source rows are `pitch_y` voxels apart, layers `pitch_z`; the
// first voxel is at `first`.

#include "shared/volume.cl"

#define LAYERS_PER_STEP (64 / VOXEL_BYTES)

__kernel void transpose(__global const VOXEL *voxels, long first, long pitch_y, long pitch_z, int dims_x, int dims_y, int dims_z,
                        __global VOXEL *transposed, ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)((dims_x + TRANSPOSED_ROWS - 1) / TRANSPOSED_ROWS) * dims_y)
        return;
#if TRANSPOSED_ROWS == 1
    const size_t first_x = id % dims_x, y = id / dims_x;
#else
    const size_t y = id % dims_y, first_x = id / dims_y * TRANSPOSED_ROWS;
#endif
    __global const VOXEL *columns = voxels + first + first_x + pitch_y * y;
    __global VOXEL *row = transposed + dims_z * (first_x * dims_y + y);
#if TRANSPOSED_ROWS == 1
    for (size_t z = 0; z < dims_z; z++)
        row[z] = columns[pitch_z * z];
#else
    const int rows = min(dims_x - (int)first_x, TRANSPOSED_ROWS);
    for (size_t from = 0; from < dims_z; from += LAYERS_PER_STEP) {
        const size_t layers = min(dims_z - from, (size_t)LAYERS_PER_STEP);
        VOXEL block[LAYERS_PER_STEP][TRANSPOSED_ROWS];
        for (size_t z = 0; z < layers; z++)
            for (size_t x = 0; x < rows; x++)
                block[z][x] = columns[pitch_z * (from + z) + x];
        for (size_t x = 0; x < rows; x++)
            for (size_t z = 0; z < layers; z++)
                row[x * dims_y * dims_z + from + z] = block[z][x];
    }
#endif
}
