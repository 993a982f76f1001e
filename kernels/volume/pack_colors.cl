// Colours of voxels in four bytes: red, green, blue, and their weight in interpolation (shared/voxel_colors.cl).

#include "shared/volume.cl"

// Voxels around a transparent one whose mean colour it gets: kernels with negative weights show it. Farther away, they show 1 % at most.
#define REACH 2
#define WINDOW (2 * REACH + 1)

// Sum of the extinctions in rows within reach, at x.
static inline float near_extinction(__global const VOXEL *extinction, PackedColorParams p, int x, int y, int z) {
    float sum = 0.0f;
    if (x >= p.dims_x)
        return sum;
    for (int k = max(z - REACH, 0); k <= min(z + REACH, p.dims_z - 1); k++)
        for (int j = max(y - REACH, 0); j <= min(y + REACH, p.dims_y - 1); j++)
            sum += extinction[((size_t)k * p.dims_y + j) * p.dims_x + x];
    return sum;
}

// `red`, `green` and `blue` are extinction times colour; `extinction` may also be an opacity. One work-item per row.
__kernel void pack_colors(__global const VOXEL *red, __global const VOXEL *green, __global const VOXEL *blue,
                          __global const VOXEL *extinction, PackedColorParams p, __global uchar *out, ulong first_item) {
    const ulong row = first_item + get_global_id(0);
    if (row >= (ulong)p.dims_y * p.dims_z)
        return;
    const int y = row % p.dims_y, z = row / p.dims_y;
    float near[WINDOW];
    for (int n = 0; n < WINDOW; n++)
        near[n] = n < REACH ? near_extinction(extinction, p, n, y, z) : 0.0f;
    for (int x = 0; x < p.dims_x; x++) {
        near[(x + REACH) % WINDOW] = near_extinction(extinction, p, x + REACH, y, z);
        float around = 0.0f;
        for (int n = 0; n < WINDOW; n++)
            around += near[n];
        const size_t id = row * p.dims_x + x;
        const float own = extinction[id];
        float4 sum = (float4)(red[id], green[id], blue[id], own);
        if (own == 0.0f && around > 0.0f)
            for (int k = max(z - REACH, 0); k <= min(z + REACH, p.dims_z - 1); k++)
                for (int j = max(y - REACH, 0); j <= min(y + REACH, p.dims_y - 1); j++)
                    for (int i = max(x - REACH, 0); i <= min(x + REACH, p.dims_x - 1); i++) {
                        const size_t at = ((size_t)k * p.dims_y + j) * p.dims_x + i;
                        sum += (float4)(red[at], green[at], blue[at], extinction[at]);
                    }
        const float3 color = sum.w > 0.0f ? sum.xyz / sum.w : (float3)(0.0f);
        const float weight = sum.w > 0.0f ? fmax(255.0f * own / p.largest, 1.0f) : 0.0f;
        vstore4(convert_uchar4_sat_rte((float4)(255.0f * color, weight)), id, out);
    }
}
