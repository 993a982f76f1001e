// Staggered columns: samples shifted from their rows by a fraction of a row, src/host/layers/lattice/stagger.rs.

// Shift in steps. `p`: parameters with the stagger; `columns`: unsigned.
#define STAGGER_STEPS(p, columns) (((p)->first_stagger + (p)->stagger_per_column * (columns)) >> 8)
// One step, as a fraction of a row: the resolution of a float.
#define STAGGER_STEP 0x1p-24f
