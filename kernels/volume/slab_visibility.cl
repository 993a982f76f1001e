// Which blocks of a slab, the space between two layers, can show anything with point-sampled layers.
//
// One work-item per (block u, block v, chunk of 8 slabs), u fastest. Slab q = 0 ... n lies between layers q-1 and q.
// `around`: blocks to either side that a ray can reach within a slab; 0 where it leans at most one voxel per layer, which
// `limits` allow for. `slack`: by how much sums of kernels overshoot the voxels' distance from the background. Bit q % 8 of
// visible[id].

#include "volume/opacity_range.cl"

__kernel void slab_visibility(__global const VOXEL *limits, int blocks_u, int blocks_v, int layers, float background,
                              float offset, float least, float largest, float table_first, float table_per_value, int table_last,
                              __global const uint *visible_before, int around, float slack, __global uchar *visible) {
    const int b = get_global_id(0) % blocks_u, c = get_global_id(0) / blocks_u % blocks_v;
    const int chunk = get_global_id(0) / (blocks_u * blocks_v);
    if (chunk > layers >> 3)
        return;
    int bits = 0;
    float last_lo = 0.0f, last_hi = 0.0f; // of the layer before
    for (int q = 8 * chunk - 1; q < min(8 * chunk + 8, layers + 1); q++) {
        const bool outside = q < 0 || q >= layers;
        float lo = outside ? background : INFINITY, hi = outside ? background : -INFINITY;
        if (!outside)
            for (int y = max(c - around, 0); y <= min(c + around, blocks_v - 1); y++)
                for (int x = max(b - around, 0); x <= min(b + around, blocks_u - 1); x++)
                    limits_of(limits, background, offset, blocks_u, blocks_v, q, q, x, y, &lo, &hi);
        if (q >= 8 * chunk) {
            const float from = MIN(lo, last_lo), to = MAX(hi, last_hi);
            bits |= any_visible(from - slack * fabs(from - background), to + slack * fabs(to - background), least, largest,
                                table_first, table_per_value, table_last, visible_before)
                    << (q & 7);
        }
        last_lo = lo, last_hi = hi;
    }
    visible[get_global_id(0)] = bits;
}
