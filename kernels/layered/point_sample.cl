// Sampling and lighting of a point-sampled layer for a single ray. VW is 1.

#include "shared/field.cl"
#include "shared/span_lighting.cl"

// A ray of a lattice: its crossing with the layer of the volume's centre, and its shear, along u and v.
typedef struct {
    float2 u, v;
} LatticeRay;

// Cell of a ray in sub-layer l. Unsigned divisions take fewer registers.
static inline Cells cells_in(const VolumeView *view, const LatticeRay *ray, float centre_layer, uint samples_per_layer, uint l) {
    const float depth = (float)l / samples_per_layer - RADIUS - centre_layer;
    return cells_from_layer(view, ray->u.x + depth * ray->u.y, ray->v.x + depth * ray->v.y, (int)(l / samples_per_layer) - RADIUS,
                            (float)(l % samples_per_layer) / samples_per_layer, 1);
}

static inline LitSample light_in_cell(__global const VOXEL *voxels, const VolumeView *view, const ShadingSource *shading,
                                      const SampleParams *p, const Cells *c) {
#if GRADIENTS_AT_VOXELS
    const FieldSample field = {value_in_cell(voxels, view, c), gradient_in_cell(shading, &p->field, c)};
#else
    const FieldSample field = field_in_cell(voxels, view, c);
#endif
    const Point point = {c->i + c->x, c->j + c->y, c->k + c->z};
    return light_sample(p, shading->light, point, field.value, field.gradient);
}
