// A tile of lattice samples that a work-group renders on GPUs, one per work-item. VW is 1.

#include "shared/vector.cl"

#ifndef SAMPLE_COLUMNS
#error "SAMPLE_COLUMNS: samples of a group along u, a multiple of 8"
#endif
#ifndef SAMPLE_ROWS
#error "SAMPLE_ROWS: along v, a multiple of 4"
#endif

// The first work-group of a launch in bands.
#define FIRST_GROUP (first_item / (SAMPLE_COLUMNS * SAMPLE_ROWS))

// 32 consecutive work-items cover 8 columns and 4 rows, so that neighbours in a work-group are neighbours on the lattice.
static inline int2 place_in_tile(int id) {
    const int block = id / 32, blocks_u = SAMPLE_COLUMNS / 8;
    return (int2)(block % blocks_u * 8 + id % 8, block / blocks_u * 4 + id / 8 % 4);
}

// The first sample of a tile, and the sample of this work-item.
static inline int2 first_sample(int tile, int tiles_u) { return (int2)(tile % tiles_u * SAMPLE_COLUMNS, tile / tiles_u * SAMPLE_ROWS); }
static inline int2 work_item_sample(int tile, int tiles_u) { return first_sample(tile, tiles_u) + place_in_tile(get_local_id(0)); }

// Sums the counts of a work-group.
ALWAYS_INLINE void count_tile(uint own, __local uint *active, __global uint *active_samples) {
    if (!get_local_id(0))
        *active = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    atomic_add(active, own);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!get_local_id(0))
        *active_samples = *active;
}
