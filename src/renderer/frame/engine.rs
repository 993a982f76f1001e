//! Runs frames: begin, steps, deliver, report. Every way to a picture goes through [`Engine::run`].

use super::super::classification::{Classification, PreparationKernels, SegmentNeeds, TableSizes};
use super::super::field::{Field, UploadedVolume};
use super::super::layered::{PointLayers, SplatLayers};
use super::super::picture::{Finished, OntoScreen, Picture, bind};
use super::super::plan::Plan;
use super::super::range::LayerRange;
use super::super::rays::{Gathers, MarchedRays};
use super::super::report::{Measured, Statistics};
use super::super::scene::{Scene, View};
use super::super::sheets::{AxisAlignedSheets, ImageAlignedSheets};
use super::super::tiles::Target;
use super::declaring::Declaring;
use super::resources::Resources;
use super::steps::{Stage, Step};
use crate::device::{Device, Limits, Rehearsal, ScratchMemory};
use crate::error::Error;
use crate::layers::{Lattice, Rays};
use crate::settings::{self, Layered, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Held, Rescale, Stored as StoredNumbers, Volume};
use opencl3::event::Event;
use std::sync::Arc;

/// Everything that frames of one renderer use, from one frame to the next.
pub(in crate::renderer) struct Engine {
    pub device: Device,
    pub field: Field,
    pub classification: Classification,
    kernels: PreparationKernels,
    passes: Passes,
    target: Target,
    /// Whether reports say what frames took.
    pub measuring: bool,
    pub limits: Limits,
    /// Whether general programs draw while the best ones are being built.
    pub general_programs: bool,
    /// The caller's memory for what enqueued frames write.
    pub scratch: Option<Arc<ScratchMemory>>,
}

#[derive(Default)]
struct Passes {
    points: PointLayers,
    splats: SplatLayers,
    rays: MarchedRays,
    axis_sheets: AxisAlignedSheets,
    view_sheets: ImageAlignedSheets,
    picture: Picture,
}

/// What tables depend on of a field.
#[derive(PartialEq)]
struct Numbers {
    stored: StoredNumbers,
    rescale: Rescale,
    range_is_declared: bool,
}

impl Numbers {
    fn of(field: &Field) -> Self {
        let rescale = field.description().rescale();
        Self { stored: field.stored(), rescale, range_is_declared: field.range_is_declared() }
    }
}

/// A frame to be run.
pub(in crate::renderer) struct Frame<'a> {
    pub rays: &'a Rays,
    pub viewport: Viewport,
    /// In the world of frames.
    pub settings: &'a Settings,
    /// One after the other; buffers of the one before make room, but for the picture in floats.
    pub stages: Vec<Stage<'a>>,
    /// Where voxels are read from that do not fit on the device.
    pub volume: Option<&'a Volume<'a>>,
    /// Memory of the caller that the picture goes to.
    pub into: Option<Finished>,
    /// Bytes that the picture needs on the host.
    pub host_bytes: u64,
}

/// Whether a frame is waited for.
#[derive(Clone, Copy)]
pub(in crate::renderer) enum Mode<'a> {
    /// It is measured if that was asked for, and has limits.
    Waited,
    /// It comes after these events.
    Enqueued(&'a [&'a Event]),
}

impl Engine {
    /// Renders a field, which others may share, on the device of an uploaded volume.
    pub fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let field = volume.field.for_renderer();
        Self {
            device: volume.device.with_own_sequence(),
            classification: Classification::new(transfer, field.description().rescale()),
            field,
            kernels: PreparationKernels::default(),
            passes: Passes::default(),
            target: Target::default(),
            measuring: false,
            limits: Limits::default(),
            general_programs: false,
            scratch: None,
        }
    }

    /// An engine of the same field and transfer function whose frames are not drawn, and the kernels that they would start. `needs`: of
    /// segments, in place of what the transfer function needs.
    pub fn for_rehearsal(&self, needs: Option<SegmentNeeds>) -> (Self, Arc<Rehearsal>) {
        let (device, rehearsal) = self.device.with_own_sequence().rehearsing();
        let engine = Self {
            device,
            field: self.field.for_rehearsal(),
            classification: self.classification.for_rehearsal(needs),
            kernels: PreparationKernels::default(),
            passes: Passes::default(),
            target: Target::default(),
            measuring: false,
            limits: Limits::default(),
            general_programs: self.general_programs,
            scratch: None,
        };
        (engine, rehearsal)
    }

    /// Exchanges the field for one on the same device. Device programs stay; tables are made again where the range differs.
    pub fn set_field(&mut self, volume: &UploadedVolume) -> Result<(), Error> {
        if volume.device.context() != self.device.context() {
            let problem = "is on a device of another context than the renderer".into();
            return Err(Error::Memory { what: "the uploaded volume", problem });
        }
        let before = Numbers::of(&self.field);
        self.field = volume.field.for_renderer();
        self.reclassify(before);
        Ok(())
    }

    /// Uploads other voxels in place of the field's.
    pub fn replace_field(&mut self, held: &Held) -> Result<(), Error> {
        self.device.begin(&[])?;
        let before = Numbers::of(&self.field);
        let room = held.dims().iter().product();
        let replaced = self.field.replace(&self.device, held, room);
        self.reclassify(before);
        replaced
    }

    /// Makes tables for the numbers of the field, unless they are those before.
    fn reclassify(&mut self, before: Numbers) {
        if Numbers::of(&self.field) != before {
            self.classification.set_field(&self.field);
        }
    }

    /// Takes another transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.classification.set_transfer_function(transfer, self.field.description().rescale());
    }

    /// Calls `declare` with the sizes that frames of this engine have.
    pub fn declaring<T>(&self, viewport: Viewport, declare: impl FnOnce(&Declaring) -> T) -> T {
        let tables = &TableSizes::of(&self.classification, &self.field);
        declare(&Declaring { shape: self.field.shape(), tables, tuning: self.device.tuning(), viewport })
    }

    /// Runs a frame; `deliver` takes its picture from the device. Returns what that returned, and what the frame took, if that is measured.
    ///
    /// Where device memory is short, everything that earlier frames left is dropped and the frame begins anew. Streamed frames cannot: the
    /// voxels that they began with are gone.
    pub fn run<T>(
        &mut self,
        frame: &Frame,
        mode: Mode,
        deliver: impl FnOnce(&Device, &Finished) -> Result<T, Error>,
    ) -> Result<(T, Statistics), Error> {
        let (device, drawn) = match self.draw(frame, mode) {
            Err(error) if frame.volume.is_none() && error.is_lack_of_device_memory() => {
                self.make_room();
                tracing::debug!("{error}; trying again without what earlier frames left");
                self.draw(frame, mode)?
            }
            drawn => drawn?,
        };
        let delivered = deliver(&device, &drawn.finished)?;
        let measured = match drawn.active_samples {
            Some(active_samples) => Some(Measured { stages: device.stage_times()?, active_samples }),
            None => None,
        };
        Ok((delivered, Statistics { measured, general_program: device.used_general_program() }))
    }

    /// The handle of a frame, whose commands begin now: what a failed frame leaves behind, no other sees.
    fn begin(&self, mode: Mode) -> Result<Device, Error> {
        match mode {
            Mode::Waited => {
                self.device.begin(&[])?;
                let device = if self.measuring { self.device.timed() } else { self.device.clone() };
                Ok(device.with_limits(&self.limits).with_general_programs(self.general_programs))
            }
            Mode::Enqueued(wait) => {
                let device = self.device.with_scratch(self.scratch.clone());
                if let Some(scratch) = device.scratch() {
                    scratch.begin();
                }
                device.begin(wait)?;
                Ok(device)
            }
        }
    }

    fn draw(&mut self, frame: &Frame, mode: Mode) -> Result<(Device, Done), Error> {
        let device = self.begin(mode)?;
        let measuring = self.measuring && matches!(mode, Mode::Waited);
        let view = View { device: &device, rays: frame.rays, viewport: frame.viewport, settings: frame.settings };
        let mut done = Done { finished: Finished::Nothing, active_samples: measuring.then_some(0) };
        for (n, stage) in frame.stages.iter().enumerate() {
            tracing::debug!("{}", stage.resources);
            if n > 0 {
                self.field.make_room();
                self.classification.make_room();
                self.target.keep_picture();
            }
            self.require(&device, frame, &stage.resources)?;
            self.target.arena.reserve(&device, &stage.resources)?;
            if let Some(into) = &frame.into {
                bind(&mut self.target, into.clone());
            }
            for step in &stage.steps {
                self.step(view, frame, step, &mut done)?;
            }
        }
        Ok((device, done))
    }

    /// Refuses a frame whose buffers do not fit into memory, before any of them is made.
    fn require(&self, device: &Device, frame: &Frame, resources: &Resources) -> Result<(), Error> {
        let Viewport { width, height } = frame.viewport;
        let missing = self.target.arena.missing(device, resources);
        device.require_within_budget(&format!("a picture of {width}x{height}"), missing, frame.host_bytes)
    }

    fn step(&mut self, view: View, frame: &Frame, step: &Step, done: &mut Done) -> Result<(), Error> {
        let View { device, rays, viewport, .. } = view;
        match *step {
            Step::Hold { voxels, room } => {
                let volume = frame.volume.expect("only streamed frames exchange voxels");
                let part = volume.part(voxels.first, voxels.dims)?;
                self.field.replace(device, &part.held(), room)?;
            }
            Step::Continue(samples) => self.target.fill(device, samples)?,
            Step::Layers { lattice, layered, ref range } => {
                self.draw_layers(view, lattice, layered, range)?;
                self.count(device, done)?;
                done.finished = Finished::Floats(self.target.drawn().samples);
            }
            Step::Screen(plan, gathers) => {
                self.draw_screen(view, plan, gathers)?;
                self.count(device, done)?;
                done.finished = Finished::Floats(self.target.drawn().samples);
            }
            Step::Warp { lattice, share } => {
                let onto = OntoScreen { lattice, rays, viewport };
                done.finished = self.passes.picture.warp(device, &self.target, onto, share)?;
            }
            Step::WarpDisplayed { lattice, background } => {
                let onto = OntoScreen { lattice, rays, viewport };
                done.finished = self.passes.picture.warp_displayed(device, &self.target, onto, background)?;
            }
            Step::Present(background) => {
                let Finished::Floats(floats) = &done.finished else { unreachable!("floats are displayed") };
                done.finished = self.passes.picture.present(device, &self.target, floats, viewport, background)?;
            }
        }
        Ok(())
    }

    /// Adds the samples with opacity of what was just drawn, if the frame is measured.
    fn count(&self, device: &Device, done: &mut Done) -> Result<(), Error> {
        if let Some(active_samples) = &mut done.active_samples {
            *active_samples += self.target.count_active(device)?;
        }
        Ok(())
    }

    fn draw_layers(&mut self, view: View, lattice: &Lattice, layered: Layered, range: &LayerRange) -> Result<(), Error> {
        let Self { field, classification, kernels, passes, target, .. } = self;
        let scene = &mut Scene::new(view, field, classification, kernels);
        match layered.classification {
            settings::Classification::Post(correction) => passes.splats.draw_lattice(scene, lattice, correction, range, target),
            settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                passes.points.draw_lattice(scene, lattice, (kernel, samples_per_layer), layered.evaluation, range, target)
            }
        }
    }

    fn draw_screen(&mut self, view: View, plan: &Plan, gathers: Gathers) -> Result<(), Error> {
        let Self { field, classification, kernels, passes, target, .. } = self;
        let scene = &mut Scene::new(view, field, classification, kernels);
        match *plan {
            Plan::Direct(axis, layered) => match layered.classification {
                settings::Classification::Post(correction) => {
                    passes.splats.draw_pixels(scene, axis, correction, layered.footprints, target)
                }
                settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                    passes.points.draw_pixels(scene, axis, (kernel, samples_per_layer), target)
                }
            },
            Plan::Raycast(kernel, step) => passes.rays.cast(scene, kernel, step, gathers, target),
            Plan::CastValues(kernel, step) => passes.rays.cast_values(scene, kernel, step, gathers, target),
            Plan::CastSegments(kernel, step) => passes.rays.cast_segments(scene, kernel, step, target),
            Plan::Slicing(step) => passes.rays.slice(scene, step, target),
            Plan::AxisSheets(axis) => passes.axis_sheets.draw(scene, axis, target),
            Plan::ViewSheets(distance) => passes.view_sheets.draw(scene, distance, target),
            Plan::Lattice(..) | Plan::Shared(..) => unreachable!("lattices are drawn in layers"),
        }
    }

    /// Drops what earlier frames left on the device but the voxels.
    fn make_room(&mut self) {
        self.field.make_room();
        self.classification.make_room();
        self.target.arena.clear();
    }
}

/// What the steps of a frame have done so far.
struct Done {
    finished: Finished,
    /// Samples with opacity, where they are counted.
    active_samples: Option<u64>,
}
