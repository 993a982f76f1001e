// Radiance along the ordinates that cross layers of cubic cells upwards, or downwards: an axis and four diagonals. Its mean in each cell, times
// the weight of the ordinate, is added to the mean radiance of the cell. Of the last sweeps (`is_last`), the upward one packs the light field,
// and the downward one adds its own and what `mean` has of sweeps along x and y (scatter_sweep.cl).
//
// A launch takes a few layers, and a work-item a block of rows in them; in one lane, a cell of each layer. Diagonals come from the rows beside,
// so a block becomes smaller by a row on either side from layer to layer. The rows between two blocks are those of a second launch (`between`).
// Each cell is loaded once for five ordinates.
//
// Rays keep their places in `rays` while they move: a row of rays, of an ordinate and a colour, is the row of cells less the steps along y,
// modulo `ring`, and a ray in it the cell less the steps along x.

#include "light/scatter_grid.cl"
#include "light/scatter_pack.cl"

#define ORDINATES 5
// Cells from layer to layer of ordinate n: the axis, then the diagonals.
#define STEP_X(n) ((n) == 0 ? 0 : (n) & 1 ? 1 : -1)
#define STEP_Y(n) ((n) == 0 ? 0 : (n) < 3 ? 1 : -1)

// Sweeps cells from `first_x` to `end_x` of a row. `is_last`: a constant.
ALWAYS_INLINE void sweep_row(const ScatterLayersParams *p, bool is_last, int step, int y, int first_x, int end_x, __global const float *medium,
                             __global const float *source, __global float *mean, __global float *rays, __global uchar *packed) {
    const ScatterGrid *grid = &p->grid;
    const size_t plane = plane_cells(grid);
    const int pitch = cell_pitch(grid), columns = pitch + grid->z, of_color = p->ring * columns;
    const int z = p->upwards ? step : grid->z - 1 - step;
    const size_t row = cell_at(grid, 0, y, z), in_mean = cell_at(grid, 0, y, z - p->held_from), held = plane / grid->z * p->held;
    __global int *words = (__global int *)packed + 4 * (size_t)grid->x * (grid->y * z + y);
    // Of cell 0 in each ordinate's row of rays.
    int ray_at[ORDINATES];
    bool enters[ORDINATES];
#pragma unroll
    for (int n = 0; n < ORDINATES; n++) {
        const int ring_row = (y - STEP_Y(n) * step + (STEP_Y(n) > 0 ? p->ring * grid->z : 0)) % p->ring;
        ray_at[n] = (3 * n * p->ring + ring_row) * columns + (STEP_X(n) > 0 ? grid->z - step : STEP_X(n) < 0 ? step : 0);
        enters[n] = step == 0 || (STEP_Y(n) > 0 && y == 0) || (STEP_Y(n) < 0 && y == grid->y - 1);
    }
    for (int x = first_x; x < end_x; x += VW) {
        const size_t at = row + x;
        const realv depth = LOAD_CELLS(medium + at), slanted = 1.7320508f * depth;
        const realv absorbs = absorbed(depth), share = mean_transmittance(depth, absorbs);
        const realv slanted_absorbs = absorbed(slanted), slanted_share = mean_transmittance(slanted, slanted_absorbs);
        const intv from_below = LANES + x <= 0, from_above = LANES + x >= grid->x - 1;
        realv light[LIGHT_PLANES];
#pragma unroll
        for (int c = 0; c < 3; c++) {
            const realv emitted = LOAD_CELLS(source + c * plane + at);
            realv in_cell[ORDINATES];
#pragma unroll
            for (int n = 0; n < ORDINATES; n++) {
                __global float *ray = rays + ray_at[n] + c * of_color + x;
                const realv outside = (realv)(p->entering[3 * n + c]);
                realv radiance = outside;
                if (!enters[n]) {
                    radiance = LOAD_CELLS(ray);
                    if (STEP_X(n) != 0)
                        radiance = (STEP_X(n) > 0 ? from_below : from_above) ? outside : radiance;
                }
                const realv beyond = radiance - emitted;
                in_cell[n] = emitted + beyond * (n ? slanted_share : share);
                STORE_CELLS(radiance - beyond * (n ? slanted_absorbs : absorbs), ray);
            }
            const realv along_y = in_cell[1] + in_cell[2], against_y = in_cell[3] + in_cell[4];
            const realv axis = p->axis * in_cell[0], diagonals = p->diagonal * (along_y + against_y);
            if (!is_last) {
                __global float *cells = mean + c * held + in_mean + x;
                STORE_CELLS(LOAD_CELLS(cells) + (axis + diagonals), cells);
                continue;
            }
            const float slope = 0.57735027f * p->diagonal;
            light[c] = axis + diagonals;
            light[3 + c] = slope * ((in_cell[2] + in_cell[4]) - (in_cell[1] + in_cell[3]));
            light[6 + c] = slope * (against_y - along_y);
            light[9 + c] = (p->upwards ? -1.0f : 1.0f) * (axis + 0.57735027f * diagonals);
            if (!p->upwards) {
                light[c] += LOAD_CELLS(mean + c * held + in_mean + x);
                light[3 + c] += LOAD_CELLS(mean + (6 + c) * held + in_mean + x);
                light[6 + c] += LOAD_CELLS(mean + (3 + c) * held + in_mean + x);
            }
        }
        if (!is_last)
            continue;
        // Upward sweeps are the first.
        __global int *out = words + 4 * (size_t)x;
        // A constant where it is one, so that GPUs keep the words in registers.
        const int count = VW == 1 ? 1 : min(VW, grid->x - x);
        intv of_cells[4];
        if (!p->upwards) {
            load_words(out, count, of_cells);
            add_packed(of_cells, light);
        }
        pack_light(light, of_cells);
        store_words(of_cells, count, out);
    }
}

__kernel void scatter_layers(__global const float *medium, __global const float *source, __global float *mean, __global float *rays,
                             __global uchar *packed, ScatterLayersParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.items)
        return;
    const ScatterGrid *grid = &p.grid;
#if VW == 1
    const int block = id / grid->x, first_x = id % grid->x, end_x = first_x + 1;
#else
    const int block = id, first_x = 0, end_x = cell_pitch(grid);
#endif
    const int end = (block + 1) * p.rows;
    for (int n = 0; n < p.layers; n++) {
        const int from = p.between ? end - n : block ? block * p.rows + n : 0;
        const int to = p.between ? min(end + n, grid->y) : end >= grid->y ? grid->y : end - n;
        for (int y = from; y < to; y++)
            if (p.is_last)
                sweep_row(&p, true, p.first + n, y, first_x, end_x, medium, source, mean, rays, packed);
            else
                sweep_row(&p, false, p.first + n, y, first_x, end_x, medium, source, mean, rays, packed);
    }
}
