// Tiles of a lattice with point-sampled layers: their rays, and the voxels below them.

#include "layered/point_layer.cl"
#include "layered/ray_lattice.cl"

// The order in which tiles are rendered. A thread of PoCL takes its share of the work-items that are left, which are consecutive. So that
// each thread gets expensive and cheap tiles, consecutive runs of tiles come from all over the picture (src/renderer/tiles.rs). Tiles that
// no run takes come last. The result is tile_v*tiles_u + tile_u.
static inline int scheduled_tile(const RayLatticeParams *p, int order) {
    const int runs = p->tiles_u * p->tiles_v / p->tiles_per_run, run = order / p->tiles_per_run;
    return run < runs ? (int)((ulong)run * p->next_run % runs) * p->tiles_per_run + order % p->tiles_per_run : order;
}

// Rays of a tile: its columns, its rows, and the outermost of both, from the layer of the volume's centre.
typedef struct {
    realv centre_u, shear_u;
    TileRows v;
    int column, row, columns, rows, bands;
    Beam beam;
} Tile;

static inline Tile make_tile(const RayLatticeParams *p, int column, int row) {
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
static inline intv lanes_with_rays(const Tile *tile, int patch) {
    return patch_columns(patch) < tile->columns && patch_sample_rows(patch) < tile->rows;
}

