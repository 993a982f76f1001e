// Visible slabs under a tile and its patches: `visible`, a bit per block and slab, from slab_visibility.cl.

#include "layered/tile.cl"

// Where the first row of a tile crosses a plane, and the distance to the crossing of the next row. PIXEL_RAYS: the mean distance.
static inline float2 first_row_crossing(const RayLatticeParams *p, const Tile *tile, float depth) {
#ifdef PIXEL_RAYS
    const int last = tile->rows - 1;
    const float first_v = tile->v.centre[0] + depth * tile->v.shear[0], last_v = tile->v.centre[last] + depth * tile->v.shear[last];
    return (float2)(first_v, last ? (last_v - first_v) / last : 1.0f);
#else
    return (float2)(tile->beam.crossing.y + depth * tile->beam.shear.y, p->rays[5] + depth * p->rays[7]);
#endif
}

// Rows, at most, by which samples of a tile lie before and behind their row of samples, which are `spacing` apart. Staggered columns are less
// than a row behind. PIXEL_RAYS: samples are farther along v, and rows are not evenly spaced.
static inline float2 rows_around(const RayLatticeParams *p, float spacing) {
#ifdef PIXEL_RAYS
    return spacing > 0.0f ? (float2)(0.25f, 1.75f) : (float2)(1.75f, 0.25f);
#else
    return (float2)(0.0f, p->farthest ? 1.0f : 0.0f);
#endif
}

// Patches of a tile over which a slab of a chunk, between two planes, can be visible: those between the first and the last visible row of
// blocks.
static inline int visible_patches(__global const uchar *visible, const RayLatticeParams *p, int chunk, int slab, const Tile *tile,
                                  float depth, float to_depth) {
    const int4 blocks = blocks_in_window(p->blocks_u, p->blocks_v, cells_crossed(&tile->beam, depth, to_depth, 0.0f));
    const int2 shown = visible_block_rows(visible, p->blocks_u, p->blocks_v, chunk, 1 << slab, blocks);
    if (shown.x > shown.y)
        return 0;
    if (shown.x == blocks.y && shown.y == blocks.w)
        return LOW_BITS(tile->bands * PATCH_ROWS);
    const float2 ends = block_rows_extent(shown, p->blocks_v), at = first_row_crossing(p, tile, depth),
        to = first_row_crossing(p, tile, to_depth);
    const float2 one = tile_rows_between(ends, at.x, at.y), other = tile_rows_between(ends, to.x, to.y);
    const float2 around = rows_around(p, at.y);
    const int top = CLAMP(MIN(one.x, other.x) - around.y, 0.0f, (float)TILE_ROWS);
    const int bottom = CLAMP(MAX(one.y, other.y) + around.x, -1.0f, tile->rows - 1.0f);
    return LOW_BITS(bottom / PATCH_ROWS * PATCH_ROWS + PATCH_ROWS) & ~LOW_BITS(top / PATCH_ROWS * PATCH_ROWS);
}

// Cached visibility bits of the chunk of slabs that a tile is in.
typedef struct {
    int index, bits;
} Chunk;

// Number of slabs, from q on up to `last` along the rays, that are known to be invisible under a tile: the rest of the chunk if it is
// empty, otherwise one slab. If 0, returns in `patches` where slab q can be visible. Slab numbers count from the volume's first layer,
// `visible` from `first`, the first resident one. `enters`: 0 or 1; a ray enters slab q at layer q-RADIUS+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, int first, const Tile *tile, int q,
                                int last, int enters, Chunk *chunk, int *patches) {
    const float to_plane = first + enters - RADIUS - p->centre_layer, to_next = to_plane + (enters ? -1.0f : 1.0f);
    q -= first, last -= first;
    if (q >> 3 != chunk->index) {
        chunk->index = q >> 3;
        const int end = enters ? max(q & ~7, last) : min(q | 7, last);
        chunk->bits = slabs_in_window(visible, p->blocks_u, p->blocks_v, chunk->index,
                                      cells_crossed(&tile->beam, q + to_plane, end + to_next, 0.0f));
        if (!chunk->bits)
            return abs(end - q) + 1;
    }
    if (!(chunk->bits >> (q & 7) & 1))
        return 1;
    *patches = visible_patches(visible, p, chunk->index, q & 7, tile, q + to_plane, q + to_next);
    return !*patches;
}
