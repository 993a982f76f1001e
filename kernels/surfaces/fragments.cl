// The next fragments of each pixel, front to back: where its ray crosses surfaces. An opaque one is the last.
//
// One work-item per block of RASTER x RASTER pixels of a tile. depths, colors: SLOTS of them per pixel, slot by slot; colors are straight, lit,
// and of half precision. states: number of fragments, FOLLOWED if there can be more, WANTED where the next ones are to be found: those behind
// the last of before, whose crossing is in `crossings`. SORTED: the entries of tiles are in the order of `nearest`, and `farthest` is what
// sort_cells.cl says.

#include "shared/elementary.cl"
#include "shared/shading.cl"
#include "shared/clipping.cl"
#include "surfaces/sorted.cl"
#include "surfaces/crossings.cl"

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

// A block before any crossing. first: of the first fragments.
static inline bool begin_block(Block *block, const BlockPlace *place, const SurfaceView *view, const RayEnds *ray_ends, int first,
                               __global const float *depths, __global const uint *crossings, __global const uchar *states) {
    const Fragment none = {INFINITY, 0}, before_all = {-INFINITY, 0};
    const size_t pixels = (size_t)view->width * view->height;
    bool any_wanted = false;
    block->start = view->start, block->is_cut = cuts_rays(ray_ends);
    for (int n = 0; n < RASTER * RASTER; n++) {
        const int x = place->column + n % RASTER, y = place->row + n / RASTER, at = y * view->width + x;
        const bool exists = n % RASTER < place->columns && n / RASTER < place->rows;
        const int state = !exists ? 0 : first ? WANTED : states[at];
        block->wanted[n] = (state & WANTED) != 0, block->followed[n] = false, block->count[n] = 0;
        block->opaque[n] = none, block->last[n] = before_all;
        any_wanted |= block->wanted[n];
        if (state & WANTED && state & FOLLOWED)
            block->last[n].depth = depths[(SLOTS - 1) * pixels + at], block->last[n].crossing = crossings[at];
        if (state & WANTED && block->is_cut) {
            const SurfaceRay ray = surface_ray(view, x, y);
            const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z}, along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
            block->clipped[n] = clip_rays(ray_ends, origin, along);
        }
    }
    return any_wanted;
}

#ifdef SORTED
// Entries that are met before it is looked whether any of the next ones can be nearer than the fragments that are kept.
#define BATCH 16

// The first entry with a crossing behind the last fragments of before.
static inline uint first_entry(const Block *block, const BlockPlace *place, __global const float *farthest) {
    float last = INFINITY;
    for (int n = 0; n < RASTER * RASTER; n++)
        last = block->wanted[n] ? fmin(last, block->last[n].depth) : last;
    uint first = place->begin, end = place->end;
    while (first < end) {
        const uint middle = first + (end - first) / 2;
        if (farthest[middle] < last)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}

// Whether crossings from a depth on are behind all fragments that are kept.
static inline bool is_complete(const Block *block, float depth) {
    bool is_complete = true;
    for (int n = 0; n < RASTER * RASTER; n++) {
        const float kept = block->count[n] == SLOTS ? block->found[SLOTS - 1][n].depth : INFINITY;
        is_complete &= !block->wanted[n] || depth > fmin(kept, block->opaque[n].depth);
    }
    return is_complete;
}
#endif

__kernel void fragments(SURFACE_DATA, __global const int2 *rounded, __global const ushort4 *bounds, __global const uint *ends,
                        __global const uint *lists, __global const float *nearest, __global const float *farthest, int chunks, int first, SurfaceView view, SampleParams sample, RayEnds ray_ends,
                        __global const uchar *light, __global const uchar *sky, __global float *depths, __global ushort4 *colors,
                        __global uint *crossings, __global uchar *states, ulong first_item) {
    const int item = first_item + get_global_id(0), across = SURFACE_TILE / RASTER;
    if (item >= view.tiles_u * across * view.tiles_v * across)
        return;
    BlockPlace place = place_of_block(&view, ends, chunks, item);
    if (place.begin == place.end) {
        for (int y = place.row; y < place.row + place.rows; y++)
            for (int x = place.column; x < place.column + place.columns; x++)
                states[y * view.width + x] = 0;
        return;
    }
    Block block = {SURFACE_DATA_SOURCE};
    if (!begin_block(&block, &place, &view, &ray_ends, first, depths, crossings, states))
        return;
#ifdef SORTED
    const uint end = place.end;
    for (place.begin = first_entry(&block, &place, farthest); place.begin < end; place.begin = place.end) {
        if (is_complete(&block, nearest[place.begin])) {
            // Perhaps by none.
            for (int n = 0; n < RASTER * RASTER; n++)
                block.followed[n] |= block.count[n] == SLOTS;
            break;
        }
        place.end = min(place.begin + BATCH, end);
        meet_cells(&block, &place, &view, points, cells, sets, rounded, bounds, lists);
    }
#else
    meet_cells(&block, &place, &view, points, cells, sets, rounded, bounds, lists);
#endif

    const LightVolume volume = {light, sky};
    const size_t pixels = (size_t)view.width * view.height;
    for (int n = 0; n < RASTER * RASTER; n++) {
        if (!block.wanted[n])
            continue;
        const int x = place.column + n % RASTER, y = place.row + n / RASTER, at = y * view.width + x;
        const Pixel pixel = {SURFACE_DATA_SOURCE, surface_ray(&view, x, y)};
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
            depths[slot * pixels + at] = fragment.depth;
            vstore_half4(lit_fragment(&pixel, &view, &sample, volume, fragment), slot * pixels + at, (__global half *)colors);
            crossings[at] = fragment.crossing;
            count = slot + 1;
        }
        // If no slot was left for the opaque one, it follows.
        const bool is_followed = !is_last && (block.followed[n] || opaque.depth < INFINITY);
        states[at] = count | (is_followed ? FOLLOWED : 0);
    }
}
