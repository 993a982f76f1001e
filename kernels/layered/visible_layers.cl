// Which layers can show anything in splatted samples under a tile.

#include "layered/beam.cl"

// What is known of eight layers: bits of the slabs before them, and of the one behind the last.
typedef struct {
    int index, slabs;
} Chunk;

static inline int slabs_around(__global const uchar *visible, int blocks_u, int blocks_v, int layers, int chunk, Window w) {
    const int own = slabs_over(visible, blocks_u, blocks_v, chunk, w), next = chunk + 1;
    return 8 * next > layers ? own : own | (slabs_over(visible, blocks_u, blocks_v, next, w) & 1) << 8;
}

// Whether any sample of a beam on layer k, -1 ... layers, can show anything: first by a look at eight layers. `depth`: of layer 0, from
// where the beam's crossings are.
static inline bool beam_shows(__global const uchar *visible, int blocks_u, int blocks_v, int layers, const Beam *beam, float2 reach,
                              float depth, int k, Chunk *known) {
    const int chunk = max(k, 0) >> 3, first = 8 * chunk, own = max(k, 0) - first;
    if (chunk != known->index) {
        known->index = chunk;
        known->slabs = slabs_around(visible, blocks_u, blocks_v, layers, chunk,
                                    cells_crossed(beam, depth + first - 1, depth + first + 8, reach));
    }
    if (!(known->slabs >> own & 3))
        return false;
    const Window w = cells_crossed(beam, depth + k, depth + k, reach);
    return slabs_around(visible, blocks_u, blocks_v, layers, chunk, w) >> own & 3;
}
