// The voxels as kernels see them: a box of (u, v, a) in any of two layouts, and what lies around it: the background, or, EDGE_GOES_ON,
// the nearest voxel.

#include "shared/vector.cl"

#ifndef VOXEL
#error "VOXEL: type of a voxel"
#endif

// Whether a voxel has a value: not NaN, infinite or beyond 1e30. In src/volume, is_valid().
#define IS_VALID(voxel) (fabs(voxel) <= 1e30f)

// A voxel's value, less the offset. UNCHECKED: in memory of the caller's own, whose floats nobody has looked at: those that are not
// valid count as background, as they do in volumes that were uploaded.
#ifdef UNCHECKED
#define VALUE_OF(view, voxel) (IS_VALID(voxel) ? (voxel) - (view)->offset : (view)->background)
#define VALUES_OF(view, voxels) (IS_VALID(voxels) ? (voxels) - (view)->offset : (realv)((view)->background))
#else
#define VALUE_OF(view, voxel) ((voxel) - (view)->offset)
#define VALUES_OF(view, voxels) ((voxels) - (view)->offset)
#endif

// By how much VW voxels are more than others, as the difference of their values is to the bit; bytes in vectors of half the width.
#if VOXEL_BYTES == 1 && VW > 1
#define WORDS_OF(voxels) CAT(convert_short, VW)(CAT(vload, VW)(0, voxels))
#define DIFFERENCES_OF(view, voxels, others) CONVERT_REALV(WORDS_OF(voxels) - WORDS_OF(others))
#elif VOXEL_BYTES == 4
#define DIFFERENCES_OF(view, voxels, others) (VALUES_OF(view, LOAD_VOXELS(voxels)) - VALUES_OF(view, LOAD_VOXELS(others)))
#else
#define DIFFERENCES_OF(view, voxels, others) (LOAD_VOXELS(voxels) - LOAD_VOXELS(others))
#endif

// The voxel nearest to a value that is not above it, and the one that is not below it; at the ends of the type's range what
// there is.
#if VOXEL_BYTES == 4
#define VOXEL_BELOW(value) (value)
#define VOXEL_ABOVE(value) (value)
#else
#define VOXEL_BELOW(value) CAT(CAT(convert_, VOXEL), _sat_rtn)(value)
#define VOXEL_ABOVE(value) CAT(CAT(convert_, VOXEL), _sat_rtp)(value)
#endif

// Place of layer k >= -2 in a ring of the three layers that a sample mixes.
static inline int slot(int k) { return (k + 3) % 3; }

#ifdef EDGE_GOES_ON
// The voxel that stands for one at or beyond the edge: the nearest one. MIRRORED: the one as far inside, so that the spline which these
// are the coefficients of goes on.
static inline int stand_in(int i, int dims) {
#ifdef MIRRORED
    i = abs(i);
    i = i < dims ? i : 2 * (dims - 1) - i;
#endif
    return clamp(i, 0, dims - 1);
}
#endif

// Voxels from one to the n-th along u. ROWS_ALONG_U: rows lie along it, as in all layouts that are made for it.
#ifdef ROWS_ALONG_U
#define ALONG_U(view, n) (n)
#else
#define ALONG_U(view, n) ((n) * (view)->stride_u)
#endif

// Any voxel, inside or around the volume.
static inline float voxel_at(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k) {
#ifdef EDGE_GOES_ON
    u = stand_in(u, view->dims_u), v = stand_in(v, view->dims_v), k = stand_in(k, view->dims_a);
#endif
    if (u < 0 || u >= view->dims_u || v < 0 || v >= view->dims_v || k < 0 || k >= view->dims_a)
        return view->background;
    return VALUE_OF(view, convert_float(voxels[ALONG_U(view, u) + v * view->stride_v + (k - view->first_a) * view->stride_a]));
}

// Whether a layer has nothing but background.
#ifdef EDGE_GOES_ON
#define BEYOND(k, view) false
#else
#define BEYOND(k, view) ((k) < 0 || (k) >= (view)->dims_a)
#endif

// `vectors` x VW voxels of row v, layer k, from u on, as floats. Needs stride_u = 1.
static inline void load_row(__global const VOXEL *voxels, const VolumeView *view, int u, int v, int k, int vectors, float *row) {
#ifdef EDGE_GOES_ON
    v = stand_in(v, view->dims_v), k = stand_in(k, view->dims_a);
#endif
    const bool inside = v >= 0 && v < view->dims_v && k >= 0 && k < view->dims_a;
    __global const VOXEL *start = voxels + v * view->stride_v + (k - view->first_a) * view->stride_a;
    for (int c = 0; c < vectors; c++, u += VW, row += VW) {
        if (inside && u >= 0 && u + VW <= view->dims_u) {
            STOREV(row, VALUES_OF(view, LOAD_VOXELS(start + u)));
#ifdef EDGE_GOES_ON
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = VALUE_OF(view, convert_float(start[stand_in(u + i, view->dims_u)]));
        }
#else
        } else if (!inside || u + VW <= 0 || u >= view->dims_u) {
            STOREV(row, (realv)(view->background));
        } else if (view->dims_u >= VW) {
            // Across the edge: the last whole vector inside, between two of background.
            const int nearest = clamp(u, 0, view->dims_u - VW);
            float around[3 * VW];
            STOREV(around, (realv)(view->background));
            STOREV(around + VW, VALUES_OF(view, LOAD_VOXELS(start + nearest)));
            STOREV(around + 2 * VW, (realv)(view->background));
            STOREV(row, LOADV(around + VW + (u - nearest)));
        } else {
            for (int i = 0; i < VW; i++)
                row[i] = u + i >= 0 && u + i < view->dims_u ? VALUE_OF(view, convert_float(start[u + i])) : view->background;
        }
#endif
    }
}

// MinMaxBlocks: blocks of BLOCK_U x BLOCK_V voxels of one layer, one block of margin on each side. Mirrored by `BlockNumbers` in
// src/device/launch/blocks.rs.
#define BLOCK_U_BITS 3
#define BLOCK_V_BITS 2
#define BLOCK_U (1 << BLOCK_U_BITS)
#define BLOCK_V (1 << BLOCK_V_BITS)

// Block 0 is the margin before voxel 0.
#define FIRST_OF_BLOCK(block, size) (((block) - 1) * (size))
