// The field reconstructed by the kernel of reconstruction.cl, and its gradient, at VW arbitrary points.

#include "shared/light_volume.cl"
#include "shared/point.cl"
#include "shared/reconstruction.cl"
#include "shared/table_entries.cl"
#include "shared/tint.cl"
#include "shared/voxel_colors.cl"
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

#include "shared/value_voxels.cl"
#include "shared/voxel_rows.cl"

#ifdef SEPARATE_GRADIENTS
#include "shared/gradient_voxels.cl"
#include "shared/voxel_access.cl"
#include "shared/voxel_rows.cl"
#else
#define gradient_voxel_row voxel_row
#endif

// Arguments of a kernel: the voxels that are sampled, those that gradients are estimated from, and light volumes.
#define LIGHT_BUFFERS __global const uchar *light, __global const uchar *sky
#define SHADED_FIELD \
    __global const VOXEL *voxels, VolumeView view, __global const GRADIENT_VOXEL *gradient_voxels, VolumeView gradient_view, LIGHT_BUFFERS

// What samples are shaded from: the voxels that gradients are estimated from, light volumes, and colours of voxels (tint.cl,
// voxel_colors.cl).
// SHADING_SOURCE: those of a kernel with the arguments `gradient_voxels`, `gradient_view`, `light` and `sky`, whose `voxels` begin at the
// first one.
typedef struct {
    __global const GRADIENT_VOXEL *voxels;
    const VolumeView *view;
    LightVolume light;
#ifdef CHANNELS
    __global const FieldPlacement *place;
#endif
#ifdef TINTED
    Tint tint;
#endif
} ShadingSource;
#ifdef SEPARATE_GRADIENTS
#define SHADING_SOURCE {gradient_voxels + gradient_view.first, &gradient_view, {light, sky} TINT_SOURCE}
#else
#define SHADING_SOURCE {voxels, &view, {light, sky} TINT_SOURCE}
#endif

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
static inline Gradient gradient_at(const ShadingSource *source, const FieldParams *field, realv u, realv v, realv a, intv needed) {
    realv values[6];
#pragma unroll 1
    for (int n = 0; n < 6; n++) {
        const float away = n & 1 ? -1.0f : 1.0f;
        const float du = n < 2 ? away : 0.0f, dv = n >> 1 == 1 ? away : 0.0f, da = n >> 1 == 2 ? away : 0.0f;
        values[n] = value_at(source->voxels, source->view, u + du, v + dv, a + da, needed);
    }
    const Gradient gradient = {0.5f * (values[0] - values[1]), 0.5f * (values[2] - values[3]), 0.5f * (values[4] - values[5])};
    return gradient;
}
#else
// The gradient, in voxel differences: slopes along its own axis, weights across it along the others. All three components share the same
// voxel rows.
static inline Gradient gradient_at(const ShadingSource *source, const FieldParams *field, realv u, realv v, realv a, intv needed) {
    const Cells c = cells_at(source->view, u, v, a, needed);
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
            const Row row = gradient_voxel_row(source->voxels, source->view, &c, dj, dk);
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
