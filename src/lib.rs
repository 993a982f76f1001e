//! Layered volume splatting on any OpenCL device, including plain CPUs.
//!
//! A [`Renderer`] holds a [`Volume`] and a [`TransferFunction`] on a [`Device`]. It renders a [`Camera`] with [`Settings`] to a
//! [`Frame`]:
//!
//! ```no_run
//! use layersplat::{Camera, Device, DeviceChoice, Projection, OpenOptions, Renderer, Settings, TransferFunction};
//! use layersplat::{Orbit, Viewport, Volume};
//!
//! # fn main() -> Result<(), layersplat::Error> {
//! let volume = Volume::open("builtin:hydrogen", &OpenOptions::default())?;
//! let transfer = TransferFunction::automatic(&volume);
//! let device = Device::open(&DeviceChoice::Default)?;
//! let mut renderer = Renderer::new(&device, &volume, &transfer)?;
//! let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
//! let projection = Projection::Parallel { scale: volume.grid().diagonal() / 2.0 };
//! let camera = Camera::orbit(volume.grid().centre(), 1.0, orbit, projection);
//! let (frame, _) = renderer.render(&camera, Viewport::new(512, 512)?, &Settings::default())?;
//! frame.save("hydrogen.png", None)?;
//! # Ok(())
//! # }
//! ```
//!
//! Vectors and matrices are types of [`glam`]; OpenCL contexts, queues and events are types of [`opencl3`]. Both crates are
//! re-exported.
//!
//! The default feature `cli` builds the `layersplat` command. Programs that use only the library disable it (`default-features =
//! false`). The undocumented modules `layers` and `reference` exist for this crate's tests and may change at any time.
//!
//! The method is that of Schlegel & Pajarola, *Layered Volume Splatting* (ISVC 2009). ARCHITECTURE.md in the repository describes
//! the modules.
#![warn(missing_docs)]

pub mod check;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod device;
#[cfg(feature = "mpi")]
pub mod distributed;
#[cfg(feature = "gl-interop")]
pub mod gl;
pub mod renderer;
#[cfg(any(feature = "cli", feature = "page"))]
mod shown;
#[cfg(feature = "page")]
#[doc(hidden)]
pub mod viewer;

#[cfg(any(feature = "cli", feature = "page"))]
use layersplat_host::files;
#[doc(inline)]
pub use layersplat_host::{annotation, camera, color, framing, image, settings, slice, surface, transfer, volume};
#[cfg(feature = "cli")]
use layersplat_host::{cache, numbers, panics, url};
use layersplat_host::{choice, error, memory, progress, viewport};
#[doc(hidden)]
pub use layersplat_host::{layers, reference};

pub use camera::{Basis, Camera, Orbit, Projection};
pub use choice::Choice;
pub use device::{Cancel, Device, DeviceChoice};
pub use framing::Framing;
pub use glam;
pub use image::{Background, Frame};
pub use layers::{Axis, Correction, Density, GradientEstimator, Kernel};
pub use layersplat_host::{Error, Viewport};
pub use opencl3;
pub use renderer::Renderer;
pub use settings::{Quality, Settings};
pub use transfer::TransferFunction;
pub use volume::{OpenOptions, Volume};

/// Builds the examples of docs/guide/embedding.md with the tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/embedding.md")]
struct Embedding;
