// The layout of layer axis x: from x fastest, then y, then z to y fastest, then z, then x.
//
// One work-item per row of the result: fixed z and x, id = x*dims_z + z. Rows begin `pitch_y` voxels apart, layers `pitch_z`, the first
// voxel at `first`.

#include "shared/volume.cl"

__kernel void transpose(__global const VOXEL *voxels, long first, long pitch_y, long pitch_z, int dims_x, int dims_y, int dims_z,
                        __global VOXEL *transposed) {
    const size_t id = get_global_id(0), z = id % dims_z, x = id / dims_z;
    if (x >= dims_x)
        return;
    __global const VOXEL *column = voxels + first + x + pitch_z * z;
    __global VOXEL *row = transposed + dims_y * id;
    for (size_t y = 0; y < dims_y; y++)
        row[y] = column[pitch_y * y];
}
