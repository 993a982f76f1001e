// Access to voxels: a box of (u, v, a) in either of two layouts. Outside is the background or, EDGE_GOES_ON, the nearest voxel.

#include "shared/vector.cl"

#ifndef VOXEL
#error "VOXEL: type of a voxel"
#endif

// Whether a voxel is valid: not NaN, infinite or beyond 1e30. Same as is_valid() in src/volume.
#define IS_VALID(voxel) (fabs(voxel) <= 1e30f)

// A voxel's value, less the offset. UNCHECKED: the voxels are caller-owned memory with unchecked floats; invalid ones count as
// background, as in uploaded volumes.
#ifdef UNCHECKED
#define VOXEL_VALUE(view, voxel) (IS_VALID(voxel) ? (voxel) - (view)->offset : (view)->background)
#define VOXEL_VALUES(view, voxels) (IS_VALID(voxels) ? (voxels) - (view)->offset : (realv)((view)->background))
#else
#define VOXEL_VALUE(view, voxel) ((voxel) - (view)->offset)
#define VOXEL_VALUES(view, voxels) ((voxels) - (view)->offset)
#endif

// Differences of two vectors of voxels, bit-identical to the differences of their values; for bytes in vectors of half the width.
#if VOXEL_BYTES == 1 && VW > 1
#define LOAD_SHORTS(voxels) CAT(convert_short, VW)(CAT(vload, VW)(0, voxels))
#define VOXEL_DIFFERENCES(view, voxels, others) CONVERT_REALV(LOAD_SHORTS(voxels) - LOAD_SHORTS(others))
#elif VOXEL_BYTES == 4
#define VOXEL_DIFFERENCES(view, voxels, others) (VOXEL_VALUES(view, LOAD_VOXELS(voxels)) - VOXEL_VALUES(view, LOAD_VOXELS(others)))
#else
#define VOXEL_DIFFERENCES(view, voxels, others) (LOAD_VOXELS(voxels) - LOAD_VOXELS(others))
#endif

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

// Value of any voxel, inside or outside the volume.
static inline float voxel_at(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k) {
#ifdef EDGE_GOES_ON
    u = nearest_index(u, view->dims_u), v = nearest_index(v, view->dims_v), k = nearest_index(k, view->dims_a);
#endif
    if (u < 0 || u >= view->dims_u || v < 0 || v >= view->dims_v || k < 0 || k >= view->dims_a)
        return view->background;
    return VOXEL_VALUE(view, convert_float(voxels[OFFSET_U(view, u) + v * view->stride_v + (k - view->first_a) * view->stride_a]));
}

// Whether a layer is entirely background.
#ifdef EDGE_GOES_ON
#define IS_OUTSIDE(k, view) false
#else
#define IS_OUTSIDE(k, view) ((k) < 0 || (k) >= (view)->dims_a)
#endif

// Loads `vectors` x VW voxels of row v, layer k, from u on, as floats. Needs stride_u = 1.
static inline void load_row(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, int vectors, float *row) {
#ifdef EDGE_GOES_ON
    v = nearest_index(v, view->dims_v), k = nearest_index(k, view->dims_a);
#endif
    const bool inside = v >= 0 && v < view->dims_v && k >= 0 && k < view->dims_a;
    __global const VOXEL *start = voxels + v * view->stride_v + (k - view->first_a) * view->stride_a;
    for (int c = 0; c < vectors; c++, u += VW, row += VW) {
        if (inside && u >= 0 && u + VW <= view->dims_u) {
            STOREV(row, VOXEL_VALUES(view, LOAD_VOXELS(start + u)));
#ifdef EDGE_GOES_ON
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = VOXEL_VALUE(view, convert_float(start[nearest_index(u + i, view->dims_u)]));
        }
#else
        } else if (!inside || u + VW <= 0 || u >= view->dims_u) {
            STOREV(row, (realv)(view->background));
        } else if (view->dims_u >= VW) {
            // Across the edge: a window of the nearest whole vector between two vectors of background.
            const int nearest = clamp(u, 0, view->dims_u - VW);
            float around[3 * VW];
            STOREV(around, (realv)(view->background));
            STOREV(around + VW, VOXEL_VALUES(view, LOAD_VOXELS(start + nearest)));
            STOREV(around + 2 * VW, (realv)(view->background));
            STOREV(row, LOADV(around + VW + (u - nearest)));
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = u + i >= 0 && u + i < view->dims_u ? VOXEL_VALUE(view, convert_float(start[u + i])) : view->background;
        }
#endif
    }
}

// Min-max blocks: BLOCK_U x BLOCK_V voxels of one layer, with a margin of one block on each side. Mirrored by `BlockNumbers` in
// src/device/launch/blocks.rs.
#define BLOCK_U_BITS 3
#define BLOCK_V_BITS 2
#define BLOCK_U (1 << BLOCK_U_BITS)
#define BLOCK_V (1 << BLOCK_V_BITS)

// First voxel of a block; block 0 is the margin before voxel 0.
#define FIRST_IN_BLOCK(block, size) (((block) - 1) * (size))
