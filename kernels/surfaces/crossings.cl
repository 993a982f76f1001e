// Where the rays of a block of RASTER x RASTER pixels of a tile cross the cells of the tile.
//
// Defined by the includer: Block; is_wanted(), whether a pixel takes part; and add_crossings(), which gets the crossings of a pixel's ray with a
// cell of a set, one with triangles and two with quadrics.

#ifndef RASTER
#error "RASTER: columns and rows of pixels of a work-item"
#endif

#include "surfaces/triangles.cl"

// Pixels of a block, of which there are fewer at the sides of the screen, and the entries of their tile in the lists.
typedef struct {
    int column, row, columns, rows;
    uint begin, end;
} BlockPlace;

// The place of a block; without pixels beyond the screen. ends: counts[chunk*tiles + tile] of bins.cl, of which those of the last chunk are where
// lists end.
static inline BlockPlace place_of_block(const SurfaceView *view, __global const uint *ends, int chunks, int item) {
    const int across = SURFACE_TILE / RASTER, blocks_u = view->tiles_u * across;
    const int column = item % blocks_u * RASTER, row = item / blocks_u * RASTER;
    BlockPlace place = {column, row, min(RASTER, view->width - column), min(RASTER, view->height - row), 0, 0};
    if (place.columns <= 0 || place.rows <= 0) {
        place.columns = place.rows = 0;
        return place;
    }
    const int tile = row / SURFACE_TILE * view->tiles_u + column / SURFACE_TILE;
    __global const uint *list_ends = ends + (size_t)(chunks - 1) * view->tiles_u * view->tiles_v;
    place.begin = tile ? list_ends[tile - 1] : 0, place.end = list_ends[tile];
    return place;
}

static inline bool is_wanted(const Block *block, int n);
static inline void add_crossings(Block *block, int n, uint index, __global const SurfaceSet *set, const SurfaceRay *ray, Crossings crossings);

// Where a ray crosses a cell. is_exact: a triangle that is known to cover the pixel.
static inline Crossings crossings_of(const SurfaceView *view, __global const float4 *points, int4 cell, const ScreenTriangle *triangle,
                                     bool is_exact, int x, int y, const SurfaceRay *ray) {
    if ((cell.w & 7) != TRIANGLE)
        return quadric_crossings(points, cell, ray);
    const bool is_covered = is_exact || covers(view, points, cell, triangle, x, y, ray);
    return (Crossings)(is_covered ? triangle_depth(points, cell, ray) : NAN, NAN);
}

// Finds all crossings. bounds: the pixels of each cell.
static inline void meet_cells(Block *block, const BlockPlace *place, const SurfaceView *view, __global const float4 *points,
                              __global const int4 *cells, __global const SurfaceSet *sets, __global const int2 *rounded,
                              __global const ushort4 *bounds, __global const uint *lists) {
    const int last_x = place->column + place->columns - 1, last_y = place->row + place->rows - 1;
    for (uint i = place->begin; i < place->end; i++) {
        const uint index = lists[i];
        const Pixels all = convert_int4(bounds[index]);
        const Pixels covered = {max(all.x, place->column), min(all.y, last_x), max(all.z, place->row), min(all.w, last_y)};
        if (covered.x > covered.y || covered.z > covered.w)
            continue;
        const int4 cell = cells[index];
        Edges edges = {0, 0, 0};
        ScreenTriangle triangle;
        bool is_exact = false;
        if ((cell.w & 7) == TRIANGLE) {
            triangle = on_pixels(rounded, cell);
            is_exact = is_rounded(&triangle);
        }
        if (is_exact)
            edges = edges_at(&triangle, covered.x, covered.z);
        for (int y = covered.z; y <= covered.w; y++, edges.here += edges.per_row) {
            long4 here = edges.here;
            for (int x = covered.x; x <= covered.y; x++, here += edges.per_column) {
                // GPUs would keep blocks indexed by a variable in memory.
                const int n = RASTER > 1 ? (y - place->row) * RASTER + (x - place->column) : 0;
                if ((is_exact && !are_alike(here)) || !is_wanted(block, n))
                    continue;
                const SurfaceRay ray = surface_ray(view, x, y);
                add_crossings(block, n, index, sets + (cell.w >> 3), &ray,
                              crossings_of(view, points, cell, &triangle, is_exact, x, y, &ray));
            }
        }
    }
}
