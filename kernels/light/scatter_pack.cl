// The light field as samples look it up (shared/light_field.cl): four words per cell, x fastest, without space around the cells.
//
// One work-item per row of cells. The first word has the mean radiance in red, green and blue, nine bits each, and their exponent. The others
// have the flux along x, y and z, each in red, green and blue as shares of the radiance, ten bits each, from -1 to 1.

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

static inline uint packed_share(float flux, float radiance) {
    return (uint)(clamp(flux / max(radiance, 1e-9f), -1.0f, 1.0f) * 511.0f + 511.5f);
}

__kernel void scatter_pack(__global const float *mean, ScatterGrid grid, __global uchar *packed, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= grid.y * grid.z)
        return;
    const size_t plane = plane_cells(&grid);
    for (int x = 0; x < grid.x; x++) {
        __global const float *cell = mean + cell_at(&grid, x, id % grid.y, id / grid.y);
        const float radiance[3] = {max(cell[0], 0.0f), max(cell[plane], 0.0f), max(cell[2 * plane], 0.0f)};
        __global uint *out = (__global uint *)packed + 4 * ((size_t)id * grid.x + x);
        out[0] = packed_radiance(radiance[0], radiance[1], radiance[2]);
        for (int i = 0; i < 3; i++) {
            uint shares = 0;
            for (int c = 0; c < 3; c++)
                shares |= packed_share(cell[(3 + 3 * i + c) * plane], radiance[c]) << 10 * c;
            out[1 + i] = shares;
        }
    }
}
