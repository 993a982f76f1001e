// Radiance along an axis x or y and against it, swept through layers of cubic cells. Its mean in each cell, times the weight of the ordinate,
// begins the mean radiance of the cell (along y) or is added to it (ALONG_X). With FLUX, planes of the flux along y, then x, follow.
//
// One work-item per row of VW rays along y; along x, per ray. In a cell the extinction and the source are constant. `mean`: planes of these
// layers.

#include "light/scatter_grid.cl"

#ifdef ALONG_X
#define IS_ADDED true
#define FLUX_PLANES 6
typedef float along_t;

// The radiance that enters each of VW cells of a ray that keeps and gains this in them. `along`: what enters the first one, then the next ones.
static inline realv radiance_between(realv gained, realv kept, int backward, float *along) {
    realv entering;
    for (int n = 0; n < VW; n++) {
        const int i = backward ? VW - 1 - n : n;
        ((float *)&entering)[i] = *along;
        *along = *along * ((const float *)&kept)[i] + ((const float *)&gained)[i];
    }
    return entering;
}
#else
#define IS_ADDED false
#define FLUX_PLANES 3
typedef realv along_t;
#endif

static inline void put_cells(realv x, bool adds, __global float *cells) {
    if (adds)
        x += LOAD_CELLS(cells);
    STORE_CELLS(x, cells);
}

__kernel void scatter_sweep(__global const float *medium, __global const float *source, __global float *mean, ScatterSweepParams p,
                            ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.items)
        return;
    const ScatterGrid *grid = &p.grid;
    const int pitch = cell_pitch(grid);
    const size_t plane = plane_cells(grid), held = (size_t)pitch * grid->y * p.layers, before = cell_at(grid, 0, 0, p.first);
    medium += before, source += before;
#ifdef ALONG_X
    const size_t first = (size_t)id * pitch;
    const int count = pitch / VW, to_next = VW;
#else
    const int groups = pitch / VW, count = grid->y, to_next = pitch;
    const size_t first = (size_t)(id / groups) * pitch * grid->y + id % groups * VW;
#endif
    for (int backward = 0; backward < 2; backward++) {
        const float sign = backward ? p.weight : -p.weight;
        along_t along[3];
#pragma unroll
        for (int c = 0; c < 3; c++)
            along[c] = p.entering[3 * backward + c];
        for (int k = 0; k < count; k++) {
            const size_t at = first + (size_t)(backward ? count - 1 - k : k) * to_next;
            const realv depth = LOAD_CELLS(medium + at);
            const realv absorbs = absorbed(depth), share = mean_transmittance(depth, absorbs);
#pragma unroll
            for (int c = 0; c < 3; c++) {
                const realv emitted = LOAD_CELLS(source + c * plane + at);
#ifdef ALONG_X
                const realv beyond = radiance_between(emitted * absorbs, 1.0f - absorbs, backward, along + c) - emitted;
#else
                const realv beyond = along[c] - emitted;
                along[c] -= beyond * absorbs;
#endif
                const realv in_cell = emitted + beyond * share;
                put_cells(p.weight * in_cell, IS_ADDED || backward, mean + c * held + at);
#ifdef FLUX
                put_cells(sign * in_cell, backward, mean + (FLUX_PLANES + c) * held + at);
#endif
            }
        }
    }
}
