// The reconstructed field at any points, VW at once: by 1 - |x| per axis, or with TRICUBIC by the paper's cubic (Eq. 2),
// or with GAUSSIAN by the sheet methods' kernel, cut off at two voxels per axis.

#include "shared/elementary.cl"
#include "shared/table_entries.cl"
#include "shared/volume.cl"

#ifndef VOXEL_BYTES
#error "VOXEL_BYTES: of a VOXEL"
#endif
#ifndef VOXEL_SIGNED
#error "VOXEL_SIGNED: 1 where a VOXEL is, else 0"
#endif

// The cells of VW points, and where in them these lie.
typedef struct {
    intv i, j, k;
    realv x, y, z;
    bool interior; // no voxel in reach is beyond the volume's edge
} Cells;

// `needed`: lanes whose points count; the others' may lie anywhere, and are moved into the volume.
ALWAYS_INLINE Cells cells_of(const VolumeView *view, realv u, realv v, realv a, intv needed) {
    Cells c;
    c.i = wholes_below(u), c.j = wholes_below(v), c.k = wholes_below(a);
    c.x = u - CONVERT_REALV(c.i), c.y = v - CONVERT_REALV(c.j), c.z = a - CONVERT_REALV(c.k);
    const intv i = clamp(c.i, 1, view->dims_u - 3), j = clamp(c.j, 1, view->dims_v - 3), k = clamp(c.k, 1, view->dims_a - 3);
    c.interior = view->dims_u > 3 && view->dims_v > 3 && view->dims_a > 3 &&
                 !ANY(needed != 0 && (i != c.i || j != c.j || k != c.k));
    if (c.interior)
        c.i = i, c.j = j, c.k = k;
    return c;
}

// Four voxels in a row along u, from one before the cell on.
typedef struct {
    realv before, low, high, behind;
} Row;

// Four voxels from each of VW places on, counted from `start`.
#if defined(GATHER_WORDS) && VOXEL_BYTES < 4
#if VOXEL_SIGNED
#define VOXEL_OF(words, n) CONVERT_REALV(((words) << (32 - 8 * VOXEL_BYTES * ((n) + 1))) >> (32 - 8 * VOXEL_BYTES))
#else
#define VOXEL_OF(words, n) CONVERT_REALV((words) >> (8 * VOXEL_BYTES * (n)) & ((1 << 8 * VOXEL_BYTES) - 1))
#endif
ALWAYS_INLINE Row four_voxels(__global const VOXEL *start, intv at) {
#if VOXEL_BYTES == 1
    const intv words = GATHER_WORDS(start, at);
    const Row row = {VOXEL_OF(words, 0), VOXEL_OF(words, 1), VOXEL_OF(words, 2), VOXEL_OF(words, 3)};
#else
    const intv near = GATHER_WORDS(start, at * 2), far = GATHER_WORDS(start, at * 2 + 4);
    const Row row = {VOXEL_OF(near, 0), VOXEL_OF(near, 1), VOXEL_OF(far, 0), VOXEL_OF(far, 1)};
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

// Of the cells' rows, dj and dk away from them. FAR_VOXELS: voxels can lie farther apart than an int counts in bytes.
ALWAYS_INLINE Row voxel_row(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, int dj, int dk) {
    Row row;
    const int *i = (const int *)&c->i, *j = (const int *)&c->j, *k = (const int *)&c->k;
#if VW > 1 && defined(FAR_VOXELS)
    if (c->interior) {
        __global const VOXEL *plane = voxels - 1 - (long)view->first_a * view->stride_a;
#define FOUR_FAR_VOXELS(n) \
    convert_float4(vload4(0, plane + i[n] + (j[n] + dj) * view->stride_v + (k[n] + dk) * view->stride_a))
        COMPONENTS(FOUR_FAR_VOXELS, &row.before, &row.low, &row.high, &row.behind);
        row.before -= view->offset, row.low -= view->offset, row.high -= view->offset, row.behind -= view->offset;
        return row;
    }
#elif VW > 1
    if (c->interior) {
        __global const VOXEL *start = voxels + i[0] - 1 + (j[0] + dj) * view->stride_v + (k[0] + dk - view->first_a) * view->stride_a;
        const intv at = c->i - i[0] + (c->j - j[0]) * (int)view->stride_v + (c->k - k[0]) * (int)view->stride_a;
        row = four_voxels(start, at);
        row.before -= view->offset, row.low -= view->offset, row.high -= view->offset, row.behind -= view->offset;
        return row;
    }
#endif
    float *out = (float *)&row;
    for (int n = 0; n < VW; n++)
        for (int e = 0; e < 4; e++)
            out[e * VW + n] = voxel_at(voxels, view, i[n] - 1 + e, j[n] + dj, k[n] + dk);
    return row;
}

#ifdef GAUSSIAN
// c1 exp(-2 x^2), c1 = sqrt(2/pi) / erf(2 sqrt 2).
inline realv gaussian(realv x) { return 0.7979350f * exp2_of(x * x * -2.8853900818f); }

ALWAYS_INLINE realv value_in(__global const VOXEL *voxels, const VolumeView *view, const Cells *c) {
    const float missing = view->background;
    const realv x0 = gaussian(c->x + 1.0f), x1 = gaussian(c->x), x2 = gaussian(1.0f - c->x), x3 = gaussian(2.0f - c->x);
    realv sum = 0.0f;
#pragma unroll
    for (int dk = -1; dk <= 2; dk++) {
        realv plane = 0.0f;
#pragma unroll
        for (int dj = -1; dj <= 2; dj++) {
            const Row row = voxel_row(voxels, view, c, dj, dk);
            plane += gaussian(c->y - dj) * (x0 * (row.before - missing) + x1 * (row.low - missing) +
                                            x2 * (row.high - missing) + x3 * (row.behind - missing));
        }
        sum += gaussian(c->z - dk) * plane;
    }
    return missing + sum;
}

ALWAYS_INLINE realv value_at(__global const VOXEL *voxels, const VolumeView *view, realv u, realv v, realv a, intv needed) {
    const Cells c = cells_of(view, u, v, a, needed);
    return value_in(voxels, view, &c);
}

// Central differences over two voxels.
inline void differences_at(__global const VOXEL *voxels, const VolumeView *view, realv u, realv v, realv a, intv needed,
                           realv *along_u, realv *along_v, realv *along_a) {
    *along_u = 0.5f * (value_at(voxels, view, u + 1.0f, v, a, needed) - value_at(voxels, view, u - 1.0f, v, a, needed));
    *along_v = 0.5f * (value_at(voxels, view, u, v + 1.0f, a, needed) - value_at(voxels, view, u, v - 1.0f, a, needed));
    *along_a = 0.5f * (value_at(voxels, view, u, v, a + 1.0f, needed) - value_at(voxels, view, u, v, a - 1.0f, needed));
}
#else
#ifdef TRICUBIC
#define WEIGHT(x) SMOOTHSTEP(x)
#else
#define WEIGHT(x) (x)
#endif

inline realv mixed(realv a, realv b, realv t) { return a + t * (b - a); }

ALWAYS_INLINE realv value_at(__global const VOXEL *voxels, const VolumeView *view, realv u, realv v, realv a, intv needed) {
    const Cells c = cells_of(view, u, v, a, needed);
    const realv x = WEIGHT(c.x), y = WEIGHT(c.y), z = WEIGHT(c.z);
    realv plane[2];
#pragma unroll
    for (int dk = 0; dk < 2; dk++) {
        const Row low = voxel_row(voxels, view, &c, 0, dk), high = voxel_row(voxels, view, &c, 1, dk);
        plane[dk] = mixed(mixed(low.low, low.high, x), mixed(high.low, high.high, x), y);
    }
    return mixed(plane[0], plane[1], z);
}

// Central differences over two voxels: twelve rows serve all three.
inline void differences_at(__global const VOXEL *voxels, const VolumeView *view, realv u, realv v, realv a, intv needed,
                           realv *along_u, realv *along_v, realv *along_a) {
    const Cells c = cells_of(view, u, v, a, needed);
    const realv x = WEIGHT(c.x), y = WEIGHT(c.y), z = WEIGHT(c.z);
    realv value[4][4], difference[2][2]; // rows (dj + 1, dk + 1), interpolated along u; and of the inner ones the difference
#pragma unroll
    for (int dk = -1; dk <= 2; dk++)
#pragma unroll
        for (int dj = -1; dj <= 2; dj++) {
            const bool inner_j = dj == 0 || dj == 1, inner_k = dk == 0 || dk == 1;
            if (!inner_j && !inner_k)
                continue;
            const Row row = voxel_row(voxels, view, &c, dj, dk);
            value[dk + 1][dj + 1] = mixed(row.low, row.high, x);
            if (inner_j && inner_k)
                difference[dk][dj] = mixed(row.high - row.before, row.behind - row.low, x);
        }
    *along_u = 0.5f * mixed(mixed(difference[0][0], difference[0][1], y), mixed(difference[1][0], difference[1][1], y), z);
    realv across[2];
#pragma unroll
    for (int n = 0; n < 2; n++)
        across[n] = mixed(value[n + 1][2] - value[n + 1][0], value[n + 1][3] - value[n + 1][1], y);
    *along_v = 0.5f * mixed(across[0], across[1], z);
#pragma unroll
    for (int n = 0; n < 2; n++)
        across[n] = mixed(value[2][n + 1] - value[0][n + 1], value[3][n + 1] - value[1][n + 1], z);
    *along_a = 0.5f * mixed(across[0], across[1], y);
}
#endif
