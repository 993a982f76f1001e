//! Asynchronous frames, enqueued into the caller's memory.

use super::frame::{Frame, Mode, Output, Stage};
use super::picture::Finished;
use super::picture_memory::{PictureFormat, PictureMemory};
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

/// Size of the small pictures that [`Renderer::prepare`] renders along each axis.
const PREPARING: Viewport = Viewport { width: 16, height: 16 };

impl Renderer {
    /// Enqueues a frame into the caller's memory, after the events `wait`, and returns at once. The returned event completes when
    /// the picture is ready. Nothing is read back and no queue is waited for. Missing programs are built and missing tables are
    /// made during the call; [`prepare`](Self::prepare) does so in advance. In a new view of surfaces, the call waits until the device
    /// has counted their fragments, on a queue of the renderer's own, whatever the frame waits for.
    ///
    /// Frames of one renderer execute in order, on any kind of queue. Camera, transfer function and settings may change as soon
    /// as this returns.
    ///
    /// # Errors
    /// Sheets, which read back their number of splats; hundreds of translucent surfaces behind each other; memory that does not fit the
    /// picture; everything that [`render`](Self::render) rejects. After an error the queue remains usable and the picture is undefined.
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
        self.check_no_readback(&planned.plan)?;
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

    /// The steps of a frame into the caller's memory, and that memory if kernels can write to it directly.
    fn stage_onto<'a>(&self, planned: &'a Planned, onto: &PictureMemory) -> Result<(Stage<'a>, Option<Finished>), Error> {
        let (device, viewport) = (&self.engine.device, planned.viewport);
        let (output, direct) = match onto.format() {
            // The pictures of several lattices are added, which reads the picture, but the caller's memory may be write-only.
            // Without a lattice, or around surfaces, there is no warp that could write to it.
            PictureFormat::Floats if !matches!(planned.plan, Plan::Lattice(..)) || self.engine.has_surfaces() => {
                (Output::Floats, None)
            }
            PictureFormat::Floats => {
                (Output::Floats, onto.direct(device, viewport)?.map(|buffer| Finished::Floats(Arc::new(buffer))))
            }
            PictureFormat::Rgba8(background) => {
                (Output::Rgba8(background), onto.direct(device, viewport)?.map(|buffer| Finished::Rgba8(Arc::new(buffer))))
            }
        };
        let bound = direct.is_some();
        let stage = self
            .engine
            .declaring(viewport, &planned.settings, |declaring| Stage::from_plan(&planned.plan, output, bound, declaring));
        Ok((stage, direct))
    }

    /// Prepares frames like this one from all directions: builds programs, and makes layouts, min-max blocks and tables. Waits
    /// until all of them are ready.
    pub fn prepare(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
        self.render_rgba8(camera, viewport, settings, Background::Transparent)?;
        self.render(camera, viewport, settings)?;
        for camera in self.cameras_along_axes(camera, viewport) {
            self.render_rgba8(&camera, PREPARING, settings, Background::Transparent)?;
        }
        Ok(())
    }

    /// Cameras that look at the centre of the volume along each axis, with the pixel size of `camera`.
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

    /// Declares that the voxels in the caller's memory have changed. Data derived from them (occupancy, the layout of layer axis
    /// x, the B-spline coefficients) are made again by the next frame that needs them, on the device, in the same buffers, after
    /// the events `wait`. The returned event completes when those do; frames wait for it automatically.
    pub fn volume_changed(&mut self, wait: &[&Event]) -> Result<Event, Error> {
        self.engine.device.begin(wait)?;
        self.engine.field_mut().voxels_changed();
        self.engine.device.end()
    }

    /// Sets the scratch memory that enqueued frames write to: the lattice and, unless it goes directly into the caller's memory,
    /// the picture. A frame takes one buffer for each of its [sizes](Self::scratch_bytes). With no buffers the renderer allocates
    /// its own again. The buffers must not be shared with another renderer whose frames may execute at the same time.
    pub fn set_scratch(&mut self, buffers: &[DeviceMemory]) -> Result<(), Error> {
        let given = (!buffers.is_empty()).then(|| ScratchMemory::new(&self.engine.device, buffers));
        self.engine.scratch = given.transpose()?.map(Arc::new);
        Ok(())
    }

    /// Sizes in bytes of the [scratch](Self::set_scratch) buffers that a frame needs, in no particular order. In addition, a
    /// renderer keeps its own tables, occupancy, layouts and lists of surfaces.
    pub fn scratch_bytes(
        &self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        onto: &PictureMemory,
    ) -> Result<Vec<usize>, Error> {
        let planned = self.planned(camera, viewport, settings)?;
        self.check_no_readback(&planned.plan)?;
        let (stage, _) = self.stage_onto(&planned, onto)?;
        Ok(stage.resources.arena_buffers().map(|resource| resource.bytes as usize).collect())
    }

    /// Rejects frames that need host readback.
    fn check_no_readback(&self, plan: &Plan) -> Result<(), Error> {
        if !plan.counts_splats() {
            return Ok(());
        }
        let problem = "sheets read back their number of splats, so they cannot be enqueued without waiting: use `render`, or another algorithm";
        Err(Error::Settings { field: "algorithm", problem: problem.into() })
    }
}
