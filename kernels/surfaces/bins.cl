// Lists the cells of surfaces that can cover the pixels of a tile of the screen, in the order of the cells.
//
// One work-item per chunk of `count` cells. Finds the pixels that its cells can cover, bounds[cell], and counts its cells per tile,
// counts[chunk*tiles + tile]; or with `fill` writes them to the places given by the scanned counts (scan.cl).

#include "shared/elementary.cl"
#include "surfaces/cells.cl"

__kernel void bins(__global const float4 *points, __global const int2 *rounded, __global const int4 *cells, int count, SurfaceView view,
                   int chunks, int fill, __global ushort4 *bounds, __global uint *counts, __global uint *lists, ulong first_item) {
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
        if (!fill)
            bounds[n] = convert_ushort4(pixels_of_cell(&view, points, rounded, cells[n]));
        const int4 pixels = convert_int4(bounds[n]), span = pixels / SURFACE_TILE;
        if (pixels.x > pixels.y || pixels.z > pixels.w)
            continue;
        for (int v = span.z; v <= span.w; v++)
            for (int u = span.x; u <= span.y; u++) {
                const int tile = v * view.tiles_u + u;
                if (fill)
                    lists[own[tile]] = n;
                own[tile]++;
            }
    }
}
