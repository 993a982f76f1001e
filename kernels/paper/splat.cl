// Geometry of splats, shared by the sheet methods.

#include "shared/elementary.cl"

#define GAUSSIAN_RADIUS 2.0f

// Where a splat at a depth begins, in sheets from the first. The next whole number is the first sheet that it covers.
static inline float sheet_position(const SplatParams *p, float depth) {
    return (depth - GAUSSIAN_RADIUS) / p->sheet_distance - 0.5f - p->first_sheet;
}
static inline int first_sheet(float reach) { return -floor_int(-reach); }

// Pixels under the bounding rectangle of a splat at (x, y), clipped to the screen: columns [x, y], rows [z, w]; empty if x > y or z > w.
ALWAYS_INLINE int4 pixels_under(const SplatParams *p, float x, float y, float w, int width, int height) {
    const float inverse = 1.0f / w, hx = p->half_width * inverse + 0.5f, hy = p->half_height * inverse + 0.5f;
    // The first pixel centre at or beyond an edge is the one after the last centre before it.
    return (int4)(floor_int(CLAMP(x - hx, -1.0f, (float)width)) + 1, floor_int(CLAMP(x + hx, 0.0f, (float)width)) - 1,
                  floor_int(CLAMP(y - hy, -1.0f, (float)height)) + 1, floor_int(CLAMP(y + hy, 0.0f, (float)height)) - 1);
}
