//! Rendering: resources kept on the device, frame planning and execution.

mod accumulation;
mod channels;
mod classification;
mod colors;
mod depth_cue;
mod depths;
mod directions;
#[cfg(feature = "mpi")]
mod distributed_report;
mod enqueued;
#[cfg(test)]
mod faults;
mod field;
mod frame;
mod label_colors;
mod label_surfaces;
mod lattice_picture;
mod layered;
mod light;
mod lighting;
#[cfg(feature = "paper")]
mod paper;
mod parts;
mod picture;
mod picture_memory;
mod plan;
mod range;
mod rays;
mod region;
mod report;
mod sampling;
mod scene;
mod screen;
#[cfg(test)]
mod shaded_places;
mod slice;
mod slice_pass;
mod store;
mod streamed;
mod surfaces;
#[cfg(feature = "gl-interop")]
mod texture;
mod tiles;
mod volume_renderer;
mod warm_up;
mod world;

pub use accumulation::Accumulation;
#[cfg(feature = "mpi")]
pub(crate) use accumulation::Jitter;
pub use channels::Channel;
pub use colors::{ColorOpacity, UploadedColors};
#[cfg(any(feature = "cli", feature = "page"))]
pub(crate) use depths::depth_settings;
pub use directions::vector_norms;
#[cfg(feature = "mpi")]
pub use distributed_report::{Composed, DistributedReport, Exchanged, RankMeasured, RankReport};
pub use field::{DeviceVoxels, UploadedVolume};
pub use label_colors::LabelColors;
pub use lattice_picture::LatticePicture;
#[cfg(feature = "mpi")]
pub(crate) use light::{HostField, LightOfParts, SweepGroup, Target, Wanted, WantedField, behind};
#[doc(hidden)] // Of this crate's own tests: it shows `layers`.
#[cfg(feature = "paper")]
pub use paper::PaperPlan;
#[cfg(any(feature = "cli", feature = "mpi"))]
pub(crate) use parts::SeenVolume;
pub use parts::{CompositedLayers, PartRenderer};
#[cfg(feature = "mpi")]
pub(crate) use parts::{LatticeView, Shares, combined};
pub use picture_memory::{PictureFormat, PictureMemory};
#[doc(hidden)] // Of this crate's own tests: it shows `layers`.
pub use plan::Plan;
pub use report::{FrameReport, LatticeReport, Measured};
pub use streamed::{StreamPlan, StreamedLattice, StreamedRenderer};
#[cfg(feature = "gl-interop")]
pub use texture::GlTexture;
pub use volume_renderer::{VolumeRenderer, volume_renderer};
pub use warm_up::ExpectedFrames;

use crate::camera::Camera;
use crate::device::{Bands, Buffer, Cancel, Device};
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::layers::Rays;
use crate::settings::Settings;
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use frame::{Engine, Mode, Output, Stage};
use picture::{FLOATS, Finished, RGBA8, read_displayed};
use std::time::Duration;
use tiles::read_samples;

/// Renders one volume on one device.
///
/// The voxels reside on the device. Derived data are cached: the layout and the min-max blocks of each layer axis from their
/// first use, tables until the transfer function changes, and buffers from frame to frame.
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
/// let (frame, _) = renderer.render(&camera, viewport, &Settings::default())?;
/// assert!(frame.pixels().iter().any(|pixel| pixel[3] > 0.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct Renderer {
    engine: Engine,
}

/// A planned view.
struct Planned {
    rays: Rays,
    viewport: Viewport,
    /// In normalised world units.
    settings: Settings,
    plan: Plan,
}

impl Renderer {
    /// Uploads a volume and creates a renderer for it with this transfer function.
    pub fn new(device: &Device, volume: &Volume, transfer: &TransferFunction) -> Result<Self, Error> {
        Self::from_uploaded(&UploadedVolume::new(device, volume)?, transfer)
    }

    /// Creates a renderer for a volume that is already on a device. Renderers of one uploaded volume share its voxels and all
    /// data derived from them.
    ///
    /// # Errors
    /// If only a part of the volume is on the device; use a [`PartRenderer`] for that.
    pub fn from_uploaded(volume: &UploadedVolume, transfer: &TransferFunction) -> Result<Self, Error> {
        check_whole(volume)?;
        Ok(Self { engine: Engine::new(volume, transfer) })
    }

    /// Replaces the transfer function, from the next frame on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.engine.set_transfer_function(transfer);
    }

    /// The current transfer function.
    pub fn transfer_function(&self) -> &TransferFunction {
        self.engine.classification().transfer_function()
    }

    /// Replaces the volume, from the next frame on. Size, type and range may differ. The new voxels reuse the old buffer if they
    /// fit and no other renderer uses it. If the voxel type is unchanged, no device program is rebuilt.
    ///
    /// # Errors
    /// [`Error::DeviceMemory`] if the voxels do not fit into a buffer of the device; the renderer keeps its volume. After other
    /// errors, such as insufficient memory, it has no volume: frames fail with [`Error::NoVolume`] until a volume is set.
    pub fn set_volume(&mut self, volume: &Volume) -> Result<(), Error> {
        self.engine.replace_field(&volume.held())
    }

    /// Replaces the volume, from the next frame on, by one that is already on the device. It may have been uploaded while frames
    /// of the previous volume were rendered.
    ///
    /// # Errors
    /// If only a part of it is on the device, or if the device has another context.
    pub fn set_uploaded_volume(&mut self, volume: &UploadedVolume) -> Result<(), Error> {
        check_whole(volume)?;
        self.engine.set_field(volume)
    }

    /// Creates a renderer that draws several fields together, at most [`Channel::MOST`].
    ///
    /// # Errors
    /// As for [`set_channels`](Self::set_channels).
    pub fn from_channels(channels: &[Channel]) -> Result<Self, Error> {
        let Some(first) = channels.first() else {
            return Err(Error::Settings { field: "channels", problem: "there is none: give at least one".into() });
        };
        let mut renderer = Self::from_uploaded(&first.volume, &first.transfer)?;
        renderer.set_channels(channels)?;
        Ok(renderer)
    }

    /// Creates a renderer of a volume of colours or labels. They are composited in point-sampled layers.
    ///
    /// # Errors
    /// Those of the device.
    pub fn from_colors(colors: &UploadedColors) -> Result<Self, Error> {
        let (volume, transfer) = colors.visibility();
        let mut renderer = Self::from_uploaded(&volume, &transfer)?;
        renderer.set_colors(colors)?;
        Ok(renderer)
    }

    /// Replaces all fields by a volume of colours or labels, from the next frame on.
    ///
    /// # Errors
    /// If it is on a device of another context.
    pub fn set_colors(&mut self, colors: &UploadedColors) -> Result<(), Error> {
        self.engine.set_colors(colors)
    }

    /// Draws the renderer's volume in the colours of labels from the next frame on, or in its own again. Its opacities stay.
    ///
    /// Composited pre-integrated layers and cast rays have them, and iso-surfaces. Frames of several fields, of colours, by other algorithms or
    /// blend modes, and slices fail.
    ///
    /// # Errors
    /// If the labels are on a device of another context, lie outside the volume, or have another size and no placement. The renderer
    /// keeps its colours then.
    pub fn set_label_colors(&mut self, colors: Option<&LabelColors>) -> Result<(), Error> {
        self.engine.set_label_colors(colors)
    }

    /// Replaces all fields and how they are shown, from the next frame on. Data derived from fields and transfer functions that stay are
    /// kept. The first channel replaces the renderer's volume and its transfer function.
    ///
    /// # Errors
    /// For other numbers of channels than 1 to [`Channel::MOST`], parts of volumes, and devices of other contexts. The renderer keeps its
    /// channels then.
    pub fn set_channels(&mut self, channels: &[Channel]) -> Result<(), Error> {
        channels.iter().try_for_each(|channel| check_whole(&channel.volume))?;
        self.engine.set_channels(channels)
    }

    /// Replaces the surfaces that are drawn in and around the volume, from the next frame on.
    ///
    /// # Errors
    /// If they do not fit into the memory of the device; there are none then.
    pub fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        self.engine.set_surfaces(surfaces)
    }

    /// The device that draws, for uploading further volumes.
    pub fn device(&self) -> &Device {
        &self.engine.device
    }

    /// The grid that places the voxels in the world.
    pub fn grid(&self) -> &Grid {
        self.engine.base_field().description().grid()
    }

    /// Enables frame statistics in reports, from the next frame on. Without them a frame is read back once, and that is the only
    /// wait for the queue. Sheets always read back their number of splats.
    pub fn measure(&mut self, measuring: bool) {
        self.engine.measuring = measuring;
    }

    /// Allows more general programs from now on, for frames whose specialised program is not built yet while a general one is
    /// ([`warm_up`](Self::warm_up) builds those first). The specialised program is then built in the background. Until it is
    /// ready, frames take longer and differ from its frames by at most 2e-3 per channel, mostly through rounding.
    /// [`FrameReport::general_program`] tells whether a general program was used. General programs exist only for point-sampled
    /// layers composited on a lattice. [Enqueued](Self::enqueue) frames always use the specialised program.
    pub fn use_general_programs(&mut self, allowed: bool) {
        self.engine.general_programs = allowed;
    }

    /// Limits the time of a frame, from the next one on. A frame that exceeds it ends with [`Error::TooLong`]. The time is
    /// checked before each kernel; a running kernel is completed. [Enqueued](Self::enqueue) frames have no limit.
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.engine.limits.longest = longest;
    }

    /// Sets the handle with which another thread can cancel frames, from the next frame on; `None` removes it. A cancelled frame
    /// ends before its next kernel with [`Error::Cancelled`], and the next frame is rendered in full. [Enqueued](Self::enqueue)
    /// frames cannot be cancelled.
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.engine.limits.cancel = cancel;
    }

    /// Renders frames in bands, from the next frame on, so that frames of other renderers can run between them; `None` launches each
    /// kernel as a whole again. [Enqueued](Self::enqueue) frames have no bands.
    pub fn set_bands(&mut self, bands: Option<Bands>) {
        self.engine.limits.bands = bands;
    }

    /// Renders a picture as premultiplied floats, without a background. Its conversions to 8 and 16 bits apply the curve of the settings.
    pub fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Frame, FrameReport), Error> {
        self.render_planned(&self.planned(camera, viewport, settings)?)
    }

    fn render_planned(&mut self, planned: &Planned) -> Result<(Frame, FrameReport), Error> {
        let viewport = planned.viewport;
        let (pixels, report) =
            self.run(planned, Output::Floats, |device, finished| read_samples(finished.floats(), device, viewport.pixels()))?;
        Ok((Frame::new(viewport, pixels).with_curve(planned.settings.curve()), report))
    }

    /// Renders a finished 8-bit RGBA picture, row by row, row 0 on top.
    pub fn render_rgba8(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<(Vec<u8>, FrameReport), Error> {
        self.render_displayed(camera, viewport, settings, background, |device, picture| read_displayed(device, picture, viewport))
    }

    /// Renders an 8-bit picture; `take` reads it from the device.
    fn render_displayed<T>(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
        take: impl FnOnce(&Device, &Buffer<[u8; 4]>) -> Result<T, Error>,
    ) -> Result<(T, FrameReport), Error> {
        let planned = self.planned(camera, viewport, settings)?;
        self.run(&planned, Output::Rgba8(background), |device, finished| take(device, finished.rgba8()))
    }

    /// Runs a planned frame and waits for it.
    fn run<T>(
        &mut self,
        planned: &Planned,
        output: Output,
        deliver: impl FnOnce(&Device, &Finished) -> Result<T, Error>,
    ) -> Result<(T, FrameReport), Error> {
        let Planned { rays, viewport, settings, plan } = planned;
        tracing::debug!("{plan}");
        let stage = self.engine.declaring(*viewport, settings, |declaring| Stage::from_plan(plan, output, false, declaring));
        let per_pixel = if matches!(output, Output::Rgba8(_)) { RGBA8 } else { FLOATS };
        let host_bytes = per_pixel * viewport.pixels() as u64;
        let frame =
            frame::Frame { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into: None, host_bytes };
        let (delivered, statistics) = self.engine.run(&frame, Mode::Waited, deliver)?;
        Ok((delivered, FrameReport::new(plan, statistics)))
    }

    fn planned(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Planned, Error> {
        let (rays, settings) = self.engine.normalised_view(camera, viewport, settings)?;
        let planned = self.planned_for(rays, viewport, settings)?;
        self.engine.check_method(planned.plan.method(), planned.settings.blend)?;
        Ok(planned)
    }

    /// The view of these rays; they and the settings are in normalised world units.
    fn planned_for(&self, rays: Rays, viewport: Viewport, settings: Settings) -> Result<Planned, Error> {
        let (grid, steepness) = (self.engine.base_field().grid(), self.engine.steepness());
        let plan = Plan::with_steepness(&rays, viewport, grid, &settings, steepness)?;
        let plan = if self.engine.has_surfaces() { plan.with_surfaces(&rays, viewport, grid, &settings)? } else { plan };
        Ok(Planned { rays, viewport, settings, plan })
    }
}

/// Rejects a part of a volume.
fn check_whole(volume: &UploadedVolume) -> Result<(), Error> {
    if volume.is_whole() {
        return Ok(());
    }
    let name = std::path::Path::new(volume.description().name());
    Err(Error::volume(name, "only a part of the volume is on the device: render it with a PartRenderer"))
}

#[cfg(test)]
mod tests;
