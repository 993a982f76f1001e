// Marching along the rays of a row of pixels.

#include "shared/screen.cl"
#include "shared/visible_points.cl"

// Number of steps that are tested together.
#define CHUNK 8

static inline void points_at(const RowRays *rays, realv t, realv *point) {
    for (int i = 0; i < 3; i++)
        point[i] = rays->o[i] + t * rays->d[i];
}
