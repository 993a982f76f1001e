// Columns of a lattice whose samples lie behind its rows, by some of a row each: src/layers/lattice/stagger.rs.

// By how many steps. `p`: parameters that tell it; `columns`: unsigned.
#define STAGGER_STEPS(p, columns) (((p)->first_stagger + (p)->stagger_per_column * (columns)) >> 8)
// Of a row: as many bits as a float tells apart.
#define STAGGER_STEP 0x1p-24f
