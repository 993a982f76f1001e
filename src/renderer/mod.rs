//! Renders frames: what is kept on the device, what a frame is planned to do, and how it runs.

mod accumulation;
mod classification;
mod depths;
mod enqueued;
#[cfg(test)]
mod faults;
mod field;
mod frame;
mod lattice_picture;
mod layered;
mod lighting;
mod onto;
mod parts;
mod picture;
mod plan;
mod range;
mod rays;
mod region;
mod report;
mod sampling;
mod scene;
mod screen;
mod sheets;
mod store;
mod streamed;
#[cfg(feature = "gl-interop")]
mod texture;
mod tiles;
mod volume_renderer;
mod warm_up;
mod world;

pub use accumulation::Accumulation;
#[cfg(feature = "cli")]
pub(crate) use depths::marched;
pub use field::{DeviceVoxels, UploadedVolume};
pub use lattice_picture::LatticePicture;
pub use onto::{PictureFormat, PictureMemory};
pub use parts::{CompositedLayers, PartRenderer};
#[cfg(feature = "mpi")]
pub(crate) use parts::{LatticeView, Shares, combined};
#[doc(hidden)] // Of this crate's own tests: it shows `layers`.
pub use plan::Plan;
pub use report::{FrameReport, LatticeReport, Measured};
pub use streamed::{StreamPlan, StreamedLattice, StreamedRenderer};
#[cfg(feature = "gl-interop")]
pub use texture::GlTexture;
pub use volume_renderer::{VolumeRenderer, volume_renderer};
pub use warm_up::ExpectedFrames;

use crate::camera::Camera;
use crate::device::{Buffer, Cancel, Device};
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::layers::Rays;
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use frame::{Engine, Mode, Output, Stage};
use picture::{FLOATS, Finished, RGBA8, read_displayed};
use std::time::Duration;
use tiles::read_samples;

/// Renders one volume on one device.
///
/// The voxels live on the device, and what can be kept is kept: the layout and min-max blocks of each layer axis from its
/// first use, tables from one transfer function to the next, buffers from frame to frame.
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

/// A view that is planned.
struct Planned {
    rays: Rays,
    viewport: Viewport,
    /// In the world of frames.
    settings: Settings,
    plan: Plan,
}

impl Renderer {
    /// Uploads a volume, to be seen through a transfer function.
    pub fn new(device: &Device, volume: &Volume, transfer: &TransferFunction) -> Result<Self, Error> {
        Self::of(&UploadedVolume::new(device, volume)?, transfer)
    }

    /// Renders a volume that is on a device already. Renderers of one uploaded volume share its voxels and what is made from these.
    ///
    /// # Errors
    /// Where only a part of it is: that is for a [`PartRenderer`].
    pub fn of(volume: &UploadedVolume, transfer: &TransferFunction) -> Result<Self, Error> {
        check_whole(volume)?;
        Ok(Self { engine: Engine::new(volume, transfer) })
    }

    /// Takes another transfer function from the next frame on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.engine.set_transfer_function(transfer);
    }

    /// The transfer function in use.
    pub fn transfer_function(&self) -> &TransferFunction {
        self.engine.classification.transfer_function()
    }

    /// Takes another volume from the next frame on, of any size, type and range. Its voxels go into the buffer of the last one where they
    /// fit and no other renderer uses that; where the type stays, no device program is built again.
    ///
    /// # Errors
    /// A device without enough memory; the renderer then has its old volume or none that can be drawn, and takes another.
    pub fn set_volume(&mut self, volume: &Volume) -> Result<(), Error> {
        self.engine.replace_field(&volume.held())
    }

    /// Takes another volume that is on the device already from the next frame on: it may have been uploaded while frames of the last one
    /// were drawn.
    ///
    /// # Errors
    /// Where only a part of it is on the device, or where it is on a device of another context.
    pub fn set_uploaded_volume(&mut self, volume: &UploadedVolume) -> Result<(), Error> {
        check_whole(volume)?;
        self.engine.set_field(volume)
    }

    /// Where the voxels lie in the world.
    pub fn grid(&self) -> &Grid {
        self.engine.field.description().grid()
    }

    /// Whether the reports of frames say what these took, from the next one on. Without, a frame is read back once, and the queue is
    /// waited for only so long; but sheets, in either case, read how many splats they have.
    pub fn measure(&mut self, measuring: bool) {
        self.engine.measuring = measuring;
    }

    /// Whether frames may be drawn by more general programs from now on, where the best one is not built yet and a general one is
    /// ([`warm_up`](Self::warm_up) builds these first). The best one is then built in the background; frames take longer until it is, and
    /// are within 2e-3 per channel of its own, rounding mostly. [`FrameReport::general_program`] tells. Only layers that are sampled at points
    /// and composited on a lattice have general programs; frames that are [enqueued](Self::enqueue) are drawn by the best.
    pub fn use_general_programs(&mut self, allowed: bool) {
        self.engine.general_programs = allowed;
    }

    /// Limits the time of a frame, from the next one on: a longer one ends with [`Error::TooLong`]. Time is looked at before each kernel;
    /// a running kernel ends first. [Enqueued](Self::enqueue) frames have no limit.
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.engine.limits.longest = longest;
    }

    /// Lets another thread cancel frames, from the next one on, or no longer (`None`). A cancelled frame ends before its next kernel with
    /// [`Error::Cancelled`], and the next frame is drawn in full. [Enqueued](Self::enqueue) frames are not cancelled.
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.engine.limits.cancel = cancel;
    }

    /// Renders a picture: premultiplied floats, without a background.
    pub fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Frame, FrameReport), Error> {
        self.render_planned(&self.planned(camera, viewport, settings)?)
    }

    fn render_planned(&mut self, planned: &Planned) -> Result<(Frame, FrameReport), Error> {
        let viewport = planned.viewport;
        let (pixels, report) =
            self.run(planned, Output::Floats, |device, finished| read_samples(finished.floats(), device, viewport.pixels()))?;
        Ok((Frame::new(viewport, pixels), report))
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

    /// Renders an 8-bit picture, which `take` takes from the device.
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

    /// Runs a planned frame that is waited for.
    fn run<T>(
        &mut self,
        planned: &Planned,
        output: Output,
        deliver: impl FnOnce(&Device, &Finished) -> Result<T, Error>,
    ) -> Result<(T, FrameReport), Error> {
        let Planned { rays, viewport, settings, plan } = planned;
        tracing::debug!("{plan}");
        let stage = self.engine.declaring(*viewport, |declaring| Stage::of_plan(plan, output, false, declaring));
        let per_pixel = if matches!(output, Output::Rgba8(_)) { RGBA8 } else { FLOATS };
        let host_bytes = per_pixel * viewport.pixels() as u64;
        let frame =
            frame::Frame { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into: None, host_bytes };
        let (delivered, statistics) = self.engine.run(&frame, Mode::Waited, deliver)?;
        Ok((delivered, FrameReport::new(plan, statistics)))
    }

    fn planned(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Planned, Error> {
        let field = &self.engine.field;
        let (rays, settings) = field.world().seen(field.grid(), camera, viewport, settings)?;
        Planned::new(rays, viewport, settings, field.grid())
    }
}

impl Planned {
    /// `settings` and `grid` in the world of frames.
    fn new(rays: Rays, viewport: Viewport, settings: Settings, grid: &Grid) -> Result<Self, Error> {
        let plan = Plan::new(&rays, viewport, grid, &settings)?;
        Ok(Self { rays, viewport, settings, plan })
    }
}

/// Refuses a part of a volume.
fn check_whole(volume: &UploadedVolume) -> Result<(), Error> {
    if volume.is_whole() {
        return Ok(());
    }
    let name = std::path::Path::new(volume.description().name());
    Err(Error::volume(name, "only a part of it is on the device: render it with a PartRenderer"))
}

#[cfg(test)]
mod tests;
