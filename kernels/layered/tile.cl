// Tiles of a lattice with point-sampled layers: their rays, and the voxels below them.

#include "layered/point_layer.cl"
#include "layered/ray_lattice.cl"

// The order in which tiles are rendered. Threads take runs of consecutive work-items, and shorter runs near the end (PoCL: 64 at most).
// Most volumes are densest in the middle of the picture. Rows of tiles therefore go from the top to the middle and then from the bottom
// to the middle, so that the expensive ones come last, in short runs. From top to bottom, one of two threads idled for up to a sixth of a
// frame. The result is tile_v*tiles_u + tile_u.
static inline int scheduled_tile(const RayLatticeParams *p, int order) {
    const int row = order / p->tiles_u, above = p->tiles_v / 2;
    return order % p->tiles_u + (row < above ? row : p->tiles_v - 1 - (row - above)) * p->tiles_u;
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

