// Visibility of each block in each slab, the space between two layers: whether any table entry in the range of values interpolated in its
// cells has opacity. Neighbouring blocks share voxels. A value interpolated from several blocks, or on a path from one to the next, has
// no opacity if all of these blocks are invisible.
//
// One work-item per (block u, block v, chunk of 8 slabs), u fastest; on CPUs per VW blocks of a chunk. Slab q = 0 ... n + 2 radius - 2 lies
// between layers q - radius and q - radius + 1; its samples use radius - 1 further layers on each side. Sums of kernels can overshoot by
// `overshoot` times the distance between the smallest and the largest voxel of the support, and by `slack` times that from the background.
// The result is bit q % 8 of visible[(chunk * blocks_v + v) * blocks_u + u].

#include "volume/opacity_range.cl"

#define MAX_RADIUS 2
// Number of layers that the slabs of a chunk use.
#define LAYERS (8 + 2 * MAX_RADIUS - 1)

#if VW == 1
// Unrolled, so that arrays are in registers.
#define UNROLLED _Pragma("unroll")

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
#else
// VW blocks of a chunk, counted without regard to rows. Where no value between the smallest and the largest of all layers is visible, no
// slab is: that is most of a volume, by an eighth of the work.

typedef CAT(VOXEL, VW) Limits;
typedef CAT(uchar, VW) Bits;

// Limits of VW blocks in a layer, of which only `count` may exist.
static inline void limits_of_blocks(__global const VOXEL *limits, int count, float background, float offset, realv *lo, realv *hi) {
    Limits pairs[2];
    if (count >= VW)
        pairs[0] = CAT(vload, VW)(0, limits), pairs[1] = CAT(vload, VW)(1, limits);
    else
        for (int n = 0; n < 2 * VW; n++)
            ((VOXEL *)pairs)[n] = limits[min(n, 2 * count - 1)];
    const realv least = CONVERT_REALV(((Limits)(pairs[0].even, pairs[1].even)));
    const realv most = CONVERT_REALV(((Limits)(pairs[0].odd, pairs[1].odd)));
    const float below = VOXEL_BELOW(background + offset), above = VOXEL_ABOVE(background + offset);
    *lo = least <= below ? MIN(least - offset, (realv)(background)) : least - offset;
    *hi = most >= above ? MAX(most - offset, (realv)(background)) : most - offset;
}

__kernel void slab_visibility(__global const VOXEL *limits, int blocks_u, int blocks_v, int layers, int radius, float background,
                              float offset, float least, float largest, float table_first, float table_per_value, int table_last,
                              __global const uint *visible_before, float overshoot, float slack, __global uchar *visible,
                              ulong first_item) {
    const int slabs = layers + 2 * radius - 1, per_layer = blocks_u * blocks_v, groups = (per_layer + VW - 1) / VW;
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)groups * ((slabs + 7) / 8))
        return;
    const int chunk = id / groups, block = id % groups * VW;
    const int count = min(per_layer - block, VW), reached = 2 * radius, first = 8 * chunk + 1 - reached;
    realv lo[LAYERS], hi[LAYERS];
    realv from = INFINITY, to = -INFINITY;
    for (int n = 0; n < LAYERS; n++) {
        const int k = first + n;
        lo[n] = hi[n] = background;
        if (n >= 7 + reached)
            continue;
        if (k >= 0 && k < layers)
            limits_of_blocks(limits + 2 * ((size_t)k * per_layer + block), count, background, offset, &lo[n], &hi[n]);
        from = MIN(from, lo[n]), to = MAX(to, hi[n]);
    }
#define SHOWS(from, to)                                                                                                                \
    any_visible_of((from) - (overshoot * ((to) - (from)) + slack * fabs((from)-background)),                                            \
                   (to) + (overshoot * ((to) - (from)) + slack * fabs((to)-background)), least, largest, table_first, table_per_value, \
                   table_last, visible_before)
    intv bits = 0;
    if (ANY(SHOWS(from, to)))
        for (int i = 0; i < min(slabs - 8 * chunk, 8); i++) {
            from = lo[i], to = hi[i];
            for (int n = 1; n < reached; n++)
                from = MIN(from, lo[i + n]), to = MAX(to, hi[i + n]);
            bits |= SHOWS(from, to) & 1 << i;
        }
    visible += (size_t)chunk * per_layer + block;
    const Bits bytes = CAT(convert_uchar, VW)(bits);
    if (count == VW)
        CAT(vstore, VW)(bytes, 0, visible);
    else
        for (int n = 0; n < count; n++)
            visible[n] = ((const uchar *)&bytes)[n];
}
#endif
