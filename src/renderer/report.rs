//! Frame reports.

#[cfg(feature = "mpi")]
use super::distributed_report::DistributedReport;
use super::plan::Plan;
use crate::device::StageTimes;
use crate::layers::Lattice;
use serde::Serialize;

/// Frame report.
///
/// ```
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let (_, report) = Renderer::new(&device, &volume, &transfer)?.render(&camera, viewport, &Settings::default())?;
/// assert!(report.lattice.is_some() && report.measured.is_none());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FrameReport {
    /// The lattice; `None` if the frame was rendered without one. If several layer axes contribute to the frame, this is the
    /// lattice of the most parallel one.
    pub lattice: Option<LatticeReport>,
    /// Frame statistics, if enabled by [`super::Renderer::measure`].
    pub measured: Option<Measured>,
    /// Whether a more general program rendered the frame because the specialised one is not built yet; see
    /// [`super::Renderer::use_general_programs`].
    pub general_program: bool,
    /// Statistics of the processes, if several rendered the frame.
    #[cfg(feature = "mpi")]
    pub processes: Option<DistributedReport>,
}

/// Frame statistics.
///
/// ```
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let mut renderer = Renderer::new(&device, &volume, &transfer)?;
/// renderer.measure(true);
/// let (_, report) = renderer.render(&camera, viewport, &Settings::default())?;
/// for (stage, milliseconds) in report.measured.expect("asked for").stages {
///     println!("{stage}: {milliseconds} ms");
/// }
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Measured {
    /// Milliseconds per stage. If several processes render the frame: those of this process.
    pub stages: StageTimes,
    /// Number of composited samples with an opacity above 0. If several processes render the frame: those of all.
    pub active_samples: u64,
}

#[cfg(feature = "mpi")]
impl Measured {
    /// Adds the times of further kernels.
    pub(crate) fn add_stages(&mut self, stages: StageTimes) {
        for (stage, ms) in stages {
            match self.stages.iter_mut().find(|(name, _)| *name == stage) {
                Some((_, total)) => *total += ms,
                None => self.stages.push((stage, ms)),
            }
        }
    }
}

/// The lattice of a frame.
///
/// ```
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let (_, report) = Renderer::new(&device, &volume, &transfer)?.render(&camera, viewport, &Settings::default())?;
/// let lattice = report.lattice.expect("layers on one lattice");
/// println!("{} x {} samples", lattice.width, lattice.height);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LatticeReport {
    /// Samples per voxel along u and v; in a perspective projection, those in the nearest layer.
    pub samples_per_voxel: [f64; 2],
    /// Number of samples along u.
    pub width: u32,
    /// Number of samples along v.
    pub height: u32,
}

/// The part of a report that does not depend on the plan.
#[derive(Default)]
pub(super) struct Statistics {
    pub measured: Option<Measured>,
    pub general_program: bool,
}

impl FrameReport {
    pub(super) fn new(plan: &Plan, Statistics { measured, general_program }: Statistics) -> Self {
        let lattice = match plan {
            Plan::Lattice(lattice, _) => Some(lattice),
            Plan::Shared(parts, _) => Some(&parts[0].0),
            _ => None,
        };
        Self {
            lattice: lattice.map(LatticeReport::new),
            measured,
            general_program,
            #[cfg(feature = "mpi")]
            processes: None,
        }
    }
}

impl LatticeReport {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let [width, height] = lattice.size;
        Self { samples_per_voxel: lattice.samples_per_voxel, width, height }
    }
}
