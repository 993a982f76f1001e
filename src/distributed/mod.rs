//! Distributed rendering with MPI, for volumes and films that are too large for one machine. Each process has its own device.
//!
//! A volume is partitioned into ranges of layers along the layer axis of the view. Each rank composites its range, with the ghost
//! layers that kernels and gradients need. A single reduction of (colour, transmittance) pairs on the lattice yields the picture,
//! before the warp. The "over" operator is associative but not commutative; MPI keeps the order of the ranks. See docs/dev/scale.md.
//!
//! ```no_run
//! use layersplat::distributed::mpi::{self, Threading, traits::*};
//! use layersplat::distributed::{Group, Renderer};
//! use layersplat::{Camera, Device, DeviceChoice, OpenOptions, Orbit, Settings, TransferFunction, Viewport};
//!
//! let (universe, _) = mpi::initialize_with_threading(Threading::Serialized).expect("MPI is not initialised yet");
//! let group = Group::new(&universe.world())?;
//! let (volume, _) = group.open("big.nrrd", &OpenOptions::default())?;
//! // Collective, like the statistics of the volume.
//! let transfer = TransferFunction::automatic(&volume);
//! let mut renderer = Renderer::new(&group, &Device::open(&DeviceChoice::Default)?, &volume, &transfer)?;
//! let viewport = Viewport::new(1024, 1024)?;
//! let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
//! let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
//! let (frame, _) = renderer.render(&camera, viewport, &Settings::default())?;
//! if let Some(frame) = frame {
//!     frame.save("big.png", None)?; // on rank 0
//! }
//! # Ok::<(), layersplat::Error>(())
//! ```

mod compose;
mod exchange;
mod group;
mod over;
mod partition;
mod renderer;
mod report;
mod volume;
mod work;

pub use crate::error::DistributedError;
pub use crate::renderer::{Composed, DistributedReport, Exchanged, RankMeasured, RankReport};
pub use group::Group;
pub use mpi;
pub use renderer::Renderer;
#[cfg(feature = "cli")]
pub(crate) use renderer::check_view;
pub use volume::Brick;
#[cfg(feature = "cli")]
pub(crate) use volume::bytes_in_parts;
