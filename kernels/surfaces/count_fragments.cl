// Bounds the number of fragments of rays: counts crossings with translucent cells, also behind opaque ones, clipped or transparent.
//
// One work-item per block of RASTER x RASTER pixels of a tile. most: the largest number of a pixel of the block.

#include "shared/elementary.cl"
#include "surfaces/cells.cl"

typedef struct {
    float start;
    uint count[RASTER * RASTER];
} Block;

#include "surfaces/crossings.cl"

static inline bool is_wanted(const Block *block, int n) { return true; }

static inline void add_crossings(Block *block, int n, uint index, __global const SurfaceSet *set, const SurfaceRay *ray, Crossings crossings) {
    // Without a crossing, NaN.
    if (!set->opaque)
        block->count[n] += (crossings.x > block->start) + (crossings.y > block->start);
}

__kernel void count_fragments(__global const float4 *points, __global const int4 *cells, __global const SurfaceSet *sets,
                              __global const int2 *rounded, __global const ushort4 *bounds, __global const uint *ends,
                              __global const uint *lists, int chunks, SurfaceView view, __global uint *most, ulong first_item) {
    const int item = first_item + get_global_id(0), across = SURFACE_TILE / RASTER;
    if (item >= view.tiles_u * across * view.tiles_v * across)
        return;
    const BlockPlace place = place_of_block(&view, ends, chunks, item);
    Block block;
    block.start = view.start;
    for (int n = 0; n < RASTER * RASTER; n++)
        block.count[n] = 0;
    meet_cells(&block, &place, &view, points, cells, sets, rounded, bounds, lists);
    uint found = 0;
    for (int n = 0; n < RASTER * RASTER; n++)
        found = max(found, block.count[n]);
    most[item] = found;
}
