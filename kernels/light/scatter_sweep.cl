// Radiance along an ordinate and along the opposite one, swept through cubic cells. Its mean in each cell is added, times the weight of the
// ordinate, to the mean radiance of the cell and, with FLUX, to the flux, whose planes follow.
//
// One work-item per row of VW rays, which crosses the layers of an axis, or the cells of rows (ALONG_X). Ordinates join the middles of
// neighbouring cells, so each ray stays in cells. In a cell the extinction and the source are constant.

#include "light/scatter_grid.cl"

// Where the rays of a work-item are.
typedef struct {
    size_t first;      // cell of the first ray in the first layer, of those in which a ray is inside
    long step;         // from layer to layer
    int layers;
    intv inside;       // ALONG_X: rays; others leave the grid through clear space
} Rays;

#ifdef ALONG_X
static inline realv load_rays(__global const float *cells, int pitch, intv inside) {
    const intv at = (inside ? LANES : (intv)(0)) * pitch;
    return GATHER(cells, at);
}
static inline void add_rays(__global float *cells, int pitch, intv inside, realv x) {
#if VW == 1
    *cells += x;
#else
    const float *lanes = (const float *)&x;
    const int *is_inside = (const int *)&inside;
    for (int i = 0; i < VW; i++)
        if (is_inside[i])
            cells[(size_t)i * pitch] += lanes[i];
#endif
}
#else
#define load_rays(cells, pitch, inside) LOAD_CELLS(cells)
#define add_rays(cells, pitch, inside, x) STORE_CELLS(LOAD_CELLS(cells) + (x), cells)
#endif

// 1 - e^-x and its quotient by x, for x >= 0.
static inline realv mean_transmittance(realv x, realv absorbs) {
    return x > 0.02f ? absorbs / x : 1.0f - x * (0.5f - x * (1.0f / 6.0f));
}

// Sweeps radiance, from `radiance` outside the grid, along rays. `toward`: unit vector against the light, times its weight.
static inline void sweep(const ScatterSweepParams *p, const Rays *rays, const float *outside, float sign, __global const float *medium,
                         __global const float *source, __global float *mean) {
    const size_t plane = plane_cells(&p->grid);
    const int pitch = cell_pitch(&p->grid);
    realv radiance[3];
    for (int c = 0; c < 3; c++)
        radiance[c] = outside[c];
    size_t at = sign > 0.0f ? rays->first : rays->first + (rays->layers - 1) * rays->step;
    const long step = sign > 0.0f ? rays->step : -rays->step;
    for (int k = 0; k < rays->layers; k++, at += step) {
        const realv depth = load_rays(medium + at, pitch, rays->inside) * p->length;
        const realv absorbs = absorbed(depth), share = mean_transmittance(depth, absorbs);
        for (int c = 0; c < 3; c++) {
            const realv emitted = load_rays(source + c * plane + at, pitch, rays->inside);
            const realv beyond = radiance[c] - emitted, in_cell = emitted + beyond * share;
            radiance[c] -= beyond * absorbs;
            add_rays(mean + c * plane + at, pitch, rays->inside, p->weight * in_cell);
#ifdef FLUX
            for (int i = 0; i < 3; i++)
                if (p->toward[i] != 0.0f)
                    add_rays(mean + (3 + 3 * i + c) * plane + at, pitch, rays->inside, sign * p->toward[i] * in_cell);
#endif
        }
    }
}

#ifndef ALONG_X
// The layers, from `*first` to `*last`, in which a row of cells that moves by `shift` per layer from `at` meets `from` to `to`.
static inline void clip_layers(int at, int shift, int from, int to, int *first, int *last) {
    if (shift > 0)
        *first = max(*first, from - at), *last = min(*last, to - at);
    else if (shift < 0)
        *first = max(*first, at - to), *last = min(*last, at - from);
}
#endif

__kernel void scatter_sweep(__global const float *medium, __global const float *source, __global float *mean, ScatterSweepParams p,
                            ulong first_item) {
    const int id = first_item + get_global_id(0);
    if (id >= p.items)
        return;
    const ScatterGrid *grid = &p.grid;
    Rays rays;
#ifdef ALONG_X
    const int groups = (grid->y + VW - 1) / VW, y = id % groups * VW;
    rays.first = cell_at(grid, 0, y, id / groups), rays.step = 1, rays.layers = grid->x;
    rays.inside = y + LANES < grid->y;
#else
    // Layers along z have rows along y, those along y have rows along z.
    const bool along_y = p.step_z == 0;
    const int layers = along_y ? grid->y : grid->z, rows = along_y ? grid->z : grid->y, shift = along_y ? 0 : p.step_y;
    const int columns = (grid->x + abs(p.step_x) * (layers - 1) + VW - 1) / VW;
    const int x = id % columns * VW - (p.step_x > 0 ? layers - 1 : 0), row = id / columns - (shift > 0 ? layers - 1 : 0);
    int first = 0, last = layers - 1;
    clip_layers(row, shift, 0, rows - 1, &first, &last);
    clip_layers(x, p.step_x, 1 - VW, grid->x - 1, &first, &last);
    if (first > last)
        return;
    const long to_row = along_y ? (long)cell_pitch(grid) * grid->y : cell_pitch(grid);
    const long to_layer = along_y ? cell_pitch(grid) : (long)cell_pitch(grid) * grid->y;
    rays.step = to_layer + shift * to_row + p.step_x;
    rays.first = (size_t)((long)cell_at(grid, 0, 0, 0) + x + row * to_row + first * rays.step);
    rays.layers = last - first + 1;
    rays.inside = LANES >= 0;
#endif
    sweep(&p, &rays, p.forward, 1.0f, medium, source, mean);
    sweep(&p, &rays, p.backward, -1.0f, medium, source, mean);
}
