// The field of one grid at the voxels of another, as floats, x fastest. One work-item per row. The field ends one voxel beyond its
// grid: values between the voxels around that end reach `end` there.

#include "shared/blend_modes.cl"
#include "shared/field.cl"

__kernel void resample(__global const VOXEL *voxels, VolumeView view, ResampleParams p, __global float *resampled, ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)p.dims_y * p.dims_z)
        return;
    voxels += view.first;
    const float y = id % p.dims_y, z = id / p.dims_y;
    const int dims[3] = {view.dims_u, view.dims_v, view.dims_a};
    __global float *out = resampled + id * p.dims_x;
    for (int x = 0; x < p.dims_x; x += VW) {
        const realv along = CONVERT_REALV(LANES) + (float)x;
        realv at[3];
        realv beyond = -INFINITY; // the end, in voxels of the new grid
        for (int i = 0; i < 3; i++) {
            const float *row = p.to_source + 4 * i;
            const realv place = row[0] * along + (row[1] * y + row[2] * z + row[3]);
            const float per_voxel = length((float3)(row[0], row[1], row[2]));
            beyond = MAX(beyond, MAX(-1.0f - place, place - (float)dims[i]) / per_voxel);
            at[i] = CLAMP(place, (realv)(-1.0f), (realv)((float)dims[i]));
        }
        const intv inside = beyond <= 0.0f;
        realv value = view.background + (p.end - view.background) / MAX(1.0f - beyond, (realv)(1.0f / p.steepest));
        if (ANY(inside)) {
            const realv own = value_at(voxels, &view, at[0], at[1], at[2], inside);
            value = inside ? CLAMP(own, (realv)(p.least), (realv)(p.largest)) : value;
        }
        value += view.offset;
        for (int n = 0; n < min(VW, p.dims_x - x); n++)
            out[x + n] = ((const float *)&value)[n];
    }
}
