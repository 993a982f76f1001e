//! The same pictures in plain, slow `f64` on the host, independent of the kernels: what the tests trust.
//!
//! [`Layered`] evaluates layered splatting ray by ray from the definition: every footprint is integrated, no lattice, no
//! table, no culling, no early termination. [`Integral`] is the converged volume rendering integral of the field that
//! the kernels reconstruct, which layered splatting approximates.

mod compositing;
mod field;
mod integral;
mod layered;
mod march;
mod points;
mod shading;
mod sheets;

pub use integral::Integral;
pub use layered::Layered;
pub use march::Marched;
pub use sheets::Sheets;
