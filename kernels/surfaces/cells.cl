// Cells of surfaces, triangles and pieces of quadrics, and where rays cross them.
//
// Coordinates are along the axes of the grid, in world units, from the volume's centre, so that floats stay precise however far the eye is.
// points: places of all sets in these coordinates, and radii. rounded: where they are on the screen. cells: points of a cell, and 8 times the
// number of its set plus its kind.
// Kinds of cells, and what their three numbers are:

// A triangle: its points.
#define TRIANGLE 0
// A sphere about a point; where it joins cones, their other points, or -1. It is seen beyond the ends of these.
#define SPHERE 1
// A cone between two points, and flags: whether there is one before and behind it.
#define CONE 2
#define CONE_BEFORE 1
#define CONE_BEHIND 2
// A disc about a point, and the other point of its cone.
#define DISC 3

// Of the numbers of crossings: which of two crossings of a cell, and the cell.
#define CROSSING(cell, second) ((uint)(cell) << 1 | (second))
#define CELL_OF(crossing) ((crossing) >> 1)

// The ray origin + t direction.
typedef struct {
    float3 origin, direction;
} SurfaceRay;

static inline float3 at_pixel(const float *affine, float x, float y) {
    const float3 first = {affine[0], affine[1], affine[2]}, right = {affine[4], affine[5], affine[6]};
    const float3 down = {affine[8], affine[9], affine[10]};
    return first + x * right + y * down;
}

static inline SurfaceRay surface_ray(const SurfaceView *view, int x, int y) {
    const SurfaceRay ray = {at_pixel(view->origin, x + 0.5f, y + 0.5f), at_pixel(view->direction, x + 0.5f, y + 0.5f)};
    return ray;
}

// Place on the screen, times the last component, which is positive in front of the eye.
static inline float3 on_screen(const SurfaceView *view, float3 p) {
    const float *m = view->to_screen;
    return (float3)(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                    m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

// Points of triangles are rounded to 1/256 of a pixel, so that the sides of an edge are told by exact integers, and edges that triangles
// share lose no pixel and draw none twice. Points that are not in front of the eye, or far outside the screen, are not rounded.
#define SUBPIXELS 256
#define FARTHEST_PIXEL 1048576.0f
#define NOT_ROUNDED INT_MIN

static inline int2 rounded_pixel(const SurfaceView *view, float3 place) {
    const float3 screen = on_screen(view, place);
    const bool is_near = screen.z > view->nearest && fabs(screen.x) < FARTHEST_PIXEL * screen.z && fabs(screen.y) < FARTHEST_PIXEL * screen.z;
    return is_near ? convert_int2_rte(screen.xy * (SUBPIXELS / screen.z)) : (int2)(NOT_ROUNDED);
}

// A triangle on the screen: its points in 1/256 of a pixel.
typedef struct {
    int2 corners[3];
} ScreenTriangle;

static inline ScreenTriangle on_pixels(__global const int2 *rounded, int4 cell) {
    const ScreenTriangle triangle = {{rounded[cell.x], rounded[cell.y], rounded[cell.z]}};
    return triangle;
}

static inline bool is_rounded(const ScreenTriangle *triangle) {
    return triangle->corners[0].x != NOT_ROUNDED && triangle->corners[1].x != NOT_ROUNDED && triangle->corners[2].x != NOT_ROUNDED;
}

// Pixels that a cell can cover: first and last column, first and last row; empty where the first is behind the last.
typedef int4 Pixels;
#define NO_PIXELS ((int4)(1, 0, 1, 0))

static inline Pixels all_pixels(const SurfaceView *view) { return (int4)(0, view->width - 1, 0, view->height - 1); }

// A box on the screen, which may reach beyond it, or be infinite. Behind the eye it is empty: its lowest place is infinite.
typedef struct {
    float2 lowest, highest;
} ScreenBox;

static inline Pixels pixels_of_box(const SurfaceView *view, ScreenBox box) {
    const float2 size = {view->width, view->height};
    if (!(box.lowest.x < size.x && box.lowest.y < size.y && box.highest.x > 0.0f && box.highest.y > 0.0f))
        return NO_PIXELS;
    const int2 first = convert_int2(max(box.lowest, (float2)(0.0f))), last = convert_int2(min(box.highest, size - 1.0f));
    return (int4)(first.x, last.x, first.y, last.y);
}

// A box around a ball. The eye may be in it.
static inline ScreenBox box_of_ball(const SurfaceView *view, float4 ball) {
    ScreenBox box = {INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
        const float radius = ball.w;
        const float3 off = {corner & 1 ? radius : -radius, corner & 2 ? radius : -radius, corner & 4 ? radius : -radius};
        const float3 screen = on_screen(view, ball.xyz + off);
        if (screen.z <= view->nearest) {
            const bool is_ahead = on_screen(view, ball.xyz).z + view->depth_of_unit * radius > view->nearest;
            box.lowest = is_ahead ? -INFINITY : INFINITY, box.highest = -box.lowest;
            return box;
        }
        const float2 at = screen.xy / screen.z;
        box.lowest = min(box.lowest, at - 1.0f), box.highest = max(box.highest, at + 1.0f);
    }
    return box;
}

// The box around what lies between two boxes. What begins behind the eye may be anywhere.
static inline ScreenBox box_between(ScreenBox one, ScreenBox other) {
    const bool is_anywhere = (one.lowest.x == INFINITY) != (other.lowest.x == INFINITY);
    const ScreenBox between = {min(one.lowest, other.lowest), max(one.highest, other.highest)}, anywhere = {-INFINITY, INFINITY};
    return is_anywhere ? anywhere : between;
}

static inline Pixels pixels_of_triangle(const SurfaceView *view, __global const float4 *points, int4 cell, const ScreenTriangle *triangle) {
    if (!is_rounded(triangle)) {
        const bool is_ahead = on_screen(view, points[cell.x].xyz).z > view->nearest ||
                              on_screen(view, points[cell.y].xyz).z > view->nearest || on_screen(view, points[cell.z].xyz).z > view->nearest;
        return is_ahead ? all_pixels(view) : NO_PIXELS;
    }
    const int2 lowest = min(min(triangle->corners[0], triangle->corners[1]), triangle->corners[2]);
    const int2 highest = max(max(triangle->corners[0], triangle->corners[1]), triangle->corners[2]);
    // Columns and rows whose centres lie between.
    const int2 first = max((lowest + (SUBPIXELS / 2 - 1)) >> 8, 0);
    const int2 last = min((highest - SUBPIXELS / 2) >> 8, (int2)(view->width - 1, view->height - 1));
    return (int4)(first.x, last.x, first.y, last.y);
}

static inline Pixels pixels_of_quadric(const SurfaceView *view, __global const float4 *points, int4 cell) {
    const float4 first = points[cell.x];
    if ((cell.w & 7) != CONE)
        return first.w > 0.0f ? pixels_of_box(view, box_of_ball(view, first)) : NO_PIXELS;
    const float4 second = points[cell.y];
    return first.w > 0.0f || second.w > 0.0f
               ? pixels_of_box(view, box_between(box_of_ball(view, first), box_of_ball(view, second)))
               : NO_PIXELS;
}

static inline Pixels pixels_of_cell(const SurfaceView *view, __global const float4 *points, __global const int2 *rounded, int4 cell) {
    if ((cell.w & 7) != TRIANGLE)
        return pixels_of_quadric(view, points, cell);
    const ScreenTriangle triangle = on_pixels(rounded, cell);
    const Pixels pixels = pixels_of_triangle(view, points, cell, &triangle);
    return pixels.x <= pixels.y && pixels.z <= pixels.w ? pixels : NO_PIXELS;
}

// Where a ray crosses a cell: at most two ray parameters, NaN where it does not.
typedef float2 Crossings;
#define NO_CROSSINGS ((float2)(NAN, NAN))

static inline bool is_in_sphere(float3 p, float4 sphere) {
    const float3 off = p - sphere.xyz;
    return dot(off, off) < sphere.w * sphere.w;
}

// `slack`: the part of its squared radius that is added.
static inline bool is_in_cone(float3 p, float4 one, float4 other, float slack) {
    const float3 axis = other.xyz - one.xyz, off = p - one.xyz;
    const float squared = dot(axis, axis), s = dot(off, axis) / squared, radius = one.w + s * (other.w - one.w);
    const float3 across = off - s * axis;
    return s > 0.0f && s < 1.0f && dot(across, across) < radius * radius * (1.0f + slack);
}

static inline Crossings sphere_crossings(float4 sphere, const SurfaceRay *ray) {
    const float3 to_centre = sphere.xyz - ray->origin;
    const float squared = dot(ray->direction, ray->direction), nearest = dot(to_centre, ray->direction) / squared;
    // From the nearest point, which is precise for spheres that are small beside their distance.
    const float3 off = to_centre - nearest * ray->direction;
    const float inside = sphere.w * sphere.w - dot(off, off);
    if (!(inside > 0.0f))
        return NO_CROSSINGS;
    const float half_chord = sqrt(inside / squared);
    return (float2)(nearest - half_chord, nearest + half_chord);
}

static inline Crossings cone_crossings(float4 one, float4 other, const SurfaceRay *ray) {
    const float3 axis = other.xyz - one.xyz, middle = 0.5f * (one.xyz + other.xyz);
    const float squared = dot(axis, axis);
    if (squared == 0.0f)
        return NO_CROSSINGS;
    // From the point of the ray nearest to the middle.
    const float nearest = dot(middle - ray->origin, ray->direction) / dot(ray->direction, ray->direction);
    const float3 off = ray->origin + nearest * ray->direction - one.xyz;
    const float m = dot(off, axis) / squared, n = dot(ray->direction, axis) / squared, slope = other.w - one.w;
    const float3 off_across = off - m * axis, along_across = ray->direction - n * axis;
    const float radius = one.w + slope * m;
    const float a = dot(along_across, along_across) - slope * slope * n * n;
    const float b = dot(off_across, along_across) - slope * n * radius, c = dot(off_across, off_across) - radius * radius;
    float2 t;
    if (fabs(a) < 1e-6f * dot(ray->direction, ray->direction)) {
        t = (float2)(b == 0.0f ? NAN : -0.5f * c / b, NAN);
    } else {
        const float inside = b * b - a * c;
        if (!(inside > 0.0f))
            return NO_CROSSINGS;
        // Without a difference of nearly equal numbers.
        const float sum = -(b + copysign(sqrt(inside), b));
        t = sum == 0.0f ? (float2)(0.0f, NAN) : (float2)(sum / a, c / sum);
        t = t.x > t.y ? t.yx : t;
    }
    const float2 s = m + t * n, radii = one.w + slope * s;
    t.x = s.x > 0.0f && s.x < 1.0f && radii.x > 0.0f ? nearest + t.x : NAN;
    t.y = s.y > 0.0f && s.y < 1.0f && radii.y > 0.0f ? nearest + t.y : NAN;
    return t;
}

static inline Crossings disc_crossings(float4 disc, float3 other, const SurfaceRay *ray) {
    const float3 axis = other - disc.xyz;
    const float along = dot(axis, ray->direction), t = dot(axis, disc.xyz - ray->origin) / along;
    return (float2)(along != 0.0f && is_in_sphere(ray->origin + t * ray->direction, disc) ? t : NAN, NAN);
}

// Whether a point on a joint is beside a cone that ends there, of which this is the other point.
static inline bool is_beside_cone(__global const float4 *points, int joint, int other, float3 p) {
    return other >= 0 && dot(p - points[joint].xyz, points[other].xyz - points[joint].xyz) > 0.0f;
}

// Where two pieces coincide, since the line turns back, the first one is seen: more than rounding of floats.
#define SAME_CONE 1e-4f

// Whether a point on a piece of a tube is inside the pieces that touch it.
static inline bool is_inside_tube(__global const float4 *points, int4 cell, float3 p) {
    const int kind = cell.w & 7;
    if (kind == SPHERE)
        return is_beside_cone(points, cell.x, cell.y, p) || is_beside_cone(points, cell.x, cell.z, p);
    return kind == CONE && ((cell.z & CONE_BEFORE && is_in_cone(p, points[cell.x - 1], points[cell.x], SAME_CONE)) ||
                            (cell.z & CONE_BEHIND && is_in_cone(p, points[cell.y], points[cell.y + 1], -SAME_CONE)));
}

static inline Crossings quadric_crossings(__global const float4 *points, int4 cell, const SurfaceRay *ray) {
    const int kind = cell.w & 7;
    Crossings t = kind == SPHERE ? sphere_crossings(points[cell.x], ray)
                  : kind == CONE ? cone_crossings(points[cell.x], points[cell.y], ray)
                                 : disc_crossings(points[cell.x], points[cell.y].xyz, ray);
    t.x = isnan(t.x) || is_inside_tube(points, cell, ray->origin + t.x * ray->direction) ? NAN : t.x;
    t.y = isnan(t.y) || is_inside_tube(points, cell, ray->origin + t.y * ray->direction) ? NAN : t.y;
    return t;
}
