// The next fragments of each pixel, front to back: where its ray crosses surfaces. An opaque one is the last.
//
// One work-item per block of RASTER x RASTER pixels of a tile. depths, colors: SLOTS of them per pixel, slot by slot; colors are straight, lit,
// and of half precision. states: number of fragments, FOLLOWED if there can be more, WANTED where the next ones are to be found: those behind
// the last of before, whose crossing is in `crossings`.

#include "shared/elementary.cl"
#include "shared/shading.cl"
#include "shared/clipping.cl"
#include "surfaces/cells.cl"
#include "surfaces/fragment_states.cl"
#include "surfaces/surface_colors.cl"

#ifndef RASTER
#error "RASTER: columns and rows of pixels of a work-item"
#endif

// A crossing; none if the depth is infinite.
typedef struct {
    float depth;
    uint crossing;
} Fragment;

// What crossings are sorted by.
typedef struct {
    SurfaceData data;
    int x, y;
    SurfaceRay ray;
} Pixel;

// Whether one of two fragments comes before the other: by depth, then by set, then by colour.
static inline bool comes_before(const Pixel *pixel, Fragment one, Fragment other) {
    if (one.depth != other.depth)
        return one.depth < other.depth;
    const int4 cell = pixel->data.cells[CELL_OF(one.crossing)], second = pixel->data.cells[CELL_OF(other.crossing)];
    if (cell.w >> 3 != second.w >> 3)
        return cell.w < second.w;
    const uint4 color = as_uint4(surface_color(&pixel->data, CELL_OF(one.crossing), &pixel->ray, one.depth));
    const uint4 behind = as_uint4(surface_color(&pixel->data, CELL_OF(other.crossing), &pixel->ray, other.depth));
    return color.x != behind.x   ? color.x < behind.x
           : color.y != behind.y ? color.y < behind.y
           : color.z != behind.z ? color.z < behind.z
           : color.w != behind.w ? color.w < behind.w
                                 : one.crossing < other.crossing;
}

// Fragments of the pixels of a block.
typedef struct {
    Fragment found[SLOTS][RASTER * RASTER], opaque[RASTER * RASTER], last[RASTER * RASTER];
    Interval clipped[RASTER * RASTER];
    bool wanted[RASTER * RASTER], followed[RASTER * RASTER];
} Block;

// Keeps the nearest fragments behind the last ones.
static inline void insert(const Pixel *pixel, Block *block, int n, Fragment fragment, bool is_opaque) {
    if (!comes_before(pixel, block->last[n], fragment) || !comes_before(pixel, fragment, block->opaque[n]))
        return;
    if (is_opaque) {
        block->opaque[n] = fragment;
        return;
    }
    // Each of these takes the place of the next one behind it.
#pragma unroll
    for (int slot = 0; slot < SLOTS; slot++) {
        const Fragment here = block->found[slot][n];
        if (fragment.depth < INFINITY && comes_before(pixel, fragment, here)) {
            block->found[slot][n] = fragment;
            fragment = here;
        }
    }
    block->followed[n] |= fragment.depth < INFINITY;
}

// Colour and opacity of a fragment.
static inline float4 lit_fragment(const Pixel *pixel, const SurfaceView *view, const SampleParams *sample, LightVolume light,
                                  Fragment fragment) {
    const uint cell = CELL_OF(fragment.crossing);
    float4 color = surface_color(&pixel->data, cell, &pixel->ray, fragment.depth);
    __global const SurfaceSet *set = set_of(&pixel->data, cell);
    const float3 place = pixel->ray.origin + fragment.depth * pixel->ray.direction;
    const Point point = {place.x * view->to_voxels[0] + view->centre[0], place.y * view->to_voxels[1] + view->centre[1],
                         place.z * view->to_voxels[2] + view->centre[2]};
    const float3 normal = surface_normal(&pixel->data, cell, &pixel->ray, fragment.depth);
    // As long as gradients of sure direction are.
    const Gradient gradient = {normal.x / sample->field.gradient_u, normal.y / sample->field.gradient_v, normal.z / sample->field.gradient_a};
    Lighting lighting = shade(sample, light, point, 0.0f, gradient);
    if (!set->shaded || !sample->light.shading) {
        FOR_LIT_COMPONENTS(i)
            lighting.factor[i] = 1.0f, lighting.highlight[i] = 0.0f;
    }
    color.x = lit_red(sample, LIT_COLOR(color.x), &lighting);
    color.y = lit_green(sample, LIT_COLOR(color.y), &lighting);
    color.z = lit_blue(sample, LIT_COLOR(color.z), &lighting);
    return color;
}

__kernel void fragments(SURFACE_DATA, __global const uint *ends, __global const uint *lists, int chunks, int first, SurfaceView view,
                        SampleParams sample, RayEnds ray_ends, __global const uchar *light, __global const uchar *sky, __global float *depths,
                        __global ushort4 *colors, __global uint *crossings, __global uchar *states, ulong first_item) {
    const int item = first_item + get_global_id(0), across = SURFACE_TILE / RASTER;
    const int blocks_u = view.tiles_u * across;
    if (item >= blocks_u * view.tiles_v * across)
        return;
    const int column = item % blocks_u * RASTER, row = item / blocks_u * RASTER;
    const int tile = row / SURFACE_TILE * view.tiles_u + column / SURFACE_TILE, tiles = view.tiles_u * view.tiles_v;
    const int columns = min(RASTER, view.width - column), rows = min(RASTER, view.height - row);
    if (columns <= 0 || rows <= 0)
        return;
    const int pixels = view.width * view.height;
    Pixel pixel = {SURFACE_DATA_SOURCE, 0, 0};
    Block block;
    bool any_wanted = false;
    const Fragment none = {INFINITY, 0}, before_all = {-INFINITY, 0};
    for (int n = 0; n < RASTER * RASTER; n++) {
        const int x = column + n % RASTER, y = row + n / RASTER, at = y * view.width + x;
        const bool exists = n % RASTER < columns && n / RASTER < rows;
        const int state = !exists ? 0 : first ? WANTED : states[at];
        block.wanted[n] = (state & WANTED) != 0, block.followed[n] = false;
        any_wanted |= block.wanted[n];
        if (!block.wanted[n])
            continue;
        for (int slot = 0; slot < SLOTS; slot++)
            block.found[slot][n] = none;
        block.opaque[n] = none, block.last[n] = before_all;
        if (state & FOLLOWED)
            block.last[n].depth = depths[(size_t)(SLOTS - 1) * pixels + at], block.last[n].crossing = crossings[at];
        const SurfaceRay ray = surface_ray(&view, x, y);
        const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z}, along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        block.clipped[n] = clip_rays(&ray_ends, origin, along);
    }
    if (!any_wanted)
        return;

    // counts[chunk*tiles + tile] of the last chunk are where lists end.
    __global const uint *list_ends = ends + (size_t)(chunks - 1) * tiles;
    const uint begin = tile ? list_ends[tile - 1] : 0, end = list_ends[tile];
    for (uint i = begin; i < end; i++) {
        const uint index = lists[i];
        const int4 cell = cells[index];
        __global const SurfaceSet *set = sets + (cell.w >> 3);
        const Pixels covered = pixels_of_cell(&view, points, cell);
        Corner corners[3];
        if ((cell.w & 7) == TRIANGLE) {
            corners[0] = make_corner(&view, points[cell.x].xyz), corners[1] = make_corner(&view, points[cell.y].xyz);
            corners[2] = make_corner(&view, points[cell.z].xyz);
        }
        const int last_x = min(covered.y, column + columns - 1), last_y = min(covered.w, row + rows - 1);
        for (int y = max(covered.z, row); y <= last_y; y++)
            for (int x = max(covered.x, column); x <= last_x; x++) {
                const int n = (y - row) * RASTER + (x - column);
                if (!block.wanted[n])
                    continue;
                pixel.x = x, pixel.y = y, pixel.ray = surface_ray(&view, x, y);
                const Crossings t = cell_crossings(&view, points, cell, corners, x, y, &pixel.ray);
                for (int second = 0; second < 2; second++) {
                    const Fragment fragment = {second ? t.y : t.x, CROSSING(index, second)};
                    // Nor where there is no crossing, whose depth is NaN.
                    if (!(fragment.depth > view.start) ||
                        (set->clipped && !(fragment.depth >= block.clipped[n].from && fragment.depth < block.clipped[n].to)))
                        continue;
                    if (!set->opaque && surface_color(&pixel.data, index, &pixel.ray, fragment.depth).w <= 0.0f)
                        continue;
                    insert(&pixel, &block, n, fragment, set->opaque);
                }
            }
    }

    const LightVolume volume = {light, sky};
    for (int n = 0; n < RASTER * RASTER; n++) {
        if (!block.wanted[n])
            continue;
        const int x = column + n % RASTER, y = row + n / RASTER, at = y * view.width + x;
        pixel.x = x, pixel.y = y, pixel.ray = surface_ray(&view, x, y);
        int count = 0;
        bool is_followed = block.followed[n], is_last = false;
#pragma unroll
        for (int slot = 0; slot < SLOTS; slot++) {
            Fragment fragment = block.found[slot][n];
            // The opaque one is behind all that are drawn.
            if (!is_last && block.opaque[n].depth <= fragment.depth && !comes_before(&pixel, fragment, block.opaque[n])) {
                fragment = block.opaque[n];
                is_last = true, is_followed = false;
            } else if (is_last) {
                fragment.depth = INFINITY;
            }
            if (fragment.depth < INFINITY) {
                depths[(size_t)slot * pixels + at] = fragment.depth;
                vstore_half4(lit_fragment(&pixel, &view, &sample, volume, fragment), (size_t)slot * pixels + at, (__global half *)colors);
                crossings[at] = fragment.crossing;
                count = slot + 1;
            }
        }
        // No slot is left for the opaque one.
        is_followed |= !is_last && block.opaque[n].depth < INFINITY;
        states[at] = count | (is_followed ? FOLLOWED : 0);
    }
}
