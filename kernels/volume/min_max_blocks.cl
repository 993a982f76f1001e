// Smallest and largest voxel that a kernel of a given radius uses in the cells of a block, within a layer.
//
// One work-item per (block u, block v, layer 0 ... n-1), u fastest. limits[2*((layer*blocks_v + v)*blocks_u + u)] is the smallest, and
// the next element the largest, of BLOCK_U x BLOCK_V voxels, with radius - 1 more before and radius more behind them: neighbouring blocks
// overlap. Block 0 is the margin before voxel 0.

#include "shared/elementary.cl"
#include "shared/volume.cl"

#ifdef UNCHECKED
#define VALID_OR_BACKGROUND(voxels) (IS_VALID(voxels) ? (voxels) : beyond)
#else
#define VALID_OR_BACKGROUND(voxels) (voxels)
#endif

// At least the voxels of a block in one row.
#define WINDOW 16
typedef CAT(VOXEL, WINDOW) Window;

__kernel void min_max_blocks(__global const VOXEL *voxels, VolumeView view, int blocks_u, int blocks_v, int radius, __global VOXEL *limits,
                             ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)blocks_u * blocks_v * view.dims_a)
        return;
    const int b = id % blocks_u, c = id / blocks_u % blocks_v;
    const int k = id / (blocks_u * blocks_v);
    const int u0 = FIRST_IN_BLOCK(b, BLOCK_U) - (radius - 1), u1 = FIRST_IN_BLOCK(b + 1, BLOCK_U) - 1 + radius;
    const int v0 = FIRST_IN_BLOCK(c, BLOCK_V) - (radius - 1), v1 = FIRST_IN_BLOCK(c + 1, BLOCK_V) - 1 + radius;
    const bool whole = u0 >= 0 && u1 < view.dims_u && v0 >= 0 && v1 < view.dims_v;
    const bool empty = u1 < 0 || u0 >= view.dims_u || v1 < 0 || v0 >= view.dims_v;
    const float beyond = view.background + view.offset;
    __global VOXEL *out = limits + 2 * id;
    if (empty) {
        out[0] = VOXEL_BELOW(beyond), out[1] = VOXEL_ABOVE(beyond);
        return;
    }
    const int first_u = max(u0, 0), last_u = min(u1, view.dims_u - 1);
    const int first_v = max(v0, 0), last_v = min(v1, view.dims_v - 1);
    voxels += view.first + k * view.stride_a;
#if VW == 1
    // One voxel after another: arrays would be in memory.
    VOXEL lo = VALID_OR_BACKGROUND(voxels[first_u + first_v * view.stride_v]), hi = lo;
    for (int v = first_v; v <= last_v; v++)
        for (int u = first_u; u <= last_u; u++) {
            const VOXEL voxel = VALID_OR_BACKGROUND(voxels[u + v * view.stride_v]);
            lo = MIN(lo, voxel);
            hi = MAX(hi, voxel);
        }
#else
    // First of columns, in vectors, and then over the columns.
    VOXEL least[WINDOW], largest[WINDOW];
    const int start = max(min(first_u, view.dims_u - WINDOW), 0);
    if (view.dims_u >= WINDOW) {
        Window lo = VALID_OR_BACKGROUND(vload16(0, voxels + start + first_v * view.stride_v)), hi = lo;
        for (int v = first_v + 1; v <= last_v; v++) {
            const Window row = VALID_OR_BACKGROUND(vload16(0, voxels + start + v * view.stride_v));
            lo = MIN(lo, row);
            hi = MAX(hi, row);
        }
        vstore16(lo, 0, least);
        vstore16(hi, 0, largest);
    } else {
        for (int u = first_u; u <= last_u; u++) {
            VOXEL lo = VALID_OR_BACKGROUND(voxels[u + first_v * view.stride_v]), hi = lo;
            for (int v = first_v + 1; v <= last_v; v++) {
                const VOXEL voxel = VALID_OR_BACKGROUND(voxels[u + v * view.stride_v]);
                lo = MIN(lo, voxel);
                hi = MAX(hi, voxel);
            }
            least[u] = lo, largest[u] = hi;
        }
    }
    VOXEL lo = least[first_u - start], hi = largest[first_u - start];
    for (int u = first_u - start + 1; u <= last_u - start; u++) {
        lo = MIN(lo, least[u]);
        hi = MAX(hi, largest[u]);
    }
#endif
    out[0] = whole ? lo : min(lo, VOXEL_BELOW(beyond));
    out[1] = whole ? hi : max(hi, VOXEL_ABOVE(beyond));
}
