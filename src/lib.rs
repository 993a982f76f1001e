//! Layered volume splatting on any OpenCL device, a plain CPU included.
//!
//! A [`Volume`] and a [`TransferFunction`] go to a [`Renderer`] on a [`Device`]; a [`Camera`] and [`Settings`] make a
//! [`Frame`]:
//!
//! ```no_run
//! use layersplat::{Camera, Device, DeviceChoice, Projection, RawOptions, Renderer, Settings, TransferFunction};
//! use layersplat::{Orbit, Viewport, Volume};
//!
//! # fn main() -> Result<(), layersplat::Error> {
//! let volume = Volume::open("builtin:hydrogen", &RawOptions::default())?;
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
//! The method is that of Schlegel & Pajarola, *Layered Volume Splatting* (ISVC 2009). ARCHITECTURE.md in the repository
//! says which module does what.
#![warn(missing_docs)]

mod camera;
pub mod cli;
pub mod device;
mod error;
pub mod framing;
pub mod image;
pub mod layers;
pub mod reference;
pub mod renderer;
pub mod transfer;
pub mod volume;

pub use camera::{Basis, Camera, Orbit, Projection};
pub use device::{Device, DeviceChoice};
pub use error::Error;
pub use framing::Framing;
pub use image::{Background, Frame};
pub use layers::Viewport;
pub use renderer::{Quality, Renderer, Settings};
pub use transfer::TransferFunction;
pub use volume::{RawOptions, Volume};
