// Voxels of labels as they are: extinction times colour, and extinction, per voxel (color_lattice.cl).

#include "shared/volume.cl"

// entries[voxel]: extinction times red, green, blue, and extinction. One work-item per row.
__kernel void label_voxels(__global const VOXEL *labels, __global const float4 *entries, LabelVoxelParams p,
                           __global float *out_red, __global float *out_green, __global float *out_blue,
                           __global float *out_extinction, ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    if (row >= (ulong)p.dims_y * p.dims_z)
        return;
    for (int x = 0; x < p.dims_x; x++) {
        const size_t id = row * p.dims_x + x;
        float4 entry = entries[min((int)labels[id], p.entry_count - 1)];
        if (p.adds)
            entry += (float4)(out_red[id], out_green[id], out_blue[id], out_extinction[id]);
        out_red[id] = entry.x, out_green[id] = entry.y, out_blue[id] = entry.z, out_extinction[id] = entry.w;
    }
}
