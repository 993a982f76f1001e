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
static inline ulong row_of_blocks(__global const uchar *row, int b0, int b1) {
    if (b1 - b0 > 7)
        return ~0ul;
    return b1 < b0 ? 0 : as_ulong(vload8(0, row + b0)) << 8 * (7 - (b1 - b0));
}

// And over a window, of all its blocks together.
static inline int slabs_over(__global const uchar *visible, int blocks_u, int blocks_v, int chunk, Window w) {
    const int4 blocks = blocks_over(blocks_u, blocks_v, w);
    ulong bits = 0;
    for (int c = blocks.y; c <= blocks.w; c++)
        bits |= row_of_blocks(visible + ((uint)chunk * blocks_v + c) * blocks_u, blocks.x, blocks.z);
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
}
