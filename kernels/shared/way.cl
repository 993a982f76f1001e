// The way from one sample of a ray to the next.

#include "shared/field.cl"

// A place of the one, and the step to the other, in voxels; and the values there.
typedef struct {
    realv place[3], step[3];
    realv from, to;
} Way;

// The field on it, 0 ... 1.
static inline realv value_on(__global const VOXEL *voxels, const VolumeView *view, const Way *way, realv t, intv lanes) {
    return value_at(voxels, view, way->place[0] + t * way->step[0], way->place[1] + t * way->step[1],
                    way->place[2] + t * way->step[2], lanes);
}
