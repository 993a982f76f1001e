// The field of field.cl, and its gradient, at one point: VW is 1, as graphics processors want it. Few registers are what counts there, so
// planes are taken one after the other, and only those that count: on the plane of a layer that one alone, with all kernels but the
// B-spline.

// Whether values are mixed of several layers.
static inline bool mixes_layers(const Cells *c) { return KERNEL == BSPLINE || c->z > 0.0f; }

// What voxel n, of -1 ... 2 but not 0, counts. Indices that change would put weights into memory.
static inline float weight_of(const Weights *w, int n) { return n == -1 ? w->of[0] : n == 1 ? w->of[2] : w->of[3]; }

// And if it may be 0, where all weights sum to `sum`.
static inline float weight_of_any(const Weights *w, int n, float sum) {
    return n == 0 ? sum - (w->of[0] + w->of[2] + w->of[3]) : weight_of(w, n);
}

// The field, and its gradient in voxel differences.
typedef struct {
    float value, along_u, along_v, along_a;
} Found;

// Where voxels beyond the volume's edge count: one voxel after another, which takes few registers, of which there are as many as the worst
// place of a program needs. Gradients are found if they are `wanted`.
ALWAYS_INLINE Found found_at_edge(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, bool wanted) {
    const Weights x = value_weights(c->x), y = value_weights(c->y), z = value_weights(c->z);
    const Weights slopes_x = slope_weights(c->x), slopes_y = slope_weights(c->y), slopes_z = slope_weights(c->z);
    const int first = wanted ? -1 : FIRST_TAP, last = wanted ? 2 : LAST_TAP;
    const float own = voxel_at(voxels, view, c->i, c->j, c->k);
    Found found = {own, 0.0f, 0.0f, 0.0f};
#pragma unroll 1
    for (int dk = first; dk <= last; dk++) {
        const float of_a = weight_of_any(&z, dk, 1.0f), slope_a = wanted ? weight_of_any(&slopes_z, dk, 0.0f) : 0.0f;
        if (of_a == 0.0f && slope_a == 0.0f)
            continue;
#pragma unroll 1
        for (int dj = first; dj <= last; dj++) {
            const float of_v = weight_of_any(&y, dj, 1.0f), slope_v = wanted ? weight_of_any(&slopes_y, dj, 0.0f) : 0.0f;
#pragma unroll 1
            for (int di = first; di <= last; di++) {
                const float of_u = weight_of_any(&x, di, 1.0f), slope_u = wanted ? weight_of_any(&slopes_x, di, 0.0f) : 0.0f;
                const float apart = voxel_at(voxels, view, c->i + di, c->j + dj, c->k + dk) - own;
                found.value += of_u * of_v * of_a * apart;
                found.along_u += slope_u * of_v * of_a * apart;
                found.along_v += of_u * slope_v * of_a * apart;
                found.along_a += of_u * of_v * slope_a * apart;
            }
        }
    }
    return found;
}

static inline float value_in(__global const VOXEL *voxels, const VolumeView *view, const Cells *c) {
    if (!c->interior)
        return found_at_edge(voxels, view, c, false).value;
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const float own = value_in_plane(voxels, view, c, &x, &y, 0);
    if (!mixes_layers(c))
        return own;
    const Weights layers = value_weights(c->z);
    float value = own;
#pragma unroll 1
    for (int dk = FIRST_TAP; dk <= LAST_TAP; dk++) {
        const float weight = dk == 0 ? 0.0f : weight_of(&layers, dk);
        if (weight != 0.0f)
            value += weight * (value_in_plane(voxels, view, c, &x, &y, dk) - own);
    }
    return value;
}

// The field in a plane of voxels, and its slopes there.
typedef struct {
    float value, along_u, along_v;
} PlaneSlopes;

// Of the one dk away.
static inline PlaneSlopes slopes_in_plane(__global const VOXEL *voxels, const VolumeView *view, const Cells *c, int dk) {
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const Weights slope_x = slope_weights(c->x), slope_y = slope_weights(c->y);
    const Row own = voxel_row(voxels, view, c, 0, dk);
    const float value = MIXED(x.of, own.before, own.low, own.high, own.behind);
    const float along_u = SLOPE(slope_x.of, own.before, own.low, own.high, own.behind);
    PlaneSlopes plane = {value, along_u, 0.0f};
#pragma unroll
    for (int dj = -1; dj <= 2; dj++) {
        if (dj == 0)
            continue;
        const Row row = voxel_row(voxels, view, c, dj, dk);
        const float apart = MIXED(x.of, row.before, row.low, row.high, row.behind) - value;
        if (IS_TAP(dj)) {
            plane.value += weight_of(&y, dj) * apart;
            plane.along_u += weight_of(&y, dj) * (SLOPE(slope_x.of, row.before, row.low, row.high, row.behind) - along_u);
        }
        plane.along_v += weight_of(&slope_y, dj) * apart;
    }
    return plane;
}

static inline Found found_in(__global const VOXEL *voxels, const VolumeView *view, const Cells *c) {
    if (!c->interior)
        return found_at_edge(voxels, view, c, true);
    const Weights x = value_weights(c->x), y = value_weights(c->y);
    const Weights layers = value_weights(c->z), slopes = slope_weights(c->z);
    const PlaneSlopes own = slopes_in_plane(voxels, view, c, 0);
    Found found = {own.value, own.along_u, own.along_v, 0.0f};
#pragma unroll 1
    for (int dk = -1; dk <= 2; dk++) {
        const float slope = dk == 0 ? 0.0f : weight_of(&slopes, dk);
        const float weight = dk != 0 && IS_TAP(dk) && mixes_layers(c) ? weight_of(&layers, dk) : 0.0f;
        if (weight != 0.0f) {
            const PlaneSlopes plane = slopes_in_plane(voxels, view, c, dk);
            found.along_u += weight * (plane.along_u - own.along_u);
            found.along_v += weight * (plane.along_v - own.along_v);
            found.along_a += slope * (plane.value - own.value);
        } else if (slope != 0.0f) {
            found.along_a += slope * (value_in_plane(voxels, view, c, &x, &y, dk) - own.value);
        }
    }
    return found;
}

static inline float value_at(__global const VOXEL *voxels, const VolumeView *view, float u, float v, float a, int needed) {
    const Cells c = cells_of(view, u, v, a, needed);
    return value_in(voxels, view, &c);
}

static inline void gradient_at(__global const VOXEL *voxels, const VolumeView *view, float u, float v, float a, int needed, float *along_u,
                        float *along_v, float *along_a) {
    const Cells c = cells_of(view, u, v, a, needed);
    const Found found = found_in(voxels, view, &c);
    *along_u = found.along_u, *along_v = found.along_v, *along_a = found.along_a;
}
