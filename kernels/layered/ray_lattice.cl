// A lattice of rays (`RayLatticeParams`): each ray has the same column and row in all layers.

#include "layered/beam.cl"
#include "shared/clipping.cl"
#include "shared/stagger.cl"

// Where a column (axis 0) or row (axis 1) crosses the layer of the volume's centre, and its shear.
static inline float2 axis_crossing(const RayLatticeParams *p, int axis, int index) {
    const float from_middle = index - 0.5f * ((axis ? p->height : p->width) - 1);
    const float *rays = p->rays + 4 * axis;
    return (float2)(rays[0] + from_middle * rays[1], rays[2] + from_middle * rays[3]);
}

// The same for VW columns or rows.
static inline void axis_crossings(const RayLatticeParams *p, int axis, intv indices, realv *centre, realv *shear) {
    const realv from_middle = CONVERT_REALV(indices) - 0.5f * ((axis ? p->height : p->width) - 1);
    const float *rays = p->rays + 4 * axis;
    *centre = rays[0] + from_middle * rays[1];
    *shear = rays[2] + from_middle * rays[3];
}

// Outermost rays of a range of columns and rows.
static inline Beam make_beam(const RayLatticeParams *p, int column, int row, int columns, int rows) {
    const float2 first_u = axis_crossing(p, 0, column), last_u = axis_crossing(p, 0, column + columns - 1);
    const float2 first_v = axis_crossing(p, 1, row), last_v = axis_crossing(p, 1, row + rows - 1);
    const Beam beam = {(float4)(first_u.x, first_v.x, last_u.x, last_v.x), (float4)(first_u.y, first_v.y, last_u.y, last_v.y)};
    return beam;
}

// Stagger of VW columns in voxels along v; less than the distance between rows.
static inline realv column_stagger(const RayLatticeParams *p, intv columns) {
    return CONVERT_REALV(STAGGER_STEPS(p, AS_UINTV(columns))) * (STAGGER_STEP * p->rays[5]);
}

// Rays of VW samples: crossings with the layer of the volume's centre, and shears.
typedef struct {
    realv centre_u, shear_u, centre_v, shear_v;
} SampleRays;

static inline SampleRays sample_rays(const RayLatticeParams *p, intv columns, intv rows) {
    SampleRays rays;
    axis_crossings(p, 0, columns, &rays.centre_u, &rays.shear_u);
    axis_crossings(p, 1, rows, &rays.centre_v, &rays.shear_v);
    rays.centre_v += column_stagger(p, columns);
    return rays;
}

// Clip intervals of rays, in layers from that of the volume's centre along them.
static inline Interval clip_sample_rays(const RayLatticeParams *p, const Clipping *clip, const SampleRays *rays) {
    const realv origin[3] = {rays->centre_u, rays->centre_v, (realv)(p->centre_layer)};
    const realv direction[3] = {rays->shear_u * p->layer_step, rays->shear_v * p->layer_step, (realv)(p->layer_step)};
    return clip_rays(clip, origin, direction, -INFINITY);
}

// Length of rays from layer to layer.
static inline realv length_per_layer(const SampleParams *sample, const SampleRays *rays) {
    const realv step_u = rays->shear_u * sample->segments.step_u, step_v = rays->shear_v * sample->segments.step_v;
    return sqrt(step_u * step_u + (step_v * step_v + sample->segments.step_a * sample->segments.step_a));
}
