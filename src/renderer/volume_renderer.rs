//! Common interface of all volume renderers: whole, streamed and distributed.

use super::accumulation::Accumulation;
use super::report::FrameReport;
use super::streamed::{StreamPlan, StreamedRenderer};
use super::{Cancel, Renderer};
use crate::camera::Camera;
use crate::device::{Bands, Device};
use crate::error::Error;
use crate::image::{Background, Depths, Frame};
use crate::settings::Settings;
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use std::time::Duration;

/// Renders a volume of lifetime `'v`. Implementations are [`Renderer`], which holds the whole volume, [`StreamedRenderer`], which
/// works within a memory budget, and the renderer of several processes. [`volume_renderer`] chooses between the first two.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::renderer::volume_renderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// // The picture does not depend on the memory.
/// let mut pictures = Vec::new();
/// for device in [device.clone(), device.with_memory(1_500_000)] {
///     let mut renderer = volume_renderer(&device, &volume, &transfer)?;
///     pictures.push(renderer.render(&camera, viewport, &Settings::default())?.0.expect("one process has the picture"));
/// }
/// assert!(pictures[0] == pictures[1]);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub trait VolumeRenderer<'v> {
    /// Replaces the transfer function, from the next frame on.
    fn set_transfer_function(&mut self, transfer: &TransferFunction);

    /// The transfer function in use.
    fn transfer_function(&self) -> &TransferFunction;

    /// Replaces the volume, from the next frame on. Size, type and range may differ.
    ///
    /// # Errors
    /// If device memory is insufficient, or if the bricks of the processes do not form a volume.
    fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error>;

    /// Replaces the surfaces that are drawn in and around the volume, from the next frame on.
    ///
    /// # Errors
    /// If they do not fit into the memory of the device; there are none then. Renderers of several processes draw none.
    fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        let problem = "several processes that share a volume draw none: use one, or omit the option".into();
        if surfaces.is_empty() { Ok(()) } else { Err(Error::Settings { field: "surface", problem }) }
    }

    /// The grid that places the voxels in the world.
    fn grid(&self) -> &Grid;

    /// Enables frame statistics in reports, from the next frame on. With several processes, all must call this; reports have the stage
    /// times of the calling process, and `processes` has those of each.
    fn measure(&mut self, measuring: bool);

    /// Limits the time of a frame, from the next one on.
    fn limit(&mut self, longest: Option<Duration>);

    /// Sets the handle with which another thread can cancel frames, from the next frame on; `None` removes it.
    fn set_cancel(&mut self, cancel: Option<Cancel>);

    /// Renders frames in bands, from the next frame on ([`Renderer::set_bands`]). Renderers of several processes have none.
    fn set_bands(&mut self, _: Option<Bands>) {}

    /// The streaming plan of a view; `None` if all voxels are on the device at once.
    ///
    /// # Errors
    /// Those of [`render`](Self::render).
    fn stream_plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error>;

    /// Renders a picture as premultiplied floats, without a background. Its conversions to 8 and 16 bits apply the curve of the settings. With
    /// several processes, one of them returns it.
    ///
    /// # Errors
    /// Invalid settings, views that need the whole volume if it is not available, and failures of the device.
    fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings)
    -> Result<(Option<Frame>, FrameReport), Error>;

    /// Renders a finished 8-bit RGBA picture, row by row, row 0 on top. With several processes, one of them returns it.
    ///
    /// # Errors
    /// Those of [`render`](Self::render).
    fn render_rgba8(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<(Option<Vec<u8>>, FrameReport), Error> {
        let (frame, report) = self.render(camera, viewport, settings)?;
        Ok((frame.map(|frame| frame.to_rgba8(background)), report))
    }

    /// Renders the next frame of an accumulation and adds it ([`Renderer::accumulate`]). With several processes, all count the frame,
    /// and the one that gets the picture adds it.
    ///
    /// # Errors
    /// Those of [`render`](Self::render). The accumulation is then unchanged.
    fn accumulate(&mut self, camera: &Camera, settings: &Settings, accumulation: &mut Accumulation)
    -> Result<FrameReport, Error>;

    /// Depths of the visible surfaces of a picture; see [`Renderer::depths`].
    ///
    /// # Errors
    /// If not all voxels are on one device, because rays need all of them.
    fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error>;

    /// Builds the kernels and tables for frames like this one, and waits for them. A [`Renderer`] also prepares the other layer axes
    /// ([`Renderer::prepare`]); the others render the view once.
    ///
    /// # Errors
    /// Those of [`render`](Self::render).
    fn prepare(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.render(camera, viewport, settings).map(|_| ())
    }

    /// The underlying [`Renderer`] if it holds the whole volume; `None` if the volume is streamed or distributed. It has more
    /// features, such as enqueueing frames into the caller's memory.
    fn whole(&mut self) -> Option<&mut Renderer> {
        None
    }

    /// The renderer of the whole volume, for the call named `what`.
    ///
    /// # Errors
    /// [`Error::NeedsWholeVolume`] where the volume is streamed or shared.
    fn require_whole(&mut self, what: &'static str) -> Result<&mut Renderer, Error> {
        self.whole().ok_or(Error::NeedsWholeVolume { what })
    }
}

/// Creates a renderer for a volume on a device. The volume is streamed if the device handle has a memory budget
/// ([`Device::with_memory`]) or if no single buffer of the device is large enough; otherwise it is held as a whole.
///
/// # Errors
/// If device memory is insufficient for the volume.
pub fn volume_renderer<'v>(
    device: &Device,
    volume: &Volume<'v>,
    transfer: &TransferFunction,
) -> Result<Box<dyn VolumeRenderer<'v> + Send + 'v>, Error> {
    let bytes = volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
    if device.memory_budget().is_some() || bytes > device.largest_buffer_bytes() {
        return Ok(Box::new(StreamedRenderer::new(device, volume, transfer)));
    }
    Ok(Box::new(Renderer::new(device, volume, transfer)?))
}

impl<'v> VolumeRenderer<'v> for Renderer {
    fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.set_transfer_function(transfer);
    }

    fn transfer_function(&self) -> &TransferFunction {
        self.transfer_function()
    }

    fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.set_volume(volume)
    }

    fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        self.set_surfaces(surfaces)
    }

    fn grid(&self) -> &Grid {
        self.grid()
    }

    fn measure(&mut self, measuring: bool) {
        self.measure(measuring);
    }

    fn limit(&mut self, longest: Option<Duration>) {
        self.limit(longest);
    }

    fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.set_cancel(cancel);
    }

    fn set_bands(&mut self, bands: Option<Bands>) {
        self.set_bands(bands);
    }

    fn stream_plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        self.planned(camera, viewport, settings).map(|_| None)
    }

    fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let (frame, report) = self.render(camera, viewport, settings)?;
        Ok((Some(frame), report))
    }

    fn render_rgba8(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<(Option<Vec<u8>>, FrameReport), Error> {
        let (picture, report) = self.render_rgba8(camera, viewport, settings, background)?;
        Ok((Some(picture), report))
    }

    fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<FrameReport, Error> {
        self.accumulate(camera, settings, accumulation)
    }

    fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        self.depths(camera, viewport, settings)
    }

    fn prepare(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.prepare(camera, viewport, settings)
    }

    fn whole(&mut self) -> Option<&mut Renderer> {
        Some(self)
    }
}

impl<'v> VolumeRenderer<'v> for StreamedRenderer<'v> {
    fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.set_transfer_function(transfer);
    }

    fn transfer_function(&self) -> &TransferFunction {
        self.transfer_function()
    }

    fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.set_volume(volume);
        Ok(())
    }

    fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        self.set_surfaces(surfaces)
    }

    fn grid(&self) -> &Grid {
        self.grid()
    }

    fn measure(&mut self, measuring: bool) {
        self.measure(measuring);
    }

    fn limit(&mut self, longest: Option<Duration>) {
        self.limit(longest);
    }

    fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.set_cancel(cancel);
    }

    fn set_bands(&mut self, bands: Option<Bands>) {
        self.set_bands(bands);
    }

    fn stream_plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        self.plan(camera, viewport, settings)
    }

    fn accumulate(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        accumulation: &mut Accumulation,
    ) -> Result<FrameReport, Error> {
        self.accumulate(camera, settings, accumulation)
    }

    fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let (frame, report) = self.render(camera, viewport, settings)?;
        Ok((Some(frame), report))
    }

    fn depths(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Depths, Error> {
        self.depths(camera, viewport, settings)
    }
}
