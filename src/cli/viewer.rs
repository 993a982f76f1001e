//! Renderer of a scene: resident, streamed or distributed.

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

/// Limits of device memory and frame time.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub(super) struct BoundOptions {
    /// Limit of device memory, e.g. 512M, 1.5G or 800MB; larger volumes are streamed (same picture) [default: all of it]
    #[arg(long, value_parser = parse::bytes, value_name = "BYTES", allow_hyphen_values = true)]
    pub memory: Option<u64>,
    /// Limit of device time per frame, checked between kernels; longer frames fail [default: none]
    #[arg(long, value_parser = parse::seconds, value_name = "SECONDS", allow_hyphen_values = true)]
    pub time_limit: Option<Duration>,
}

/// Renders a scene with this process, or with several.
pub(super) enum Viewer {
    Alone {
        renderer: Box<dyn VolumeRenderer<'static> + Send>,
        is_streamed: bool,
    },
    #[cfg(feature = "mpi")]
    Shared(Box<distributed::Renderer<'static>>),
}

impl Viewer {
    /// Creates the renderer. Streams the volume if `--memory` is given or the device has no buffer large enough.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let Scene { device, volume, transfer, time_limit, .. } = scene;
        #[cfg(feature = "mpi")]
        if let Some(team) = scene.processes.team() {
            let mut renderer = distributed::Renderer::new(team, device, volume, transfer)?;
            renderer.limit(*time_limit);
            return Ok(Self::Shared(Box::new(renderer)));
        }
        let mut renderer = volume_renderer(device, volume, transfer)?;
        renderer.limit(*time_limit);
        let is_streamed = renderer.whole().is_none();
        Ok(Self::Alone { renderer, is_streamed })
    }

    pub fn renderer(&mut self) -> &mut dyn VolumeRenderer<'static> {
        match self {
            Self::Alone { renderer, .. } => renderer.as_mut(),
            #[cfg(feature = "mpi")]
            Self::Shared(renderer) => renderer.as_mut(),
        }
    }

    /// Stream plan of a view, also printed to standard error. `None` if the view is not streamed.
    pub fn announce(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        match self {
            Self::Alone { renderer, is_streamed: true } => {
                let plan = renderer.stream_plan(camera, viewport, settings)?;
                match &plan {
                    Some(plan) => eprintln!("memory: {plan}"),
                    None => eprintln!("memory: this view needs the whole volume on the device, where it fits"),
                }
                Ok(plan)
            }
            _ => Ok(None),
        }
    }

    /// Whether the volume is streamed.
    pub fn is_streamed(&self) -> bool {
        matches!(self, Self::Alone { is_streamed: true, .. })
    }

    /// Report on the last picture, if several processes share the volume.
    #[cfg(feature = "mpi")]
    pub fn shared_report(&self) -> Option<&DistributedReport> {
        let Self::Shared(renderer) = self else { return None };
        renderer.last_report()
    }

    /// Depths of a view, along rays through the pixel centres.
    ///
    /// # Errors
    /// [`Error::Settings`] if the volume is streamed or shared, because rays need all of it.
    pub fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        let problem = match self {
            Self::Alone { renderer, is_streamed: false } => return renderer.depths(camera, viewport, settings),
            Self::Alone { .. } => "depths need the whole volume on the device: omit --memory or --depth",
            #[cfg(feature = "mpi")]
            Self::Shared(..) => "depths need the whole volume on one device: use --ranks-per-picture 1, or omit --depth",
        };
        Err(Error::Settings { field: "depth", problem: problem.into() })
    }
}
