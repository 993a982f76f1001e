// Tiles of a lattice with point-sampled layers: their rays.

#include "layered/ray_lattice.cl"
#include "layered/tile_rows.cl"

// The order in which tiles are rendered. A thread of PoCL takes its share of the work-items that are left, which are consecutive. So that
// each thread gets expensive and cheap tiles, consecutive runs of tiles come from all over the picture (src/renderer/tiles.rs). Tiles that
// no run takes come last. The result is tile_v*tiles_u + tile_u.
static inline int scheduled_tile(const RayLatticeParams *p, int order) {
    const int runs = p->tiles_u * p->tiles_v / p->tiles_per_run, run = order / p->tiles_per_run;
    return run < runs ? (int)((ulong)run * p->next_run % runs) * p->tiles_per_run + order % p->tiles_per_run : order;
}

#ifdef PIXEL_RAYS
#include "layered/pixel_tile.cl"
#else
// Columns do not lean: each is at one u in all rows of voxels.
#define MOST_LEAN 0

// Rays of a tile: its columns, its rows, and the outermost of both, from the layer of the volume's centre.
typedef struct {
    realv centre_u, shear_u;
    TileRows v;
    int column, row, columns, rows, bands;
    Beam beam;
} Tile;

// Tile number tile_v*tiles_u + tile_u.
static inline Tile make_tile(const RayLatticeParams *p, int id) {
    const int column = id % p->tiles_u * VW, row = id / p->tiles_u * TILE_ROWS;
    Tile tile;
    tile.column = column, tile.row = row;
    tile.rows = min(TILE_ROWS, p->height - row), tile.columns = min(VW, p->width - column);
    tile.bands = (tile.rows + PATCH_ROWS - 1) / PATCH_ROWS;
    axis_crossings(p, 0, LANES + column, &tile.centre_u, &tile.shear_u);
    tile.v.stagger = column_stagger(p, LANES + column), tile.v.farthest = p->farthest;
    for (int r = 0; r < PADDED_ROWS; r++) {
        const float2 crossing = axis_crossing(p, 1, row + min(r, tile.rows - 1));
        tile.v.centre[r] = crossing.x, tile.v.shear[r] = crossing.y;
    }
    tile.beam = make_beam(p, column, row, tile.columns, tile.rows);
    if (p->farthest)
        tile.beam.crossing.w += p->rays[5];
    return tile;
}

// Rays of a patch, and the lanes that have one: none beyond the lattice.
static inline SampleRays patch_rays(const RayLatticeParams *p, const Tile *tile, int patch) {
    return sample_rays(p, patch_columns(patch) + tile->column, patch_sample_rows(patch) + tile->row);
}
static inline intv lanes_with_rays(const RayLatticeParams *p, const Tile *tile, int patch) {
    return patch_columns(patch) < tile->columns && patch_sample_rows(patch) < tile->rows;
}

// The samples of row r of a tile, and the lanes that have one.
static inline intv samples_of_row(const RayLatticeParams *p, const Tile *tile, int r) {
    return (tile->row + r) * p->width + tile->column + LANES;
}
#define LANES_IN_ROW(p, tile, r) (LANES < (tile)->columns)

// Loads or stores row r of a tile.
#define FIRST_OF_ROW(p, lattice, tile, r) ((lattice) + (size_t)((tile)->row + (r)) * (p)->width + (tile)->column)
#define LOAD_ROW(p, sample, lattice, tile, r) load_raw(sample, FIRST_OF_ROW(p, lattice, tile, r), (tile)->columns, 1)
#define STORE_ROW(p, sample, table, gathered, interval, lattice, tile, r, total) \
    STORE_RAYS(p, sample, table, gathered, interval, (tile).columns, 1, FIRST_OF_ROW(&(p), lattice, &(tile), r), total)
#define STORE_ROW_COLORS(p, color, lattice, tile, r) store_colors(color, (tile)->columns, 1, FIRST_OF_ROW(p, lattice, tile, r))
#define COUNT_VISIBLE_IN_ROW(p, color, tile, r) count_visible(color, (tile)->columns)
#endif
