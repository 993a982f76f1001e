//! The same pictures in plain, slow `f64` on the host, independent of the kernels: what the tests trust.
//!
//! [`Layered`] evaluates layered splatting ray by ray from the definition: every footprint is integrated, no lattice, no
//! table, no culling, no early termination; [`Marched`] and [`Sheets`] do the same for the other renderers. Where a ray counts
//! is one interval for all, in all blend modes. [`Integral`] is the converged volume rendering integral of the field that
//! the kernels reconstruct, which layered splatting approximates, or of the function itself that voxels sample.

mod blending;
mod coefficients;
mod compositing;
mod field;
mod integral;
mod interval;
mod known;
mod layered;
mod march;
mod points;
mod shading;
mod sheets;

pub use integral::Integral;
pub use layered::Layered;
pub use march::Marched;
pub use sheets::Sheets;
