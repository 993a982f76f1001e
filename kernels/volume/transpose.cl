// The layout for layer axis x: from (x fastest, then y, then z) to (z fastest, then y, then x).
//
// One work-item per TRANSPOSED_ROWS rows of the result, with neighbouring x and the same y. For several rows, id = x / TRANSPOSED_ROWS *
// dims_y + y: the work-item advances along z in steps of one cache line, and turns squares of 16 x 16 voxels in registers. For one row,
// id = y * dims_x + x: neighbouring work-items read neighbouring voxels. Source rows are `pitch_y` voxels apart, layers `pitch_z`; the
// first voxel is at `first`.

#include "shared/volume.cl"

#define LAYERS_PER_STEP (64 / VOXEL_BYTES)

#if TRANSPOSED_ROWS > 1
typedef CAT(VOXEL, 16) Sixteen;

#define LOWER(a, b) \
    (Sixteen)((a).s0, (b).s0, (a).s1, (b).s1, (a).s2, (b).s2, (a).s3, (b).s3, (a).s4, (b).s4, (a).s5, (b).s5, (a).s6, (b).s6, (a).s7, (b).s7)
#define UPPER(a, b) \
    (Sixteen)((a).s8, (b).s8, (a).s9, (b).s9, (a).sa, (b).sa, (a).sb, (b).sb, (a).sc, (b).sc, (a).sd, (b).sd, (a).se, (b).se, (a).sf, (b).sf)

// 16 layers of 16 columns, `pitch` apart, become 16 rows `out_pitch` apart: four perfect shuffles of all rows.
static inline void transpose_square(__global const VOXEL *columns, long pitch, __global VOXEL *rows, size_t out_pitch) {
    Sixteen a[16], b[16];
#pragma unroll
    for (int n = 0; n < 16; n++)
        a[n] = vload16(0, columns + pitch * n);
#pragma unroll
    for (int n = 0; n < 8; n++)
        b[2 * n] = LOWER(a[n], a[n + 8]), b[2 * n + 1] = UPPER(a[n], a[n + 8]);
#pragma unroll
    for (int n = 0; n < 8; n++)
        a[2 * n] = LOWER(b[n], b[n + 8]), a[2 * n + 1] = UPPER(b[n], b[n + 8]);
#pragma unroll
    for (int n = 0; n < 8; n++)
        b[2 * n] = LOWER(a[n], a[n + 8]), b[2 * n + 1] = UPPER(a[n], a[n + 8]);
#pragma unroll
    for (int n = 0; n < 8; n++)
        a[2 * n] = LOWER(b[n], b[n + 8]), a[2 * n + 1] = UPPER(b[n], b[n + 8]);
#pragma unroll
    for (int n = 0; n < 16; n++)
        vstore16(a[n], 0, rows + out_pitch * n);
}
#endif

__kernel void transpose(__global const VOXEL *voxels, long first, long pitch_y, long pitch_z, int dims_x, int dims_y, int dims_z,
                        __global VOXEL *transposed, ulong first_item) {
    const size_t id = first_item + get_global_id(0);
    if (id >= (size_t)((dims_x + TRANSPOSED_ROWS - 1) / TRANSPOSED_ROWS) * dims_y)
        return;
#if TRANSPOSED_ROWS == 1
    const size_t first_x = id % dims_x, y = id / dims_x;
#else
    const size_t y = id % dims_y, first_x = id / dims_y * TRANSPOSED_ROWS;
#endif
    __global const VOXEL *columns = voxels + first + first_x + pitch_y * y;
    __global VOXEL *row = transposed + dims_z * (first_x * dims_y + y);
#if TRANSPOSED_ROWS == 1
    for (size_t z = 0; z < dims_z; z++)
        row[z] = columns[pitch_z * z];
#else
    const int rows = min(dims_x - (int)first_x, TRANSPOSED_ROWS);
    const size_t pitch = (size_t)dims_y * dims_z;
    for (size_t from = 0; from < dims_z; from += LAYERS_PER_STEP) {
        const size_t layers = min(dims_z - from, (size_t)LAYERS_PER_STEP);
        if (rows == TRANSPOSED_ROWS && layers == LAYERS_PER_STEP) {
            for (size_t x = 0; x < TRANSPOSED_ROWS; x += 16)
                for (size_t z = 0; z < LAYERS_PER_STEP; z += 16)
                    transpose_square(columns + pitch_z * (from + z) + x, pitch_z, row + x * pitch + from + z, pitch);
            continue;
        }
        for (size_t x = 0; x < rows; x++)
            for (size_t z = 0; z < layers; z++)
                row[x * pitch + from + z] = columns[pitch_z * (from + z) + x];
    }
#endif
}
