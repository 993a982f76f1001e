// Beams: the neighbouring rays of a tile, and what can be visible along them.

#include "layered/visible_cells.cl"

// Where the first and the last ray of a beam cross a layer, along u and v, and their shears.
typedef struct {
    float4 crossing, shear;
} Beam;

// Cells that a beam crosses from one plane to another, with a margin of `reach`.
static inline Window cells_crossed(const Beam *beam, float depth, float to_depth, float2 reach) {
    const float4 at = beam->crossing + depth * beam->shear, to = beam->crossing + to_depth * beam->shear;
    const float4 lowest = MIN(at, to), highest = MAX(at, to);
    return cells_between(MIN(lowest.lo, lowest.hi) - reach, MAX(highest.lo, highest.hi) + reach);
}

// Visibility of the eight slabs of a chunk over the blocks b0 ... b1 of a row: a byte for each block, bit q % 8 for each slab. A row is
// loaded at once; more than eight blocks count as visible, and an empty range as invisible.
static inline ulong load_block_row(__global const uchar *row, int b0, int b1) {
    if (b1 - b0 > 7)
        return ~0ul;
    return b1 < b0 ? 0 : as_ulong(vload8(0, row + b0)) << 8 * (7 - (b1 - b0));
}

// Slabs of a chunk that can be visible over a window: the union over its blocks.
static inline int slabs_in_window(__global const uchar *visible, int blocks_u, int blocks_v, int chunk, Window w) {
    const int4 blocks = blocks_in_window(blocks_u, blocks_v, w);
    ulong bits = 0;
    for (int c = blocks.y; c <= blocks.w; c++)
        bits |= load_block_row(visible + ((uint)chunk * blocks_v + c) * blocks_u, blocks.x, blocks.z);
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
}

// First and last row of blocks in which any of the `slabs` of a chunk can be visible. If there is none, the first is beyond the last.
static inline int2 visible_block_rows(__global const uchar *visible, int blocks_u, int blocks_v, int chunk, int slabs, int4 blocks) {
    const ulong any = 0x0101010101010101ul * slabs;
    int2 rows = {INT_MAX, INT_MIN};
    for (int c = blocks.y; c <= blocks.w; c++)
        if (load_block_row(visible + ((uint)chunk * blocks_v + c) * blocks_u, blocks.x, blocks.z) & any)
            rows = (int2)(min(rows.x, c), c);
    return rows;
}

// Extent of rows of blocks along v. Rows at the edge extend to infinity.
static inline float2 block_rows_extent(int2 rows, int blocks_v) {
    return (float2)(rows.x == 0 ? -INFINITY : FIRST_IN_BLOCK(rows.x, BLOCK_V) - ROUNDING_MARGIN,
                    rows.y == blocks_v - 1 ? INFINITY : FIRST_IN_BLOCK(rows.y + 1, BLOCK_V) + ROUNDING_MARGIN);
}

// Rows of a tile between two positions; `v` is the first row, `spacing` the distance to the next.
static inline float2 tile_rows_between(float2 ends, float v, float spacing) {
    const float2 rows = (ends - v) / spacing;
    return (float2)(MIN(rows.x, rows.y), MAX(rows.x, rows.y));
}
