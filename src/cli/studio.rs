//! Where finished pictures are made: rendered, averaged, annotated.

use super::notice;
use super::options::{CameraOptions, Fit};
use super::parse;
use super::progress;
use super::scene::{Cameras, Scene};
use super::viewer::Viewer;
use crate::annotation::{Annotations, Shown};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::{Background, Depths, Frame};
use crate::renderer::{FrameReport, StreamPlan};
use crate::viewport::Viewport;
use clap::Args;

/// What is done to pictures beyond rendering them.
#[derive(Args)]
#[command(next_help_heading = "Camera and picture")]
pub(super) struct PictureOptions {
    /// Supersampling: the mean of N×N rays per pixel, 1 to 16
    #[arg(long, default_value_t = 1, value_parser = parse::samples, value_name = "N", allow_hyphen_values = true)]
    pub samples: u32,
    /// Draw a colour bar with the transfer function's opacities beside it, and a scale bar where the projection is parallel
    #[arg(long)]
    pub legend: bool,
    /// Draw the box around the voxels, back edges behind the volume, front edges before it, and fit it unless --fit says otherwise
    #[arg(long = "box")]
    pub bounding_box: bool,
    /// Draw the world's axes in the lower left corner
    #[arg(long)]
    pub axes: bool,
    /// What data values are in, for the colour bar
    #[arg(long, value_name = "TEXT", requires = "legend")]
    pub units: Option<String>,
    /// What world units are, for the scale bar
    #[arg(long, value_name = "TEXT", requires = "legend")]
    pub length_units: Option<String>,
}

/// Renders the pictures of a scene.
pub(super) struct Studio<'a> {
    scene: &'a Scene,
    options: &'a PictureOptions,
    background: Background,
    annotations: Annotations,
    viewer: Viewer,
    /// Whether it was said what is wrong with pictures, if anything is.
    looked: bool,
}

impl<'a> Studio<'a> {
    /// Its pictures will stand on a `background`, or on black where there is none.
    pub fn new(scene: &'a Scene, options: &'a PictureOptions, background: Option<Background>) -> Result<Self, Error> {
        let background = background.unwrap_or(Background::BLACK);
        Ok(Self { scene, options, background, annotations: options.annotations(), viewer: Viewer::new(scene)?, looked: false })
    }

    /// Draws a legend from the next picture on, or none.
    pub fn set_legend(&mut self, legend: bool) {
        self.annotations.legend = legend;
    }

    /// How a view will be streamed, also told on standard error; `None` where it will not.
    pub fn announce(&self, camera: &Camera, size: Viewport) -> Result<Option<StreamPlan>, Error> {
        self.viewer.announce(camera, self.options.rendered(size)?, &self.scene.settings)
    }

    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    pub fn is_streamed(&self) -> bool {
        self.viewer.is_streamed()
    }

    /// What renders its pictures.
    #[cfg(feature = "mpi")]
    pub fn viewer(&self) -> &Viewer {
        &self.viewer
    }

    pub fn measure(&mut self, measuring: bool) {
        self.viewer.renderer().measure(measuring);
    }

    /// A finished picture, without a background. If the first one shows nothing, that is explained on standard error. Of those that
    /// processes share, one of these has it.
    pub fn picture(&mut self, camera: &Camera, size: Viewport) -> Result<(Option<Frame>, FrameReport), Error> {
        let rendered = self.options.rendered(size)?;
        let (frame, report) = {
            let Self { viewer, scene, .. } = self;
            progress::tell_compiling(|| viewer.renderer().render(camera, rendered, &scene.settings))?
        };
        let Some(frame) = frame else { return Ok((None, report)) };
        if !std::mem::replace(&mut self.looked, true)
            && let Some(notice) = notice::of_picture(&frame, camera, self.scene)
        {
            eprintln!("layersplat: {notice}");
        }
        let frame = if self.options.samples > 1 { frame.averaged(self.options.samples)? } else { frame };
        let Scene { volume, transfer, settings, .. } = self.scene;
        let shown = Shown { camera, grid: volume.grid(), transfer, blend: settings.blend, background: self.background };
        Ok((Some(self.annotations.drawn(frame, shown)?), report))
    }

    /// How far away is what a picture shows, through the centres of its pixels.
    pub fn depths(&mut self, camera: &Camera, size: Viewport) -> Result<Depths, Error> {
        self.viewer.depths(camera, size, &self.scene.settings)
    }
}

impl PictureOptions {
    /// Cameras that fit what is visible, and what is drawn around it.
    pub fn cameras<'a>(&self, options: &CameraOptions, scene: &'a Scene) -> Cameras<'a> {
        if self.bounding_box { Cameras::of_box(options, scene) } else { Cameras::new(options, scene, Fit::Visible) }
    }

    fn annotations(&self) -> Annotations {
        let Self { legend, bounding_box, axes, .. } = *self;
        Annotations { legend, bounding_box, axes, units: self.units.clone(), length_units: self.length_units.clone() }
    }

    /// Size of the frame that is averaged to a picture of this size.
    pub fn rendered(&self, size: Viewport) -> Result<Viewport, Error> {
        let n = self.samples;
        let [width, height] = [size.width, size.height].map(|side| side.saturating_mul(n));
        Viewport::new(width, height).map_err(|_| {
            let Viewport { width: w, height: h } = size;
            let problem = format!(
                "{n}x{n} samples of {w}x{h} pixels are a frame of {width}x{height}, and {} per side is the most: at most {} fit here",
                Viewport::MAX_SIDE,
                Viewport::MAX_SIDE / w.max(h)
            );
            Error::Settings { field: "samples", problem }
        })
    }
}
