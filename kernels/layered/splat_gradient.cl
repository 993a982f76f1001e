// Gradients at the samples of splatted layers. Central differences are splatted like values. Smoothed ones (GRADIENT) are estimated at the
// voxels of the sample's layer and interpolated there: splatting them, too, would take as many sums as they have voxels.

#include "shared/field.cl"

#define SPLATS_GRADIENTS (GRADIENT == CENTRAL)

// Source of smoothed gradients, and of light.
typedef struct {
    const ShadingSource *shading;
    const FieldParams *field;
} SmoothedGradients;

static inline Gradient smoothed_gradient(const SmoothedGradients *s, Point point) {
    return gradient_at(s->shading, s->field, point.u, point.v, point.a, (intv)(1));
}
