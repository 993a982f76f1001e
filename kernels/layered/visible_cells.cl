// What can show anything over some of the cells between voxels: by the bits of slab_visibility.cl, one per block and slab, the space between
// two layers. Slabs are counted from the first layer that voxels hold.

#include "shared/elementary.cl"
#include "shared/volume.cl"

// What rounding may take from a place, in voxels.
#define ROUNDING_MARGIN 0.01f

// Farther than any voxel, and within an int.
#define MAX_CELL 1e9f

// Cells from (u, v) to (u, v), numbered as the voxels before them.
typedef int4 Window;

// The cells from one place (u, v) to another, which is not before it.
static inline Window cells_between(float2 lowest, float2 highest) {
    const float4 ends = CLAMP((float4)(lowest - ROUNDING_MARGIN, highest + ROUNDING_MARGIN), -MAX_CELL, MAX_CELL);
    const int4 cells = convert_int4(ends);
    return cells + (ends < convert_float4(cells));
}

// The blocks over a window, as it is: none where nothing but background is, as none of that counts (src/renderer/region.rs). Bounds are
// vectors: Oclgrind reads lanes of scalar ones.
static inline int4 blocks_in_window(int blocks_u, int blocks_v, Window w) {
    const int4 blocks = (w >> (int4)(BLOCK_U_BITS, BLOCK_V_BITS, BLOCK_U_BITS, BLOCK_V_BITS)) + 1;
    return (int4)(max(blocks.lo, (int2)(0)), min(blocks.hi, (int2)(blocks_u, blocks_v) - 1));
}

// Whether slab q can show anything over a window, block by block: best where these are few. A uint counts the chunks of blocks of 2^40
// voxels, and takes half the registers of a size_t.
static inline bool is_slab_visible(__global const uchar *visible, int blocks_u, int blocks_v, int q, Window w) {
    const int4 blocks = blocks_in_window(blocks_u, blocks_v, w);
    int slabs = 0;
    for (int c = blocks.y; c <= blocks.w; c++)
        for (int b = blocks.x; b <= blocks.z; b++)
            slabs |= visible[((uint)(q >> 3) * blocks_v + c) * blocks_u + b];
    return slabs >> (q & 7) & 1;
}

// How far the voxels that splat into a sample lie from its own cell: the sums of three layers that it mixes have voxels 1 + |s| around the
// ray, which lies |s| farther on the layers beside.
static inline float2 splat_reach(float2 shear) { return 2.0f * fabs(shear); }

// Whether splatted samples of layer k can show anything over a window: a slab at either side of it, 0 ... last_slab.
static inline bool is_layer_visible(__global const uchar *visible, int blocks_u, int blocks_v, int last_slab, int k, Window w) {
    return is_slab_visible(visible, blocks_u, blocks_v, max(k, 0), w) || is_slab_visible(visible, blocks_u, blocks_v, min(k + 1, last_slab), w);
}
