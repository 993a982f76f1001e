// A lattice of rays (`RayLatticeParams`): each ray has the same column and row in all layers. PIXEL_RAYS: samples are pixels, and their
// columns lean (src/host/layers/lattice/pixel_rays.rs).

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

#ifdef PIXEL_RAYS
// Distances of rays from that in the middle of the lattice, along u and v, where the spread is 1.
static inline void ray_offsets(const RayLatticeParams *p, intv columns, intv rows, realv *u, realv *v) {
    const realv i = CONVERT_REALV(columns) - 0.5f * (p->width - 1), j = CONVERT_REALV(rows) - 0.5f * (p->height - 1);
    const realv inverse = 1.0f / (1.0f + (p->depth_per_column * i + p->depth_per_row * j));
    *u = (p->u_per_column * i + p->u_per_row * j) * inverse;
    *v = (p->v_per_column * i + p->v_per_row * j) * inverse;
}

// Rays between two, given by their offsets (u, v, u, v).
static inline Beam beam_between(const RayLatticeParams *p, float4 offsets) {
    const float4 crossing = (float4)(p->rays[0], p->rays[4], p->rays[0], p->rays[4]);
    const float4 shear = (float4)(p->rays[2], p->rays[6], p->rays[2], p->rays[6]);
    const Beam beam = {crossing + p->spread_at_centre * offsets, shear + p->spread_per_layer * offsets};
    return beam;
}
#endif

// Outermost rays of a range of columns and rows.
#if defined(PIXEL_RAYS) && VW == 1
static inline Beam make_beam(const RayLatticeParams *p, int column, int row, int columns, int rows) {
    float4 offsets = (float4)(INFINITY, INFINITY, -INFINITY, -INFINITY);
    for (int corner = 0; corner < 4; corner++) {
        float u, v;
        ray_offsets(p, corner & 1 ? column + columns - 1 : column, corner & 2 ? row + rows - 1 : row, &u, &v);
        offsets.lo = MIN(offsets.lo, (float2)(u, v)), offsets.hi = MAX(offsets.hi, (float2)(u, v));
    }
    return beam_between(p, offsets);
}
#else
static inline Beam make_beam(const RayLatticeParams *p, int column, int row, int columns, int rows) {
    const float2 first_u = axis_crossing(p, 0, column), last_u = axis_crossing(p, 0, column + columns - 1);
    const float2 first_v = axis_crossing(p, 1, row), last_v = axis_crossing(p, 1, row + rows - 1);
    const Beam beam = {(float4)(first_u.x, first_v.x, last_u.x, last_v.x), (float4)(first_u.y, first_v.y, last_u.y, last_v.y)};
    return beam;
}
#endif

// Stagger of VW columns in voxels along v; less than the distance between rows.
static inline realv column_stagger(const RayLatticeParams *p, intv columns) {
    return CONVERT_REALV(STAGGER_STEPS(p, AS_UINTV(columns))) * (STAGGER_STEP * p->rays[5]);
}

// Rays of VW samples: crossings with the layer of the volume's centre, and shears.
typedef struct {
    realv centre_u, shear_u, centre_v, shear_v;
} SampleRays;

#ifdef PIXEL_RAYS
static inline SampleRays rays_with_offsets(const RayLatticeParams *p, realv u, realv v) {
    const SampleRays rays = {p->rays[0] + p->spread_at_centre * u, p->rays[2] + p->spread_per_layer * u,
                             p->rays[4] + p->spread_at_centre * v, p->rays[6] + p->spread_per_layer * v};
    return rays;
}
#endif

static inline SampleRays sample_rays(const RayLatticeParams *p, intv columns, intv rows) {
    SampleRays rays;
#ifdef PIXEL_RAYS
    realv u, v;
    ray_offsets(p, columns, rows, &u, &v);
    rays = rays_with_offsets(p, u, v);
#else
    axis_crossings(p, 0, columns, &rays.centre_u, &rays.shear_u);
    axis_crossings(p, 1, rows, &rays.centre_v, &rays.shear_v);
    rays.centre_v += column_stagger(p, columns);
#endif
    return rays;
}

// Clip intervals of rays, in layers from that of the volume's centre along them.
static inline Interval clip_sample_rays(const RayLatticeParams *p, const RayEnds *ends, const SampleRays *rays) {
    const realv origin[3] = {rays->centre_u, rays->centre_v, (realv)(p->centre_layer)};
    const realv direction[3] = {rays->shear_u * p->layer_step, rays->shear_v * p->layer_step, (realv)(p->layer_step)};
    return clip_rays(ends, origin, direction);
}

// Length of rays from layer to layer.
static inline realv length_per_layer(const SampleParams *sample, const SampleRays *rays) {
    const realv step_u = rays->shear_u * sample->segments.step_u, step_v = rays->shear_v * sample->segments.step_v;
    return sqrt(step_u * step_u + (step_v * step_v + sample->segments.step_a * sample->segments.step_a));
}
