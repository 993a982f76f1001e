// Interpolation of premultiplied RGBA.

#include "picture/display.cl"

// Weights of the samples -1 ... 2, counted from the one below.
static inline float4 catmull_rom(float t) {
    const float4 cubic = (float4)(-0.5f, 1.5f, -1.5f, 0.5f), square = (float4)(1.0f, -2.5f, 2.0f, -0.5f);
    const float4 linear = (float4)(-0.5f, 0.0f, 0.5f, 0.0f), whole = (float4)(0.0f, 1.0f, 0.0f, 0.0f);
    return ((cubic * t + square) * t + linear) * t + whole;
}
