//! Slices: the field on the pixels of a plane.

use super::Renderer;
use super::field::Field;
use super::frame::{Frame as DeviceFrame, Mode, Stage, Step};
use super::picture::{FLOATS, Finished};
use super::slice_pass::{Shows, SlicePlan};
use super::tiles::read_samples;
use crate::device::Device;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Kernel, Rays};
use crate::settings::{Blend, Method, Settings};
use crate::slice::{Slice, SliceColors, SliceValues};
use crate::viewport::Viewport;
use glam::DVec3;

impl Renderer {
    /// Draws a slice as premultiplied floats, without a background. The field is reconstructed with `kernel` at the centre of each pixel,
    /// is not lit, and is not clipped. It continues at the edges of the volume, to half a voxel beyond the outermost ones; pixels
    /// outside are transparent. The background value does not occur, except at invalid voxels.
    ///
    /// ```
    /// use layersplat::slice::{Slice, SliceAxis, SliceColors};
    /// use layersplat::{Kernel, Renderer};
    /// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
    /// # let transfer = layersplat::TransferFunction::automatic(&volume);
    /// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
    /// # let viewport = layersplat::Viewport::new(32, 24)?;
    ///
    /// let mut renderer = Renderer::new(&device, &volume, &transfer)?;
    /// let slice = Slice::at(volume.grid(), SliceAxis::Z, 7.5, viewport)?;
    /// let frame = renderer.slice(&slice, viewport, Kernel::Linear, SliceColors::Window { level: 50.0, width: 100.0 })?;
    /// assert_eq!(frame.pixel(16, 12)[3], 1.0);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// Invalid slices and colours, and failures of the device.
    pub fn slice(&mut self, slice: &Slice, viewport: Viewport, kernel: Kernel, colors: SliceColors) -> Result<Frame, Error> {
        colors.check()?;
        let pixels = self.draw_slice(slice, viewport, SlicePlan { kernel, shows: Shows::Colors(colors) })?;
        Ok(Frame::new(viewport, pixels))
    }

    /// The data values of a slice instead of colours.
    ///
    /// # Errors
    /// Those of [`slice`](Self::slice).
    pub fn slice_values(&mut self, slice: &Slice, viewport: Viewport, kernel: Kernel) -> Result<SliceValues, Error> {
        let pixels = self.draw_slice(slice, viewport, SlicePlan { kernel, shows: Shows::Values })?;
        let (rescale, offset) = (self.engine.base_field().description().rescale(), self.engine.base_field().offset());
        let value = |&[stored, _, _, inside]: &[f32; 4]| {
            if inside > 0.0 { rescale.value(f64::from(stored) + offset) as f32 } else { f32::NAN }
        };
        Ok(SliceValues::new(viewport, pixels.iter().map(value).collect()))
    }

    fn draw_slice(&mut self, slice: &Slice, viewport: Viewport, plan: SlicePlan) -> Result<Vec<[f32; 4]>, Error> {
        let rays = rays(slice, viewport, self.engine.base_field())?;
        // The edges of the field are those of the blend modes that take values; there is no light.
        let settings = Settings { blend: Blend::Average, shading: None, ..Settings::default() };
        self.engine.check_method(Method::Slices, settings.blend)?;
        let stage = self.engine.declaring(viewport, &settings, |declaring| Stage::new(vec![Step::Slice(plan)], false, declaring));
        let host_bytes = 2 * FLOATS * viewport.pixels() as u64;
        let frame =
            DeviceFrame { rays: &rays, viewport, settings: &settings, stages: vec![stage], volume: None, into: None, host_bytes };
        let read = |device: &Device, finished: &Finished| read_samples(finished.floats(), device, viewport.pixels());
        Ok(self.engine.run(&frame, Mode::Waited, read)?.0)
    }
}

/// Rays that begin on the plane and leave it along its normal.
fn rays(slice: &Slice, viewport: Viewport, field: &Field) -> Result<Rays, Error> {
    let (pixels, normal) = (slice.pixels(viewport)?, slice.normal()?);
    let (given, grid) = (field.description().grid(), field.grid());
    let to_voxels = given.world_to_voxel_linear();
    Ok(Rays {
        origin: [given.world_to_voxel(pixels.corner), to_voxels * pixels.right, to_voxels * pixels.down],
        direction: [to_voxels * -normal, DVec3::ZERO, DVec3::ZERO],
        start: f64::NEG_INFINITY,
        pixel_size: pixels.right.length() / field.world().unit(),
        to_eye: given.world_to_grid_axes() * normal,
        spacing: grid.spacing(),
    })
}
