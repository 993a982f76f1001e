// The light field as samples look it up (shared/light_field.cl): two words per cell, x fastest, without space around the cells.
//
// One work-item per row of cells. The first word has the mean radiance in red, green and blue, nine bits each, and their exponent. The second
// has the flux along x, y and z as shares of the radiance, ten bits each, from -1 to 1.

#include "light/scatter_grid.cl"

#define LARGEST_MANTISSA 511
#define LOWEST_EXPONENT (-15)

static inline uint packed_radiance(float r, float g, float b) {
    const float largest = max(max(r, g), max(b, 0x1p-20f));
    // Of largest < 2^exponent.
    int exponent = clamp((as_int(largest) >> 23) - 126, LOWEST_EXPONENT, LOWEST_EXPONENT + 31);
    float scale = as_float((127 + 9 - exponent) << 23);
    if (largest * scale + 0.5f >= LARGEST_MANTISSA + 1 && exponent < LOWEST_EXPONENT + 31)
        exponent++, scale *= 0.5f;
    const uint red = min((int)(r * scale + 0.5f), LARGEST_MANTISSA), green = min((int)(g * scale + 0.5f), LARGEST_MANTISSA);
    const uint blue = min((int)(b * scale + 0.5f), LARGEST_MANTISSA);
    return red | green << 9 | blue << 18 | (uint)(exponent - LOWEST_EXPONENT) << 27;
}

static inline uint packed_share(float flux, float per_luminance) {
    return (uint)(clamp(flux * per_luminance, -1.0f, 1.0f) * 511.0f + 511.5f);
}

__kernel void scatter_pack(__global const float *mean, ScatterPackParams p, __global uchar *packed, ulong first_item) {
    const int id = first_item + get_global_id(0);
    const ScatterGrid *grid = &p.grid;
    if (id >= grid->y * grid->z)
        return;
    const size_t plane = plane_cells(grid);
    __global const float *flux = mean + 3 * plane;
    for (int x = 0; x < grid->x; x++) {
        const size_t at = cell_at(grid, x, id % grid->y, id / grid->y);
        const float r = max(mean[at], 0.0f), g = max(mean[plane + at], 0.0f), b = max(mean[2 * plane + at], 0.0f);
        const float per_luminance = 1.0f / max(p.luminance_r * r + p.luminance_g * g + p.luminance_b * b, 1e-9f);
        __global uint *out = (__global uint *)packed + 2 * ((size_t)id * grid->x + x);
        out[0] = packed_radiance(r, g, b);
        out[1] = packed_share(flux[at], per_luminance) | packed_share(flux[plane + at], per_luminance) << 10 |
                 packed_share(flux[2 * plane + at], per_luminance) << 20;
    }
}
