// The light that cells scatter, from the mean radiance in them.
//
// One work-item per row of cells. The mean radiance is that of a start value (START), that of a coarser grid, interpolated (REFINED), or the
// next one of an iteration whose last two are `radiance` and `older`. `older` receives it, unless it is interpolated, and at the start
// `radiance`, too.

#include "light/scatter_grid.cl"

#ifdef REFINED
// Interpolates linearly between cells of the coarser grid.
static inline realv between_cells(__global const float *plane, const ScatterGrid *grid, realv x, float y, float z) {
    const int j = min((int)y, grid->y - 1), k = min((int)z, grid->z - 1);
    const float t = min(y - j, 1.0f), u = min(z - k, 1.0f);
    const int next_j = min(j + 1, grid->y - 1), next_k = min(k + 1, grid->z - 1);
    const intv i = CLAMP_INTV(CONVERT_INTV(x), 0, grid->x - 1), next_i = CLAMP_INTV(i + 1, 0, grid->x - 1);
    const realv s = MIN(x - CONVERT_REALV(i), (realv)(1.0f));
    realv rows[4];
    for (int n = 0; n < 4; n++) {
        __global const float *row = plane + cell_at(grid, 0, n & 1 ? next_j : j, n & 2 ? next_k : k);
        const realv low = GATHER(row, i), high = GATHER(row, next_i);
        rows[n] = low + s * (high - low);
    }
    const realv front = rows[0] + t * (rows[1] - rows[0]), back = rows[2] + t * (rows[3] - rows[2]);
    return front + u * (back - front);
}
#endif

__kernel void scatter_source(__global const float *medium, __global float *radiance, __global float *older, __global float *mean,
                             __global float *source, ScatterSourceParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    const ScatterGrid *grid = &p.grid;
    if (id >= grid->y * grid->z)
        return;
    const size_t plane = plane_cells(grid);
    const int y = id % grid->y, z = id / grid->y;
    for (int x = 0; x < cell_pitch(grid); x += VW) {
        const size_t at = cell_at(grid, x, y, z);
        for (int c = 0; c < 3; c++) {
            const realv albedo = p.scattering * LOAD_CELLS(medium + (ALBEDO + c) * plane + at);
            const realv direct = LOAD_CELLS(medium + (DIRECT + c) * plane + at);
#ifdef START
            const realv root = sqrt(MAX(1.0f - albedo, (realv)(0.0f)));
            const realv own = p.sky[c] * (1.0f - root) + 0.5f * direct * (1.0f / MAX(root, (realv)(0.03f)) - 1.0f);
#elif defined(REFINED)
            const realv column = MAX((CONVERT_REALV(x + LANES) + 0.5f) * p.per_cell - 0.5f, (realv)(0.0f));
            const realv own = between_cells(radiance + c * plane_cells(&p.coarser), &p.coarser, column,
                                            MAX((y + 0.5f) * p.per_cell - 0.5f, 0.0f), MAX((z + 0.5f) * p.per_cell - 0.5f, 0.0f));
#else
            const realv last = LOAD_CELLS(radiance + c * plane + at), before = LOAD_CELLS(older + c * plane + at);
            const realv swept = LOAD_CELLS(mean + c * plane + at);
            const realv own = MAX(p.relaxation * (p.gain * (swept - last) + last - before) + before, (realv)(0.0f));
#endif
#ifdef START
            STORE_CELLS(own, radiance + c * plane + at);
#endif
#ifndef REFINED
            STORE_CELLS(own, older + c * plane + at);
#endif
            STORE_CELLS(albedo * (own + direct), source + c * plane + at);
        }
    }
}
