//! layersplat for C. `include/layersplat.h` is generated from this source.
//!
//! There is one file per kind of handle. All calls go through `boundary.rs`, which catches panics and stores the message for
//! `layersplat_last_error`.
#![warn(missing_docs)]
// The safety contract is the same for all functions: the header begins with it (cbindgen.toml).
#![allow(clippy::missing_safety_doc)]

mod boundary;
mod camera;
mod cancel;
mod channels;
mod choices;
mod colors;
mod device;
mod enqueued;
mod grid;
mod in_place;
mod labels;
mod opencl;
mod picture;
mod render;
mod renderer;
mod sequence;
mod settings;
mod slice;
mod status;
mod stream;
mod transfer;
mod volume;

pub use boundary::layersplat_last_error;
pub use camera::*;
pub use cancel::*;
pub use channels::*;
pub use choices::*;
pub use colors::*;
pub use device::*;
pub use enqueued::*;
pub use grid::*;
pub use in_place::*;
pub use labels::*;
pub use opencl::{_cl_command_queue, _cl_context, _cl_device_id, _cl_event, _cl_mem};
pub use picture::*;
pub use render::*;
pub use renderer::*;
pub use sequence::*;
pub use settings::*;
pub use slice::*;
pub use status::Status;
pub use stream::*;
pub use transfer::*;
pub use volume::*;
