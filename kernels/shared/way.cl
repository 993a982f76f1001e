// The way from one sample of a ray to the next.

#include "shared/field.cl"
#include "shared/point.cl"

// A place of the one, and the step to the other, in voxels; and the values there.
typedef struct {
    realv place[3], step[3];
    realv from, to;
} Way;

// Of rays that cross the layer of the volume's centre in columns and rows, and lean so: from plane k on, and between two values.
static inline Way way_on(realv centre_u, realv shear_u, realv centre_v, realv shear_v, float centre_layer, float k, float step, realv from,
                         realv to) {
    const float depth = k - centre_layer;
    const Way way = {{centre_u + depth * shear_u, centre_v + depth * shear_v, k}, {step * shear_u, step * shear_v, step}, from, to};
    return way;
}

// The point at t of it, 0 ... 1, and the field there.
static inline Point point_on(const Way *way, realv t) {
    const Point point = {way->place[0] + t * way->step[0], way->place[1] + t * way->step[1], way->place[2] + t * way->step[2]};
    return point;
}
static inline realv value_on(__global const VOXEL *voxels, const VolumeView *view, const Way *way, realv t, intv lanes) {
    const Point point = point_on(way, t);
    return value_at(voxels, view, point.u, point.v, point.a, lanes);
}
