// Voxels of labels as the four fields that are interpolated: extinction times colour, and extinction, per voxel (color_lattice.cl).

#include "shared/volume.cl"

// entries[voxel]: extinction times red, green, blue, and extinction. `adds`: to what other labels have left. One work-item per voxel.
__kernel void label_voxels(__global const VOXEL *labels, __global const float4 *entries, int entry_count, int adds, ulong count,
                           __global float *out_red, __global float *out_green, __global float *out_blue,
                           __global float *out_extinction, ulong first_item) {
    const ulong id = first_item + get_global_id(0);
    if (id >= count)
        return;
    float4 entry = entries[clamp((int)labels[id], 0, entry_count - 1)];
    if (adds)
        entry += (float4)(out_red[id], out_green[id], out_blue[id], out_extinction[id]);
    out_red[id] = entry.x, out_green[id] = entry.y, out_blue[id] = entry.z, out_extinction[id] = entry.w;
}
