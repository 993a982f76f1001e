// The light that cells scatter, from the mean radiance in them.
//
// One work-item per row of cells. The mean radiance is a start value (`starts`), or the next one of an iteration whose last two are
// `radiance` and `older`. `older` receives it, and at the start `radiance`, too.

#include "light/scatter_grid.cl"

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
            realv own;
            if (p.starts) {
                const realv root = sqrt(MAX(1.0f - albedo, (realv)(0.0f)));
                own = p.sky[c] * (1.0f - root) + 0.5f * direct * (1.0f / MAX(root, (realv)(0.03f)) - 1.0f);
                STORE_CELLS(own, radiance + c * plane + at);
            } else {
                const realv last = LOAD_CELLS(radiance + c * plane + at), before = LOAD_CELLS(older + c * plane + at);
                const realv swept = LOAD_CELLS(mean + c * plane + at);
                own = MAX(p.relaxation * (p.gain * (swept - last) + last - before) + before, (realv)(0.0f));
            }
            STORE_CELLS(own, older + c * plane + at);
            STORE_CELLS(albedo * (own + direct), source + c * plane + at);
        }
    }
}
