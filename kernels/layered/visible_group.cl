// Cooperative visibility look-up on GPUs: the work-items of a group test different slabs, or splatted layers, for the whole group, and
// then cross the visible ones together. Single rays would have to test all their slabs, one after another.

#include "layered/ray_lattice.cl"
#include "layered/sample_tile.cl"
#include "shared/bit_sets.cl"

// Number of slabs or layers that are tested, 1 KiB of bits; further ones count as visible.
#define MAX_LOOKED_UP 8192
#define WORDS_LOOKED_UP (MAX_LOOKED_UP / 32)

// The outermost rays of the samples of a tile.
static inline Beam tile_beam(const RayLatticeParams *p, int tile) {
    const int2 first = first_sample(tile, p->tiles_u);
    Beam beam = make_beam(p, first.x, first.y, min(SAMPLE_COLUMNS, p->width - first.x), min(SAMPLE_ROWS, p->height - first.y));
    // The stagger of columns is less than a row.
    if (p->first_stagger | p->stagger_per_column)
        beam.crossing.w += p->rays[5];
    return beam;
}

// Whether slab or layer `at` can be visible to a beam; defined by the including file.
static inline bool is_visible_to_beam(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, const Beam *beam,
                                      int at);

// Tests `count` slabs or layers, from `first` on in the order of rays, with all work-items of a group. One bit each.
ALWAYS_INLINE void find_visible(__global const uchar *visible, const RayLatticeParams *p, const VolumeView *view, int tile, int first,
                                int count, __local uint *bits) {
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

// The lowest element of a word, counted from the first one of all.
static inline int lowest_in_word(int word, uint left) { return 32 * word + (int)LOWEST_BIT(left); }

// Visible elements of a word, of `count` in all.
static inline uint visible_word(__local const uint *bits, int word, int count) {
    const uint all = word < WORDS_LOOKED_UP ? bits[word] : ~0u;
    const int left = count - 32 * word;
    return left < 32 ? all & ~0u >> (32 - left) : all;
}
