//! Reference renderers in plain `f64` on the host, independent of the kernels, for tests.
//!
//! [`Layered`] evaluates layered splatting ray by ray from its definition, with exact footprints and without lattice, table, culling and
//! early ray termination. [`Marched`] and [`Sheets`] do the same for the other algorithms, and [`Slices`] for planes. All of them clip rays to a single interval.
//! [`Integral`] is the converged volume rendering integral of the reconstructed field, which layered splatting approximates, or of the
//! analytic function that the voxels sample; [`Sum`] is that of several fields, [`Colors`] that of
//! volumes of colours, and [`Labels`] that of labels.

mod blending;
mod channels;
mod coefficients;
mod colors;
mod compositing;
mod depth_cue;
mod field;
mod integral;
mod interval;
mod known;
mod label_colors;
mod labels;
mod layered;
mod march;
mod path_tracer;
mod points;
mod shading;
mod shadow_rays;
#[cfg(feature = "paper")]
mod sheets;
mod slices;
mod smoothing;
mod surfaces;
mod taps;

pub use channels::Sum;
pub use colors::Colors;
pub use integral::Integral;
pub use labels::Labels;
pub use layered::Layered;
pub use march::Marched;
pub use path_tracer::{PathTracer, against_halves};
#[cfg(feature = "paper")]
pub use sheets::Sheets;
pub use slices::Slices;
