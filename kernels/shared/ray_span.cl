// The span of a ray between two consecutive samples.

#include "shared/field.cl"
#include "shared/point.cl"

// Position of the first sample, and the step to the second, in voxels; field values at both.
typedef struct {
    realv origin[3], step[3];
    realv from, to;
} RaySpan;

// Span that starts in plane k, of rays with these crossings and shears at the centre layer, between two values.
static inline RaySpan span_at_plane(realv centre_u, realv shear_u, realv centre_v, realv shear_v, float centre_layer, float k, float step,
                                    realv from, realv to) {
    const float depth = k - centre_layer;
    const RaySpan span = {{centre_u + depth * shear_u, centre_v + depth * shear_v, k}, {step * shear_u, step * shear_v, step}, from, to};
    return span;
}

// The point at the parameter t of a span, 0 ... 1, and the field there.
static inline Point point_on_span(const RaySpan *span, realv t) {
    const Point point = {span->origin[0] + t * span->step[0], span->origin[1] + t * span->step[1], span->origin[2] + t * span->step[2]};
    return point;
}
static inline realv value_on_span(__global const VOXEL *voxels, const VolumeView *view, const RaySpan *span, realv t, intv lanes) {
    const Point point = point_on_span(span, t);
    return value_at(voxels, view, point.u, point.v, point.a, lanes);
}
