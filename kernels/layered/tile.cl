// A tile of a lattice with point-sampled layers: which rays it has, and which voxels are below them.

#include "layered/point_layer.cl"
#include "layered/ray_lattice.cl"

// The tile whose turn it is, tile_v*tiles_u + tile_u. Threads take runs of neighbours, shorter ones when less is left (PoCL: 64 at most). A
// volume shows most in the middle of its picture, so rows of tiles come from above to the middle and then from below to it: what is left for
// short runs is worth sharing. From above to below, one thread waited for the other for up to a sixth of a frame.
static inline int scheduled_tile(const RayLatticeParams *p, int order) {
    const int row = order / p->tiles_u, above = p->tiles_v / 2;
    return order % p->tiles_u + (row < above ? row : p->tiles_v - 1 - (row - above)) * p->tiles_u;
}

// The rays of a tile: its columns, its rows, and the outermost of both, from the layer of the volume's centre.
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

// The rays of a patch, and which of them there are: none beyond the lattice.
static inline SampleRays patch_rays(const RayLatticeParams *p, const Tile *tile, int patch) {
    return sample_rays(p, patch_columns(patch) + tile->column, patch_sample_rows(patch) + tile->row);
}
static inline intv lanes_with_rays(const Tile *tile, int patch) {
    return patch_columns(patch) < tile->columns && patch_sample_rows(patch) < tile->rows;
}

