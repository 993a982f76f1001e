//! What layersplat does on the host, without OpenCL: volumes and their formats, transfer functions, the mathematics of layers, settings, slices,
//! pictures, and the f64 reference. The crate `layersplat` re-exports all that users need; use that one.
#![warn(missing_docs)]

pub mod annotation;
#[doc(hidden)]
pub mod cache;
pub mod camera;
#[doc(hidden)]
pub mod choice;
pub mod color;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod files;
pub mod framing;
pub mod image;
#[doc(hidden)]
pub mod layers;
#[doc(hidden)]
pub mod memory;
#[doc(hidden)]
pub mod npy;
#[doc(hidden)]
pub mod numbers;
#[doc(hidden)]
pub mod panics;
#[doc(hidden)]
pub mod progress;
#[doc(hidden)]
pub mod reference;
pub mod settings;
pub mod slice;
pub mod surface;
pub mod transfer;
#[doc(hidden)]
pub mod url;
#[doc(hidden)]
pub mod viewport;
pub mod volume;

pub use camera::{Basis, Camera, Orbit, Projection};
pub use choice::Choice;
pub use error::Error;
pub use framing::Framing;
pub use glam;
pub use image::{Background, Frame};
pub use layers::{Axis, Correction, Density, GradientEstimator, Kernel};
pub use settings::{Quality, Settings};
pub use transfer::TransferFunction;
pub use viewport::Viewport;
pub use volume::{OpenOptions, Volume};
