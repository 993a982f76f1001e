//! Volumes that no single machine holds, and films that one is too slow for: processes that speak MPI, each with its own device.
//!
//! A volume is cut into ranges of layers along the axis of the view. Each rank composites its own, with the layers around them that
//! kernels and gradients need, and the picture is one reduction of (colour, transmittance) pairs on the lattice, before the warp: "over"
//! is associative, and not commutative, which MPI keeps. See docs/scale.md.

mod compose;
mod cut;
mod exchange;
mod group;
mod over;
mod renderer;
mod report;
mod volume;
mod work;

pub use crate::error::DistributedError;
pub use compose::Composed;
pub use exchange::Exchanged;
pub use group::Group;
pub use mpi;
pub use renderer::Renderer;
pub use report::{DistributedReport, RankReport};
pub use volume::{Brick, bytes_in_parts};
