// A tile of a lattice with point-sampled layers: which rays it has, and which voxels are below them.

#include "layered/point_layer.cl"
#include "layered/ray_lattice.cl"

// The tile whose turn it is, tile_v*tiles_u + tile_u. Threads take runs of neighbours, shorter ones when less is left (PoCL: 64 at most). A
// volume shows most in the middle of its picture, so rows of tiles come from above to the middle and then from below to it: what is left for
// short runs is worth sharing. From above to below, one thread waited for the other for up to a sixth of a frame.
static inline int tile_in_turn(const RayLatticeParams *p, int turn) {
    const int row = turn / p->tiles_u, above = p->tiles_v / 2;
    return turn % p->tiles_u + (row < above ? row : p->tiles_v - 1 - (row - above)) * p->tiles_u;
}

// The rays of a tile: its columns, its rows, and the outermost of both, from the layer of the volume's centre.
typedef struct {
    realv centre_u, shear_u;
    TileRows v;
    int column, row, columns, rows, bands;
    Beam beam;
} Tile;

static inline Tile tile_of(const RayLatticeParams *p, int column, int row) {
    Tile tile;
    tile.column = column, tile.row = row;
    tile.rows = min(TILE_ROWS, p->height - row), tile.columns = min(VW, p->width - column);
    tile.bands = (tile.rows + PATCH_ROWS - 1) / PATCH_ROWS;
    crossings_of(p, 0, LANES + column, &tile.centre_u, &tile.shear_u);
    tile.v.stagger = stagger_of_columns(p, LANES + column), tile.v.farthest = p->farthest;
    for (int r = 0; r < PADDED_ROWS; r++) {
        const float2 crossing = crossing_of(p, 1, row + min(r, tile.rows - 1));
        tile.v.centre[r] = crossing.x, tile.v.shear[r] = crossing.y;
    }
    tile.beam = beam_of(p, column, row, tile.columns, tile.rows);
    if (p->farthest)
        tile.beam.crossing.w += p->rays[5];
    return tile;
}

// The rays of a patch, and which of them there are: none beyond the lattice.
static inline SampleRays rays_of_patch(const RayLatticeParams *p, const Tile *tile, int patch) {
    return rays_of_samples(p, columns_of_patch(patch) + tile->column, rows_of_patch(patch) + tile->row);
}
static inline intv has_rays(const Tile *tile, int patch) {
    return columns_of_patch(patch) < tile->columns && rows_of_patch(patch) < tile->rows;
}

