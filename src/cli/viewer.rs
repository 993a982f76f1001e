//! What renders a scene: with all of its volume on the device, or part by part.

use super::parse;
use super::scene::Scene;
use crate::camera::Camera;
#[cfg(feature = "mpi")]
use crate::distributed::{self, DistributedReport};
use crate::error::Error;
use crate::image::{Background, Depths, Frame};
use crate::renderer::{FrameReport, Renderer, StreamPlan, StreamedRenderer};
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use clap::Args;
use std::time::Duration;

/// How much of the device, and for how long.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub(super) struct BoundOptions {
    /// Bytes that buffers on the device may take together, as 900000, 512M (or MiB), 1.5G, 800MB: larger volumes are streamed, to the
    /// same picture; first_ms counts from their opening then [default: the device's own]
    #[arg(long, value_parser = parse::bytes, value_name = "BYTES", allow_hyphen_values = true)]
    pub memory: Option<u64>,
    /// Seconds that a picture may take on the device, which is looked at between its kernels; a longer one is given up [default: no limit]
    #[arg(long, value_parser = parse::seconds, value_name = "SECONDS", allow_hyphen_values = true)]
    pub time_limit: Option<Duration>,
}

/// A renderer of either kind.
pub(super) enum Viewer {
    Whole(Box<Renderer>),
    Streamed(Box<StreamedRenderer<'static>>),
    /// With other processes, and what they last did.
    #[cfg(feature = "mpi")]
    Shared(Box<distributed::Renderer<'static>>, Option<DistributedReport>),
}

impl Viewer {
    /// Streams where memory is bounded, and what the device has no single buffer for.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let Scene { device, volume, transfer, longest, .. } = scene;
        #[cfg(feature = "mpi")]
        if let Some(team) = scene.processes.team() {
            let mut renderer = distributed::Renderer::new(team, device, volume, transfer)?;
            renderer.limit(*longest);
            return Ok(Self::Shared(Box::new(renderer), None));
        }
        let bytes = volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
        if device.memory_budget().is_some() || bytes > device.largest_buffer_bytes() {
            let mut renderer = StreamedRenderer::new(device, volume, transfer);
            renderer.limit(*longest);
            return Ok(Self::Streamed(Box::new(renderer)));
        }
        let mut renderer = Renderer::new(device, volume, transfer)?;
        renderer.limit(*longest);
        Ok(Self::Whole(Box::new(renderer)))
    }

    /// How a view will be streamed, also told on standard error; `None` where it will not.
    pub fn announce(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        let Self::Streamed(renderer) = self else { return Ok(None) };
        let plan = renderer.plan(camera, viewport, settings)?;
        match &plan {
            Some(plan) => eprintln!("memory: {plan}"),
            None => eprintln!("memory: this view needs the whole volume on the device, and that fits"),
        }
        Ok(plan)
    }

    /// Whether what does not fit is streamed.
    pub fn is_streamed(&self) -> bool {
        matches!(self, Self::Streamed(_))
    }

    pub fn measure(&mut self, measuring: bool) {
        match self {
            Self::Whole(renderer) => renderer.measure(measuring),
            Self::Streamed(renderer) => renderer.measure(measuring),
            #[cfg(feature = "mpi")]
            Self::Shared(..) => {}
        }
    }

    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        match self {
            Self::Whole(renderer) => renderer.set_transfer_function(transfer),
            Self::Streamed(renderer) => renderer.set_transfer_function(transfer),
            #[cfg(feature = "mpi")]
            Self::Shared(renderer, _) => renderer.set_transfer_function(transfer),
        }
    }

    /// A picture; of those that processes share, one of these has it.
    pub fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let (frame, report) = match self {
            Self::Whole(renderer) => renderer.render(camera, viewport, settings)?,
            Self::Streamed(renderer) => renderer.render(camera, viewport, settings)?,
            #[cfg(feature = "mpi")]
            Self::Shared(renderer, last) => {
                let (frame, report) = renderer.render(camera, viewport, settings)?;
                let told = FrameReport { lattice: Some(report.lattice), measured: None, general_program: false };
                *last = Some(report);
                return Ok((frame, told));
            }
        };
        Ok((Some(frame), report))
    }

    /// What processes did for the last picture, if several share the volume.
    #[cfg(feature = "mpi")]
    pub fn shared_report(&self) -> Option<&DistributedReport> {
        let Self::Shared(_, last) = self else { return None };
        last.as_ref()
    }

    /// # Errors
    /// Where the volume is streamed or shared: rays need all of it.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        match self {
            Self::Whole(renderer) => renderer.depths(camera, viewport, settings),
            Self::Streamed(_) => {
                let problem = "depths need the whole volume on the device: leave --memory or --depth out".into();
                Err(Error::Settings { field: "depth", problem })
            }
            #[cfg(feature = "mpi")]
            Self::Shared(..) => {
                let problem =
                    "depths need the whole volume on one device: choose --ranks-per-picture 1, or leave --depth out".into();
                Err(Error::Settings { field: "depth", problem })
            }
        }
    }

    pub fn render_rgba8(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<(Option<Vec<u8>>, FrameReport), Error> {
        if let Self::Whole(renderer) = self {
            let (picture, report) = renderer.render_rgba8(camera, viewport, settings, background)?;
            return Ok((Some(picture), report));
        }
        let (frame, report) = self.render(camera, viewport, settings)?;
        Ok((frame.map(|frame| frame.to_rgba8(background)), report))
    }
}
