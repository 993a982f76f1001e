//! The scene of a picture, built from the shared options.

use super::blending::BlendOptions;
use super::channels::{ChannelOptions, Field, FieldLook, FieldSteps};
use super::check;
use super::colors::{ColorOptions, reject_value_options};
use super::options::{
    BoundOptions, CameraOptions, DeviceOptions, Fit, LabelOptions, LightOptions, QualityOptions, TransferOptions, VolumeOptions,
};
use super::orientation::describe;
use super::processes::{Processes, TeamOptions};
use super::remarks::{remark_on_components, remark_on_transfer, remark_on_volume};
use super::shown_steps::ShownSteps;
use super::surfaces::{self, SurfaceArguments, is_surface_file};
use super::values::Tent;
use crate::annotation::{Legend, LegendEntry};
use crate::camera::Camera;
use crate::device::Device;
use crate::error::Error;
use crate::framing::{Framing, Orientation, UpReason};
use crate::renderer::SeenVolume;
use crate::settings::{Blend, CropBox, Settings};
use crate::shown::{Shown, legend_of};
use crate::surface::Surface;
use crate::transfer::{TransferFunction, Value};
use crate::viewport::Viewport;
use crate::volume::{Grid, LabelTable, Labels, Sequence, Volume};
use clap::Args;
use glam::DVec3;
use std::time::{Duration, Instant};

/// Options shared by `render`, `rotate`, `views` and `bench`.
#[derive(Args)]
pub(super) struct SceneOptions {
    #[command(flatten)]
    pub volume: VolumeOptions,
    #[command(flatten)]
    pub channels: ChannelOptions,
    #[command(flatten)]
    pub colors: ColorOptions,
    #[command(flatten)]
    pub labels: LabelOptions,
    #[command(flatten)]
    pub surfaces: SurfaceArguments,
    #[command(flatten)]
    pub transfer: TransferOptions,
    #[command(flatten)]
    pub camera: CameraOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub bounds: BoundOptions,
    #[command(flatten)]
    pub teams: TeamOptions,
    #[command(flatten)]
    pub quality: QualityOptions,
    #[command(flatten)]
    pub blend: BlendOptions,
}

impl SceneOptions {
    /// Whether surfaces are drawn, with a volume or alone.
    pub fn has_surfaces(&self) -> bool {
        self.surfaces.are_given() || is_surface_file(&self.volume.volume)
    }
}

/// A volume with its transfer function, settings and device.
pub(super) struct OpenedScene {
    /// The volume, or the first step of a sequence.
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
    /// How the volume is shown beside other fields.
    pub look: FieldLook,
    /// Fields that are drawn together with the volume.
    pub others: Vec<Field>,
    /// Colours or labels that are shown instead of values.
    pub shown: Option<Shown>,
    /// Names and looks of the labels of each layer.
    pub labels: Vec<LabelTable>,
    /// Name and colour of the volume and of each other field.
    pub entries: Vec<LegendEntry>,
    /// Surfaces in and around the volume.
    pub surfaces: Vec<Surface>,
    /// Labels in whose colours the volume is drawn.
    pub label_colors: Option<Labels>,
    /// Names and colours for the legend, instead of the transfer function's.
    pub legend: Option<Legend>,
    pub settings: Settings,
    pub device: Device,
    /// The processes of the run. Those of a team share the volume.
    pub processes: Processes,
    /// Time limit per frame on the device.
    pub time_limit: Option<Duration>,
    /// Time at which opening the volume began.
    pub opened_at: Instant,
    /// Duration of opening the volume, which is a pass over all voxels for their range.
    pub first_pass: Duration,
    /// A sample of all steps of a sequence.
    pub overview: Option<Volume<'static>>,
    /// Whether the volume is the level that stands for all until [`read_seen`](Self::read_seen).
    pub is_overview: bool,
    /// Grid of all voxels, the same for all levels of a data set.
    pub extent: Grid,
    /// Bounds of what the steps of a sequence show, if views are fitted to them.
    pub shown_by_steps: Option<Framing>,
}

impl OpenedScene {
    /// Checks the options, opens the device and reads the volume, or this process's part of it.
    pub fn open(options: &SceneOptions, processes: &Processes) -> Result<Self, Error> {
        Self::open_first(options, processes, None, &[], None, false)
    }

    /// As [`open`](Self::open), for commands that say by [`read_seen`](Self::read_seen) what their pictures show of the volume.
    pub fn open_for_views(options: &SceneOptions, processes: &Processes) -> Result<Self, Error> {
        let is_plain = !options.channels.are_given() && !options.labels.are_given();
        let by_view = is_plain && options.volume.leaves_level() && processes.counts().is_none_or(|(count, _)| count == 1);
        Self::open_first(options, processes, None, &[], None, by_view)
    }

    /// As [`open`](Self::open), for a sequence, the steps of the fields beside it, and colours or labels that it shows. Values, transfer function and fit are those of its
    /// sampled steps.
    pub fn open_sequence(
        options: &SceneOptions,
        processes: &Processes,
        sequence: &Sequence,
        others: &[FieldSteps],
        shown: Option<&ShownSteps>,
    ) -> Result<Self, Error> {
        let mut scene = Self::open_first(options, processes, Some(sequence), others, shown, false)?;
        let mut framings: Vec<Framing> = Vec::new();
        match shown {
            _ if options.camera.fit.is_some_and(|fit| fit != Fit::Visible) => {}
            Some(shown) => {
                for step in shown.sampled() {
                    framings.push(scene.framing_of_shown(&shown.step(step)?)?);
                }
            }
            None => {
                for step in sequence.play(sequence.sampled_steps()) {
                    framings.push(scene.framing_of(&step?));
                }
            }
        }
        scene.shown_by_steps = framings.into_iter().reduce(Framing::joined);
        Ok(scene)
    }

    fn open_first(
        options: &SceneOptions,
        processes: &Processes,
        sequence: Option<&Sequence>,
        others: &[FieldSteps],
        in_time: Option<&ShownSteps>,
        by_view: bool,
    ) -> Result<Self, Error> {
        let settings = options.quality.settings(options.camera.background)?;
        // Conflicting options fail before the volume is read.
        options.blend.check()?;
        let surface_color = options.blend.surface_color(&options.transfer)?;
        let memory = options.bounds.memory;
        if let Some(bytes) = memory {
            eprintln!(
                "memory: limit of {bytes} bytes on the device; first, passes over the volume find its range and its visible part"
            );
        }
        if options.volume.is_default() && !options.channels.has_scene() && processes.leads() {
            eprintln!("volume: {}, which is built in; name a file to render your own", VolumeOptions::DEFAULT);
        }
        let opened_at = Instant::now();
        if options.has_surfaces() {
            settings.check_surfaces()?;
        }
        let (alone, shown) = match sequence {
            None if is_surface_file(&options.volume.volume) => (Some(options.surfaces.open_alone(&options.volume.volume)?), None),
            None => (None, options.colors.open(options)?),
            Some(_) => (None, in_time.map(|steps| steps.step(0)).transpose()?),
        };
        shown.as_ref().map_or(Ok(()), |shown| reject_value_options(shown, options))?;
        let volume = match (&alone, &shown, sequence) {
            (Some(alone), ..) => alone.volume.clone(),
            (_, Some(shown), _) => shown.volume().clone(),
            (_, _, Some(sequence)) => sequence.step(0)?,
            _ => match options.channels.first_component() {
                Some(first) => options.volume.open_component(&first, Some(options.camera.size))?,
                None if by_view => options.volume.open_overview(memory)?,
                None => processes.open(&options.volume, Some(options.camera.size), memory)?,
            },
        };
        let mut fields = options.channels.open(&options.volume, (&volume, shown.as_ref()), options.camera.size, others)?;
        let (first, first_shown) = (fields.first.take(), fields.first_shown.take());
        let shown = if first.is_some() { first_shown } else { shown };
        let volume = first.unwrap_or(volume);
        // Steps of a sequence are masked when they are read.
        let volume = if sequence.is_some() { volume } else { options.labels.masked(volume, options.volume.placement())? };
        let overview = sequence.map(Sequence::overview).transpose()?;
        let values = overview.as_ref().unwrap_or(&volume);
        let first_pass = opened_at.elapsed();
        if processes.leads() && alone.is_none() {
            remark_on_volume(&options.volume, &volume);
            if shown.is_none() && !options.channels.name_fields() && !options.volume.has_channel() {
                remark_on_components(&volume);
            }
        }
        let extent = volume.framed().grid().clone();
        let settings = options.quality.light.with_sky_of(settings, options.camera.orientation(&extent).up());
        let mut settings = options.blend.apply(settings, Value::finder(values));
        settings.clipping.crop = options.blend.crop_of(&volume);
        if settings.blend.gathers_values() && volume.grid().voxel_count() == 1 {
            let problem =
                "maximum, minimum and average are taken between voxels, but the volume has a single one: omit the option";
            return Err(Error::Settings { field: "blend", problem: problem.into() });
        }
        let transfer = match (&alone, surface_color) {
            (Some(alone), _) => alone.transfer.clone(),
            (_, Some(color)) => TransferFunction::new("surface", vec![(0.0, color)], vec![(0.0, 1.0)])?,
            (None, None) => match shown.as_ref().filter(|_| options.transfer.transfer.is_none()).and_then(Shown::opacities) {
                Some(opacities) => adjusted(&options.transfer, values, opacities)?,
                None => match fields.first_transfer(values, settings.blend)?.filter(|_| !options.transfer.is_given()) {
                    Some(transfer) => adjusted(&options.transfer, values, transfer)?,
                    None => open_transfer(&options.transfer, values, settings.blend)?,
                },
            },
        };
        let look = fields.first_look(values);
        let labels = shown.as_ref().map_or_else(|| Ok(Vec::new()), |shown| shown.tables(&[]))?;
        let label_colors = options
            .labels
            .label_colors(options.volume.placement())?
            .map(|labels| labels.over(volume.description()))
            .transpose()?;
        let entries = fields.entries(&volume, &transfer)?;
        let of_shown = || in_time.map_or_else(|| shown.as_ref()?.legend(&labels), ShownSteps::legend);
        let legend = fields.legend(&entries, shown.as_ref())?.or_else(of_shown);
        let legend = match &label_colors {
            Some(labels) if legend.is_none() => Some(legend_of(labels, &labels.changed_tables(&[])?)),
            _ => legend,
        };
        let (is_alone, is_overview) = (alone.is_some(), by_view && shown.is_none() && alone.is_none());
        let of_scene = surfaces::open_scene(&fields.surfaces, Some(&volume).filter(|_| !is_alone))?;
        let surfaces = match alone {
            Some(alone) => [alone.surfaces, of_scene].concat(),
            None => [options.surfaces.open(&volume)?, of_scene].concat(),
        };
        if processes.leads() && !is_alone {
            surfaces::warn_of_places(&surfaces, volume.grid());
        }
        let legend = match legend {
            None if surfaces.is_empty() => None,
            listed => {
                let mut listed =
                    listed.unwrap_or_else(|| Legend { entries: if is_alone { Vec::new() } else { entries.clone() } });
                listed.entries.extend(surfaces::entries(&surfaces));
                Some(listed)
            }
        };
        let others = fields.into_others(settings.blend)?;
        // A function that options have changed is the user's own.
        if processes.leads() && !is_alone && !options.transfer.changes_opacity() {
            remark_on_transfer(&transfer);
        }
        let choice = options.device.choice();
        let device = processes.agree(Device::open(&choice))?;
        let device = memory.map_or(device.clone(), |bytes| device.with_memory(bytes));
        let time_limit = options.bounds.time_limit;
        let (processes, shown_by_steps) = (processes.clone(), None);
        Ok(Self {
            volume,
            transfer,
            look,
            others,
            shown,
            labels,
            entries,
            surfaces,
            label_colors,
            legend,
            settings,
            device,
            processes,
            time_limit,
            opened_at,
            first_pass,
            overview,
            is_overview,
            extent,
            shown_by_steps,
        })
    }

    /// The settings with other options of light.
    pub fn settings_with_light(&self, options: &SceneOptions, light: &LightOptions) -> Result<Settings, Error> {
        let settings = options.quality.settings_with_light(light, options.camera.background)?;
        let settings = light.with_sky_of(settings, options.camera.orientation(&self.extent).up());
        let Settings { blend, clipping, .. } = self.settings;
        Ok(Settings { blend, clipping, ..settings })
    }

    /// Fixes lights in the world where the first camera of a turn sees them, so that shadows stay in place and no light is swept again. With
    /// `--light-space camera` they move with the camera.
    pub fn fix_lights(&mut self, options: &SceneOptions, first: &Camera) -> Result<(), Error> {
        if !options.quality.light.moves_with_camera() {
            self.settings = self.settings.with_light_in_world(first)?;
        }
        Ok(())
    }

    /// Rejects several fields, colours and labels, which `what` does not draw.
    #[cfg(feature = "mpi")]
    pub fn require_one_field(&self, what: &str) -> Result<(), Error> {
        if !self.has_channels() && self.shown.is_none() && self.label_colors.is_none() {
            return Ok(());
        }
        let problem = format!("{what} show the values of one field in its own colours: choose one, or use render or rotate");
        Err(Error::Settings { field: "channels", problem })
    }

    /// Whether the volume is drawn together with others, or not as one alone.
    pub fn has_channels(&self) -> bool {
        !self.others.is_empty() || self.look != FieldLook::default()
    }

    /// Id of the label that is seen at a position, or 0; `None` if there are no labels.
    pub fn label_at(&self) -> Option<impl Fn(DVec3) -> u32 + Sync> {
        let labels = self.shown.as_ref().and_then(Shown::labels).or(self.label_colors.as_ref())?;
        Some(|position| labels.visible_label_near(position).map_or(0, |label| label.id))
    }

    /// A volume with the values of the volume, or of all steps of a sequence.
    pub fn values(&self) -> &Volume<'static> {
        self.overview.as_ref().unwrap_or(&self.volume)
    }

    /// The orientation of the volume, with a line on standard error if it was not given.
    pub fn orientation(&self, options: &CameraOptions) -> Orientation {
        let grid = &self.extent;
        let orientation = options.orientation(grid);
        if orientation.reason() != UpReason::Given && self.processes.leads() {
            eprintln!("up: {} (choose another with --up)", describe(&orientation, grid));
        }
        orientation
    }

    /// Bounds of the visible part.
    pub fn framing(&self) -> Framing {
        let of_volume = || self.shown_by_steps.clone().unwrap_or_else(|| self.framing_of(&self.volume));
        match surfaces::framing(&self.surfaces) {
            None => of_volume(),
            // The volume around surfaces without one.
            Some(surfaces) if self.transfer.opacities().iter().all(|point| point.1 == 0.0) => surfaces,
            Some(surfaces) => of_volume().joined(surfaces),
        }
    }

    /// Bounds of the visible part of the volume, or of another step.
    fn framing_of(&self, volume: &Volume) -> Framing {
        let framing = match &self.shown {
            Some(shown) => shown.framing(&self.transfer, &self.labels),
            None => self.visible_part(volume, &self.transfer, None),
        };
        self.cropped(framing, volume)
    }

    /// Bounds of the visible part of another step of colours or labels.
    fn framing_of_shown(&self, shown: &Shown) -> Result<Framing, Error> {
        let framing = shown.framing(&self.transfer, &shown.tables(&[])?);
        Ok(self.cropped(framing, shown.volume()))
    }

    /// What the crop box leaves of bounds, joined with those of other fields.
    fn cropped(&self, framing: Framing, volume: &Volume) -> Framing {
        let framing = match self.settings.clipping.crop {
            Some(CropBox { lowest, highest }) => framing.cropped(volume.grid(), lowest, highest),
            None => framing,
        };
        let visible = self.others.iter().filter(|field| field.is_visible());
        visible.fold(framing, |framing, field| framing.joined(self.framing_of_field(field)))
    }

    /// Bounds of the visible part of another field.
    fn framing_of_field(&self, field: &Field) -> Framing {
        match &field.shown {
            // The labels are those of the file with all changes.
            Some(shown) => {
                shown.tables(&[]).map_or_else(|_| Framing::whole(&field.volume), |tables| shown.framing(&field.transfer, &tables))
            }
            None => self.visible_part(&field.volume, &field.transfer, field.iso()),
        }
    }

    /// Bounds of the visible part of one field. `iso`: the value of its surface, unless it is that of the settings.
    fn visible_part(&self, volume: &Volume, transfer: &TransferFunction, iso: Option<f64>) -> Framing {
        match self.settings.blend {
            Blend::Composite => Framing::visible(volume, transfer, self.settings.unit_distance),
            Blend::Iso(value) => Framing::iso(volume, iso.unwrap_or(value)),
            _ => Framing::whole(volume),
        }
    }

    /// Fails for views that processes which share the volume cannot render.
    pub fn require_shared(&self, size: Viewport, cameras: &[Camera], settings: &Settings) -> Result<(), Error> {
        let seen = SeenVolume { description: self.volume.description(), transfer: &self.transfer };
        self.processes.check_views(seen, cameras, size, settings)
    }

    /// Fails if the device check of the kernels for these views failed, now or earlier.
    pub fn require_checked(&self, options: &SceneOptions, size: Viewport, cameras: &[Camera]) -> Result<(), Error> {
        self.require_shared(size, cameras, &self.settings)?;
        let families = check::families(cameras, size, self.volume.grid(), &self.settings, !self.surfaces.is_empty());
        self.processes.in_turn(|| check::require(&self.device, &families, &options.device))
    }
}

/// Opens the transfer function given by the options, or derives one from the histogram: a grey ramp for projections of values.
pub(super) fn open_transfer(options: &TransferOptions, volume: &Volume, blend: Blend) -> Result<TransferFunction, Error> {
    let transfer = match (&options.transfer, &options.preset, &options.palette) {
        (Some(source), ..) => TransferFunction::open(source, volume)?,
        (None, Some(preset), _) => TransferFunction::preset(preset, volume)?,
        (None, None, Some(palette)) => TransferFunction::automatic_in(volume, palette)?,
        (None, None, None) if options.window.is_some() => TransferFunction::builtin("grey", volume)?,
        (None, None, None) => match blend {
            Blend::Maximum | Blend::Average => TransferFunction::grey_ramp(volume),
            Blend::Minimum => TransferFunction::inverted_grey_ramp(volume),
            _ => TransferFunction::automatic(volume),
        },
    };
    adjusted(options, volume, transfer)
}

/// A transfer function with the changes that the options ask for.
pub(super) fn adjusted(
    options: &TransferOptions,
    volume: &Volume,
    mut transfer: TransferFunction,
) -> Result<TransferFunction, Error> {
    let find = Value::finder(volume);
    if let Some((lo, hi)) = options.transfer_range {
        transfer = transfer.stretched(find(lo), find(hi))?;
    }
    if let Some((level, width)) = options.window {
        transfer = transfer.windowed(find(level), width)?;
    }
    match &options.opacity {
        Some(opacities) => {
            transfer = transfer.with_opacities(opacities.0.iter().map(|&(value, opacity)| (find(value), opacity)).collect())?;
        }
        None if !options.tent.is_empty() => transfer = transfer.faded(0.0)?,
        None => {}
    }
    for &Tent { value, width, opacity } in &options.tent {
        transfer = transfer.with_tent(find(value), width, opacity)?;
    }
    Ok(transfer)
}
