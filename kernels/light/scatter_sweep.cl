// Radiance along an axis x or y and against it, swept through layers of cubic cells. Its mean in each cell, times the weight of the ordinate,
// begins the mean radiance of the cell (along y) or is added to it (`along_x`). If `flux`, planes of the flux along y, then x, follow.
//
// One work-item per row of VW rays along y; along x, per ray. In a cell the extinction and the source are constant. `mean`: planes of these
// layers.

#include "light/scatter_grid.cl"

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
static inline void put_cells(realv x, bool adds, __global float *cells) {
    if (adds)
        x += LOAD_CELLS(cells);
    STORE_CELLS(x, cells);
}

// Sweeps rays along x (`along_x`, a constant), or VW rays along y.
ALWAYS_INLINE void sweep_along(const ScatterSweepParams *p, bool along_x, int id, __global const float *medium, __global const float *source,
                               __global float *mean) {
    const ScatterGrid *grid = &p->grid;
    const int pitch = cell_pitch(grid), groups = pitch / VW, to_next = along_x ? VW : pitch, count = along_x ? groups : grid->y;
    const size_t plane = plane_cells(grid), held = (size_t)pitch * grid->y * p->layers, before = cell_at(grid, 0, 0, p->first);
    const size_t first = along_x ? (size_t)id * pitch : (size_t)(id / groups) * pitch * grid->y + id % groups * VW;
    medium += before, source += before;
    for (int backward = 0; backward < 2; backward++) {
        const float sign = backward ? p->weight : -p->weight;
        // Of the ray along x, or of those along y.
        float ray[3];
        realv rays[3];
#pragma unroll
        for (int c = 0; c < 3; c++)
            rays[c] = ray[c] = p->entering[3 * backward + c];
        for (int k = 0; k < count; k++) {
            const size_t at = first + (size_t)(backward ? count - 1 - k : k) * to_next;
            const realv depth = LOAD_CELLS(medium + at);
            const realv absorbs = absorbed(depth), share = mean_transmittance(depth, absorbs);
#pragma unroll
            for (int c = 0; c < 3; c++) {
                const realv emitted = LOAD_CELLS(source + c * plane + at);
                if (along_x)
                    rays[c] = radiance_between(emitted * absorbs, 1.0f - absorbs, backward, ray + c);
                const realv beyond = rays[c] - emitted;
                rays[c] -= beyond * absorbs;
                const realv in_cell = emitted + beyond * share;
                put_cells(p->weight * in_cell, along_x || backward, mean + c * held + at);
                if (p->flux)
                    put_cells(sign * in_cell, backward, mean + ((along_x ? 6 : 3) + c) * held + at);
            }
        }
    }
}

__kernel void scatter_sweep(__global const float *medium, __global const float *source, __global float *mean, ScatterSweepParams p,
                            ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.items)
        return;
    if (p.along_x)
        sweep_along(&p, true, id, medium, source, mean);
    else
        sweep_along(&p, false, id, medium, source, mean);
}
