// Places the points of a set in the coordinates of cells.cl, and on the screen.
//
// One work-item per point: `count` of them from `first` on.

#include "shared/elementary.cl"
#include "surfaces/cells.cl"

__kernel void place_points(__global const float4 *own, __global const SurfaceSet *sets, int set, int first, int count, SurfaceView view,
                           __global float4 *points, __global int2 *rounded, ulong first_item) {
    const int n = first_item + get_global_id(0);
    if (n >= count)
        return;
    const float4 p = own[first + n];
    __global const float *m = sets[set].to_view;
    const float3 place = {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
    points[first + n] = (float4)(place, sets[set].scale * p.w);
    rounded[first + n] = rounded_pixel(&view, place);
}
