//! Every kernel that layers and rays can be sampled with: as the f64 reference has it, nearer to its own integral with every sample, and
//! how near each comes to what the voxels are samples of: the tables in docs/kernels.md.

#[path = "../common/mod.rs"]
mod common;
mod convergence;
mod device;
mod fidelity;
mod scene;
