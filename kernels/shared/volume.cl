// Access to voxels: a box of (u, v, a) in either of two layouts. Outside is the background or, EDGE_GOES_ON, the nearest voxel.

#include "shared/vector.cl"

#ifndef VOXEL
#error "VOXEL: type of a voxel"
#endif

// Whether a voxel is valid: not NaN, infinite or beyond 1e30. Same as is_valid() in src/host/volume.
#define IS_VALID(voxel) (fabs(voxel) <= 1e30f)

// A voxel's value, less the offset. UNCHECKED: the voxels are caller-owned memory with unchecked floats; invalid ones count as
// background, as in uploaded volumes.
#define PLAIN_VALUE(view, voxel) ((voxel) - (view)->offset)
#define CHECKED_VALUE(view, voxel) (IS_VALID(voxel) ? (voxel) - (view)->offset : (view)->background)
#define CHECKED_VALUES(view, voxels) (IS_VALID(voxels) ? (voxels) - (view)->offset : (realv)((view)->background))
#ifdef UNCHECKED
#define VOXEL_VALUE CHECKED_VALUE
#define VOXEL_VALUES CHECKED_VALUES
#else
#define VOXEL_VALUE PLAIN_VALUE
#define VOXEL_VALUES PLAIN_VALUE
#endif

// Differences of two vectors of voxels, bit-identical to the differences of their values; for bytes in vectors of half the width.
// `values`: VOXEL_VALUES of this type, of 1, 2 or 4 bytes.
#if VW > 1
#define LOAD_SHORTS(voxels) CAT(convert_short, VW)(CAT(vload, VW)(0, voxels))
#define DIFFERENCES_1(values, view, voxels, others) CONVERT_REALV(LOAD_SHORTS(voxels) - LOAD_SHORTS(others))
#else
#define DIFFERENCES_1 DIFFERENCES_2
#endif
#define DIFFERENCES_2(values, view, voxels, others) (LOAD_VOXELS(voxels) - LOAD_VOXELS(others))
#define DIFFERENCES_4(values, view, voxels, others) (values(view, LOAD_VOXELS(voxels)) - values(view, LOAD_VOXELS(others)))
#define VOXEL_DIFFERENCES(view, voxels, others) CAT(DIFFERENCES_, VOXEL_BYTES)(VOXEL_VALUES, view, voxels, others)
#define ELEMENT_DIFFERENCES(view, voxels, others) CAT(DIFFERENCES_, ELEMENT_BYTES)(ELEMENT_VALUES, view, voxels, others)

// The largest voxel not above a value, and the smallest not below it, saturated to the range of the type.
#if VOXEL_BYTES == 4
#define VOXEL_BELOW(value) (value)
#define VOXEL_ABOVE(value) (value)
#else
#define VOXEL_BELOW(value) CAT(CAT(convert_, VOXEL), _sat_rtn)(value)
#define VOXEL_ABOVE(value) CAT(CAT(convert_, VOXEL), _sat_rtp)(value)
#endif

// Slot of layer k >= -2 in a ring of the three layers that a sample mixes.
static inline int slot(int k) { return (k + 3) % 3; }

#ifdef EDGE_GOES_ON
// Index of the voxel used for one at or beyond the edge: the nearest one. MIRRORED: the mirrored one, which continues a spline with these
// coefficients.
static inline int nearest_index(int i, int dims) {
#ifdef MIRRORED
    i = abs(i);
    i = i < dims ? i : 2 * (dims - 1) - i;
#endif
    return clamp(i, 0, dims - 1);
}
#endif

// Offset of n voxels along u. ROWS_ALONG_U: rows are contiguous along u, as in all layouts prepared for this.
#ifdef ROWS_ALONG_U
#define OFFSET_U(view, n) (n)
#else
#define OFFSET_U(view, n) ((n) * (view)->stride_u)
#endif

// Whether a layer is entirely background.
#ifdef EDGE_GOES_ON
#define IS_OUTSIDE(k, view) false
#else
#define IS_OUTSIDE(k, view) ((k) < 0 || (k) >= (view)->dims_a)
#endif

#include "shared/value_voxels.cl"
#include "shared/voxel_access.cl"

// Min-max blocks: BLOCK_U x BLOCK_V voxels of one layer, with a margin of one block on each side. Mirrored by `BlockNumbers` in
// src/device/launch/blocks.rs.
#define BLOCK_U_BITS 3
#define BLOCK_V_BITS 2
#define BLOCK_U (1 << BLOCK_U_BITS)
#define BLOCK_V (1 << BLOCK_V_BITS)

// First voxel of a block; block 0 is the margin before voxel 0.
#define FIRST_IN_BLOCK(block, size) (((block) - 1) * (size))
