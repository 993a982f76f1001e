// Whether a slab, the space between two layers, can show anything near one ray: by the bits of slab_visibility.cl.

#include "shared/elementary.cl"
#include "shared/volume.cl"

// Slab q, counted from the first layer that voxels hold, of a ray that enters it at (u, v). A uint counts the chunks of blocks of 2^40
// voxels, and takes half the registers of a size_t.
static inline bool slab_shows(__global const uchar *visible, int blocks_u, int blocks_v, int q, float u, float v) {
    const int b = clamp(block_of(whole_below(u), BLOCK), 0, blocks_u - 1);
    const int c = clamp(block_of(whole_below(v), POINT_BLOCK_ROWS), 0, blocks_v - 1);
    return visible[((uint)(q >> 3) * blocks_v + c) * blocks_u + b] >> (q & 7) & 1;
}
