// Grids of cubic cells for scattered light: planes of floats, of which each row has at least VW cells of clear space on either side.

#include "shared/elementary.cl"

// Planes of the medium: optical depth along the edge of a cell, albedo, and the light of the lights that scatters, in red, green and blue.
#define DEPTH 0
#define ALBEDO 1
#define DIRECT 4
#define MEDIUM_PLANES 7

#if VW == 1
#define LOAD_CELLS(p) (*(p))
#define STORE_CELLS(x, p) (*(p) = (x))
#else
#define LOAD_CELLS(p) CAT(vload, VW)(0, p)
#define STORE_CELLS(x, p) CAT(vstore, VW)(x, 0, p)
#endif

static inline int cell_pitch(const ScatterGrid *grid) { return (grid->x + VW - 1) / VW * VW + 2 * VW; }

// Cells of a plane.
static inline size_t plane_cells(const ScatterGrid *grid) { return (size_t)cell_pitch(grid) * grid->y * grid->z; }

// The cell with these indices, in a plane.
static inline size_t cell_at(const ScatterGrid *grid, int x, int y, int z) {
    return ((size_t)z * grid->y + y) * cell_pitch(grid) + VW + x;
}
