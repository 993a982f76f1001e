// The fields of a volume of colours. Absorption is of the extinction per unit distance or, with linear extinction, of the opacity of a unit
// distance.

#include "shared/field.cl"
#include "shared/shading.cl"

// Arguments of a kernel: the fields of a volume of colours, the last of which is the extinction.
#define COLOR_FIELDS \
    __global const VOXEL *red, __global const VOXEL *green, __global const VOXEL *blue, SHADED_FIELD, __global const uchar *visible, \
        SampleParams sample, RayEnds ray_ends, OUTPUT

static inline realv color_absorption(const SampleParams *p, realv extinction) {
    return p->classification.linear ? absorbed(extinction) : extinction;
}
