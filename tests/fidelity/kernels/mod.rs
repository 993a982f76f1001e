//! All kernels for layers and rays: agreement with the f64 reference, convergence to their own integral, and fidelity to the sampled
//! signal (the tables in docs/dev/kernels.md).

mod convergence;
mod device;
mod fidelity;
mod gradients;
mod scene;
