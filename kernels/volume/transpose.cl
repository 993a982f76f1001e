// The layout of layer axis x: from x fastest, then y, then z to y fastest, then z, then x.
//
// One work-item per TRANSPOSED_ROWS rows of the result, of neighbouring x at fixed z: id = x / TRANSPOSED_ROWS * dims_z + z. It goes along
// y in steps of one cache line, so that each line that is read, and each that is written, is needed once. Rows begin `pitch_y` voxels
// apart, layers `pitch_z`, the first voxel at `first`.

#include "shared/volume.cl"

#define COLUMNS_PER_STEP (64 / VOXEL_BYTES)

__kernel void transpose(__global const VOXEL *voxels, long first, long pitch_y, long pitch_z, int dims_x, int dims_y, int dims_z,
                        __global VOXEL *transposed) {
    const size_t id = get_global_id(0), z = id % dims_z, first_x = id / dims_z * TRANSPOSED_ROWS;
    if (first_x >= dims_x)
        return;
    const int rows = min(dims_x - (int)first_x, TRANSPOSED_ROWS);
    __global const VOXEL *columns = voxels + first + first_x + pitch_z * z;
    __global VOXEL *row = transposed + dims_y * (first_x * dims_z + z);
    for (size_t from = 0; from < dims_y; from += COLUMNS_PER_STEP) {
        const size_t to = min(from + COLUMNS_PER_STEP, (size_t)dims_y);
        for (size_t x = 0; x < rows; x++)
            for (size_t y = from; y < to; y++)
                row[x * dims_y * dims_z + y] = columns[x + pitch_y * y];
    }
}
