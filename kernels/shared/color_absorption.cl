// The fields of a volume of colours. Absorption is of the extinction per unit distance or, with linear extinction, of the opacity of a unit
// distance.

#include "shared/field.cl"
#include "shared/shading.cl"

// Arguments of a kernel: the fields of a volume of colours. SHADED_FIELD is the extinction. LABELS: it is the opacity, and the others are
// opacity times colour; VARIED_OPACITIES: `second` and `third` are the squared and the cubed opacity (label_surface.cl).
#define COLOR_FIELDS \
    __global const VOXEL *red, __global const VOXEL *green, __global const VOXEL *blue, __global const VOXEL *second, \
        __global const VOXEL *third, LabelParams labels, SHADED_FIELD, __global const uchar *visible, SampleParams sample, \
        RayEnds ray_ends, OUTPUT

// Numbers of the fields: red, green and blue come first. SMOOTHED_OPACITY: what gradients are estimated from.
#define SHADED 3
#define SMOOTHED_OPACITY 4
#define SECOND 5
#define THIRD 6
#define COLOR_VOXELS red + view.first, green + view.first, blue + view.first, voxels
#define GRADIENT_INPUT (__global const VOXEL *)shading.voxels
#if defined(LABELS) && defined(VARIED_OPACITIES)
#define FIELDS 7
#define FIELD_VOXELS {COLOR_VOXELS, GRADIENT_INPUT, second + view.first, third + view.first}
#elif defined(LABELS)
#define FIELDS 5
#define FIELD_VOXELS {COLOR_VOXELS, GRADIENT_INPUT}
#else
#define FIELDS 4
#define FIELD_VOXELS {COLOR_VOXELS}
#endif

#ifdef LABELS
#include "shared/label_surface.cl"
#endif

static inline realv color_absorption(const SampleParams *p, realv extinction) {
    return p->classification.linear ? absorbed(extinction) : extinction;
}
