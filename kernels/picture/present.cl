// Converts a frame to the finished 8-bit picture.
//
// One work-item per pixel.

#include "picture/display.cl"

__kernel void present(__global const float4 *frame, float4 background, float4 curve, int pixels, __global uchar4 *rgba, ulong first_item) {
    const int i = first_item + get_global_id(0);
    if (i < pixels)
        rgba[i] = displayed(frame[i], background, curve);
}
