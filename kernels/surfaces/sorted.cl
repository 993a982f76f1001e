// Sorted fragments of the pixels of a block.

#include "surfaces/cells.cl"
#include "surfaces/fragment_states.cl"
#include "surfaces/surface_colors.cl"

// A crossing; none if the depth is infinite.
typedef struct {
    float depth;
    uint crossing;
} Fragment;

// What crossings are sorted by.
typedef struct {
    SurfaceData data;
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

// Fragments of the pixels of a block: the nearest translucent ones, sorted, and the nearest opaque one, behind the last ones of before, and from
// `start` on. count: of translucent ones; followed: whether there are more of them; clipped: the parts of rays to which clipped sets are cut.
typedef struct {
    SurfaceData data;
    float start;
    bool is_cut;
    Fragment found[SLOTS][RASTER * RASTER], opaque[RASTER * RASTER], last[RASTER * RASTER];
    Interval clipped[RASTER * RASTER];
    uchar count[RASTER * RASTER];
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
    // Each of these takes the place of the next one behind it. Unrolled: GPUs would keep slots indexed by a variable in memory.
    const int count = block->count[n];
    bool is_kept = false;
#if RASTER == 1
#pragma unroll
#endif
    for (int slot = 0; slot < SLOTS; slot++) {
        const Fragment here = block->found[slot][n];
        if (!is_kept && (slot >= count || comes_before(pixel, fragment, here))) {
            block->found[slot][n] = fragment;
            fragment = here;
            is_kept = slot >= count;
        }
    }
    block->count[n] = count + is_kept;
    block->followed[n] |= !is_kept;
}

static inline bool is_wanted(const Block *block, int n) { return block->wanted[n]; }

static inline void add_crossings(Block *block, int n, uint index, __global const SurfaceSet *set, const SurfaceRay *ray, Crossings crossings) {
    const Pixel pixel = {block->data, *ray};
    for (int second = 0; second < 2; second++) {
        const Fragment fragment = {second ? crossings.y : crossings.x, CROSSING(index, second)};
        // Nor where there is no crossing, whose depth is NaN.
        if (!(fragment.depth > block->start && fragment.depth <= block->opaque[n].depth) ||
            (block->is_cut && set->clipped && !(fragment.depth >= block->clipped[n].from && fragment.depth < block->clipped[n].to)))
            continue;
        if (set->opaque || surface_color(&pixel.data, index, &pixel.ray, fragment.depth).w > 0.0f)
            insert(&pixel, block, n, fragment, set->opaque);
    }
}
