// Visible layers and rows of splatted samples under a tile.

#include "layered/beam.cl"

// Cached visibility of the eight layers of a chunk: bits of their slabs, and of the one behind the last.
typedef struct {
    int index, slabs;
} LayerChunk;

// Whether layer k is the last of its chunk, so that the slab behind it belongs to the next chunk, if there is one.
static inline bool is_last_of_chunk(int last_slab, int k) { return (k & 7) == 7 && k < last_slab; }

// First and last of the `rows` rows of a beam in which splatted samples of layer k can be visible; the first is beyond the last if there
// is none. Tests the whole chunk of eight layers first. `last_slab`: the one behind the last layer in use. `depth`: of layer 0, from the
// layer of the beam's crossings.
static inline int2 visible_rows(__global const uchar *visible, int blocks_u, int blocks_v, int last_slab, const Beam *beam, int rows,
                                float2 reach, float depth, int k, LayerChunk *layer_chunk) {
    const int own = max(k, 0), chunk = own >> 3, first = 8 * chunk;
    if (chunk != layer_chunk->index) {
        const Window w = cells_crossed(beam, depth + first - 1, depth + first + 8, reach);
        layer_chunk->index = chunk;
        layer_chunk->slabs = slabs_in_window(visible, blocks_u, blocks_v, chunk, w);
        if (is_last_of_chunk(last_slab, first + 7))
            layer_chunk->slabs |= (slabs_in_window(visible, blocks_u, blocks_v, chunk + 1, w) & 1) << 8;
    }
    const int2 none = {0, -1};
    if (!(layer_chunk->slabs >> (own - first) & 3))
        return none;
    const int4 blocks = blocks_in_window(blocks_u, blocks_v, cells_crossed(beam, depth + k, depth + k, reach));
    int2 shown = visible_block_rows(visible, blocks_u, blocks_v, chunk, 3 << (own - first) & 0xff, blocks);
    if (is_last_of_chunk(last_slab, own)) {
        const int2 behind = visible_block_rows(visible, blocks_u, blocks_v, chunk + 1, 1, blocks);
        shown = (int2)(min(shown.x, behind.x), max(shown.y, behind.y));
    }
    if (shown.x > shown.y)
        return none;
    const float2 ends = block_rows_extent(shown, blocks_v) + (float2)(-reach.y, reach.y);
    const float v = beam->crossing.y + (depth + k) * beam->shear.y, last_v = beam->crossing.w + (depth + k) * beam->shear.w;
    const float2 over = tile_rows_between(ends, v, rows > 1 ? (last_v - v) / (rows - 1) : 1.0f);
    return (int2)(CLAMP(over.x, 0.0f, (float)rows), CLAMP(over.y, -1.0f, rows - 1.0f));
}

// Layers behind k that are in the same chunk.
static inline int layers_left_in_chunk(int k, int layer_step) {
    const int place = max(k, 0) & 7;
    return layer_step > 0 ? 7 - place : place;
}
