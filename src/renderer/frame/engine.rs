//! Runs frames: begin, steps, deliver, report. All render paths go through [`Engine::run`].

use super::super::channels::{Channel, Fields};
use super::super::classification::{Classification, PreparationKernels};
use super::super::colors::UploadedColors;
use super::super::field::{Field, UploadedVolume};
use super::super::label_colors::LabelColors;
use super::super::layered::{PointLayers, SplatLayers};
#[cfg(test)]
use super::super::light::Illumination;
use super::super::light::LightVolumes;
#[cfg(test)]
use super::super::light::ScatterGrids;
use super::super::picture::{Finished, Picture, WarpInputs, bind};
use super::super::plan::Plan;
use super::super::range::LayerRange;
use super::super::rays::{MarchedRays, RayOutput};
use super::super::report::{Measured, Statistics};
use super::super::scene::{Scene, View};
use super::super::slice_pass::Slices;
use super::super::surfaces::{Pending, SurfacePass, UploadedSurfaces};
use super::super::tiles::Target;
use super::declaring::{DeclaredLight, Declaring};
use super::resources::Resources;
use super::steps::{Stage, Step, between, drawn_by};
use crate::camera::Camera;
use crate::device::launch::structs::Float4;
use crate::device::{Buffer, Device, Limits, Rehearsal, ScratchMemory};
use crate::error::Error;
use crate::layers::{Lattice, Rays};
use crate::settings::{self, Blend, FieldKind, Layered, Method, Settings};
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Held, Volume};
use opencl3::event::Event;
use std::sync::Arc;

/// State of a renderer that is reused across frames.
pub(in crate::renderer) struct Engine {
    pub device: Device,
    fields: Fields,
    kernels: PreparationKernels,
    light: LightVolumes,
    passes: Passes,
    target: Target,
    pub surfaces: Option<Arc<UploadedSurfaces>>,
    /// Whether reports include frame statistics.
    pub measuring: bool,
    pub limits: Limits,
    /// Whether general programs render while the specialised ones are being built.
    pub general_programs: bool,
    /// The caller's scratch memory for enqueued frames.
    pub scratch: Option<Arc<ScratchMemory>>,
}

#[derive(Default)]
struct Passes {
    points: PointLayers,
    splats: SplatLayers,
    rays: MarchedRays,
    #[cfg(feature = "paper")]
    paper: super::super::paper::PaperPasses,
    slices: Slices,
    surfaces: SurfacePass,
    picture: Picture,
}

/// A frame to run.
pub(in crate::renderer) struct Frame<'a> {
    pub rays: &'a Rays,
    pub viewport: Viewport,
    /// In normalised world units.
    pub settings: &'a Settings,
    /// Stages run in sequence. Each frees the buffers of the previous one, except the float picture.
    pub stages: Vec<Stage<'a>>,
    /// Source of the voxels of a streamed frame.
    pub volume: Option<&'a Volume<'a>>,
    /// The caller's memory that receives the picture.
    pub into: Option<Finished>,
    /// Bytes of the picture on the host.
    pub host_bytes: u64,
}

/// Whether the caller waits for a frame.
#[derive(Clone, Copy)]
pub(in crate::renderer) enum Mode<'a> {
    /// The frame has limits, and is measured if measuring is enabled.
    Waited,
    /// The frame executes after these events.
    Enqueued(&'a [&'a Event]),
}

impl Engine {
    /// An engine for an uploaded volume. Other engines may share its field.
    pub fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        Self {
            device: volume.device.with_own_sequence(),
            fields: Fields::new(volume, transfer),
            kernels: PreparationKernels::default(),
            light: LightVolumes::default(),
            passes: Passes::default(),
            target: Target::default(),
            surfaces: None,
            measuring: false,
            limits: Limits::default(),
            general_programs: false,
            scratch: None,
        }
    }

    /// An engine of the same fields and transfer function that records the kernels its frames would launch. `dimmed` replaces
    /// that need of the transfer function's integrals.
    pub fn for_rehearsal(&self, dimmed: Option<bool>) -> (Self, Arc<Rehearsal>) {
        let (device, rehearsal) = self.device.with_own_sequence().rehearsing();
        let engine = Self {
            device,
            fields: self.fields.for_rehearsal(dimmed),
            kernels: PreparationKernels::default(),
            light: LightVolumes::default(),
            passes: Passes::default(),
            target: Target::default(),
            surfaces: None,
            measuring: false,
            limits: Limits::default(),
            general_programs: self.general_programs,
            scratch: None,
        };
        (engine, rehearsal)
    }

    /// Replaces the field by one on the same device. Device programs are kept; tables are made again if the range differs.
    pub fn set_field(&mut self, volume: &UploadedVolume) -> Result<(), Error> {
        self.require_context(volume)?;
        self.fields.set_first(volume)
    }

    /// Replaces the surfaces.
    pub fn set_surfaces(&mut self, surfaces: &[Surface]) -> Result<(), Error> {
        // Before the new ones: there may not be enough memory for both.
        self.surfaces = None;
        self.surfaces = UploadedSurfaces::new(&self.device, surfaces)?.map(Arc::new);
        if self.surfaces.is_none() {
            self.passes.surfaces.drop_cached();
        }
        Ok(())
    }

    /// Whether frames have surfaces.
    pub fn has_surfaces(&self) -> bool {
        self.surfaces.is_some()
    }

    fn require_context(&self, volume: &UploadedVolume) -> Result<(), Error> {
        self.require_own_context(&volume.device, "the uploaded volume")
    }

    fn require_own_context(&self, device: &Device, what: &'static str) -> Result<(), Error> {
        if device.context() == self.device.context() {
            return Ok(());
        }
        Err(Error::Memory { what, problem: "is on a device of another context than the renderer".into() })
    }

    /// Replaces all fields.
    pub fn set_channels(&mut self, channels: &[Channel]) -> Result<(), Error> {
        channels.iter().try_for_each(|channel| self.require_context(&channel.volume))?;
        self.device.begin(&[])?;
        self.fields.set(channels, &mut self.kernels, &self.device)
    }

    /// Replaces all fields by colours.
    pub fn set_colors(&mut self, colors: &UploadedColors) -> Result<(), Error> {
        self.require_context(&colors.visibility().0)?;
        self.fields.set_colors(colors);
        Ok(())
    }

    /// Draws the first field in the colours of labels, or in its own.
    pub fn set_label_colors(&mut self, colors: Option<&LabelColors>) -> Result<(), Error> {
        colors.map_or(Ok(()), |colors| self.require_own_context(&colors.device, "the colours of labels"))?;
        self.fields.set_label_colors(colors)
    }

    /// The field of the renderer's volume.
    pub fn field(&self) -> &Field {
        &self.fields.first.field
    }

    pub fn field_mut(&mut self) -> &mut Field {
        &mut self.fields.first.field
    }

    /// The first visible field: frames have its grid and its world units.
    pub fn base_field(&self) -> &Field {
        self.fields.base()
    }

    /// The classification of that field.
    pub fn classification(&self) -> &Classification {
        &self.fields.first.classification
    }

    /// Rays and settings of a view of the visible fields, in normalised units.
    pub fn normalised_view(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(Rays, Settings), Error> {
        let base = self.base_field();
        let (rays, settings) = base.world().normalised_view(base.grid(), camera, viewport, settings)?;
        Ok((rays, self.fields.settings(settings)?))
    }

    /// Fails for a method that does not draw the visible fields with a blend mode.
    pub fn check_method(&self, method: Method, blend: Blend) -> Result<(), Error> {
        self.fields.kind(blend).check_method(method, blend)
    }

    /// Uploads other voxels to replace those of the field.
    pub fn replace_field(&mut self, held: &Held) -> Result<(), Error> {
        self.device.begin(&[])?;
        self.fields.replace_first(&self.device, held)
    }

    /// Replaces the transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.fields.first.set_transfer_function(transfer);
    }

    /// Largest steepness of the transfer functions over the values of the whole volume.
    pub fn steepness(&self) -> f64 {
        self.fields.steepness()
    }

    /// Calls `declare` with the sizes of this engine's frames.
    pub fn declaring<T>(&self, viewport: Viewport, settings: &Settings, declare: impl FnOnce(&Declaring) -> T) -> T {
        let fields = self.fields.sizes();
        let (shape, tables) = &fields[0];
        let kind = self.fields.kind(settings.blend);
        let light = DeclaredLight::new(settings, self.field().grid());
        declare(&Declaring {
            shape: *shape,
            tables,
            others: &fields[1..],
            channel: 0,
            is_tiled: self.fields.are_tiled(settings.blend),
            tuning: self.device.tuning(),
            viewport,
            gradient: settings.needed_gradient(),
            surfaces: self.surfaces.as_deref().map(UploadedSurfaces::sizes),
            light: light.map(|light| DeclaredLight { of_colors: matches!(kind, FieldKind::Colors | FieldKind::Labels), ..light }),
        })
    }

    /// Runs a frame; `deliver` reads its picture from the device. Returns the result of `deliver` and the frame statistics, if
    /// measured.
    ///
    /// If device memory is insufficient, all cached data and buffers of earlier frames are dropped and the frame is restarted.
    /// Streamed frames cannot restart, because their first voxels are already replaced.
    pub fn run<T>(
        &mut self,
        frame: &Frame,
        mode: Mode,
        deliver: impl FnOnce(&Device, &Finished) -> Result<T, Error>,
    ) -> Result<(T, Statistics), Error> {
        // Streamed frames upload their voxels themselves.
        if frame.volume.is_none() {
            self.field().require_voxels()?;
        }
        let (device, drawn) = match self.draw(frame, mode) {
            Err(error) if frame.volume.is_none() && error.is_lack_of_device_memory() => {
                self.drop_cached();
                tracing::debug!("{error}; retrying without the cached data of earlier frames");
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

    /// Begins the commands of a frame and returns its device handle. State of a failed frame stays with its handle.
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
        let view = View { device: &device, rays: frame.rays, viewport: frame.viewport, settings: frame.settings, is_cut: false };
        let is_enqueued = matches!(mode, Mode::Enqueued(_));
        let mut done = Done { finished: Finished::Nothing, active_samples: measuring.then_some(0), is_enqueued };
        for (n, stage) in frame.stages.iter().enumerate() {
            tracing::debug!("{}", stage.resources);
            if n > 0 {
                self.fields.drop_cached();
                self.light.drop_cached();
                self.passes.surfaces.drop_cached();
                self.target.keep_picture();
                self.field_mut().release_beyond(&device, stage.capacity())?;
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

    /// Rejects a frame whose buffers do not fit into memory, before any is allocated.
    fn require(&self, device: &Device, frame: &Frame, resources: &Resources) -> Result<(), Error> {
        let Viewport { width, height } = frame.viewport;
        let missing = self.target.arena.missing(device, resources);
        device.require_within_budget(&format!("a picture of {width}x{height}"), missing, frame.host_bytes)
    }

    fn step(&mut self, view: View, frame: &Frame, step: &Step, done: &mut Done) -> Result<(), Error> {
        let View { device, rays, viewport, settings, .. } = view;
        match *step {
            Step::Sweep { light, group, slab } => self.with_scene(view, |scene| scene.sweep_slab(light, group, slab))?,
            Step::FinishLight(light) => self.with_scene(view, |scene| scene.finish_light(light))?,
            Step::SumBlocks { light, slabs, slab } => {
                self.with_scene(view, |scene| scene.sum_blocks(light, &slabs.slabs[slab]))?
            }
            Step::Scatter(light) => self.with_scene(view, |scene| scene.scatter_light(light))?,
            Step::HoldLight { light, axis, ref voxels } => {
                self.with_scene(view, |scene| scene.hold_light(light, axis, voxels))?
            }
            Step::Hold { voxels, .. } if self.field().holds(voxels) => {}
            Step::Hold { voxels, capacity } => {
                tracing::debug!("reading {voxels:?}");
                let volume = frame.volume.expect("only streamed frames replace voxels");
                let part = volume.part(voxels.first, voxels.dims)?;
                self.field_mut().replace(device, &part.held(), capacity)?;
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
            Step::Surfaces(ref volume, _) => {
                done.finished = Finished::Floats(self.draw_surfaces(view, frame, volume, done)?);
            }
            Step::Slice(plan) => {
                let Self { fields, kernels, light, passes, target, .. } = self;
                fields.with_scene(view, kernels, light, |scene| passes.slices.draw(scene, plan, target))?;
                done.finished = Finished::Floats(target.drawn().samples);
            }
            Step::Warp { lattice, share } => {
                let onto = WarpInputs { lattice, rays, viewport, is_linear: settings.studio.is_some() };
                done.finished = self.passes.picture.warp(device, &self.target, onto, share)?;
            }
            Step::WarpDisplayed { lattice, background } => {
                let onto = WarpInputs { lattice, rays, viewport, is_linear: settings.studio.is_some() };
                done.finished = self.passes.picture.warp_displayed(device, &self.target, onto, (background, settings.curve()))?;
            }
            Step::Present(background) => {
                let Finished::Floats(floats) = &done.finished else { unreachable!("floats are displayed") };
                done.finished =
                    self.passes.picture.present(device, &self.target, floats, viewport, (background, settings.curve()))?;
            }
        }
        Ok(())
    }

    fn with_scene<T>(&mut self, view: View, work: impl FnOnce(&mut Scene) -> Result<T, Error>) -> Result<T, Error> {
        let Self { fields, kernels, light, .. } = self;
        fields.with_scene(view, kernels, light, work)
    }

    /// Adds the number of samples with opacity of the last pass, if the frame is measured.
    fn count(&self, device: &Device, done: &mut Done) -> Result<(), Error> {
        if let Some(active_samples) = &mut done.active_samples {
            *active_samples += self.target.count_active(device)?;
        }
        Ok(())
    }

    fn draw_layers(&mut self, view: View, lattice: &Lattice, layered: Layered, range: &LayerRange) -> Result<(), Error> {
        let Self { fields, kernels, light, passes, target, .. } = self;
        fields.with_scene(view, kernels, light, |scene| match layered.classification {
            settings::Classification::Post(correction) => passes.splats.draw_lattice(scene, lattice, correction, range, target),
            settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                passes.points.draw_lattice(scene, lattice, (kernel, samples_per_layer), layered.evaluation, range, target)
            }
        })
    }

    fn draw_screen(&mut self, view: View, plan: &Plan, gathers: RayOutput) -> Result<(), Error> {
        let Self { fields, kernels, light, passes, target, .. } = self;
        fields.with_scene(view, kernels, light, |scene| match *plan {
            Plan::Raycast(kernel, step) => passes.rays.cast(scene, kernel, step, gathers, target),
            // Several fields, and colours, are classified at each sample of a ray, not between them.
            Plan::CastSegments(kernel, step) if scene.is_tiled() => passes.rays.cast(scene, kernel, step, gathers, target),
            Plan::CastSegments(kernel, step) => passes.rays.cast_segments(scene, kernel, step, target),
            Plan::CastValues(kernel, step) => passes.rays.cast_values(scene, kernel, step, gathers, target),
            Plan::Direct(axis, layered) => match layered.classification {
                settings::Classification::Post(correction) => {
                    passes.splats.draw_pixels(scene, axis, correction, layered.footprints, target)
                }
                settings::Classification::Preintegrated { kernel, samples_per_layer } => {
                    passes.points.draw_pixels(scene, axis, (kernel, samples_per_layer), target)
                }
            },
            #[cfg(feature = "paper")]
            Plan::Paper(plan) => passes.paper.draw(scene, plan, target),
            Plan::Lattice(..) | Plan::Shared(..) => unreachable!("drawn as layers"),
        })
    }

    /// Draws surfaces, and between them the volume by these steps.
    fn draw_surfaces(
        &mut self,
        view: View,
        frame: &Frame,
        volume: &[Step],
        done: &mut Done,
    ) -> Result<Arc<Buffer<Float4>>, Error> {
        let view = View { is_cut: true, ..view };
        let (lattice, gathers) = drawn_by(volume);
        let mut drawn = self.target.drawn().samples;
        let mut first = true;
        let mut pending = Pending::FIRST;
        let is_enqueued = done.is_enqueued;
        let mut enqueued =
            self.with_surfaces(view, |pass, surfaces, scene, target| pass.begin(scene, surfaces, lattice, is_enqueued, target))?;
        while !pending.is_nothing() {
            if pending.find {
                self.with_surfaces(view, |pass, surfaces, scene, target| pass.find(scene, surfaces, target, first))?;
            }
            if let Some(layers) = pending.draw {
                self.target.cuts = Some(SurfacePass::cuts(&self.target, lattice.is_some()));
                let result = between(volume, layers).iter().try_for_each(|step| self.step(view, frame, step, done));
                self.target.cuts = None;
                result?;
                drawn = done.finished.floats().clone();
            }
            pending = self.with_surfaces(view, |pass, _, scene, target| {
                pass.composite(scene, (&drawn, lattice), target, gathers, first)?;
                enqueued.as_mut().map_or_else(|| SurfacePass::pending(scene, target), |passes| Ok(passes.next()))
            })?;
            first = false;
        }
        if enqueued.is_none() {
            self.passes.surfaces.end();
        }
        Ok(SurfacePass::picture(&self.target))
    }

    fn with_surfaces<T>(
        &mut self,
        view: View,
        work: impl FnOnce(&mut SurfacePass, &Arc<UploadedSurfaces>, &mut Scene, &mut Target) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let Self { fields, kernels, light, passes, target, surfaces, .. } = self;
        let surfaces = surfaces.as_ref().expect("frames with surfaces have them");
        fields.with_scene(view, kernels, light, |scene| work(&mut passes.surfaces, surfaces, scene, target))
    }

    /// The light volumes of a view.
    #[cfg(test)]
    pub fn illumination(&mut self, rays: &Rays, viewport: Viewport, settings: &Settings) -> Result<Illumination, Error> {
        let Self { device, fields, kernels, light, .. } = self;
        fields.with_scene(View { device, rays, viewport, settings, is_cut: false }, kernels, light, |scene| scene.illumination())
    }

    /// What blocks of voxels absorb and scatter, in the studio.
    #[cfg(test)]
    pub fn lit_blocks(
        &mut self,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(ScatterGrids, crate::device::Buffer<f32>), Error> {
        let Self { device, fields, kernels, light, .. } = self;
        fields.with_scene(View { device, rays, viewport, settings, is_cut: false }, kernels, light, |scene| scene.lit_blocks())
    }

    /// Number of light volumes made so far.
    #[cfg(test)]
    pub fn light_volumes_made(&self) -> usize {
        self.light.made()
    }

    /// Drops all cached data and buffers on the device except the voxels.
    fn drop_cached(&mut self) {
        self.fields.drop_cached();
        self.light.drop_cached();
        self.passes.surfaces.drop_cached();
        self.target.arena.clear();
    }
}

/// Results of the steps so far.
struct Done {
    finished: Finished,
    /// Number of samples with opacity, if counted.
    active_samples: Option<u64>,
    /// Whether nothing may be read back.
    is_enqueued: bool,
}
