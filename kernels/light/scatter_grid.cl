// Grids of cubic cells for scattered light: planes of floats, whose rows are filled up with clear cells to a multiple of VW.

#include "shared/elementary.cl"

// Planes of the medium: optical depth along the edge of a cell, albedo, and the light of the lights that scatters, in red, green and blue.
#define DEPTH 0
#define ALBEDO 1
#define DIRECT 4
#define MEDIUM_PLANES 7

// Cells in vectors: through a typedef, since vloadn and vstoren are divided on PoCL.
typedef realv_unaligned Cells;
#define LOAD_CELLS(p) (*(__global const Cells *)(p))
#define STORE_CELLS(x, p) (*(__global Cells *)(p) = (x))

static inline int cell_pitch(const ScatterGrid *grid) { return (grid->x + VW - 1) / VW * VW; }

// Cells of a plane.
static inline size_t plane_cells(const ScatterGrid *grid) { return (size_t)cell_pitch(grid) * grid->y * grid->z; }

// The cell with these indices, in a plane.
static inline size_t cell_at(const ScatterGrid *grid, int x, int y, int z) {
    return ((size_t)z * grid->y + y) * cell_pitch(grid) + x;
}

// The mean transmittance from an end of a cell to a point in it, which is `absorbs` = 1 - e^-depth over the depth.
static inline realv mean_transmittance(realv depth, realv absorbs) {
    return depth > 0.02f ? absorbs / depth : 1.0f - depth * (0.5f - depth * (1.0f / 6.0f));
}
