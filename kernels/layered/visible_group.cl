// Which slabs, or splatted layers, can show anything before the rays of a group, a work-item to each: they look at different ones, and go through
// those that can side by side. A ray by itself would look at all that lie before it, one after another.

#include "layered/ray_lattice.cl"
#include "layered/sample_tile.cl"
#include "shared/bit_sets.cl"

// Slabs or layers that are looked up, 1 KiB of bits: those behind them count as if they could.
#define MAX_LOOKED_UP 8192
#define WORDS_LOOKED_UP (MAX_LOOKED_UP / 32)

// The outermost rays of a tile's samples.
static inline Beam tile_beam(const RayLatticeParams *p, int tile) {
    const int2 first = first_sample(tile, p->tiles_u);
    Beam beam = make_beam(p, first.x, first.y, min(SAMPLE_COLUMNS, p->width - first.x), min(SAMPLE_ROWS, p->height - first.y));
    // Staggered columns lie less than a row behind.
    if (p->first_stagger | p->stagger_per_column)
        beam.crossing.w += p->rays[5];
    return beam;
}

// Whether a beam can see anything of the one at a number: known to who includes this.
static inline bool is_visible_to_beam(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, const Beam *beam, int at);

// Looks up so many, from `first` on in the order of rays, with all work-items of a group: a bit each.
ALWAYS_INLINE void find_visible(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, int tile,
                           int first, int count, __local uint *bits) {
    const int id = get_local_id(0), group = SAMPLE_COLUMNS * SAMPLE_ROWS, looked_up = min(count, MAX_LOOKED_UP);
    for (int word = id; 32 * word < looked_up; word += group)
        bits[word] = p->culling ? 0 : ~0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (p->culling) {
        const Beam beam = tile_beam(p, tile);
        for (int n = id; n < looked_up; n += group)
            if (is_visible_to_beam(visible, p, view, &beam, first + n * p->layer_step))
                atomic_or(&bits[n / 32], 1u << n % 32);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// The lowest one of a word, counted from the first of all.
static inline int lowest_in_word(int word, uint left) { return 32 * word + (int)LOWEST_BIT(left); }

// Those of a word that can show anything, of so many in all.
static inline uint visible_word(__local const uint *bits, int word, int count) {
    const uint all = word < WORDS_LOOKED_UP ? bits[word] : ~0u;
    const int left = count - 32 * word;
    return left < 32 ? all & ~0u >> (32 - left) : all;
}
