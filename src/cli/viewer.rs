//! What renders a scene: with all of its volume on the device, or part by part.

use super::parse;
use super::scene::Scene;
use crate::camera::Camera;
#[cfg(feature = "mpi")]
use crate::distributed::{self, DistributedReport};
use crate::error::Error;
use crate::image::Depths;
use crate::renderer::{StreamPlan, VolumeRenderer, volume_renderer};
use crate::settings::Settings;
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

/// What renders a scene: this process, or several.
pub(super) enum Viewer {
    Alone {
        renderer: Box<dyn VolumeRenderer<'static> + Send>,
        is_streamed: bool,
    },
    #[cfg(feature = "mpi")]
    Shared(Box<distributed::Renderer<'static>>),
}

impl Viewer {
    /// Streams where memory is bounded, and what the device has no single buffer for.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let Scene { device, volume, transfer, longest, .. } = scene;
        #[cfg(feature = "mpi")]
        if let Some(team) = scene.processes.team() {
            let mut renderer = distributed::Renderer::new(team, device, volume, transfer)?;
            renderer.limit(*longest);
            return Ok(Self::Shared(Box::new(renderer)));
        }
        let mut renderer = volume_renderer(device, volume, transfer)?;
        renderer.limit(*longest);
        let is_streamed = renderer.whole().is_none();
        Ok(Self::Alone { renderer, is_streamed })
    }

    /// The renderer.
    pub fn renderer(&mut self) -> &mut dyn VolumeRenderer<'static> {
        match self {
            Self::Alone { renderer, .. } => renderer.as_mut(),
            #[cfg(feature = "mpi")]
            Self::Shared(renderer) => renderer.as_mut(),
        }
    }

    /// How a view will be streamed, also said on standard error; `None` where it will not.
    pub fn announce(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        match self {
            Self::Alone { renderer, is_streamed: true } => {
                let plan = renderer.stream_plan(camera, viewport, settings)?;
                match &plan {
                    Some(plan) => eprintln!("memory: {plan}"),
                    None => eprintln!("memory: this view needs the whole volume on the device, and that fits"),
                }
                Ok(plan)
            }
            _ => Ok(None),
        }
    }

    /// Whether a volume that does not fit is streamed.
    pub fn is_streamed(&self) -> bool {
        matches!(self, Self::Alone { is_streamed: true, .. })
    }

    /// What processes did for the last picture, if several share the volume.
    #[cfg(feature = "mpi")]
    pub fn shared_report(&self) -> Option<&DistributedReport> {
        let Self::Shared(renderer) = self else { return None };
        renderer.last_report()
    }

    /// # Errors
    /// Where the volume is streamed or shared: rays need all of it.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        let problem = match self {
            Self::Alone { renderer, is_streamed: false } => return renderer.depths(camera, viewport, settings),
            Self::Alone { .. } => "depths need the whole volume on the device: leave --memory or --depth out",
            #[cfg(feature = "mpi")]
            Self::Shared(..) => "depths need the whole volume on one device: choose --ranks-per-picture 1, or leave --depth out",
        };
        Err(Error::Settings { field: "depth", problem: problem.into() })
    }
}
