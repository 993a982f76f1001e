// Which blocks can show anything: some table entry between the smallest and largest value in reach has opacity.
//
// One work-item per (block u, block v, layer+1 of -1 ... n), u fastest. A layer's samples mix the splat sums of three
// layers. visible_before[i] counts visible table entries before i. Bit NEAR is for rays that lean at most one voxel per
// layer and reach REACH voxels, bit FAR for others: it takes the blocks around into account.

#include "volume/opacity_range.cl"

__kernel void visibility(__global const VOXEL *limits, int blocks_u, int blocks_v, int layers, float background,
                         float offset, float least, float largest, float table_first, float table_per_value, int table_last,
                         __global const uint *visible_before, __global uchar *visible) {
    const int b = get_global_id(0) % blocks_u, c = get_global_id(0) / blocks_u % blocks_v;
    const int k = (int)(get_global_id(0) / (blocks_u * blocks_v)) - 1;
    if (k > layers)
        return;
    const bool outer = k <= 0 || k >= layers - 1;
    float lo = outer ? background : INFINITY, hi = outer ? background : -INFINITY;
    const int from = max(k - 1, 0), to = min(k + 1, layers - 1);
    limits_of(limits, background, offset, blocks_u, blocks_v, from, to, b, c, &lo, &hi);
    const uchar near = any_visible(lo, hi, least, largest, table_first, table_per_value, table_last, visible_before);
    for (int y = max(c - 1, 0); y <= min(c + 1, blocks_v - 1); y++)
        for (int x = max(b - 1, 0); x <= min(b + 1, blocks_u - 1); x++)
            limits_of(limits, background, offset, blocks_u, blocks_v, from, to, x, y, &lo, &hi);
    const uchar far = any_visible(lo, hi, least, largest, table_first, table_per_value, table_last, visible_before);
    visible[get_global_id(0)] = (near ? NEAR : 0) | (far ? FAR : 0);
}
