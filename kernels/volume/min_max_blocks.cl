// Smallest and largest voxel that a kernel of a given radius uses in the cells of a block, within a layer.
//
// One work-item per (block u, block v, layer 0 ... n-1), u fastest; on CPUs per row of blocks. limits[2*((layer*blocks_v + v)*blocks_u +
// u)] is the smallest, and the next element the largest, of BLOCK_U x BLOCK_V voxels, with radius - 1 more before and radius more behind
// them: neighbouring blocks overlap. Block 0 is the margin before voxel 0.

#include "shared/elementary.cl"
#include "shared/volume.cl"

#ifdef UNCHECKED
#define VALID_OR_BACKGROUND(voxels) (IS_VALID(voxels) ? (voxels) : beyond)
#else
#define VALID_OR_BACKGROUND(voxels) (voxels)
#endif

#if VW == 1
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
    // One voxel after another: arrays would be in memory.
    VOXEL lo = VALID_OR_BACKGROUND(voxels[first_u + first_v * view.stride_v]), hi = lo;
    for (int v = first_v; v <= last_v; v++)
        for (int u = first_u; u <= last_u; u++) {
            const VOXEL voxel = VALID_OR_BACKGROUND(voxels[u + v * view.stride_v]);
            lo = MIN(lo, voxel);
            hi = MAX(hi, voxel);
        }
    out[0] = whole ? lo : min(lo, VOXEL_BELOW(beyond));
    out[1] = whole ? hi : max(hi, VOXEL_ABOVE(beyond));
}
#else
// Columns of voxels that are reduced at once, and those of STRIP blocks with what they share with their neighbours.
#define WINDOW 16
#define STRIP 8
#define STRIP_COLUMNS (STRIP * BLOCK_U + WINDOW)
typedef CAT(VOXEL, WINDOW) Window;
typedef CAT(VOXEL, 8) Half;
typedef CAT(VOXEL, 4) Quarter;
typedef CAT(VOXEL, 8) __attribute__((aligned(VOXEL_BYTES))) HalfUnaligned;

// Smallest or largest, by `LESS` MIN or MAX, of BLOCK_U + 2 radius - 1 columns.
#define REDUCE(LESS, columns, radius, result)                                                       \
    {                                                                                               \
        const Half first = *(const HalfUnaligned *)(columns);                                       \
        const Half last = *(const HalfUnaligned *)((columns) + 2 * (radius)-1);                     \
        const Half eight = LESS(first, last);                                                       \
        const Quarter four = LESS(eight.lo, eight.hi);                                              \
        const VOXEL x = LESS(four.x, four.z), y = LESS(four.y, four.w);                             \
        result = LESS(x, y);                                                                        \
    }

__kernel void min_max_blocks(__global const VOXEL *voxels, VolumeView view, int blocks_u, int blocks_v, int radius, __global VOXEL *limits,
                             ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)blocks_v * view.dims_a)
        return;
    // Consecutive work-items read neighbouring memory.
    const bool layers_first = view.stride_a < view.stride_v;
    const int k = layers_first ? id % view.dims_a : id / blocks_v, c = layers_first ? id / view.dims_a : id % blocks_v;
    const int v0 = FIRST_IN_BLOCK(c, BLOCK_V) - (radius - 1), v1 = FIRST_IN_BLOCK(c + 1, BLOCK_V) - 1 + radius;
    const int first_v = max(v0, 0), last_v = min(v1, view.dims_v - 1);
    const bool whole = v0 >= 0 && v1 < view.dims_v;
    const float beyond = view.background + view.offset;
    const VOXEL below = VOXEL_BELOW(beyond), above = VOXEL_ABOVE(beyond);
    voxels += view.first + k * view.stride_a + first_v * view.stride_v;
    limits += 2 * ((size_t)k * blocks_v + c) * blocks_u;
    for (int b = 0; b < blocks_u; b += STRIP) {
        const int first_u = FIRST_IN_BLOCK(b, BLOCK_U) - (radius - 1);
        VOXEL least[STRIP_COLUMNS], largest[STRIP_COLUMNS];
        // The rows that the next work-item needs in addition: CPUs do not foresee them, since each is short.
        if (!layers_first)
            for (int v = last_v + 1; v <= min(last_v + BLOCK_V, view.dims_v - 1); v++)
                PREFETCH(voxels + max(first_u, 0) + (v - first_v) * view.stride_v);
        for (int w = 0; w < STRIP_COLUMNS; w += WINDOW) {
            const int u = first_u + w;
            Window lo = below, hi = above;
            if (u >= 0 && u + WINDOW <= view.dims_u && first_v <= last_v) {
                __global const VOXEL *column = voxels + u;
                lo = hi = VALID_OR_BACKGROUND(vload16(0, column));
                for (int v = first_v + 1; v <= last_v; v++) {
                    column += view.stride_v;
                    const Window row = VALID_OR_BACKGROUND(vload16(0, column));
                    lo = MIN(lo, row), hi = MAX(hi, row);
                }
                if (!whole)
                    lo = MIN(lo, (Window)(below)), hi = MAX(hi, (Window)(above));
            }
            vstore16(lo, 0, least + w);
            vstore16(hi, 0, largest + w);
            if (u + WINDOW <= view.dims_u && u >= 0 || first_v > last_v)
                continue;
            // A window across the margin of the volume.
            for (int n = max(0, -u); n < min(WINDOW, view.dims_u - u); n++) {
                __global const VOXEL *column = voxels + u + n;
                VOXEL lo = VALID_OR_BACKGROUND(*column), hi = lo;
                for (int v = first_v + 1; v <= last_v; v++) {
                    column += view.stride_v;
                    const VOXEL voxel = VALID_OR_BACKGROUND(*column);
                    lo = MIN(lo, voxel), hi = MAX(hi, voxel);
                }
                least[w + n] = whole ? lo : MIN(lo, below), largest[w + n] = whole ? hi : MAX(hi, above);
            }
        }
        for (int n = 0; n < min(STRIP, blocks_u - b); n++) {
            REDUCE(MIN, least + BLOCK_U * n, radius, limits[2 * (b + n)]);
            REDUCE(MAX, largest + BLOCK_U * n, radius, limits[2 * (b + n) + 1]);
        }
    }
}
#endif
