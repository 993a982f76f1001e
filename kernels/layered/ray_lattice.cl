// A lattice of rays (`RayLatticeParams`): a ray keeps its column and row in all layers.

#include "shared/clipping.cl"
#include "shared/stagger.cl"

// Where a column (axis 0) or row (1) crosses the layer of the volume's centre, and its shear.
static inline float2 crossing_of(const RayLatticeParams *p, int axis, int index) {
    const float from_middle = index - 0.5f * ((axis ? p->height : p->width) - 1);
    const float *rays = p->rays + 4 * axis;
    return (float2)(rays[0] + from_middle * rays[1], rays[2] + from_middle * rays[3]);
}

// The same of VW neighbouring columns, from one on.
static inline void crossings_of_columns(const RayLatticeParams *p, int column, realv *centre, realv *shear) {
    const realv from_middle = CONVERT_REALV(LANES) + (column - 0.5f * (p->width - 1));
    *centre = p->rays[0] + from_middle * p->rays[1];
    *shear = p->rays[2] + from_middle * p->rays[3];
}

// Voxels along v by which the samples of VW neighbouring columns lie behind their rows, from one column on: less than from row to row.
static inline realv stagger_of_columns(const RayLatticeParams *p, int column) {
    const uintv columns = AS_UINTV((intv)(LANES) + column);
    return CONVERT_REALV(STAGGER_STEPS(p, columns)) * (STAGGER_STEP * p->rays[5]);
}

// The interval of VW columns in a row, in layers from that of the volume's centre along the rays. `stagger`: of the columns.
static inline Interval interval_of_columns(const RayLatticeParams *p, const Clipping *clip, realv centre_u, realv shear_u, realv stagger,
                                           int row) {
    const float2 crossing = crossing_of(p, 1, row);
    const realv origin[3] = {centre_u, crossing.x + stagger, (realv)(p->centre_layer)};
    const realv direction[3] = {shear_u * p->layer_step, (realv)(crossing.y * p->layer_step), (realv)(p->layer_step)};
    return interval_of(clip, origin, direction, -INFINITY);
}
