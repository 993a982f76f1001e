// Tiles whose samples are pixels, where columns of pixels lean (src/host/layers/lattice/pixel_rays.rs).
//
// A column of pixels lies on a line in each layer. All these lines lean by their own angle, which is the same in all layers. Rows of pixels
// cross the columns at other angles. So the rows of a tile follow rows of voxels instead: next columns begin `drift` samples farther down.
// The drift changes from tile to tile, and tiles share their edges: columns of a tile differ by a sample or two in length.

#ifndef RAGGED_ROWS
#error "RAGGED_ROWS: samples by which columns of a tile may be longer than others"
#endif
#define ROW_STEP (TILE_ROWS - RAGGED_ROWS)

// Voxels, at most, by which the columns of a tile lean: 0.4 times the voxel rows under a tile (src/host/layers/lattice/pixel_rays.rs).
#define MOST_LEAN 14

// Rays of a tile: its columns in its middle row, how far they lean from a row of voxels to the next, the offsets of its rays by patch, its
// rows, and the outermost rays.
typedef struct {
    realv centre_u, shear_u, centre_v, shear_v, lean;
    realv offset_u[TILE_ROWS], offset_v[TILE_ROWS];
    TileRows v;
    int column, tile_v, drift, end_drift, rows, bands;
    Beam beam;
} Tile;

// Drift at an edge of a tile, in 32nds of a row; edge n is above tiles of row n. Tiles share edges, so no rounding is left to the compiler,
// which may contract operations.
static inline int drift_at(const RayLatticeParams *p, int tile_u, int edge) {
    const float i = tile_u * VW + 0.5f * (VW - p->width), j = edge * ROW_STEP - p->lead - 0.5f * (p->height - 1);
    const float factor = 32.0f / fma(p->drift[3], i, p->drift[2]);
    return convert_int_rtn(fma(fma(p->drift[1], j, p->drift[0]), factor, 0.5f));
}

// The lattice rows where columns of a tile begin, and behind its last rows; `columns` of the tile.
static inline intv rows_at(const RayLatticeParams *p, int edge, int drift, intv columns) {
    return edge * ROW_STEP - p->lead + ((drift * (2 * columns - (VW - 1)) + 32) >> 6);
}
static inline intv first_rows(const RayLatticeParams *p, const Tile *tile, intv columns) {
    return rows_at(p, tile->tile_v, tile->drift, columns);
}
static inline intv end_rows(const RayLatticeParams *p, const Tile *tile, intv columns) {
    return rows_at(p, tile->tile_v + 1, tile->end_drift, columns);
}

static inline Tile make_tile(const RayLatticeParams *p, int id) {
    Tile tile;
    const int tile_u = id % p->tiles_u;
    tile.tile_v = id / p->tiles_u, tile.column = tile_u * VW;
    tile.drift = drift_at(p, tile_u, tile.tile_v), tile.end_drift = drift_at(p, tile_u, tile.tile_v + 1);
    const intv first = first_rows(p, &tile, LANES);
    tile.rows = clamp((int)largest_lane(CONVERT_REALV(end_rows(p, &tile, LANES) - first)), 1, TILE_ROWS);
    tile.bands = (tile.rows + PATCH_ROWS - 1) / PATCH_ROWS;
    const intv columns = LANES + tile.column;
    const realv i = CONVERT_REALV(columns) - 0.5f * (p->width - 1);
    const float lean_u = p->u_per_row * p->depth_per_column - p->u_per_column * p->depth_per_row;
    const float lean_v = p->v_per_row * p->depth_per_column - p->v_per_column * p->depth_per_row;
    tile.lean = (p->u_per_row + lean_u * i) / (p->v_per_row + lean_v * i);

    tile.v.spread_at_centre = p->spread_at_centre, tile.v.spread_per_layer = p->spread_per_layer, tile.v.farthest = p->farthest;
    realv lowest_u = INFINITY, highest_u = -INFINITY, lowest_v = INFINITY, highest_v = -INFINITY;
    for (int r = 0; r < PADDED_ROWS; r++) {
        if (r >= tile.rows) {
            tile.v.centre[r] = tile.v.centre[tile.rows - 1], tile.v.shear[r] = tile.v.shear[tile.rows - 1];
            if (r < TILE_ROWS) {
                tile.v.stagger[r] = tile.v.stagger[tile.rows - 1];
                tile.offset_u[r] = tile.offset_u[tile.rows - 1], tile.offset_v[r] = tile.offset_v[tile.rows - 1];
            }
            continue;
        }
        realv u, v;
        ray_offsets(p, columns, first + r, &u, &v);
        // All other columns are farther along v.
        const float before = p->spread_at_centre > 0.0f ? smallest_lane(v) : largest_lane(v);
        tile.v.centre[r] = p->rays[4] + p->spread_at_centre * before, tile.v.shear[r] = p->rays[6] + p->spread_per_layer * before;
        tile.v.stagger[r] = v - before;
        tile.offset_u[r] = u, tile.offset_v[r] = v;
        lowest_u = MIN(lowest_u, u), highest_u = MAX(highest_u, u), lowest_v = MIN(lowest_v, v), highest_v = MAX(highest_v, v);
    }
    tile.beam = beam_between(p, (float4)(smallest_lane(lowest_u), smallest_lane(lowest_v), largest_lane(highest_u), largest_lane(highest_v)));
    const SampleRays middle = rays_with_offsets(p, tile.offset_u[tile.rows / 2], tile.offset_v[tile.rows / 2]);
    tile.centre_u = middle.centre_u, tile.shear_u = middle.shear_u, tile.centre_v = middle.centre_v, tile.shear_v = middle.shear_v;
    regroup_all(tile.offset_u, 1, tile.bands);
    regroup_all(tile.offset_v, 1, tile.bands);
    return tile;
}

static inline SampleRays patch_rays(const RayLatticeParams *p, const Tile *tile, int patch) {
    return rays_with_offsets(p, tile->offset_u[patch], tile->offset_v[patch]);
}

// The lanes with a pixel, for rows of the tile.
static inline intv lanes_with_samples(const RayLatticeParams *p, const Tile *tile, intv columns, intv rows) {
    const intv first = first_rows(p, tile, columns);
    return first + rows < end_rows(p, tile, columns) && first + rows >= 0 && first + rows < p->height && columns + tile->column < p->width;
}

static inline intv lanes_with_rays(const RayLatticeParams *p, const Tile *tile, int patch) {
    return lanes_with_samples(p, tile, patch_columns(patch), patch_sample_rows(patch));
}

// Columns of a tile at a distance from the centre layer: lines through (u, v).
typedef struct {
    realv u, v, lean;
} ColumnLine;

static inline ColumnLine columns_at(const Tile *tile, float depth) {
    const ColumnLine line = {tile->centre_u + depth * tile->shear_u, tile->centre_v + depth * tile->shear_v, tile->lean};
    return line;
}

// Their u in a row of voxels, whatever other rows are sampled.
static inline realv column_in_row(const ColumnLine *line, int row) { return line->u + line->lean * ((float)row - line->v); }

// Loads or stores row r of a tile.
static inline intv samples_of_row(const RayLatticeParams *p, const Tile *tile, int r) {
    return (first_rows(p, tile, LANES) + r) * p->width + (LANES + tile->column);
}
#define LANES_IN_ROW(p, tile, r) lanes_with_samples(p, tile, LANES, (intv)(r))
#define LOAD_ROW(p, sample, lattice, tile, r) load_raw_at(sample, lattice, samples_of_row(p, tile, r), LANES_IN_ROW(p, tile, r))
#define STORE_ROW(p, sample, table, gathered, interval, lattice, tile, r, total) \
    STORE_RAYS_AT(p, sample, table, gathered, interval, samples_of_row(&(p), &(tile), r), LANES_IN_ROW(&(p), &(tile), r), lattice, total)
#define STORE_ROW_COLORS(p, color, lattice, tile, r) \
    store_colors_at(color, samples_of_row(p, tile, r), LANES_IN_ROW(p, tile, r), lattice)
#define COUNT_VISIBLE_IN_ROW(p, color, tile, r) count_visible_lanes(color, LANES_IN_ROW(p, tile, r))
