// Interpolation of premultiplied RGBA.

#include "picture/display.cl"

// Filters overshoot, so colours are limited to their opacity; and sums of means and shares, which rounding makes larger, to 1. LINEAR: colours
// in linear light may be brighter.
#ifdef LINEAR
#define WITHIN_OPACITY(color, opacity) (color)
#define BRIGHTEST (float4)(INFINITY, INFINITY, INFINITY, 1.0f)
#else
#define WITHIN_OPACITY(color, opacity) MIN(color, opacity)
#define BRIGHTEST (float4)(1.0f)
#endif

// Weights of the samples -1 ... 2, counted from the one below.
static inline float4 catmull_rom(float t) {
    const float4 cubic = (float4)(-0.5f, 1.5f, -1.5f, 0.5f), square = (float4)(1.0f, -2.5f, 2.0f, -0.5f);
    const float4 linear = (float4)(-0.5f, 0.0f, 0.5f, 0.0f), whole = (float4)(0.0f, 1.0f, 0.0f, 0.0f);
    return ((cubic * t + square) * t + linear) * t + whole;
}
