// Cubic cells from blocks of voxels.
//
// One work-item per row of cells. `blocks`: planes of sums (scatter_medium.cl), of blocks_x * blocks_y * blocks_z blocks without space around
// them. A cell covers blocks_per_cell blocks along each axis, some of them in part; what lies outside all blocks is clear. If `refined`, of
// the medium the optical depth alone is stored, and the light that cells scatter with the mean radiance of a coarser grid, interpolated.

#include "light/scatter_grid.cl"

// The blocks, from `*first` to `*last`, that cell `n` covers along an axis, and the share that it covers of block i.
static inline void covered_blocks(int n, float per_cell, int count, int *first, int *last) {
    *first = (int)(n * per_cell);
    *last = min((int)ceil((n + 1) * per_cell), count) - 1;
}
static inline float covered_share(int n, float per_cell, int i) {
    return max(min((n + 1) * per_cell, i + 1.0f) - max(n * per_cell, (float)i), 0.0f);
}

// Columns of blocks that are summed together: on GPUs one, which registers hold, else all that VW cells cover. Cells are at most three blocks
// wide, unless the volume has one block along x.
#define COLUMNS (VW == 1 ? 1 : 4 * VW + 4)

// Adds blocks to the sums of cells x ... x + VW - 1. `columns`: sums over those of rows and layers, of the blocks from `first` on.
static inline void sum_columns(const ScatterCellsParams *p, const float *columns, int first, int count, int x, realv *sums) {
    const realv cells = CONVERT_REALV(LANES + x), from = cells * p->per_cell_x, to = (cells + 1.0f) * p->per_cell_x;
    for (intv i = MAX(CONVERT_INTV(from), (intv)(first));; i += 1) {
        const realv low = CONVERT_REALV(i);
        const realv covered = i < first + count ? MAX(MIN(to, low + 1.0f) - MAX(from, low), (realv)(0.0f)) : (realv)(0.0f);
        if (!ANY(covered > 0.0f))
            return;
        const intv at = COLUMNS == 1 ? (intv)(0) : MIN(i - first, (intv)(count - 1));
        const bool is_row = p->per_cell_x == 1.0f;
#pragma unroll
        for (int n = 0; n < MEDIUM_PLANES; n++)
            sums[n] += covered * (is_row ? LOADV(columns + n * COLUMNS) : GATHER(columns + n * COLUMNS, at));
    }
}

// Adds rows of blocks, times `share`, to the sums of columns.
static inline void add_row(__global const float *row, size_t plane, int count, float share, float *columns) {
    for (int n = 0; n < MEDIUM_PLANES; n++) {
        int i = 0;
        for (; i + VW <= count; i += VW)
            STOREV(columns + n * COLUMNS + i, LOADV(columns + n * COLUMNS + i) + share * LOAD_CELLS(row + n * plane + i));
        for (; i < count; i++)
            columns[n * COLUMNS + i] += share * row[n * plane + i];
    }
}

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

__kernel void scatter_cells(__global const float *blocks, __global float *medium, __global const float *coarser, __global float *source,
                            ScatterCellsParams p, ulong first_item) {
    const int id = first_item + get_global_id(0);
    const ScatterGrid *grid = &p.grid;
    if (id >= grid->y * grid->z)
        return;
    const size_t plane = plane_cells(grid), count = (size_t)p.blocks_x * p.blocks_y * p.blocks_z;
    const int y = id % grid->y, z = id / grid->y;
    int first_y, last_y, first_z, last_z;
    covered_blocks(y, p.per_cell_y, p.blocks_y, &first_y, &last_y);
    covered_blocks(z, p.per_cell_z, p.blocks_z, &first_z, &last_z);
    const float per_volume = p.edges / (p.per_cell_x * p.per_cell_y * p.per_cell_z);
    for (int x = 0; x < cell_pitch(grid); x += VW) {
        realv sums[MEDIUM_PLANES];
        for (int n = 0; n < MEDIUM_PLANES; n++)
            sums[n] = 0.0f;
        const int end_x = min((int)ceil((x + VW) * p.per_cell_x), p.blocks_x);
        for (int first = (int)(x * p.per_cell_x); first < end_x; first += COLUMNS) {
            float columns[MEDIUM_PLANES * COLUMNS] = {0.0f};
            const int blocks_x = COLUMNS == 1 ? 1 : end_x - first;
            for (int k = first_z; k <= last_z; k++)
                for (int j = first_y; j <= last_y; j++) {
                    const float share = covered_share(z, p.per_cell_z, k) * covered_share(y, p.per_cell_y, j);
                    if (share > 0.0f)
                        add_row(blocks + ((size_t)k * p.blocks_y + j) * p.blocks_x + first, count, blocks_x, share, columns);
                }
            sum_columns(&p, columns, first, blocks_x, x, sums);
        }
        const size_t at = cell_at(grid, x, y, z);
        const realv per_depth = sums[DEPTH] > 0.0f ? 1.0f / sums[DEPTH] : (realv)(0.0f);
        STORE_CELLS(sums[DEPTH] * per_volume, medium + at);
        if (!p.refined) {
            for (int n = 1; n < MEDIUM_PLANES; n++)
                STORE_CELLS(sums[n] * per_depth, medium + n * plane + at);
            continue;
        }
        const realv column = MAX((CONVERT_REALV(x + LANES) + 0.5f) * p.per_coarse - 0.5f, (realv)(0.0f));
        const float row = max((y + 0.5f) * p.per_coarse - 0.5f, 0.0f), layer = max((z + 0.5f) * p.per_coarse - 0.5f, 0.0f);
        for (int c = 0; c < 3; c++) {
            const realv own = between_cells(coarser + c * plane_cells(&p.coarser), &p.coarser, column, row, layer);
            const realv albedo = p.scattering * (sums[ALBEDO + c] * per_depth), direct = sums[DIRECT + c] * per_depth;
            STORE_CELLS(albedo * (own + direct), source + c * plane + at);
        }
    }
}
