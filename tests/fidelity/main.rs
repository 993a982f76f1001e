//! How close pictures are to the converged integral, and lattices to their own samples.

#[path = "../common/mod.rs"]
mod common;
mod generated;
mod kernels;
mod lattice_samples;
mod lattice_vs_direct;
mod lit;
mod presets;
mod steep_opacities;
mod studio;
mod surfaces;
