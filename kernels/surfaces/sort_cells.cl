// Sorts the cells of a tile by the nearest of their crossings with rays of its pixels, so that those of a few fragments are met without the others.
//
// One work-item per tile. nearest, farthest: per entry of the lists, the nearest crossing of the cell, and the farthest of all cells up to it.

#include "shared/elementary.cl"
#include "surfaces/cells.cl"

#define RASTER SURFACE_TILE

typedef struct {
    float nearest, farthest;
} Block;

#include "surfaces/crossings.cl"

static inline bool is_wanted(const Block *block, int n) { return true; }

// More than programs differ in rounding.
#define ROUNDED 1e-5f

static inline void add_crossings(Block *block, int n, uint index, __global const SurfaceSet *set, const SurfaceRay *ray, Crossings crossings) {
    // No result of these is NaN.
    const float2 margin = ROUNDED * fabs(crossings);
    block->nearest = fmin(block->nearest, fmin(crossings.x - margin.x, crossings.y - margin.y));
    block->farthest = fmax(block->farthest, fmax(crossings.x + margin.x, crossings.y + margin.y));
}

static inline void swap_entries(__global uint *lists, __global float *nearest, __global float *farthest, uint one, uint other) {
    const uint cell = lists[one];
    const float2 depths = {nearest[one], farthest[one]};
    lists[one] = lists[other], nearest[one] = nearest[other], farthest[one] = farthest[other];
    lists[other] = cell, nearest[other] = depths.x, farthest[other] = depths.y;
}

// Moves the root of a part of a heap, whose farthest entries are on top, to its place.
static inline void sift(__global uint *lists, __global float *nearest, __global float *farthest, uint root, uint count) {
    for (uint child = 2 * root + 1; child < count; child = 2 * root + 1) {
        child += child + 1 < count && nearest[child + 1] > nearest[child];
        if (nearest[root] >= nearest[child])
            return;
        swap_entries(lists, nearest, farthest, root, child);
        root = child;
    }
}

__kernel void sort_cells(__global const float4 *points, __global const int4 *cells, __global const SurfaceSet *sets,
                         __global const int2 *rounded, __global const ushort4 *bounds, __global const uint *ends, __global uint *lists,
                         int chunks, SurfaceView view, __global float *nearest, __global float *farthest, ulong first_item) {
    const int tile = first_item + get_global_id(0);
    if (tile >= view.tiles_u * view.tiles_v)
        return;
    const BlockPlace all = place_of_block(&view, ends, chunks, tile);
    BlockPlace place = all;
    for (uint i = all.begin; i < all.end; i++) {
        place.begin = i, place.end = i + 1;
        Block block = {INFINITY, -INFINITY};
        meet_cells(&block, &place, &view, points, cells, sets, rounded, bounds, lists);
        nearest[i] = block.nearest, farthest[i] = block.farthest;
    }
    lists += all.begin, nearest += all.begin, farthest += all.begin;
    const uint count = all.end - all.begin;
    for (uint root = count / 2; root-- > 0;)
        sift(lists, nearest, farthest, root, count);
    for (uint left = count; left-- > 1;) {
        swap_entries(lists, nearest, farthest, 0, left);
        sift(lists, nearest, farthest, 0, left);
    }
    for (uint i = 1; i < count; i++)
        farthest[i] = fmax(farthest[i], farthest[i - 1]);
}
