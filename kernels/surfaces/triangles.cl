// The pixels that a triangle covers, and its depth there.

#include "surfaces/cells.cl"

// Sides of the edges of a triangle of rounded points at a pixel: positive on the left. The fourth repeats the first.
typedef struct {
    long4 here, per_column, per_row;
} Edges;

static inline Edges edges_between(long4 from_x, long4 from_y, long4 to_x, long4 to_y, int x, int y) {
    const long pixel_x = (long)x * SUBPIXELS + SUBPIXELS / 2, pixel_y = (long)y * SUBPIXELS + SUBPIXELS / 2;
    const long4 along_x = to_x - from_x, along_y = to_y - from_y;
    // Pixels on an edge itself belong to one side, which does not depend on the triangle. True is -1.
    const long4 owns = (along_y > 0) | ((along_y == 0) & (along_x < 0));
    const Edges edges = {(from_x - pixel_x) * along_y - (from_y - pixel_y) * along_x - owns, along_y * -SUBPIXELS, along_x * SUBPIXELS};
    return edges;
}

static inline Edges edges_at(const ScreenTriangle *triangle, int x, int y) {
    const long2 a = convert_long2(triangle->corners[0]), b = convert_long2(triangle->corners[1]), c = convert_long2(triangle->corners[2]);
    return edges_between((long4)(a.x, b.x, c.x, a.x), (long4)(a.y, b.y, c.y, a.y), (long4)(b.x, c.x, a.x, b.x), (long4)(b.y, c.y, a.y, b.y), x, y);
}

// Whether a pixel is on the same side of all edges.
static inline bool are_alike(long4 sides) {
    const long4 left = sides > 0;
    return all(left) || !any(left);
}

// An order of points that does not depend on the triangle.
static inline bool is_before(float3 a, float3 b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; }

// Whether a pixel is on the left of an edge.
static inline bool is_left_of(const SurfaceView *view, float3 from, float3 to, int2 rounded_from, int2 rounded_to, int x, int y,
                              const SurfaceRay *ray) {
    if (rounded_from.x != NOT_ROUNDED && rounded_to.x != NOT_ROUNDED)
        return edges_between(rounded_from.x, rounded_from.y, rounded_to.x, rounded_to.y, x, y).here.x > 0;
    // The volume of the tetrahedron between the edge and the ray, computed alike for both directions of the edge.
    const bool swapped = is_before(to, from);
    const float3 first = swapped ? to : from, second = swapped ? from : to;
    const float volume = view->handedness * dot(ray->direction, cross(first - ray->origin, second - ray->origin));
    return (volume > 0.0f) != swapped;
}

// Whether a triangle, some points of which are not rounded, covers a pixel.
static inline bool covers(const SurfaceView *view, __global const float4 *points, int4 cell, const ScreenTriangle *triangle, int x, int y,
                          const SurfaceRay *ray) {
    const float3 a = points[cell.x].xyz, b = points[cell.y].xyz, c = points[cell.z].xyz;
    const int2 *rounded = triangle->corners;
    const bool left = is_left_of(view, a, b, rounded[0], rounded[1], x, y, ray);
    return is_left_of(view, b, c, rounded[1], rounded[2], x, y, ray) == left && is_left_of(view, c, a, rounded[2], rounded[0], x, y, ray) == left;
}

// Where a ray crosses the plane of a triangle, NaN if they are parallel.
static inline float triangle_depth(__global const float4 *points, int4 cell, const SurfaceRay *ray) {
    const float3 first = points[cell.x].xyz, normal = cross(points[cell.y].xyz - first, points[cell.z].xyz - first);
    const float along = dot(normal, ray->direction);
    return along == 0.0f ? NAN : dot(normal, first - ray->origin) / along;
}
