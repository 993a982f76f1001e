// The smallest and the largest valid voxel, and the number of invalid ones, of caller-owned memory.
//
// One work-item per part of the rows: rows id, id + parts ... of all layers. The host combines the results of the parts. least[id] >
// largest[id] if a part has no valid voxel.

#include "shared/elementary.cl"
#include "shared/volume.cl"

__kernel void value_range(__global const VOXEL *voxels, VolumeView view, int parts, __global float *least, __global float *largest,
                          __global uint *invalid, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= parts)
        return;
    voxels += view.first;
    float lo = INFINITY, hi = -INFINITY;
    uint invalid_count = 0;
    for (long row = id; row < (long)view.dims_v * view.dims_a; row += parts) {
        __global const VOXEL *start = voxels + row % view.dims_v * view.stride_v + row / view.dims_v * view.stride_a;
        for (int u = 0; u < view.dims_u; u++) {
            const float value = convert_float(start[u]);
            const bool valid = IS_VALID(value);
            lo = valid ? MIN(lo, value) : lo;
            hi = valid ? MAX(hi, value) : hi;
            invalid_count += valid ? 0 : 1;
        }
    }
    least[id] = lo, largest[id] = hi, invalid[id] = invalid_count;
}
