//! Frames that are enqueued and not waited for, into memory of the caller's own.

use super::onto::{PictureFormat, PictureMemory};
use super::picture::FLOATS;
use super::plan::Plan;
use super::scene::View;
use super::tiles::Tiles;
use super::{Drawn, Renderer};
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
        let device = self.device.with_scratch(self.scratch.clone());
        onto.check(&device, viewport)?;
        let (rays, settings) = self.seen(camera, viewport, settings)?;
        let plan = Plan::new(&rays, viewport, self.prepared.grid(), &settings)?;
        check_reads_nothing(&plan)?;
        if let Some(scratch) = device.scratch() {
            scratch.begin();
        }
        self.require_room(&device, &plan, viewport, matches!(onto.format(), PictureFormat::Rgba8(_)))?;
        self.begin(wait)?;
        let view = View { device: &device, rays: &rays, viewport, settings: &settings };
        let (drawn, _) = self.draw(view, &plan)?;
        self.deliver(view, &drawn, onto)?;
        device.end()
    }

    /// Brings what was drawn to where the caller wants it.
    fn deliver(&mut self, view: View, drawn: &Drawn, onto: &PictureMemory) -> Result<(), Error> {
        let View { device, viewport, .. } = view;
        match onto.format() {
            PictureFormat::Floats => {
                let direct = onto.direct(device, viewport)?;
                let floats = self.floats(view, drawn, direct.as_ref())?;
                if direct.as_ref().is_some_and(|direct| std::ptr::eq(direct, floats)) {
                    return Ok(());
                }
                onto.copy(device, floats, viewport)
            }
            PictureFormat::Rgba8(background) => {
                let direct = onto.direct(device, viewport)?;
                let displayed = self.displayed(view, drawn, background, direct.as_ref())?;
                if direct.is_some() { Ok(()) } else { onto.copy(device, displayed, viewport) }
            }
        }
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
        let centre = self.grid.centre();
        let distance = camera.position.distance(camera.focal_point).max(self.grid.diagonal());
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
        self.begin(wait)?;
        self.prepared.voxels_changed();
        self.device.end()
    }

    /// Gives memory for what enqueued frames write: the lattice and, where that does not go straight into the caller's memory, the
    /// picture. A frame takes a buffer for each of the [sizes that it needs](Self::scratch_bytes); no buffers, and it makes its own
    /// again. They must not be given to another renderer whose frames may be drawn at the same time.
    pub fn set_scratch(&mut self, buffers: &[DeviceMemory]) -> Result<(), Error> {
        let given = (!buffers.is_empty()).then(|| ScratchMemory::new(&self.device, buffers));
        self.scratch = given.transpose()?.map(Arc::new);
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
        let (rays, settings) = self.seen(camera, viewport, settings)?;
        let plan = Plan::new(&rays, viewport, self.prepared.grid(), &settings)?;
        check_reads_nothing(&plan)?;
        let direct = onto.direct::<u8>(&self.device, viewport)?.is_some();
        let tuning = self.device.tuning();
        let pixels = viewport.pixels();
        let targets = match &plan {
            Plan::Lattice(lattice, layered) => {
                vec![(lattice.samples(), Tiles::of_lattice(lattice, layered.classification, tuning))]
            }
            Plan::Shared(parts, layered) => {
                parts.iter().map(|(l, _)| (l.samples(), Tiles::of_lattice(l, layered.classification, tuning))).collect()
            }
            Plan::Direct(..) => vec![(pixels, Tiles::of_pixels(viewport))],
            _ => vec![(pixels, Tiles::of_screen(viewport, tuning))],
        };
        // A lattice goes where the one before was, unless it is larger.
        let mut needed = Vec::new();
        let [mut samples, mut counts] = [0; 2];
        for (more, tiles) in targets {
            needed.extend((more > samples).then_some(more * FLOATS as usize));
            needed.extend((tiles.all_counts() > counts).then_some(tiles.all_counts() * size_of::<u32>()));
            (samples, counts) = (samples.max(more), counts.max(tiles.all_counts()));
        }
        needed.extend(matches!(plan, Plan::Shared(..)).then_some(pixels * FLOATS as usize));
        let drawn_as_it_is = onto.format() == PictureFormat::Floats && !matches!(plan, Plan::Lattice(..));
        needed.extend((!direct && !drawn_as_it_is).then_some(pixels * onto.format().bytes()));
        Ok(needed)
    }
}

/// Refuses what has to read from the device what it goes on with.
fn check_reads_nothing(plan: &Plan) -> Result<(), Error> {
    let (Plan::AxisSheets(_) | Plan::ViewSheets(_)) = plan else { return Ok(()) };
    let problem =
        "sheets read back how many splats they have, which takes a queue that is waited for: use `render`, or another algorithm";
    Err(Error::Settings { field: "algorithm", problem: problem.into() })
}
