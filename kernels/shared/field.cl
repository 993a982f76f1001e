// The field reconstructed by the kernel of reconstruction.cl, and its gradient, at VW arbitrary points.

#include "shared/point.cl"
#include "shared/reconstruction.cl"
#include "shared/table_entries.cl"
#include "shared/volume.cl"

#ifndef VOXEL_BYTES
#error "VOXEL_BYTES: of a VOXEL"
#endif
#ifndef VOXEL_SIGNED
#error "VOXEL_SIGNED: 1 where a VOXEL is, else 0"
#endif

// Cells of VW points, and the positions of the points in them.
typedef struct {
    intv i, j, k;
    realv x, y, z;
    bool interior; // all voxels in the kernel's support are inside the volume
} Cells;

// Cells of points at distance `z` from layer k towards the next one. `needed`: lanes whose points count. The others may lie anywhere, and
// are moved into the volume.
ALWAYS_INLINE Cells cells_from_layer(const VolumeView *view, realv u, realv v, intv k, realv z, intv needed) {
    Cells c;
    c.i = floor_ints(u), c.j = floor_ints(v), c.k = k;
    c.x = u - CONVERT_REALV(c.i), c.y = v - CONVERT_REALV(c.j), c.z = z;
#if VW == 1
    c.interior = c.i >= 1 && c.i + 2 < view->dims_u && c.j >= 1 && c.j + 2 < view->dims_v && k >= 1 && k + 2 < view->dims_a;
#else
    const intv i = CLAMP_INTV(c.i, 1, view->dims_u - 3), j = CLAMP_INTV(c.j, 1, view->dims_v - 3);
    const intv inner_k = CLAMP_INTV(k, 1, view->dims_a - 3);
    c.interior = view->dims_u > 3 && view->dims_v > 3 && view->dims_a > 3 &&
                 !ANY(needed != 0 && (i != c.i || j != c.j || inner_k != k));
    if (c.interior)
        c.i = i, c.j = j, c.k = inner_k;
#endif
    return c;
}

ALWAYS_INLINE Cells cells_at(const VolumeView *view, realv u, realv v, realv a, intv needed) {
    const intv k = floor_ints(a);
    return cells_from_layer(view, u, v, k, a - CONVERT_REALV(k), needed);
}

// Four consecutive voxels along u: the one before the cell, its two, and the one behind.
typedef struct {
    realv before, low, high, behind;
} Row;

// Four consecutive voxels at each of VW offsets from `start`.
#if defined(GATHER_WORDS) && VOXEL_BYTES < 4
#if VOXEL_SIGNED
#define UNPACK_VOXEL(words, n) CONVERT_REALV(((words) << (32 - 8 * VOXEL_BYTES * ((n) + 1))) >> (32 - 8 * VOXEL_BYTES))
#else
#define UNPACK_VOXEL(words, n) CONVERT_REALV((words) >> (8 * VOXEL_BYTES * (n)) & ((1 << 8 * VOXEL_BYTES) - 1))
#endif
ALWAYS_INLINE Row four_voxels(__global const VOXEL *start, intv at) {
#if VOXEL_BYTES == 1
    const intv words = GATHER_WORDS(start, at);
    const Row row = {UNPACK_VOXEL(words, 0), UNPACK_VOXEL(words, 1), UNPACK_VOXEL(words, 2), UNPACK_VOXEL(words, 3)};
#else
    const intv near = GATHER_WORDS(start, at * 2), far = GATHER_WORDS(start, at * 2 + 4);
    const Row row = {UNPACK_VOXEL(near, 0), UNPACK_VOXEL(near, 1), UNPACK_VOXEL(far, 0), UNPACK_VOXEL(far, 1)};
#endif
    return row;
}
#elif VW > 1
ALWAYS_INLINE Row four_voxels(__global const VOXEL *start, intv at) {
    const int *lane = (const int *)&at;
    Row row;
#define FOUR_VOXELS(n) convert_float4(vload4(0, start + lane[n]))
    COMPONENTS(FOUR_VOXELS, &row.before, &row.low, &row.high, &row.behind);
    return row;
}
#endif

// Voxel rows at the offset (dj, dk) from the cells. FAR_VOXELS: byte offsets can exceed an int.
ALWAYS_INLINE Row voxel_row(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, int dj, int dk) {
    Row row;
    const int *i = (const int *)&c->i, *j = (const int *)&c->j, *k = (const int *)&c->k;
#if VW > 1 && defined(FAR_VOXELS)
    if (c->interior) {
        __global const VOXEL *plane = voxels - 1 - (long)view->first_a * view->stride_a;
#define FOUR_FAR_VOXELS(n) \
    convert_float4(vload4(0, plane + i[n] + (j[n] + dj) * view->stride_v + (k[n] + dk) * view->stride_a))
        COMPONENTS(FOUR_FAR_VOXELS, &row.before, &row.low, &row.high, &row.behind);
        row.before = VOXEL_VALUES(view, row.before), row.low = VOXEL_VALUES(view, row.low);
        row.high = VOXEL_VALUES(view, row.high), row.behind = VOXEL_VALUES(view, row.behind);
        return row;
    }
#elif VW > 1
    if (c->interior) {
        __global const VOXEL *start = voxels + i[0] - 1 + (j[0] + dj) * view->stride_v + (k[0] + dk - view->first_a) * view->stride_a;
        const intv at = c->i - i[0] + (c->j - j[0]) * (int)view->stride_v + (c->k - k[0]) * (int)view->stride_a;
        row = four_voxels(start, at);
        row.before = VOXEL_VALUES(view, row.before), row.low = VOXEL_VALUES(view, row.low);
        row.high = VOXEL_VALUES(view, row.high), row.behind = VOXEL_VALUES(view, row.behind);
        return row;
    }
#else
    if (c->interior) {
        __global const VOXEL *start =
            voxels + OFFSET_U(view, c->i - 1) + (c->j + dj) * view->stride_v + (c->k + dk - view->first_a) * view->stride_a;
        row.before = VOXEL_VALUE(view, convert_float(start[0])), row.low = VOXEL_VALUE(view, convert_float(start[OFFSET_U(view, 1)]));
        row.high = VOXEL_VALUE(view, convert_float(start[OFFSET_U(view, 2)])),
        row.behind = VOXEL_VALUE(view, convert_float(start[OFFSET_U(view, 3)]));
        return row;
    }
#endif
    float *out = (float *)&row;
    for (int n = 0; n < VW; n++)
        for (int e = 0; e < 4; e++)
            out[e * VW + n] = voxel_at(voxels, view, i[n] - 1 + e, j[n] + dj, k[n] + dk);
    return row;
}

// The field in the voxel plane dk layers from the cells, interpolated along u and v.
ALWAYS_INLINE realv value_in_plane(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, const Weights *x,
                                   const Weights *y, int dk) {
    realv rows[4];
#pragma unroll
    for (int dj = FIRST_TAP; dj <= LAST_TAP; dj++) {
        Row row = voxel_row(voxels, view, c, dj, dk);
#if KERNEL == GAUSSIAN
        // The weights of this kernel do not sum to one: they must not scale the background.
        row.before -= view->background, row.low -= view->background;
        row.high -= view->background, row.behind -= view->background;
#endif
        rows[dj + 1] = MIXED(x->tap, row.before, row.low, row.high, row.behind);
    }
    return MIXED(y->tap, rows[0], rows[1], rows[2], rows[3]);
}

#if VW == 1 && KERNEL != GAUSSIAN
#include "shared/scalar_field.cl"
#else
ALWAYS_INLINE realv value_at(__global const VOXEL *voxels, const VolumeView *view, realv u, realv v, realv a, intv needed) {
    const Cells c = cells_at(view, u, v, a, needed);
    const Weights x = value_weights(c.x), y = value_weights(c.y), z = value_weights(c.z);
    realv planes[4];
#pragma unroll
    for (int dk = FIRST_TAP; dk <= LAST_TAP; dk++)
        planes[dk + 1] = value_in_plane(voxels, view, &c, &x, &y, dk);
    const realv value = MIXED(z.tap, planes[0], planes[1], planes[2], planes[3]);
    return KERNEL == GAUSSIAN ? view->background + value : value;
}

#if KERNEL == GAUSSIAN
// The gradient, in voxel differences: central differences of the field over one voxel in each direction. One call in a loop instead of
// six: Intel's compiler takes 394 s for six calls and 80 s for the loop. On PoCL the loop costs 3 % per frame and saves a fifth of the
// compile time.
static inline Gradient gradient_at(__global const VOXEL *voxels, const VolumeView *view, const FieldParams *field, realv u, realv v,
                                   realv a, intv needed) {
    realv values[6];
#pragma unroll 1
    for (int n = 0; n < 6; n++) {
        const float away = n & 1 ? -1.0f : 1.0f;
        const float du = n < 2 ? away : 0.0f, dv = n >> 1 == 1 ? away : 0.0f, da = n >> 1 == 2 ? away : 0.0f;
        values[n] = value_at(voxels, view, u + du, v + dv, a + da, needed);
    }
    const Gradient gradient = {0.5f * (values[0] - values[1]), 0.5f * (values[2] - values[3]), 0.5f * (values[4] - values[5])};
    return gradient;
}
#else
// The gradient, in voxel differences: slopes along its own axis, weights across it along the others. All three components share the same
// voxel rows.
static inline Gradient gradient_at(__global const VOXEL *voxels, const VolumeView *view, const FieldParams *field, realv u, realv v,
                                   realv a, intv needed) {
    const Cells c = cells_at(view, u, v, a, needed);
    const Weights x = across_weights(c.x, field->smoothing_u), y = across_weights(c.y, field->smoothing_v);
    const Weights z = across_weights(c.z, field->smoothing_a);
    const Weights slope_x = slope_weights(c.x), slope_y = slope_weights(c.y), slope_z = slope_weights(c.z);
    realv planes[4], planes_u[4], planes_v[4];
#pragma unroll
    for (int dk = -1; dk <= 2; dk++) {
        realv rows[4], rows_u[4];
#pragma unroll
        for (int dj = -1; dj <= 2; dj++) {
            if (!IS_ACROSS_TAP(dj) && !IS_ACROSS_TAP(dk))
                continue;
            const Row row = voxel_row(voxels, view, &c, dj, dk);
            rows[dj + 1] = ACROSS(x.tap, row.before, row.low, row.high, row.behind);
            if (IS_ACROSS_TAP(dj) && IS_ACROSS_TAP(dk))
                rows_u[dj + 1] = SLOPE(slope_x.tap, row.before, row.low, row.high, row.behind);
        }
        planes[dk + 1] = ACROSS(y.tap, rows[0], rows[1], rows[2], rows[3]);
        if (IS_ACROSS_TAP(dk)) {
            planes_u[dk + 1] = ACROSS(y.tap, rows_u[0], rows_u[1], rows_u[2], rows_u[3]);
            planes_v[dk + 1] = SLOPE(slope_y.tap, rows[0], rows[1], rows[2], rows[3]);
        }
    }
    const Gradient gradient = {ACROSS(z.tap, planes_u[0], planes_u[1], planes_u[2], planes_u[3]),
                               ACROSS(z.tap, planes_v[0], planes_v[1], planes_v[2], planes_v[3]),
                               SLOPE(slope_z.tap, planes[0], planes[1], planes[2], planes[3])};
    return gradient;
}
#endif
#endif
