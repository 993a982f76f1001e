// Visibility of ranges of cells, from the bits of slab_visibility.cl: one per block and slab, the space between two layers. Slabs are
// counted from the first resident layer.

#include "shared/elementary.cl"
#include "shared/volume.cl"

// Margin for rounding errors of positions, in voxels.
#define ROUNDING_MARGIN 0.01f

// Beyond any voxel, and in the range of int.
#define MAX_CELL 1e9f

// A range of cells (u, v, u, v), numbered like the voxels before them.
typedef int4 Window;

// Cells from one position (u, v) to another that is not before it.
static inline Window cells_between(float2 lowest, float2 highest) {
    const float4 ends = CLAMP((float4)(lowest - ROUNDING_MARGIN, highest + ROUNDING_MARGIN), -MAX_CELL, MAX_CELL);
    const int4 cells = convert_int4(ends);
    return cells + (ends < convert_float4(cells));
}

// Blocks over a window. Empty where all is background, which never counts there (src/renderer/region.rs). The bounds are vectors because
// Oclgrind reads lanes even of scalar ones.
static inline int4 blocks_in_window(int blocks_u, int blocks_v, Window w) {
    const int4 blocks = (w >> (int4)(BLOCK_U_BITS, BLOCK_V_BITS, BLOCK_U_BITS, BLOCK_V_BITS)) + 1;
    return (int4)(max(blocks.lo, (int2)(0)), min(blocks.hi, (int2)(blocks_u, blocks_v) - 1));
}

// Whether slab q can be visible over a window, block by block: best for few blocks. A uint is enough for the chunks of blocks of 2^40
// voxels, and takes half the registers of a size_t.
static inline bool is_slab_visible(__global const uchar *visible, int blocks_u, int blocks_v, int q, Window w) {
    const int4 blocks = blocks_in_window(blocks_u, blocks_v, w);
    int slabs = 0;
    for (int c = blocks.y; c <= blocks.w; c++)
        for (int b = blocks.x; b <= blocks.z; b++)
            slabs |= visible[((uint)(q >> 3) * blocks_v + c) * blocks_u + b];
    return slabs >> (q & 7) & 1;
}

// Distance from a sample's cell to the voxels that splat into it. The sums of three layers contribute: their voxels are within 1 + |s| of
// the ray, which is displaced by |s| in the neighbouring layers.
static inline float2 splat_reach(float2 shear) { return 2.0f * fabs(shear); }

// Whether splatted samples of layer k can be visible over a window: checks the slabs on both sides, of 0 ... last_slab.
static inline bool is_layer_visible(__global const uchar *visible, int blocks_u, int blocks_v, int last_slab, int k, Window w) {
    return is_slab_visible(visible, blocks_u, blocks_v, max(k, 0), w) ||
           is_slab_visible(visible, blocks_u, blocks_v, min(k + 1, last_slab), w);
}
