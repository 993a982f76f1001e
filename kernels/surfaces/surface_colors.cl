// Colours and normals where a ray crosses a cell.

// What the cells of all sets have. attributes: straight colours, or values; normals of points.
typedef struct {
    __global const float4 *points;
    __global const int4 *cells;
    __global const SurfaceSet *sets;
    __global const float *attributes;
    __global const float4 *normals, *tables;
} SurfaceData;

#define SURFACE_DATA                                                                                                               \
    __global const float4 *points, __global const int4 *cells, __global const SurfaceSet *sets, __global const float *attributes, \
        __global const float4 *normals, __global const float4 *tables
#define SURFACE_DATA_SOURCE {points, cells, sets, attributes, normals, tables}

// Kinds of shading: SurfaceShading of src/host/surface.
#define FLAT 1
#define SMOOTH 2

// Kinds of attributes.
#define NO_ATTRIBUTE 0
#define COLORS_OF_POINTS 1
#define COLORS_OF_CELLS 2
#define VALUES_OF_POINTS 3
#define VALUES_OF_CELLS 4

static inline __global const SurfaceSet *set_of(const SurfaceData *data, uint cell) { return data->sets + (data->cells[cell].w >> 3); }

// Weights of the points of a cell at a place on it.
static inline float3 weights_in_cell(const SurfaceData *data, int4 cell, float3 place) {
    const float3 first = data->points[cell.x].xyz;
    if ((cell.w & 7) == TRIANGLE) {
        const float3 one = data->points[cell.y].xyz - first, other = data->points[cell.z].xyz - first, off = place - first;
        const float3 normal = cross(one, other);
        const float inverse = 1.0f / dot(normal, normal);
        const float second = clamp(dot(cross(off, other), normal) * inverse, 0.0f, 1.0f);
        const float third = clamp(dot(cross(one, off), normal) * inverse, 0.0f, 1.0f - second);
        return (float3)(1.0f - second - third, second, third);
    }
    if ((cell.w & 7) != CONE)
        return (float3)(1.0f, 0.0f, 0.0f);
    const float3 axis = data->points[cell.y].xyz - first;
    const float second = clamp(dot(place - first, axis) / dot(axis, axis), 0.0f, 1.0f);
    return (float3)(1.0f - second, second, 0.0f);
}

// Number of the points of a cell that have weights.
static inline int points_of_cell(int4 cell) { return (cell.w & 7) == TRIANGLE ? 3 : (cell.w & 7) == CONE ? 2 : 1; }

// Straight colour and opacity, unlit.
static inline float4 surface_color(const SurfaceData *data, uint index, const SurfaceRay *ray, float depth) {
    const int4 cell = data->cells[index];
    __global const SurfaceSet *set = data->sets + (cell.w >> 3);
    const float4 own = {set->color[0], set->color[1], set->color[2], set->color[3]};
    if (set->attribute == NO_ATTRIBUTE)
        return own;
    __global const float *attributes = data->attributes + set->first_attribute;
    const bool is_color = set->attribute <= COLORS_OF_CELLS;
    float4 sum = 0.0f;
    if (set->attribute == COLORS_OF_CELLS || set->attribute == VALUES_OF_CELLS) {
        const uint n = index - set->first_cell;
        sum = is_color ? vload4(n, attributes) : (float4)(attributes[n]);
    } else {
        const float3 weights = weights_in_cell(data, cell, ray->origin + depth * ray->direction);
        const int count = points_of_cell(cell);
        const int numbers[3] = {cell.x, count > 1 ? cell.y : cell.x, count > 2 ? cell.z : cell.x};
        const float shares[3] = {weights.x, weights.y, weights.z};
#pragma unroll
        for (int i = 0; i < 3; i++) {
            const uint n = numbers[i] - set->first_point;
            sum += shares[i] * (is_color ? vload4(n, attributes) : (float4)(attributes[n]));
        }
    }
    if (is_color)
        return (float4)(sum.xyz, sum.w * own.w);
    if (isnan(sum.x) || isinf(sum.x))
        return own;
    const float place = clamp((sum.x - set->table_from) * set->table_per_value, 0.0f, (float)(SURFACE_COLORS - 1));
    const int entry = min((int)place, SURFACE_COLORS - 2);
    __global const float4 *table = data->tables + set->first_color;
    const float4 color = mix(table[entry], table[entry + 1], place - entry);
    return (float4)(color.xyz, own.w);
}

// Direction of a tube, and growth of its radius along it.
typedef struct {
    float3 along;
    float slope;
} Course;

static inline Course course_between(float4 from, float4 to) {
    const float3 axis = to.xyz - from.xyz;
    const float inverse = rsqrt(dot(axis, axis));
    const Course course = {axis * inverse, (to.w - from.w) * inverse};
    return course;
}

// Between two others; `instead` where they are opposite.
static inline Course mixed_course(Course one, Course other, float share, Course instead) {
    Course course = {mix(one.along, other.along, share), mix(one.slope, other.slope, share)};
    const float squared = dot(course.along, course.along);
    course.along *= rsqrt(squared);
    return squared > 1e-6f ? course : instead;
}

// The course of a line at one of its points, halfway between those before and behind it.
static inline Course course_at_joint(__global const float4 *points, int before, int joint, int behind, Course instead) {
    return mixed_course(course_between(points[before], points[joint]), course_between(points[joint], points[behind]), 0.5f, instead);
}

// The unit normal where a tube has a point off its axis.
static inline float3 normal_across(Course course, float3 off) {
    const float3 across = off - dot(off, course.along) * course.along;
    const float squared = dot(across, across);
    return normalize(across * (squared > 0.0f ? rsqrt(squared) : 0.0f) - course.slope * course.along);
}

// Smooth normals of tubes follow the course of the line from joint to joint.
static inline float3 cone_normal(__global const float4 *points, int4 cell, float3 place, bool is_smooth) {
    const float4 first = points[cell.x], second = points[cell.y];
    const float3 axis = second.xyz - first.xyz;
    const float s = dot(place - first.xyz, axis) / dot(axis, axis);
    const Course own = course_between(first, second);
    Course start = own, end = own;
    if (is_smooth && cell.z & CONE_BEFORE)
        start = course_at_joint(points, cell.x - 1, cell.x, cell.y, own);
    if (is_smooth && cell.z & CONE_BEHIND)
        end = course_at_joint(points, cell.x, cell.y, cell.y + 1, own);
    return normal_across(mixed_course(start, end, s, own), place - first.xyz - s * axis);
}

static inline float3 sphere_normal(__global const float4 *points, int4 cell, float3 place, bool is_smooth) {
    const float3 off = place - points[cell.x].xyz;
    const Course none = {0.0f, 0.0f};
    Course course = none;
    if (is_smooth && cell.y >= 0 && cell.z >= 0)
        course = course_at_joint(points, cell.y, cell.x, cell.z, none);
    return normal_across(course, off);
}

// Unit normal, on either side.
static inline float3 surface_normal(const SurfaceData *data, uint index, const SurfaceRay *ray, float depth) {
    const int4 cell = data->cells[index];
    __global const SurfaceSet *set = data->sets + (cell.w >> 3);
    const float4 first = data->points[cell.x];
    const float3 place = ray->origin + depth * ray->direction;
    const int kind = cell.w & 7;
    if (kind == SPHERE)
        return sphere_normal(data->points, cell, place, set->shaded == SMOOTH);
    if (kind == CONE)
        return cone_normal(data->points, cell, place, set->shaded == SMOOTH);
    const float3 axis = data->points[cell.y].xyz - first.xyz;
    if (kind == DISC)
        return normalize(axis);
    const float3 flat = cross(axis, data->points[cell.z].xyz - first.xyz);
    if (set->first_normal < 0)
        return normalize(flat);
    __global const float4 *normals = data->normals + set->first_normal - set->first_point;
    const float3 weights = weights_in_cell(data, cell, place);
    const float3 own = weights.x * normals[cell.x].xyz + weights.y * normals[cell.y].xyz + weights.z * normals[cell.z].xyz;
    __global const float *m = set->normal_to_view;
    const float3 placed = {m[0] * own.x + m[1] * own.y + m[2] * own.z, m[3] * own.x + m[4] * own.y + m[5] * own.z,
                           m[6] * own.x + m[7] * own.y + m[8] * own.z};
    const float squared = dot(placed, placed);
    return squared > 0.0f && isfinite(squared) ? placed * rsqrt(squared) : normalize(flat);
}
