//! Finished pictures: rendered, supersampled, annotated.

use super::cameras::Cameras;
use super::compiling;
use super::names;
use super::notice;
use super::options::{CameraOptions, EncodingOptions, Fit};
use super::parse;
use super::scene::OpenedScene;
use super::scene_renderer::SceneRenderer;
use super::time::{FirstOfStep, NextStep};
use crate::annotation::{AnnotatedView, Annotations, VectorFormat};
use crate::camera::Camera;
use crate::color::Curve;
use crate::error::Error;
use crate::image::{Background, Depths, Frame, ImageFormat};
use crate::renderer::{Channel, FrameReport, StreamPlan};
use crate::settings::Settings;
use crate::shown::Shown;
use crate::surface::Surface;
use crate::viewport::Viewport;
use crate::volume::Grid;
use clap::{Args, ValueEnum};

/// Typographic points.
const POINTS_PER_INCH: f64 = 72.0;

/// Supersampling, annotations and file encoding.
#[derive(Args)]
#[command(next_help_heading = "Camera and picture")]
pub(super) struct PictureOptions {
    /// Supersample with N×N rays per pixel, 1 to 16
    #[arg(long, default_value_t = 1, value_parser = parse::samples, value_name = "N", allow_hyphen_values = true)]
    pub samples: u32,
    /// Draw a colour bar with opacities, and with a parallel projection a scale bar
    #[arg(long, group = "colour_bar")]
    pub legend: bool,
    /// Draw the bounding box, and frame it unless --fit is given
    #[arg(long = "box")]
    pub bounding_box: bool,
    /// Draw the world axes in the lower left corner
    #[arg(long)]
    pub axes: bool,
    /// Where legend and axes are: beside the volume, which is drawn smaller, or over it
    #[arg(long, default_value = "beside", value_name = "WHERE", value_parser = names::of_enum::<LegendPlace>())]
    pub legend_place: LegendPlace,
    /// Unit of the values, for the colour bar
    #[arg(long, value_name = "TEXT", requires = "colour_bar")]
    pub units: Option<String>,
    /// Unit of length, for the scale bar
    #[arg(long, value_name = "TEXT", requires = "legend")]
    pub length_units: Option<String>,
    /// Size of letters in points, of 1/72 inch by --dpi [default: by the size of the picture]
    #[arg(long, value_name = "POINTS", requires = "dpi", value_parser = parse::positive, allow_hyphen_values = true)]
    pub font_size: Option<f64>,
    #[command(flatten)]
    pub encoding: EncodingOptions,
}

/// Place of legend and axes.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(super) enum LegendPlace {
    Beside,
    Over,
}

/// Renders the pictures of a scene. Sizes are those of finished pictures; legend and axes may take a part.
pub(super) struct Pictures<'a> {
    scene: &'a OpenedScene,
    options: &'a PictureOptions,
    background: Background,
    annotations: Annotations,
    /// Whether pictures become files of floats, which stay in linear light.
    keeps_floats: bool,
    scene_renderer: SceneRenderer,
    /// Grid of the volume that is drawn.
    grid: Grid,
    /// The surfaces that are drawn.
    surfaces: Vec<Surface>,
    /// The fields beside it on the device, once a step was changed; hidden ones stay `None`.
    others: Vec<Option<Channel>>,
    /// Whether the first picture was checked for being empty or of one colour.
    first_checked: bool,
    has_empty_picture: bool,
}

impl<'a> Pictures<'a> {
    /// Creates the renderer of a scene. `background` selects contrasting annotation colours; the default is black.
    pub fn new(scene: &'a OpenedScene, options: &'a PictureOptions, background: Option<Background>) -> Result<Self, Error> {
        let background = background.unwrap_or(Background::BLACK);
        let annotations = options.annotations(scene);
        Ok(Self {
            scene,
            options,
            background,
            annotations,
            keeps_floats: false,
            scene_renderer: SceneRenderer::new(scene)?,
            grid: scene.extent.clone(),
            surfaces: scene.surfaces.clone(),
            others: vec![None; scene.others.len()],
            first_checked: false,
            has_empty_picture: false,
        })
    }

    /// The following pictures are for files of this format.
    pub fn set_format(&mut self, format: ImageFormat) {
        self.keeps_floats = format.has_floats();
    }

    /// Enables or disables the legend of the following pictures.
    pub fn set_legend(&mut self, legend: bool) {
        self.annotations.legend = legend;
    }

    /// Draws the surfaces of the scene in the following pictures, of which others may be visible. All visible ones are uploaded then.
    pub fn set_surfaces(&mut self, surfaces: Vec<Surface>) -> Result<(), Error> {
        let visible = |surfaces: &[Surface]| surfaces.iter().map(|surface| surface.is_visible).collect::<Vec<_>>();
        if visible(&surfaces) != visible(&self.surfaces) {
            self.scene_renderer.renderer().set_surfaces(&surfaces)?;
            self.surfaces = surfaces;
        }
        Ok(())
    }

    /// Draws another step of a sequence in the following pictures.
    pub fn set_step(&mut self, step: NextStep) -> Result<(), Error> {
        let first = match step.first {
            FirstOfStep::Values(volume) => *volume,
            FirstOfStep::Shown(shown) => return self.set_shown(&shown),
        };
        self.grid = first.grid().clone();
        if !self.scene.has_channels() {
            return self.scene_renderer.renderer().set_volume(&first);
        }
        let OpenedScene { device, transfer, look, others, .. } = self.scene;
        for ((kept, volume), field) in self.others.iter_mut().zip(step.others).zip(others).filter(|(_, field)| field.is_visible())
        {
            // A field that stands still is uploaded once.
            if volume.is_some() || kept.is_none() {
                *kept = Some(field.look.channel(device, volume.as_ref().unwrap_or(&field.volume), &field.transfer)?);
            }
        }
        let first = look.channel(device, &first, transfer)?;
        let channels: Vec<Channel> = std::iter::once(first).chain(self.others.iter().flatten().cloned()).collect();
        self.scene_renderer.renderer().require_whole("a sequence of several fields")?.set_channels(&channels)
    }

    /// Draws other colours or labels.
    fn set_shown(&mut self, shown: &Shown) -> Result<(), Error> {
        let OpenedScene { device, transfer, .. } = self.scene;
        self.grid = shown.volume().grid().clone();
        let colors = shown.colors(device, &shown.upload(device)?, transfer, &shown.tables(&[])?)?;
        self.scene_renderer.renderer().require_whole("a sequence of colours or labels")?.set_colors(&colors)
    }

    /// Stream plan of a view, also printed to standard error. `None` if the view is not streamed.
    pub fn announce(&self, camera: &Camera, size: Viewport) -> Result<Option<StreamPlan>, Error> {
        self.scene_renderer.announce(camera, self.options.rendered(self.inner(size))?, &self.scene.settings)
    }

    pub fn scene(&self) -> &'a OpenedScene {
        self.scene
    }

    fn inner(&self, size: Viewport) -> Viewport {
        self.options.inner(size, self.scene)
    }

    /// Whether a picture so far showed nothing.
    pub fn has_empty_picture(&self) -> bool {
        self.has_empty_picture
    }

    pub fn is_streamed(&self) -> bool {
        self.scene_renderer.is_streamed()
    }

    pub fn measure(&mut self, measuring: bool) {
        self.scene_renderer.renderer().measure(measuring);
    }

    /// Renders a finished picture without a background. If the first one is empty, prints a hint to standard error. If processes
    /// share the volume, only the leader of the team receives the picture.
    pub fn picture(&mut self, camera: &Camera, size: Viewport) -> Result<(Option<Frame>, FrameReport), Error> {
        self.picture_with(camera, size, &self.scene.settings)
    }

    /// As [`picture`](Self::picture), with other settings than the scene's.
    pub fn picture_with(
        &mut self,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let rendered = self.options.rendered(self.inner(size))?;
        let (frame, report) = {
            let Self { scene_renderer, .. } = self;
            compiling::while_rendering(|| scene_renderer.renderer().render(camera, rendered, settings))?
        };
        let Some(frame) = frame else { return Ok((None, report)) };
        self.has_empty_picture |= notice::is_empty(&frame);
        if !std::mem::replace(&mut self.first_checked, true)
            && let Some(notice) = notice::explain_picture(&frame, camera, self.scene)
        {
            eprintln!("layersplat: {notice}");
        }
        let frame = if self.options.samples > 1 { frame.averaged(self.options.samples)? } else { frame };
        let shown = AnnotatedView {
            camera,
            grid: &self.grid,
            transfer: &self.scene.transfer,
            blend: settings.blend,
            background: self.background,
        };
        // Annotations keep their colours in pictures of integers: they are drawn on coded ones.
        let curve = settings.curve();
        let frame = if self.keeps_floats { frame.with_curve(curve) } else { frame.coded(curve) };
        Ok((Some(self.annotations.drawn_beside(frame, size, shown)?), report))
    }

    /// The curve that is left for finished pictures.
    pub fn curve(&self) -> Curve {
        let curve = self.scene.settings.curve();
        if self.keeps_floats { curve } else { curve.of_coded() }
    }

    /// Depths of a picture, along rays through the pixel centres, and the ids of its labels there.
    pub fn depths(&mut self, camera: &Camera, size: Viewport) -> Result<Depths, Error> {
        let inner = self.inner(size);
        let depths = self.scene_renderer.renderer().depths(camera, inner, &self.scene.settings)?;
        let depths = match self.scene.label_at() {
            Some(id_at) => depths.with_ids(camera, id_at)?,
            None => depths,
        };
        depths.within(size)
    }
}

impl PictureOptions {
    /// Cameras that fit the visible part, or the bounding box if it is drawn. Says on standard error which way is up.
    pub fn cameras(&self, options: &CameraOptions, scene: &OpenedScene) -> Cameras {
        let orientation = scene.orientation(options);
        let options = CameraOptions { size: self.inner(options.size, scene), ..options.clone() };
        match self.bounding_box {
            true => Cameras::with_bounding_box(&options, scene, orientation),
            false => Cameras::new(&options, scene, Fit::Visible, orientation),
        }
    }

    /// Size of the volume's part of a picture, beside which legend and axes are.
    pub fn inner(&self, size: Viewport, scene: &OpenedScene) -> Viewport {
        match self.legend_place {
            LegendPlace::Beside => self.annotations(scene).inner(size, &scene.transfer, scene.settings.blend),
            LegendPlace::Over => size,
        }
    }

    /// The colour bar of a scene, as it is beside a picture of `size`.
    pub fn colour_bar(&self, size: Viewport, scene: &OpenedScene, background: Option<Background>) -> Result<Frame, Error> {
        let background = background.unwrap_or(Background::BLACK);
        self.annotations(scene).legend_alone(size, &scene.transfer, scene.settings.blend, background)
    }

    /// As [`colour_bar`](Self::colour_bar), as a file of vector graphics.
    pub fn colour_bar_document(
        &self,
        size: Viewport,
        scene: &OpenedScene,
        background: Option<Background>,
        format: VectorFormat,
    ) -> Result<Vec<u8>, Error> {
        let (background, encoding) = (background.unwrap_or(Background::BLACK), self.encoding.encoding());
        self.annotations(scene).legend_document(size, &scene.transfer, scene.settings.blend, background, format, &encoding)
    }

    fn annotations(&self, scene: &OpenedScene) -> Annotations {
        let Self { legend, bounding_box, axes, .. } = *self;
        let length_units = self.length_units.clone().or_else(|| scene.volume.length_unit().map(Into::into));
        let units = self.units.clone();
        Annotations { legend, list: scene.legend.clone(), bounding_box, axes, units, length_units, font_size: self.font_pixels() }
    }

    /// Size of letters in pixels, if given.
    fn font_pixels(&self) -> Option<f64> {
        self.font_size.zip(self.encoding.dpi()).map(|(points, dpi)| points * f64::from(dpi.get()) / POINTS_PER_INCH)
    }

    /// Size of the supersampled frame for a picture of `size`.
    ///
    /// # Errors
    /// [`Error::Settings`] if the frame would exceed [`Viewport::MAX_SIDE`], or letters cannot be drawn.
    pub fn rendered(&self, size: Viewport) -> Result<Viewport, Error> {
        let annotations = Annotations { legend: self.legend, font_size: self.font_pixels(), ..Annotations::default() };
        annotations.check()?;
        let n = self.samples;
        let [width, height] = [size.width, size.height].map(|side| side.saturating_mul(n));
        Viewport::new(width, height).map_err(|_| {
            let Viewport { width: w, height: h } = size;
            let problem = format!(
                "{n}x{n} samples of {w}x{h} pixels need a frame of {width}x{height}, larger than the maximum of {} per side: use at most {}",
                Viewport::MAX_SIDE,
                Viewport::MAX_SIDE / w.max(h)
            );
            Error::Settings { field: "samples", problem }
        })
    }
}
