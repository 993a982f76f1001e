// The next fragments of each pixel, front to back: where its ray crosses surfaces. An opaque one is the last.
//
// One work-item per block of RASTER x RASTER pixels of a tile. depths, colors: SLOTS of them per pixel, slot by slot; colors are straight, lit,
// and of half precision. states: number of fragments, FOLLOWED if there can be more, WANTED where the next ones are to be found: those behind
// the last of before, whose crossing is in `crossings`.

#ifndef RASTER
#error "RASTER: columns and rows of pixels of a work-item"
#endif

#include "shared/elementary.cl"
#include "shared/shading.cl"
#include "shared/clipping.cl"
#include "surfaces/triangles.cl"
#include "surfaces/sorted.cl"


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

// Whether surfaces are cut anywhere.
static inline bool cuts_rays(const RayEnds *ends) {
    bool cuts = ends->plane_count > 0;
    for (int i = 0; i < 3; i++)
        cuts |= ends->lowest[i] > -INFINITY || ends->highest[i] < INFINITY;
    return cuts;
}

__kernel void fragments(SURFACE_DATA, __global const int2 *rounded, __global const ushort4 *bounds, __global const uint *ends,
                        __global const uint *lists, int chunks, int first, SurfaceView view, SampleParams sample, RayEnds ray_ends,
                        __global const uchar *light, __global const uchar *sky, __global float *depths, __global ushort4 *colors,
                        __global uint *crossings, __global uchar *states, ulong first_item) {
    const int item = first_item + get_global_id(0), across = SURFACE_TILE / RASTER;
    const int blocks_u = view.tiles_u * across;
    if (item >= blocks_u * view.tiles_v * across)
        return;
    const int column = item % blocks_u * RASTER, row = item / blocks_u * RASTER;
    const int tile = row / SURFACE_TILE * view.tiles_u + column / SURFACE_TILE, tiles = view.tiles_u * view.tiles_v;
    const int columns = min(RASTER, view.width - column), rows = min(RASTER, view.height - row);
    if (columns <= 0 || rows <= 0)
        return;
    // counts[chunk*tiles + tile] of the last chunk are where lists end.
    __global const uint *list_ends = ends + (size_t)(chunks - 1) * tiles;
    const uint begin = tile ? list_ends[tile - 1] : 0, end = list_ends[tile];
    const int pixels = view.width * view.height;
    if (begin == end) {
        for (int y = row; y < row + rows; y++)
            for (int x = column; x < column + columns; x++)
                states[y * view.width + x] = 0;
        return;
    }
    Pixel pixel = {SURFACE_DATA_SOURCE};
    Block block;
    bool any_wanted = false;
    const bool is_cut = cuts_rays(&ray_ends);
    const Fragment none = {INFINITY, 0}, before_all = {-INFINITY, 0};
    for (int n = 0; n < RASTER * RASTER; n++) {
        const int x = column + n % RASTER, y = row + n / RASTER, at = y * view.width + x;
        const bool exists = n % RASTER < columns && n / RASTER < rows;
        const int state = !exists ? 0 : first ? WANTED : states[at];
        block.wanted[n] = (state & WANTED) != 0, block.followed[n] = false, block.count[n] = 0;
        block.opaque[n] = none, block.last[n] = before_all;
        any_wanted |= block.wanted[n];
        if (state & WANTED && state & FOLLOWED)
            block.last[n].depth = depths[(size_t)(SLOTS - 1) * pixels + at], block.last[n].crossing = crossings[at];
        if (state & WANTED && is_cut) {
            const SurfaceRay ray = surface_ray(&view, x, y);
            const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z}, along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
            block.clipped[n] = clip_rays(&ray_ends, origin, along);
        }
    }
    if (!any_wanted)
        return;

    for (uint i = begin; i < end; i++) {
        const uint index = lists[i];
        const Pixels covered = convert_int4(bounds[index]);
        const int first_x = max(covered.x, column), last_x = min(covered.y, column + columns - 1);
        const int first_y = max(covered.z, row), last_y = min(covered.w, row + rows - 1);
        if (first_x > last_x || first_y > last_y)
            continue;
        const int4 cell = cells[index];
        __global const SurfaceSet *set = sets + (cell.w >> 3);
        const bool is_triangle = (cell.w & 7) == TRIANGLE, is_clipped = is_cut && set->clipped;
        Edges edges = {0, 0, 0};
        ScreenTriangle triangle;
        bool is_exact = false;
        if (is_triangle) {
            triangle = on_pixels(rounded, cell);
            is_exact = is_rounded(&triangle);
        }
        if (is_exact)
            edges = edges_at(&triangle, first_x, first_y);
        for (int y = first_y; y <= last_y; y++) {
            long4 here = edges.here;
            for (int x = first_x; x <= last_x; x++, here += edges.per_column) {
                // GPUs would keep blocks indexed by a variable in memory.
                const int n = RASTER > 1 ? (y - row) * RASTER + (x - column) : 0;
                if ((is_exact && !are_alike(here)) || !block.wanted[n])
                    continue;
                pixel.ray = surface_ray(&view, x, y);
                Crossings t = NO_CROSSINGS;
                if (!is_triangle)
                    t = quadric_crossings(points, cell, &pixel.ray);
                else if (is_exact || covers(&view, points, cell, &triangle, x, y, &pixel.ray))
                    t.x = triangle_depth(points, cell, &pixel.ray);
                for (int second = 0; second < (is_triangle ? 1 : 2); second++) {
                    const Fragment fragment = {second ? t.y : t.x, CROSSING(index, second)};
                    // Nor where there is no crossing, whose depth is NaN.
                    if (!(fragment.depth > view.start && fragment.depth <= block.opaque[n].depth) ||
                        (is_clipped && !(fragment.depth >= block.clipped[n].from && fragment.depth < block.clipped[n].to)))
                        continue;
                    if (!set->opaque && surface_color(&pixel.data, index, &pixel.ray, fragment.depth).w <= 0.0f)
                        continue;
                    insert(&pixel, &block, n, fragment, set->opaque);
                }
            }
            edges.here += edges.per_row;
        }
    }

    const LightVolume volume = {light, sky};
    for (int n = 0; n < RASTER * RASTER; n++) {
        if (!block.wanted[n])
            continue;
        const int x = column + n % RASTER, y = row + n / RASTER, at = y * view.width + x;
        pixel.ray = surface_ray(&view, x, y);
        const Fragment opaque = block.opaque[n];
        int count = 0;
        bool is_last = false;
#if RASTER == 1
#pragma unroll
#endif
        for (int slot = 0; slot < SLOTS; slot++) {
            const bool is_found = slot < block.count[n];
            Fragment fragment = block.found[slot][n];
            // The opaque one is behind all that are drawn.
            if (is_last || !(is_found || opaque.depth < INFINITY))
                continue;
            if (!is_found || !comes_before(&pixel, fragment, opaque))
                fragment = opaque, is_last = true;
            depths[(size_t)slot * pixels + at] = fragment.depth;
            vstore_half4(lit_fragment(&pixel, &view, &sample, volume, fragment), (size_t)slot * pixels + at, (__global half *)colors);
            crossings[at] = fragment.crossing;
            count = slot + 1;
        }
        // If no slot was left for the opaque one, it follows.
        const bool is_followed = !is_last && (block.followed[n] || opaque.depth < INFINITY);
        states[at] = count | (is_followed ? FOLLOWED : 0);
    }
}
