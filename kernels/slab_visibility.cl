// Which blocks of a slab, the space between two layers, can show anything with point-sampled layers.
//
// One work-item per (block u, block v, chunk of 8 slabs), u fastest. Slab q = 0 ... n lies between layers q-1 and q. Bit q % 8 of near_bits is for rays that
// lean at most one voxel per layer, of far_bits for others: it takes the blocks around into account.

__kernel void slab_visibility(__global const VOXEL *limits, int blocks_u, int blocks_v, int layers, float background,
                              float offset, float table_first, float table_per_value, int table_last,
                              __global const uint *visible_before, __global uchar *near_bits,
                              __global uchar *far_bits) {
    const int b = get_global_id(0) % blocks_u, c = get_global_id(0) / blocks_u % blocks_v;
    const int chunk = get_global_id(0) / (blocks_u * blocks_v);
    if (chunk > layers >> 3)
        return;
    int near = 0, far = 0;
    for (int i = 0; i < 8; i++) {
        const int q = 8 * chunk + i;
        if (q > layers)
            break;
        const bool outer = q == 0 || q == layers;
        float lo = outer ? background : INFINITY, hi = outer ? background : -INFINITY;
        const int from = max(q - 1, 0), to = min(q, layers - 1);
        limits_of(limits, offset, blocks_u, blocks_v, from, to, b, c, &lo, &hi);
        near |= any_visible(lo, hi, table_first, table_per_value, table_last, visible_before) << i;
        for (int y = max(c - 1, 0); y <= min(c + 1, blocks_v - 1); y++)
            for (int x = max(b - 1, 0); x <= min(b + 1, blocks_u - 1); x++)
                limits_of(limits, offset, blocks_u, blocks_v, from, to, x, y, &lo, &hi);
        far |= any_visible(lo, hi, table_first, table_per_value, table_last, visible_before) << i;
    }
    near_bits[get_global_id(0)] = near;
    far_bits[get_global_id(0)] = far;
}
