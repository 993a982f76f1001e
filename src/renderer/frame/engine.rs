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
use super::super::picture::{Finished, Picture, bind};
use super::super::rays::MarchedRays;
use super::super::report::{Measured, Statistics};
use super::super::scene::View;
use super::super::slice_pass::Slices;
use super::super::surfaces::{SurfacePass, UploadedSurfaces};
use super::super::tiles::Target;
use super::declaring::{DeclaredLight, Declaring};
use super::resources::Resources;
use super::steps::Stage;
use crate::camera::Camera;
use crate::device::{Device, Limits, Rehearsal, ScratchMemory};
use crate::error::Error;
use crate::layers::Rays;
use crate::settings::{Blend, FieldKind, Method, Settings};
use crate::surface::Surface;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Held, Volume};
use opencl3::event::Event;
use std::sync::Arc;

/// State of a renderer that is reused across frames.
pub(in crate::renderer) struct Engine {
    pub device: Device,
    pub(super) fields: Fields,
    pub(super) kernels: PreparationKernels,
    pub(super) light: LightVolumes,
    pub(super) passes: Passes,
    pub(super) target: Target,
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
pub(super) struct Passes {
    pub points: PointLayers,
    pub splats: SplatLayers,
    pub rays: MarchedRays,
    #[cfg(feature = "paper")]
    pub paper: super::super::paper::PaperPasses,
    pub slices: Slices,
    pub surfaces: SurfacePass,
    pub picture: Picture,
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
        UploadedSurfaces::replace(&mut self.surfaces, &self.device, surfaces)?;
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
pub(super) struct Done {
    pub finished: Finished,
    /// Number of samples with opacity, if counted.
    pub active_samples: Option<u64>,
    /// Whether nothing may be read back.
    pub is_enqueued: bool,
}
