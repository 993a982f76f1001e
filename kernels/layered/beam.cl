// Rays side by side, as those of a tile, and what can show anything before them.

#include "layered/visible_cells.cl"

// Where the first and the last of them cross a layer, along u and v, and their shears.
typedef struct {
    float4 crossing, shear;
} Beam;

// The cells that a beam crosses from one plane to another, and `reach` around them.
static inline Window cells_crossed(const Beam *beam, float depth, float to_depth, float2 reach) {
    const float4 at = beam->crossing + depth * beam->shear, to = beam->crossing + to_depth * beam->shear;
    const float4 lowest = MIN(at, to), highest = MAX(at, to);
    return cells_between(MIN(lowest.lo, lowest.hi) - reach, MAX(highest.lo, highest.hi) + reach);
}

// The slabs of a chunk of eight over a row of blocks, b0 ... b1: bits q % 8 of a byte for each. A row is read at once; more than eight are not
// looked at, and none are left of none.
static inline ulong load_block_row(__global const uchar *row, int b0, int b1) {
    if (b1 - b0 > 7)
        return ~0ul;
    return b1 < b0 ? 0 : as_ulong(vload8(0, row + b0)) << 8 * (7 - (b1 - b0));
}

// And over a window, of all its blocks together.
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

// The first and the last row of some blocks in which any of some slabs of a chunk can show anything; none: the first beyond the last.
static inline int2 visible_block_rows(__global const uchar *visible, int blocks_u, int blocks_v, int chunk, int slabs, int4 blocks) {
    const ulong any = 0x0101010101010101ul * slabs;
    int2 rows = {INT_MAX, INT_MIN};
    for (int c = blocks.y; c <= blocks.w; c++)
        if (load_block_row(visible + ((uint)chunk * blocks_v + c) * blocks_u, blocks.x, blocks.z) & any)
            rows = (int2)(min(rows.x, c), c);
    return rows;
}

// The places along v that rows of blocks lie between: at the edges all that is beyond too.
static inline float2 block_rows_extent(int2 rows, int blocks_v) {
    return (float2)(rows.x == 0 ? -INFINITY : FIRST_IN_BLOCK(rows.x, BLOCK_V) - ROUNDING_MARGIN,
                    rows.y == blocks_v - 1 ? INFINITY : FIRST_IN_BLOCK(rows.y + 1, BLOCK_V) + ROUNDING_MARGIN);
}

// The rows of a tile between two places, whose first one is at `v` and the next `spacing` on.
static inline float2 tile_rows_between(float2 ends, float v, float spacing) {
    const float2 rows = (ends - v) / spacing;
    return (float2)(MIN(rows.x, rows.y), MAX(rows.x, rows.y));
}
