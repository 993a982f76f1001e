// Visibility of each block in each slab, the space between two layers: whether any table entry in the range of values interpolated in its
// cells has opacity. Neighbouring blocks share voxels. A value interpolated from several blocks, or on a path from one to the next, has
// no opacity if all of these blocks are invisible.
//
// One work-item per (block u, block v, chunk of 8 slabs), u fastest. Slab q = 0 ... n + 2 radius - 2 lies between layers q - radius and q
// - radius + 1; its samples use radius - 1 further layers on each side. Sums of kernels can overshoot by `overshoot` times the distance
// between the smallest and the largest voxel of the support, and by `slack` times that from the background. The result is bit q % 8 of
// visible[id].

#include "volume/opacity_range.cl"

#define MAX_RADIUS 2
// Number of layers that the slabs of a chunk use.
#define LAYERS (8 + 2 * MAX_RADIUS - 1)
// Unrolled on GPUs, so that arrays are in registers. CPUs take half as long again with so much code.
#if VW == 1
#define UNROLLED _Pragma("unroll")
#else
#define UNROLLED
#endif

__kernel void slab_visibility(__global const VOXEL *limits, int blocks_u, int blocks_v, int layers, int radius, float background,
                              float offset, float least, float largest, float table_first, float table_per_value, int table_last,
                              __global const uint *visible_before, float overshoot, float slack, __global uchar *visible,
                              ulong first_item) {
    const int slabs = layers + 2 * radius - 1;
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)blocks_u * blocks_v * ((slabs + 7) / 8))
        return;
    const int b = id % blocks_u, c = id / blocks_u % blocks_v;
    const int chunk = id / (blocks_u * blocks_v);
    const int reached = 2 * radius, first = 8 * chunk + 1 - reached;
    float lo[LAYERS], hi[LAYERS];
    UNROLLED for (int n = 0; n < LAYERS; n++) {
        const int k = first + n;
        const bool outside = k < 0 || k >= layers || n >= 7 + reached;
        lo[n] = hi[n] = background;
        if (!outside)
            block_limits(limits, background, offset, ((size_t)k * blocks_v + c) * blocks_u + b, &lo[n], &hi[n]);
    }
    int bits = 0;
    UNROLLED for (int i = 0; i < 8; i++) {
        float from = lo[i], to = hi[i];
#pragma unroll
        for (int n = 1; n < 2 * MAX_RADIUS; n++)
            if (n < reached)
                from = MIN(from, lo[i + n]), to = MAX(to, hi[i + n]);
        const float below = overshoot * (to - from) + slack * fabs(from - background);
        const float above = overshoot * (to - from) + slack * fabs(to - background);
        if (i < slabs - 8 * chunk)
            bits |= any_visible(from - below, to + above, least, largest, table_first, table_per_value, table_last, visible_before) << i;
    }
    visible[id] = bits;
}
