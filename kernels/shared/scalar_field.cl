// The field of field.cl and its gradient at one point (VW is 1), for GPUs. Few registers are the goal here: planes are taken one after
// another, and only those with a weight. On a layer that is one plane, except for the B-spline.

// Whether several layers have a weight.
static inline bool mixes_layers(const Cells *c) { return KERNEL == BSPLINE || c->z > 0.0f; }

// Weight of voxel n, of -1 ... 2 but not 0. Variable indices would put the weights in memory.
static inline float tap_weight(const Weights *w, int n) { return n == -1 ? w->tap[0] : n == 1 ? w->tap[2] : w->tap[3]; }

// Weight of voxel n, including 0, where all weights sum to `sum`.
static inline float any_tap_weight(const Weights *w, int n, float sum) {
    return n == 0 ? sum - (w->tap[0] + w->tap[2] + w->tap[3]) : tap_weight(w, n);
}

// The field, and its gradient in voxel differences.
typedef struct {
    float value;
    Gradient gradient;
} FieldSample;

// Points whose support crosses the edge of the volume. One voxel after another, which takes few registers: a program is allocated as many
// as its worst path needs. Computes the gradient only `with_gradient`.
ALWAYS_INLINE FieldSample field_at_edge(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, bool with_gradient) {
    const Weights x = value_weights(c->x), y = value_weights(c->y), z = value_weights(c->z);
    const Weights slopes_x = slope_weights(c->x), slopes_y = slope_weights(c->y), slopes_z = slope_weights(c->z);
    const int first = with_gradient ? -1 : FIRST_TAP, last = with_gradient ? 2 : LAST_TAP;
    const float own = voxel_at(voxels, view, c->i, c->j, c->k);
    FieldSample field = {own, {0.0f, 0.0f, 0.0f}};
#pragma unroll 1
    for (int dk = first; dk <= last; dk++) {
        const float weight_a = any_tap_weight(&z, dk, 1.0f), slope_a = with_gradient ? any_tap_weight(&slopes_z, dk, 0.0f) : 0.0f;
        if (weight_a == 0.0f && slope_a == 0.0f)
            continue;
#pragma unroll 1
        for (int dj = first; dj <= last; dj++) {
            const float weight_v = any_tap_weight(&y, dj, 1.0f), slope_v = with_gradient ? any_tap_weight(&slopes_y, dj, 0.0f) : 0.0f;
#pragma unroll 1
            for (int di = first; di <= last; di++) {
                const float weight_u = any_tap_weight(&x, di, 1.0f), slope_u = with_gradient ? any_tap_weight(&slopes_x, di, 0.0f) : 0.0f;
                const float difference = voxel_at(voxels, view, c->i + di, c->j + dj, c->k + dk) - own;
                field.value += weight_u * weight_v * weight_a * difference;
                field.gradient.u += slope_u * weight_v * weight_a * difference;
                field.gradient.v += weight_u * slope_v * weight_a * difference;
                field.gradient.a += weight_u * weight_v * slope_a * difference;
            }
        }
    }
    return field;
}

static inline float value_in_cell(__global const VOXEL *voxels, const VolumeView *view, const Cells *c) {
    if (!c->interior)
        return field_at_edge(voxels, view, c, false).value;
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const float own = value_in_plane(voxels, view, c, &x, &y, 0);
    if (!mixes_layers(c))
        return own;
    const Weights layers = value_weights(c->z);
    float value = own;
#pragma unroll 1
    for (int dk = FIRST_TAP; dk <= LAST_TAP; dk++) {
        const float weight = dk == 0 ? 0.0f : tap_weight(&layers, dk);
        if (weight != 0.0f)
            value += weight * (value_in_plane(voxels, view, c, &x, &y, dk) - own);
    }
    return value;
}

// The field in a voxel plane, and its slopes in that plane.
typedef struct {
    float value, along_u, along_v;
} PlaneSlopes;

// The field and its slopes in the plane dk layers from the cell.
static inline PlaneSlopes slopes_in_plane(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, int dk) {
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const Weights slope_x = slope_weights(c->x), slope_y = slope_weights(c->y);
    const Row own = voxel_row(voxels, view, c, 0, dk);
    const float value = MIXED(x.tap, own.before, own.low, own.high, own.behind);
    const float along_u = SLOPE(slope_x.tap, own.before, own.low, own.high, own.behind);
    PlaneSlopes plane = {value, along_u, 0.0f};
#pragma unroll
    for (int dj = -1; dj <= 2; dj++) {
        if (dj == 0)
            continue;
        const Row row = voxel_row(voxels, view, c, dj, dk);
        const float difference = MIXED(x.tap, row.before, row.low, row.high, row.behind) - value;
        if (IS_TAP(dj)) {
            plane.value += tap_weight(&y, dj) * difference;
            plane.along_u += tap_weight(&y, dj) * (SLOPE(slope_x.tap, row.before, row.low, row.high, row.behind) - along_u);
        }
        plane.along_v += tap_weight(&slope_y, dj) * difference;
    }
    return plane;
}

#if GRADIENTS_AT_VOXELS
// Weights of voxel n, -1 ... 2, at `t` from voxel 0 to 1: those of estimates at the two voxels, as in slope_weights() and across_weights().
// Computed for one voxel at a time, which takes fewer registers than keeping all.
static inline float slope_tap(float t, int n) {
    const float below = n == -1 ? -0.5f : n == 1 ? 0.5f : 0.0f, above = n == 0 ? -0.5f : n == 2 ? 0.5f : 0.0f;
    return below + t * (above - below);
}
static inline float across_tap(float t, float smoothing, int n) {
    const float s = GRADIENT == SMOOTHED ? smoothing : 0.0f, own = 1.0f - 2.0f * s;
    const float below = n == 0 ? own : n == 2 ? 0.0f : s, above = n == 1 ? own : n == -1 ? 0.0f : s;
    return below + t * (above - below);
}

// The gradient of estimates at the voxels, one row after another. Differences from one voxel keep constant fields exact.
static inline Gradient gradient_in_cell(const ShadingSource *source, const FieldParams *params, const Cells *c) {
    const Weights x = across_weights(c->x, params->smoothing_u), slope_x = slope_weights(c->x);
    Gradient gradient = {0.0f, 0.0f, 0.0f};
    const float own = gradient_voxel_row(source->voxels, source->view, c, 0, 0).low;
#pragma unroll 1
    for (int dk = -1; dk <= 2; dk++) {
        const float weight_a = across_tap(c->z, params->smoothing_a, dk), slope_a = slope_tap(c->z, dk);
        if (weight_a == 0.0f && slope_a == 0.0f)
            continue;
#pragma unroll 1
        for (int dj = -1; dj <= 2; dj++) {
            const float weight_v = across_tap(c->y, params->smoothing_v, dj), slope_v = slope_tap(c->y, dj);
            if (weight_v == 0.0f && slope_v == 0.0f)
                continue;
            const Row row = gradient_voxel_row(source->voxels, source->view, c, dj, dk);
            const float difference = ACROSS(x.tap, row.before, row.low, row.high, row.behind) - own;
            gradient.u += weight_a * weight_v * SLOPE(slope_x.tap, row.before, row.low, row.high, row.behind);
            gradient.v += weight_a * slope_v * difference;
            gradient.a += slope_a * weight_v * difference;
        }
    }
    return gradient;
}
#else
static inline FieldSample field_in_cell(__global const VOXEL *voxels, const VolumeView *view, const Cells *c) {
    if (!c->interior)
        return field_at_edge(voxels, view, c, true);
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const Weights layers = value_weights(c->z), slopes = slope_weights(c->z);
    const PlaneSlopes own = slopes_in_plane(voxels, view, c, 0);
    FieldSample field = {own.value, {own.along_u, own.along_v, 0.0f}};
#pragma unroll 1
    for (int dk = -1; dk <= 2; dk++) {
        const float slope = dk == 0 ? 0.0f : tap_weight(&slopes, dk);
        const float weight = dk != 0 && IS_TAP(dk) && mixes_layers(c) ? tap_weight(&layers, dk) : 0.0f;
        if (weight != 0.0f) {
            const PlaneSlopes plane = slopes_in_plane(voxels, view, c, dk);
            field.gradient.u += weight * (plane.along_u - own.along_u);
            field.gradient.v += weight * (plane.along_v - own.along_v);
            field.gradient.a += slope * (plane.value - own.value);
        } else if (slope != 0.0f) {
            field.gradient.a += slope * (value_in_plane(voxels, view, c, &x, &y, dk) - own.value);
        }
    }
    return field;
}
#endif

static inline float value_at(__global const VOXEL *voxels, const VolumeView *view, float u, float v, float a, int needed) {
    const Cells c = cells_at(view, u, v, a, needed);
    return value_in_cell(voxels, view, &c);
}

static inline Gradient gradient_at(const ShadingSource *source, const FieldParams *params, float u, float v, float a, int needed) {
    const Cells c = cells_at(source->view, u, v, a, needed);
#if GRADIENTS_AT_VOXELS
    return gradient_in_cell(source, params, &c);
#else
    return field_in_cell(source->voxels, source->view, &c).gradient;
#endif
}
