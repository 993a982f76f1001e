// Which slabs can show anything under a tile, and under which of its patches: `visible`, a bit per block and slab, from slab_visibility.cl.

#include "layered/tile.cl"

// What rounding may take from a row of samples. (It takes more of rows that are less than a thousandth of a voxel apart: what they miss of a
// block is less than that.)
#define ROUNDED 0.01f

// The blocks over a window, and where the bits of the first are.
typedef struct {
    int b0, b1, c0, c1;
    __global const uchar *first;
} Blocks;

static inline Blocks blocks_over(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    Blocks blocks;
    blocks.b0 = clamp(block_of(w.u0, BLOCK), 0, p->blocks_u - 1), blocks.b1 = clamp(block_of(w.u1, BLOCK), 0, p->blocks_u - 1);
    blocks.c0 = clamp(block_of(w.v0, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    blocks.c1 = clamp(block_of(w.v1, POINT_BLOCK_ROWS), 0, p->blocks_v - 1);
    blocks.first = visible + ((size_t)chunk * p->blocks_v + blocks.c0) * p->blocks_u + blocks.b0;
    return blocks;
}

// A row of blocks is read at once; more than eight are not looked at.
#define MOST_BLOCKS 8
static inline ulong bits_of(__global const uchar *row, const Blocks *blocks) {
    return as_ulong(vload8(0, row)) << 8 * (MOST_BLOCKS - 1 - (blocks->b1 - blocks->b0));
}

// Whether the slabs of a chunk can show anything over a window: bit q % 8.
static inline int slabs_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, Window w) {
    const Blocks blocks = blocks_over(visible, p, chunk, w);
    if (blocks.b1 - blocks.b0 >= MOST_BLOCKS)
        return 0xff;
    __global const uchar *row = blocks.first;
    ulong bits = 0;
    for (int c = blocks.c0; c <= blocks.c1; c++, row += p->blocks_u)
        bits |= bits_of(row, &blocks);
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return bits & 0xff;
}

// The patches of a tile over which a slab of a chunk can show anything: from the first to the last row of blocks that can.
static inline int patches_visible(__global const uchar *visible, const RayLatticeParams *p, int chunk, int slab, const Tile *tile, float depth) {
    const int all = FIRST_FEW(tile->bands * PATCH_ROWS);
    const Blocks blocks = blocks_over(visible, p, chunk, window_at(tile, depth));
    if (blocks.b1 - blocks.b0 >= MOST_BLOCKS)
        return all;
    __global const uchar *row = blocks.first;
    int first = INT_MAX, last = INT_MIN;
    for (int c = blocks.c0; c <= blocks.c1; c++, row += p->blocks_u)
        if (bits_of(row, &blocks) & 0x0101010101010101ul << slab)
            first = min(first, c), last = c;
    if (first > last)
        return 0;
    if (first == blocks.c0 && last == blocks.c1)
        return all;
    // Rows of samples over them: blocks at the edges have all that is beyond too.
    const float v = tile->first_v.x + depth * tile->first_v.y, spacing = p->rays[5] + depth * p->rays[7];
    const float above = first == 0 ? -INFINITY : FIRST_OF_BLOCK(first, POINT_BLOCK_ROWS) - v;
    const float below = last == p->blocks_v - 1 ? INFINITY : FIRST_OF_BLOCK(last + 1, POINT_BLOCK_ROWS) - v;
    const float one = above / spacing, other = below / spacing;
    // A staggered column lies less than a row behind.
    const int top = CLAMP(MIN(one, other) - (FARTHEST ? 1.0f : 0.0f) - ROUNDED, 0.0f, (float)TILE_ROWS);
    const int bottom = CLAMP(MAX(one, other) + ROUNDED, -1.0f, tile->rows - 1.0f);
    return FIRST_FEW(bottom / PATCH_ROWS * PATCH_ROWS + PATCH_ROWS) & ~FIRST_FEW(top / PATCH_ROWS * PATCH_ROWS);
}

// Bits of the chunk of slabs that a tile is in.
typedef struct {
    int index, bits;
} Chunk;

// How many slabs from q on, up to `last` of a ray's order, can show nothing under a tile, as far as that is known: whole
// chunks first, then a slab of its own, of which the `patches` are told. `visible` counts slabs from `first`, the first layer that voxels hold.
// `enters`: 0 or 1, a ray enters slab q at layer q-RADIUS+enters.
ALWAYS_INLINE int slabs_to_skip(__global const uchar *visible, const RayLatticeParams *p, int first, const Tile *tile, int q,
                                int last, int enters, Chunk *chunk, int *patches) {
    const float to_plane = first + enters - RADIUS - p->centre_layer;
    q -= first, last -= first;
    if (q >> 3 != chunk->index) {
        chunk->index = q >> 3;
        const int end = enters ? max(q & ~7, last) : min(q | 7, last);
        const Window a = window_at(tile, q + to_plane), b = window_at(tile, end + to_plane);
        const Window both = {min(a.u0, b.u0), max(a.u1, b.u1), min(a.v0, b.v0), max(a.v1, b.v1)};
        chunk->bits = slabs_visible(visible, p, chunk->index, both);
        if (!chunk->bits)
            return abs(end - q) + 1;
    }
    if (!(chunk->bits >> (q & 7) & 1))
        return 1;
    *patches = patches_visible(visible, p, chunk->index, q & 7, tile, q + to_plane);
    return !*patches;
}
