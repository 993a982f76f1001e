// Lists the cells of surfaces that can cover the pixels of a tile of the screen, in the order of the cells.
//
// One work-item per chunk of `count` cells. Counts its cells per tile, counts[chunk*tiles + tile], or with `fill` writes them to the places
// given by the scanned counts (scan.cl).

#include "shared/elementary.cl"
#include "surfaces/cells.cl"

__kernel void bins(__global const float4 *points, __global const int4 *cells, int count, SurfaceView view, int chunks, int fill,
                   __global uint *counts, __global uint *lists, ulong first_item) {
    const int chunk = first_item + get_global_id(0);
    if (chunk >= chunks)
        return;
    const int tiles = view.tiles_u * view.tiles_v;
    __global uint *own = counts + (size_t)chunk * tiles;
    if (!fill)
        for (int tile = 0; tile < tiles; tile++)
            own[tile] = 0;
    const int begin = (long)count * chunk / chunks, end = (long)count * (chunk + 1) / chunks;
    for (int n = begin; n < end; n++) {
        const Pixels pixels = pixels_of_cell(&view, points, cells[n]);
        if (pixels.x > pixels.y || pixels.z > pixels.w)
            continue;
        for (int v = pixels.z / SURFACE_TILE; v <= pixels.w / SURFACE_TILE; v++)
            for (int u = pixels.x / SURFACE_TILE; u <= pixels.y / SURFACE_TILE; u++) {
                const int tile = v * view.tiles_u + u;
                if (fill)
                    lists[own[tile]] = n;
                own[tile]++;
            }
    }
}
