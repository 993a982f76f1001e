// Lists of splats per tile of the screen, in the order of the splats.
//
// One work-item per chunk of the `count` sorted splats. Counts its splats per tile, counts[chunk*tiles + tile], or with `fill` writes
// their indices to the positions given by the scanned counts. Afterwards these are the ends of each chunk's part of a list.

#include "paper/splat.cl"

#ifndef TILE_COLUMNS
#error "TILE_COLUMNS: columns of a tile"
#endif
#ifndef TILE_ROWS
#error "TILE_ROWS: rows of a tile"
#endif

__kernel void tiled_splats(__global const Splat *sorted, int count, SplatParams p, int width, int height, int tiles_u, int tiles_v,
                           int chunks, int fill, __global uint *counts, __global uint *lists, ulong first_item) {
    const int chunk = first_item + get_global_id(0);
    if (chunk >= chunks)
        return;
    __global uint *own = counts + (size_t)chunk * tiles_u * tiles_v;
    if (!fill)
        for (int t = 0; t < tiles_u * tiles_v; t++)
            own[t] = 0;
    const int begin = (long)count * chunk / chunks, end = (long)count * (chunk + 1) / chunks;
    for (int n = begin; n < end; n++) {
        const int4 pixels = pixels_under(&p, sorted[n].x, sorted[n].y, sorted[n].w, width, height);
        for (int j = pixels.z / TILE_ROWS; j <= pixels.w / TILE_ROWS; j++)
            for (int i = pixels.x / TILE_COLUMNS; i <= pixels.y / TILE_COLUMNS; i++) {
                if (fill)
                    lists[own[j * tiles_u + i]++] = n;
                else
                    own[j * tiles_u + i]++;
            }
    }
}
