//! Orchestrates a frame: what is kept between frames, what is planned, which kernels run in which order.

mod cache;
mod depths;
mod enqueued;
#[cfg(test)]
mod faults;
mod in_place;
mod lattice_picture;
mod layered;
mod onto;
mod parts;
mod picture;
mod plan;
mod prepared;
mod range;
mod rays;
mod region;
mod report;
mod scene;
mod scratch;
mod screen;
mod sheets;
mod streamed;
#[cfg(feature = "gl-interop")]
mod texture;
mod tiles;
mod uploaded;
mod world;

#[cfg(feature = "cli")]
pub(crate) use depths::marched;
pub use in_place::DeviceVoxels;
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
pub use uploaded::UploadedVolume;

use crate::camera::Camera;
use crate::device::launch::structs::Float4;
use crate::device::{Buffer, Cancel, Device, Limits, ScratchMemory};
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::layers::{Axis, Lattice, Rays};
use crate::settings::{Classification, Layered, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use layered::{PointLayers, SplatLayers};
use opencl3::event::Event;
use picture::{FLOATS, OntoScreen, Picture, RGBA8, Share, read_displayed};
use prepared::Prepared;
use range::LayerRange;
use rays::{Gathers, MarchedRays};
use scene::View;
use sheets::{AxisAlignedSheets, ImageAlignedSheets};
use std::sync::Arc;
use std::time::Duration;
use tiles::{Target, read_samples};
use world::World;

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
    device: Device,
    grid: Grid,
    world: World,
    prepared: Prepared,
    measuring: bool,
    limits: Limits,
    /// The caller's, for what frames write that are enqueued.
    scratch: Option<Arc<ScratchMemory>>,
    points: PointLayers,
    splats: SplatLayers,
    rays: MarchedRays,
    axis_sheets: AxisAlignedSheets,
    view_sheets: ImageAlignedSheets,
    /// Where lattices are drawn, and pictures without one.
    target: Target,
    picture: Picture,
}

/// Where a frame is when it is drawn.
enum Drawn {
    /// In a lattice, still to be warped.
    Lattice(Box<Lattice>),
    /// On the screen, warped from several lattices.
    Warped,
    /// On the screen.
    Screen,
}

impl Renderer {
    /// Uploads a volume, to be seen through a transfer function.
    pub fn new(device: &Device, volume: &Volume, transfer: &TransferFunction) -> Result<Self, Error> {
        Self::of(&UploadedVolume::new(device, volume)?, transfer)
    }

    /// Renders a volume that is on a device already.
    ///
    /// # Errors
    /// Where only a part of it is: that is for a [`PartRenderer`].
    pub fn of(volume: &UploadedVolume, transfer: &TransferFunction) -> Result<Self, Error> {
        if volume.is_whole() {
            return Ok(Self::holding(volume, transfer));
        }
        let name = std::path::Path::new(volume.description().name());
        Err(Error::volume(name, "only a part of it is on the device: render it with a PartRenderer"))
    }

    /// Renders what is held.
    fn holding(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let grid = volume.description().grid();
        let world = World::of(grid);
        Self {
            device: volume.device.with_own_sequence(),
            grid: grid.clone(),
            world,
            prepared: Prepared::new(volume, world.grid(grid), transfer),
            measuring: false,
            limits: Limits::default(),
            scratch: None,
            points: PointLayers::default(),
            splats: SplatLayers::default(),
            rays: MarchedRays::default(),
            axis_sheets: AxisAlignedSheets::default(),
            view_sheets: ImageAlignedSheets::default(),
            target: Target::default(),
            picture: Picture::default(),
        }
    }

    /// Takes another transfer function from the next frame on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.prepared.set_transfer_function(transfer);
    }

    /// The transfer function in use.
    pub fn transfer_function(&self) -> &TransferFunction {
        self.prepared.transfer_function()
    }

    /// Where the volume's voxels lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Whether the reports of frames say what these took, from the next one on. Without, a frame is read back once, and the queue is
    /// waited for only so long; but sheets, in either case, read how many splats they have.
    pub fn measure(&mut self, measuring: bool) {
        self.measuring = measuring;
    }

    /// Limits the time of a frame, from the next one on: a longer one ends with [`Error::TooLong`]. Time is looked at before each kernel;
    /// a running kernel ends first. [Enqueued](Self::enqueue) frames have no limit.
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.limits.longest = longest;
    }

    /// Lets another thread cancel frames, from the next one on, or no longer (`None`). A cancelled frame ends before its next kernel with
    /// [`Error::Cancelled`], and the next frame is drawn in full. [Enqueued](Self::enqueue) frames are not cancelled.
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.limits.cancel = cancel;
    }

    /// Renders a picture: premultiplied floats, without a background.
    pub fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Frame, FrameReport), Error> {
        let device = self.frame_device()?;
        let (rays, settings) = self.seen(camera, viewport, settings)?;
        let view = View { device: &device, rays: &rays, viewport, settings: &settings };
        let plan = Plan::new(&rays, viewport, self.prepared.grid(), &settings)?;
        self.require_room(&device, &plan, viewport, false)?;
        let (drawn, active_samples) = self.draw(view, &plan)?;
        let pixels = read_samples(self.floats(view, &drawn, None)?, &device, viewport.pixels())?;
        Ok((Frame::new(viewport, pixels), self.report(&device, &plan, active_samples)?))
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
        let device = self.frame_device()?;
        let (rays, settings) = self.seen(camera, viewport, settings)?;
        let view = View { device: &device, rays: &rays, viewport, settings: &settings };
        let plan = Plan::new(&rays, viewport, self.prepared.grid(), &settings)?;
        self.require_room(&device, &plan, viewport, true)?;
        let (drawn, active_samples) = self.draw(view, &plan)?;
        let taken = take(&device, self.displayed(view, &drawn, background, None)?)?;
        Ok((taken, self.report(&device, &plan, active_samples)?))
    }

    /// What was drawn as a frame of floats: warped `into` the caller's where it is still in a lattice.
    fn floats<'a>(
        &'a mut self,
        view: View,
        drawn: &Drawn,
        into: Option<&'a Buffer<Float4>>,
    ) -> Result<&'a Buffer<Float4>, Error> {
        let View { device, rays, viewport, .. } = view;
        match drawn {
            Drawn::Lattice(lattice) => {
                self.picture.warp(device, &mut self.target, OntoScreen { lattice, rays, viewport }, Share::WHOLE, into)
            }
            Drawn::Warped => self.picture.warped(device, viewport),
            Drawn::Screen => Ok(self.target.drawn(device)?.0),
        }
    }

    /// What was drawn as an 8-bit picture, `into` the caller's or its own.
    fn displayed<'a>(
        &'a mut self,
        view: View,
        drawn: &Drawn,
        background: Background,
        into: Option<&'a Buffer<[u8; 4]>>,
    ) -> Result<&'a Buffer<[u8; 4]>, Error> {
        let View { device, rays, viewport, .. } = view;
        let Self { picture, target, .. } = self;
        match drawn {
            Drawn::Lattice(lattice) => {
                picture.warp_displayed(device, target, OntoScreen { lattice, rays, viewport }, background, into)
            }
            Drawn::Warped => picture.present(device, None, viewport, background, into),
            Drawn::Screen => picture.present(device, Some(target), viewport, background, into),
        }
    }

    fn seen(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Rays, Settings), Error> {
        self.world.seen(self.prepared.grid(), camera, viewport, settings)
    }

    /// Begins what comes after `wait`. What frames that failed were to make for later ones may not be there: it is made again.
    fn begin(&mut self, wait: &[&Event]) -> Result<(), Error> {
        if self.device.begin(wait)? {
            self.prepared.forget();
        }
        Ok(())
    }

    /// The device as one frame uses it: what that leaves behind, if it fails, no other sees.
    fn frame_device(&mut self) -> Result<Device, Error> {
        self.begin(&[])?;
        let device = if self.measuring { self.device.timed() } else { self.device.clone() };
        Ok(device.with_limits(&self.limits))
    }

    /// Refuses a picture that would not fit into memory, as floats or displayed, before anything of it is made.
    fn require_room(&self, device: &Device, plan: &Plan, viewport: Viewport, displayed: bool) -> Result<(), Error> {
        let pixels = viewport.pixels();
        let [frame, rgba] = self.picture.missing(device, viewport);
        let drawn = match plan {
            Plan::Lattice(lattice, _) if displayed => self.target.missing(device, lattice.samples()),
            Plan::Lattice(lattice, _) => self.target.missing(device, lattice.samples()) + frame,
            Plan::Shared(parts, _) => {
                parts.iter().map(|(lattice, _)| self.target.missing(device, lattice.samples())).max().unwrap_or(0) + frame
            }
            _ => self.target.missing(device, pixels),
        };
        let (on_device, on_host) = if displayed { (drawn + rgba, RGBA8) } else { (drawn, FLOATS) };
        let what = format!("a picture of {}x{}", viewport.width, viewport.height);
        self.device.require(&what, on_device, on_host * pixels as u64)
    }

    /// Draws what is planned; and the samples with opacity of lattices that are not in the target any more.
    fn draw(&mut self, view: View, plan: &Plan) -> Result<(Drawn, u64), Error> {
        tracing::debug!("{plan}");
        let Self { prepared, target, .. } = self;
        match *plan {
            Plan::Lattice(ref lattice, layered) => {
                self.draw_lattice(view, lattice, layered, &LayerRange::whole(lattice))?;
                return Ok((Drawn::Lattice(Box::new(lattice.clone())), 0));
            }
            Plan::Shared(ref parts, layered) => return Ok((Drawn::Warped, self.draw_shared(view, parts, layered)?)),
            Plan::Direct(axis, layered) => self.draw_pixels(view, axis, layered)?,
            Plan::Raycast(kernel, step) => self.rays.cast(&mut view.of(prepared), kernel, step, Gathers::Colors, target)?,
            Plan::CastValues(kernel, step) => {
                self.rays.cast_values(&mut view.of(prepared), kernel, step, Gathers::Colors, target)?;
            }
            Plan::CastSegments(kernel, step) => self.rays.cast_segments(&mut view.of(prepared), kernel, step, target)?,
            Plan::Slicing(step) => self.rays.slice(&mut view.of(prepared), step, target)?,
            Plan::AxisSheets(axis) => self.axis_sheets.draw(&mut view.of(prepared), axis, target)?,
            Plan::ViewSheets(distance) => self.view_sheets.draw(&mut view.of(prepared), distance, target)?,
        }
        Ok((Drawn::Screen, 0))
    }

    /// Draws lattices one after the other, each warped with its share; and the samples with opacity of all but the last.
    fn draw_shared(&mut self, view: View, parts: &[(Lattice, f64)], layered: Layered) -> Result<u64, Error> {
        let mut counted = 0;
        for (n, (lattice, share)) in parts.iter().enumerate() {
            if n > 0 && self.measuring {
                counted += self.target.count_active(view.device)?;
            }
            self.draw_lattice(view, lattice, layered, &LayerRange::whole(lattice))?;
            let onto = OntoScreen { lattice, rays: view.rays, viewport: view.viewport };
            self.picture.warp(view.device, &mut self.target, onto, Share { share: *share, added: n > 0 }, None)?;
        }
        Ok(counted)
    }

    fn draw_lattice(&mut self, view: View, lattice: &Lattice, layered: Layered, range: &LayerRange) -> Result<(), Error> {
        let Self { prepared, target, .. } = self;
        let scene = &mut view.of(prepared);
        match layered.classification {
            Classification::Post(correction) => self.splats.draw_lattice(scene, lattice, correction, range, target),
            Classification::Preintegrated { kernel, samples_per_layer } => {
                self.points.draw_lattice(scene, lattice, (kernel, samples_per_layer), layered.evaluation, range, target)
            }
        }
    }

    fn draw_pixels(&mut self, view: View, axis: Option<Axis>, layered: Layered) -> Result<(), Error> {
        let Self { prepared, target, .. } = self;
        let scene = &mut view.of(prepared);
        match layered.classification {
            Classification::Post(correction) => self.splats.draw_pixels(scene, axis, correction, layered.footprints, target),
            Classification::Preintegrated { kernel, samples_per_layer } => {
                self.points.draw_pixels(scene, axis, (kernel, samples_per_layer), target)
            }
        }
    }

    /// Completes a frame's report; `active_samples` are those of lattices that are not in the target any more.
    fn report(&mut self, device: &Device, plan: &Plan, active_samples: u64) -> Result<FrameReport, Error> {
        let measured = if self.measuring {
            let active_samples = active_samples + self.target.count_active(device)?;
            Some(Measured { stages: device.stage_times()?, active_samples })
        } else {
            None
        };
        Ok(FrameReport::new(plan, measured))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renderers_go_from_thread_to_thread() {
        fn movable<T: Send>() {}
        movable::<Renderer>();
    }
}
