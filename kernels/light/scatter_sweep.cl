// Radiance along an axis x or y and against it, swept through cubic cells. Its mean in each cell, times the weight of the ordinate, begins the
// mean radiance of the cell (along y) or is added to it (ALONG_X). So it is with FLUX for the flux along the axis, whose planes follow.
//
// One work-item per row of VW rays. In a cell the extinction and the source are constant.

#include "light/scatter_grid.cl"

#ifdef ALONG_X
// Neighbouring rays are a row apart; those beyond the last row read its cells.
static inline realv load_rays(__global const float *cells, int pitch, int inside) {
    return GATHER(cells, MIN(LANES, (intv)(inside - 1)) * pitch);
}
static inline void store_rays(__global float *cells, int pitch, int inside, bool adds, realv x) {
#if VW == 1
    *cells = adds ? *cells + x : x;
#else
    const float *lanes = (const float *)&x;
    for (int i = 0; i < inside; i++)
        cells[(size_t)i * pitch] = adds ? cells[(size_t)i * pitch] + lanes[i] : lanes[i];
#endif
}
#else
#define load_rays(cells, pitch, inside) LOAD_CELLS(cells)
static inline void store_rays(__global float *cells, int pitch, int inside, bool adds, realv x) {
    if (adds)
        x += LOAD_CELLS(cells);
    STORE_CELLS(x, cells);
}
#endif

__kernel void scatter_sweep(__global const float *medium, __global const float *source, __global float *mean, ScatterSweepParams p,
                            ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.items)
        return;
    const ScatterGrid *grid = &p.grid;
    const size_t plane = plane_cells(grid);
    const int pitch = cell_pitch(grid);
#ifdef ALONG_X
    const int groups = (grid->y + VW - 1) / VW, y = id % groups * VW, layers = grid->x, to_next = 1;
    const size_t first = cell_at(grid, 0, y, id / groups);
    const int inside = min(VW, grid->y - y);
#define AXIS 0
#else
    const int groups = pitch / VW, layers = grid->y, to_next = pitch, inside = VW;
    const size_t first = cell_at(grid, id % groups * VW, 0, id / groups);
#define AXIS 1
#endif
    for (int backward = 0; backward < 2; backward++) {
        realv radiance[3];
#pragma unroll
        for (int c = 0; c < 3; c++)
            radiance[c] = (realv)(p.entering[3 * backward + c]);
        for (int k = 0; k < layers; k++) {
            const size_t at = first + (size_t)(backward ? layers - 1 - k : k) * to_next;
            const realv depth = load_rays(medium + at, pitch, inside);
            const realv absorbs = absorbed(depth), share = mean_transmittance(depth, absorbs);
#pragma unroll
            for (int c = 0; c < 3; c++) {
                const realv emitted = load_rays(source + c * plane + at, pitch, inside);
                const realv beyond = radiance[c] - emitted, in_cell = p.weight * (emitted + beyond * share);
                radiance[c] -= beyond * absorbs;
                store_rays(mean + c * plane + at, pitch, inside, AXIS == 0 || backward, in_cell);
#ifdef FLUX
                store_rays(mean + FLUX_PLANE(AXIS, c) * plane + at, pitch, inside, backward, backward ? in_cell : -in_cell);
#endif
            }
        }
    }
}
