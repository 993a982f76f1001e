//! Frames that are enqueued and not waited for, into memory of the caller's own.

use super::frame::{Frame, Mode, Output, Stage};
use super::onto::{PictureFormat, PictureMemory};
use super::picture::Finished;
use super::plan::Plan;
use super::{Planned, Renderer};
use crate::camera::{Camera, Projection};
use crate::device::{DeviceMemory, ScratchMemory};
use crate::error::Error;
use crate::image::Background;
use crate::settings::Settings;
use crate::viewport::Viewport;
use glam::DVec3;
use opencl3::event::Event;
use std::sync::Arc;

/// Of the small pictures that [`Renderer::prepare`] renders along each axis.
const PREPARING: Viewport = Viewport { width: 16, height: 16 };

impl Renderer {
    /// Enqueues a frame into memory of the caller's own, after `wait`, and returns at once: with the event that is complete when the
    /// picture is there. Nothing is read back and no queue is waited for. Kernels that were not built yet are, and tables that were not
    /// made; [`prepare`](Self::prepare) does that beforehand.
    ///
    /// Frames of one renderer come one after the other, on any queue. Camera, transfer function and settings may change as soon as this
    /// returns.
    ///
    /// # Errors
    /// Sheets, which read back how many splats they have; memory that the picture does not fit; all that [`render`](Self::render)
    /// refuses. What was enqueued before an error leaves the queue usable and the picture undefined.
    pub fn enqueue(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        onto: &PictureMemory,
        wait: &[&Event],
    ) -> Result<Event, Error> {
        onto.check(&self.engine.device, viewport)?;
        let planned = self.planned(camera, viewport, settings)?;
        check_reads_nothing(&planned.plan)?;
        tracing::debug!("{}", planned.plan);
        let (stage, direct) = self.stage_onto(&planned, onto)?;
        let Planned { rays, viewport, settings, .. } = &planned;
        let frame =
            Frame { rays, viewport: *viewport, settings, stages: vec![stage], volume: None, into: direct.clone(), host_bytes: 0 };
        let (event, _) = self.engine.run(&frame, Mode::Enqueued(wait), |device, finished| {
            match (&direct, onto.format()) {
                (Some(_), _) => {}
                (None, PictureFormat::Floats) => onto.copy(device, finished.floats(), *viewport)?,
                (None, PictureFormat::Rgba8(_)) => onto.copy(device, finished.rgba8(), *viewport)?,
            }
            device.end()
        })?;
        Ok(event)
    }

    /// The steps of a frame into memory of the caller, and that memory where kernels can write it directly.
    fn stage_onto<'a>(&self, planned: &'a Planned, onto: &PictureMemory) -> Result<(Stage<'a>, Option<Finished>), Error> {
        let (device, viewport) = (&self.engine.device, planned.viewport);
        let (output, direct) = match onto.format() {
            // Several lattices add up to a picture, and the memory may be write-only; without a lattice nothing is warped.
            PictureFormat::Floats if !matches!(planned.plan, Plan::Lattice(..)) => (Output::Floats, None),
            PictureFormat::Floats => {
                (Output::Floats, onto.direct(device, viewport)?.map(|buffer| Finished::Floats(Arc::new(buffer))))
            }
            PictureFormat::Rgba8(background) => {
                (Output::Rgba8(background), onto.direct(device, viewport)?.map(|buffer| Finished::Rgba8(Arc::new(buffer))))
            }
        };
        let bound = direct.is_some();
        let stage = self.engine.declaring(viewport, |declaring| Stage::of_plan(&planned.plan, output, bound, declaring));
        Ok((stage, direct))
    }

    /// Makes what frames like this one need, from any side: kernels are built; layouts, blocks and tables are made. It waits until all of
    /// it is there.
    pub fn prepare(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.render_rgba8(camera, viewport, settings, Background::Transparent)?;
        self.render(camera, viewport, settings)?;
        for camera in self.cameras_along_axes(camera, viewport) {
            self.render_rgba8(&camera, PREPARING, settings, Background::Transparent)?;
        }
        Ok(())
    }

    /// What a camera would see of the middle of the volume along each axis, in pixels as large as its own.
    fn cameras_along_axes(&self, camera: &Camera, viewport: Viewport) -> [Camera; 3] {
        let centre = self.grid().centre();
        let distance = camera.position.distance(camera.focal_point).max(self.grid().diagonal());
        let part = f64::from(PREPARING.height) / f64::from(viewport.height);
        let projection = match camera.projection {
            Projection::Parallel { scale } => Projection::Parallel { scale: scale * part },
            Projection::Perspective { field_of_view } => {
                let half = (field_of_view.to_radians() / 2.0).tan() * part;
                Projection::Perspective { field_of_view: 2.0 * half.atan().to_degrees() }
            }
        };
        DVec3::AXES.map(|axis| Camera {
            position: centre + distance * axis,
            focal_point: centre,
            view_up: axis.any_orthogonal_vector(),
            projection,
        })
    }

    /// The voxels have changed, where they are in memory of the caller's own: what is made of them (occupancy, the layout of layer axis x,
    /// the B-spline's coefficients) is made again by the next frame that needs it, on the device and in the same buffers, after `wait`.
    /// Returns an event that is complete when `wait` is; frames wait for it by themselves.
    pub fn volume_changed(&mut self, wait: &[&Event]) -> Result<Event, Error> {
        self.engine.device.begin(wait)?;
        self.engine.field.voxels_changed();
        self.engine.device.end()
    }

    /// Gives memory for what enqueued frames write: the lattice and, where that does not go straight into the caller's memory, the
    /// picture. A frame takes a buffer for each of the [sizes that it needs](Self::scratch_bytes); no buffers, and it makes its own
    /// again. They must not be given to another renderer whose frames may be drawn at the same time.
    pub fn set_scratch(&mut self, buffers: &[DeviceMemory]) -> Result<(), Error> {
        let given = (!buffers.is_empty()).then(|| ScratchMemory::new(&self.engine.device, buffers));
        self.engine.scratch = given.transpose()?.map(Arc::new);
        Ok(())
    }

    /// Bytes of each buffer of [scratch](Self::set_scratch) that a frame needs, in no order. Besides, a renderer keeps tables, occupancy
    /// and layouts of its own.
    pub fn scratch_bytes(
        &self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        onto: &PictureMemory,
    ) -> Result<Vec<usize>, Error> {
        let planned = self.planned(camera, viewport, settings)?;
        check_reads_nothing(&planned.plan)?;
        let (stage, _) = self.stage_onto(&planned, onto)?;
        Ok(stage.resources.of_arena().map(|resource| resource.bytes as usize).collect())
    }
}

/// Refuses what has to read from the device what it goes on with.
fn check_reads_nothing(plan: &Plan) -> Result<(), Error> {
    let (Plan::AxisSheets(_) | Plan::ViewSheets(_)) = plan else { return Ok(()) };
    let problem =
        "sheets read back how many splats they have, which takes a queue that is waited for: use `render`, or another algorithm";
    Err(Error::Settings { field: "algorithm", problem: problem.into() })
}
