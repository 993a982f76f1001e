//! Orchestrates a frame: what is kept between frames, what is planned, which kernels run in which order.

mod algorithm;
mod direct;
mod frame;
mod kept;
mod kernels;
mod lattice;
mod march;
mod plan;
mod points;
mod sample;
mod scratch;
mod screen;
mod settings;
mod sheets;
mod splat_list;
mod splats;
mod tables;

pub use algorithm::Algorithm;
pub use frame::{FrameReport, LatticePicture, LatticeReport};
pub use plan::Plan;
pub use settings::{Classification, Evaluation, Footprints, LayerAxis, Quality, Settings, Shading};

use crate::camera::Camera;
use crate::device::Device;
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::layers::{Rays, Viewport};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Volume};
use kept::Kept;
use kernels::Kernels;
use scratch::Scratch;

/// Renders one volume on one device.
///
/// The voxels live on the device, and what can be kept is kept: the layout and occupancy of each layer axis from its
/// first use, tables from one transfer function to the next, buffers from frame to frame.
pub struct Renderer {
    device: Device,
    grid: Grid,
    value_range: (f64, f64),
    field_range: (f64, f64),
    transfer: TransferFunction,
    kernels: Kernels,
    kept: Kept,
    scratch: Scratch,
}

impl Renderer {
    /// Uploads a volume, to be seen through a transfer function.
    pub fn new(device: &Device, volume: &Volume, transfer: &TransferFunction) -> Result<Self, Error> {
        Ok(Self {
            device: device.clone(),
            grid: volume.grid().clone(),
            value_range: volume.range(),
            field_range: volume.field_range(),
            transfer: transfer.clone(),
            kernels: Kernels::new(volume.voxels().voxel_type()),
            kept: Kept::upload(device, volume)?,
            scratch: Scratch::default(),
        })
    }

    /// Takes another transfer function from the next frame on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.transfer = transfer.clone();
        self.kept.forget_transfer();
    }

    /// The transfer function in use.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.transfer
    }

    /// Where the volume's voxels lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Renders a picture: premultiplied floats, without a background.
    pub fn render(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Frame, FrameReport), Error> {
        let drawn = self.draw(camera, viewport, settings)?;
        self.draw_frame(&drawn, viewport)?;
        let frame = self.scratch.read_frame(&self.device, viewport)?;
        Ok((frame, self.finish(drawn.report)?))
    }

    /// Renders a finished 8-bit RGBA picture, row by row, row 0 on top.
    pub fn render_rgba8(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        background: Background,
    ) -> Result<(Vec<u8>, FrameReport), Error> {
        let drawn = self.draw(camera, viewport, settings)?;
        let picture = self.draw_picture(&drawn, viewport, background)?;
        Ok((picture, self.finish(drawn.report)?))
    }

    /// The composited lattice before it is warped to the screen, with the ray of each sample; `None` where the view has
    /// no lattice. Where axes share a picture, that of the most parallel one.
    pub fn lattice_picture(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<Option<LatticePicture>, Error> {
        let rays = Rays::new(camera, viewport, &self.grid)?;
        let plan = match Plan::new(&rays, viewport, &self.grid, settings)? {
            Plan::Shared(mut parts) => parts.swap_remove(0).0,
            plan => plan,
        };
        let report = self.run(&plan, &rays, viewport, settings)?;
        let picture = self.read_lattice(plan)?;
        self.finish(report)?;
        Ok(picture)
    }

    fn run(&mut self, plan: &Plan, rays: &Rays, viewport: Viewport, settings: &Settings) -> Result<FrameReport, Error> {
        match (plan, settings.classification) {
            (Plan::Lattice(lattice), Classification::Post(correction)) => {
                self.run_lattice(lattice, correction, rays, settings)?
            }
            (Plan::Perspective(lattice), Classification::Post(correction)) => {
                self.run_perspective(lattice, correction, rays, settings)?;
            }
            (Plan::Lattice(_) | Plan::Perspective(_), Classification::Preintegrated { .. }) => {
                self.run_points(plan, rays, settings)?;
            }
            (Plan::Direct(axis), Classification::Post(correction)) => {
                self.run_direct(*axis, correction, rays, viewport, settings)?;
            }
            (Plan::Direct(axis), Classification::Preintegrated { .. }) => {
                self.run_point_direct(*axis, rays, viewport, settings)?
            }
            (Plan::Raycast(interpolation, step), _) => {
                let (interpolation, step) = (*interpolation, *step);
                // Also where layers are asked for and no lattice reaches.
                let settings = Settings { algorithm: Algorithm::Raycast { interpolation, step }, ..*settings };
                self.run_raycast(interpolation, step, rays, viewport, &settings)?
            }
            (Plan::Shared(_), _) => unreachable!("draw() takes its parts one by one"),
            (Plan::Stretches(step), _) => self.run_stretches(*step, rays, viewport, settings)?,
            (Plan::Slicing(step), _) => self.run_slicing(*step, rays, viewport, settings)?,
            (Plan::AxisSheets(axis), _) => self.run_axis_sheets(*axis, rays, viewport, settings)?,
            (Plan::ViewSheets(distance), _) => self.run_view_sheets(*distance, rays, viewport, settings)?,
        }
        Ok(FrameReport::new(plan))
    }
}
