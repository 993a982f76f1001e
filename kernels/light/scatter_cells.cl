// Cubic cells from blocks of voxels.
//
// One work-item per row of cells. `blocks`: planes of sums (scatter_medium.cl), of blocks_x * blocks_y * blocks_z blocks without space around
// them. A cell covers blocks_per_cell blocks along each axis, some of them in part; what lies outside all blocks is clear.

#include "light/scatter_grid.cl"

// The blocks, from `*first` to `*last`, that cell `n` covers along an axis, and the share that it covers of block i.
static inline void covered_blocks(int n, float per_cell, int count, int *first, int *last) {
    *first = (int)(n * per_cell);
    *last = min((int)ceil((n + 1) * per_cell), count) - 1;
}
static inline float covered_share(int n, float per_cell, int i) {
    return max(min((n + 1) * per_cell, i + 1.0f) - max(n * per_cell, (float)i), 0.0f);
}

__kernel void scatter_cells(__global const float *blocks, __global float *medium, ScatterCellsParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    const ScatterGrid *grid = &p.grid;
    if (id >= grid->y * grid->z)
        return;
    const size_t plane = plane_cells(grid), count = (size_t)p.blocks_x * p.blocks_y * p.blocks_z;
    const int y = id % grid->y, z = id / grid->y;
    int first[3], last[3];
    covered_blocks(y, p.per_cell_y, p.blocks_y, first + 1, last + 1);
    covered_blocks(z, p.per_cell_z, p.blocks_z, first + 2, last + 2);
    const float volume = p.per_cell_x * p.per_cell_y * p.per_cell_z;
    for (int x = 0; x < cell_pitch(grid); x++) {
        float sums[MEDIUM_PLANES] = {0.0f};
        if (x < grid->x) {
            covered_blocks(x, p.per_cell_x, p.blocks_x, first, last);
            for (int k = first[2]; k <= last[2]; k++)
                for (int j = first[1]; j <= last[1]; j++) {
                    const float share = covered_share(z, p.per_cell_z, k) * covered_share(y, p.per_cell_y, j);
                    __global const float *row = blocks + ((size_t)k * p.blocks_y + j) * p.blocks_x;
                    for (int i = first[0]; i <= last[0]; i++) {
                        const float weight = share * covered_share(x, p.per_cell_x, i);
                        for (int n = 0; n < MEDIUM_PLANES; n++)
                            sums[n] += weight * row[n * count + i];
                    }
                }
        }
        const size_t at = cell_at(grid, x, y, z);
        const float per_depth = sums[DEPTH] > 0.0f ? 1.0f / sums[DEPTH] : 0.0f;
        medium[at] = sums[DEPTH] / volume * p.edges;
        for (int n = 1; n < MEDIUM_PLANES; n++)
            medium[n * plane + at] = sums[n] * per_depth;
    }
}
