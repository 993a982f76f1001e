// Voxels of colours as the four fields that are interpolated: extinction times colour, and extinction, per voxel (color_lattice.cl).

#include "shared/volume.cl"

// One component of a colour, 0 ... 1.
#define SHARE(voxels, id) clamp(convert_float(voxels[id]) * p.per_step, 0.0f, 1.0f)

// Opacities up to this are exact; more have its extinction, which is opaque in a voxel.
#define LARGEST_OPACITY 0.99999f

// Components red, green, blue; `alpha` is read where p.opacity_from is 0. One work-item per voxel.
__kernel void color_voxels(__global const VOXEL *red, __global const VOXEL *green, __global const VOXEL *blue, __global const VOXEL *alpha,
                           __global const float *opacities, ColorVoxelParams p, __global float *out_red, __global float *out_green,
                           __global float *out_blue, __global float *out_extinction, ulong first_item) {
    const ulong id = first_item + get_global_id(0);
    if (id >= p.count)
        return;
    const float r = SHARE(red, id), g = SHARE(green, id), b = SHARE(blue, id);
    float opacity;
    if (p.opacity_from == 0) {
        opacity = SHARE(alpha, id);
    } else {
        // 1: luminance (BT.709); 2: the largest difference of a component from the background.
        const float luminance = 0.2126f * r + 0.7152f * g + 0.0722f * b;
        const float away = fmax(fmax(fabs(r - p.background_r), fabs(g - p.background_g)), fabs(b - p.background_b));
        const float place = (p.opacity_from == 1 ? luminance : away) * (p.opacity_count - 1);
        const int below = min((int)place, p.opacity_count - 2);
        opacity = opacities[below] + (place - below) * (opacities[below + 1] - opacities[below]);
    }
    const float extinction = -log1p(-fmin(opacity, LARGEST_OPACITY));
    out_red[id] = extinction * r, out_green[id] = extinction * g, out_blue[id] = extinction * b, out_extinction[id] = extinction;
}
