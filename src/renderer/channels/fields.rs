//! The fields of a renderer, each with its classification.

use super::super::classification::{Classification, PreparationKernels, TableSizes};
use super::super::colors::{ColorFields, UploadedColors, color_settings};
use super::super::field::{Field, FieldShape, UploadedVolume};
use super::super::label_colors::LabelColors;
use super::super::light::LightVolumes;
use super::super::scene::{OtherField, Scene, View};
use super::super::store::Version;
use super::super::world::World;
use super::common_grid::common_grid;
use super::on_frame::OnFrame;
use super::{Channel, ChannelLook};
use crate::device::Device;
use crate::error::Error;
use crate::settings::{self, Algorithm, Blend, CropBox, FieldKind, Settings};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Held, Rescale, Stored as StoredNumbers};
use glam::DVec3;

/// A field on the device with its classification.
pub(in crate::renderer) struct ClassifiedField {
    pub field: Field,
    pub classification: Classification,
    pub look: ChannelLook,
}

/// The field of a renderer's volume, and those that are drawn together with it.
pub(in crate::renderer) struct Fields {
    pub first: ClassifiedField,
    others: Vec<ClassifiedField>,
    /// The other fields of colours, if the first field is one.
    colors: Option<ColorFields>,
    /// Colours of labels over the first field.
    label_colors: Option<LabelColors>,
    /// Grid of the first field's own voxels.
    first_grid: Grid,
    floats: Vec<Floats>,
    /// The visible fields at the voxels of the frame, for algorithms that need them there.
    on_frame: OnFrame,
}

/// A field whose voxels have become floats.
struct Floats {
    source: Version,
    field: Field,
}

/// Farther away than any voxel of a grid.
const FAR: DVec3 = DVec3::splat(1e12);

/// Properties of a field on which tables depend.
#[derive(PartialEq)]
struct Numbers {
    stored: StoredNumbers,
    rescale: Rescale,
    range_is_declared: bool,
    end: Option<f64>,
}

impl Numbers {
    fn new(field: &Field) -> Self {
        let rescale = field.description().rescale();
        Self { stored: field.stored(), rescale, range_is_declared: field.range_is_declared(), end: field.end() }
    }
}

impl ClassifiedField {
    fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let field = volume.field.for_renderer();
        Self { classification: Classification::new(transfer, &field), field, look: ChannelLook::default() }
    }

    /// A copy for rehearsals, with empty caches.
    pub(super) fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let (field, classification) = (self.field.for_rehearsal(), self.classification.for_rehearsal(dimmed));
        Self { field, classification, look: self.look }
    }

    /// Replaces the field. Tables are made again if the stored numbers differ.
    pub fn set_field(&mut self, field: Field) {
        let before = Numbers::new(&self.field);
        self.field = field;
        self.reclassify(before);
    }

    /// Uploads other voxels to replace those of the field.
    pub fn replace(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        let before = Numbers::new(&self.field);
        let capacity = held.dims().iter().product::<usize>().max(self.field.capacity());
        let replaced = self.field.replace(device, held, capacity);
        self.reclassify(before);
        replaced
    }

    /// Replaces the transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.classification.set_transfer_function(transfer, &self.field);
    }

    /// Takes over transfer function, factor and look.
    pub(super) fn classify_as(&mut self, other: &Self) {
        self.set_transfer_function(other.classification.transfer_function());
        self.classification.set_factor(other.classification.factor());
        self.look = other.look;
    }

    fn set(&mut self, channel: &Channel, field: Field) {
        self.set_field(field);
        self.set_transfer_function(&channel.transfer);
        self.classification.set_factor(channel.look.factor);
        self.look = channel.look;
    }

    /// Invalidates the tables if the stored numbers of the field have changed.
    fn reclassify(&mut self, before: Numbers) {
        if Numbers::new(&self.field) != before {
            self.classification.set_field(&self.field);
        }
    }

    /// Steepness of the transfer function over the values of the whole volume.
    fn steepness(&self) -> f64 {
        self.classification.transfer_function().steepness(self.field.description().field_range())
    }

    /// Whether the field can change a picture.
    fn shows(&self, blend: Blend) -> bool {
        let opaque = || self.look.factor > 0.0 && self.classification.shows_anything();
        self.look.visible && (blend != Blend::Composite || opaque())
    }

    fn sizes(&self) -> (FieldShape, TableSizes<'_>) {
        (self.field.shape(), TableSizes::from_classification(&self.classification, &self.field))
    }

    fn drop_cached(&mut self) {
        self.field.drop_cached();
        self.classification.drop_cached();
    }
}

/// Fields in a scene with others.
fn others_of<'a>(fields: Vec<&'a mut ClassifiedField>, settings: &Settings, world: World) -> Vec<OtherField<'a>> {
    let other = |ClassifiedField { field, classification, look }: &'a mut ClassifiedField| OtherField {
        field,
        classification,
        settings: look.settings(settings, world),
    };
    fields.into_iter().map(other).collect()
}

/// The fields that can change a picture, or the first if none can.
fn shown(fields: Vec<&mut ClassifiedField>, blend: Blend) -> Vec<&mut ClassifiedField> {
    let none = !fields.iter().any(|field| field.shows(blend));
    fields.into_iter().enumerate().filter(|(n, field)| field.shows(blend) || (none && *n == 0)).map(|(_, field)| field).collect()
}

/// Whether voxels are splatted, or treated one by one in another way: they are those of the frame then.
fn is_splatted(settings: &Settings) -> bool {
    match settings.algorithm {
        Algorithm::Layered(layered) => matches!(layered.classification, settings::Classification::Post(_)),
        Algorithm::Raycast { .. } => false,
        _ => true,
    }
}

/// The error of fields whose common grid would have too many voxels.
fn too_many_voxels(fields: &[&Field]) -> Error {
    let spacing = |field: &&&Field| field.description().grid().spacing().min_element();
    let diagonal = |field: &&&Field| field.description().grid().diagonal();
    let finest = fields.iter().min_by(|a, b| spacing(a).total_cmp(&spacing(b))).expect("a scene has a field");
    let largest = fields.iter().max_by(|a, b| diagonal(a).total_cmp(&diagonal(b))).expect("a scene has a field");
    let problem = format!(
        "{} has a spacing of {:.4e}, and {} a diagonal of {:.4e}: a grid for both has too many voxels; check the units of both, or draw \
         one alone",
        finest.description().name(),
        spacing(&finest),
        largest.description().name(),
        diagonal(&largest)
    );
    Error::Settings { field: "channels", problem }
}

impl Fields {
    /// The field of an uploaded volume. Others may share its voxels.
    pub fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let first_grid = volume.description().grid().clone();
        Self {
            first: ClassifiedField::new(volume, transfer),
            others: Vec::new(),
            colors: None,
            label_colors: None,
            first_grid,
            floats: Vec::new(),
            on_frame: OnFrame::default(),
        }
    }

    /// Copies for rehearsals, with empty caches.
    pub fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let others = self.others.iter().map(|other| other.for_rehearsal(dimmed)).collect();
        let (colors, label_colors, first_grid) = (self.colors.clone(), self.label_colors.clone(), self.first_grid.clone());
        let (first, on_frame) = (self.first.for_rehearsal(dimmed), self.on_frame.for_rehearsal(dimmed));
        Self { first, others, colors, label_colors, first_grid, floats: Vec::new(), on_frame }
    }

    /// Replaces the field of the renderer's volume.
    ///
    /// # Errors
    /// If others are drawn together with it.
    pub fn set_first(&mut self, volume: &UploadedVolume) -> Result<(), Error> {
        self.require_one()?;
        self.first_grid = volume.description().grid().clone();
        self.first.set_field(volume.field.for_renderer());
        Ok(())
    }

    /// Uploads other voxels to replace those of the renderer's volume.
    ///
    /// # Errors
    /// If others are drawn together with it, and errors of the device.
    pub fn replace_first(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        self.require_one()?;
        self.first_grid = held.description.grid().clone();
        self.first.replace(device, held)
    }

    /// Replaces all fields by colours.
    pub fn set_colors(&mut self, colors: &UploadedColors) {
        let (volume, transfer) = colors.visibility();
        self.others.clear();
        self.floats.clear();
        self.first_grid = volume.description().grid().clone();
        self.first.set(&Channel::new(&volume, &transfer), volume.field.for_renderer());
        self.colors = Some(colors.fields.clone());
    }

    /// Draws the first field in the colours of labels, or in its own.
    ///
    /// # Errors
    /// As [`LabelColors::grid_over`]; the colours stay then.
    pub fn set_label_colors(&mut self, colors: Option<&LabelColors>) -> Result<(), Error> {
        colors.map_or(Ok(()), |colors| colors.grid_over(self.first.field.description()).map(|_| ()))?;
        self.label_colors = colors.cloned();
        Ok(())
    }

    fn require_one(&self) -> Result<(), Error> {
        if self.others.is_empty() && self.colors.is_none() {
            return Ok(());
        }
        let problem = "the renderer draws several: replace one of them by set_channels".into();
        Err(Error::Settings { field: "channels", problem })
    }

    /// Replaces all fields. Visible fields with several grids share the grid of the frame, and keep their voxels.
    ///
    /// # Errors
    /// For other numbers of channels than 1 to [`Channel::MOST`], and if there is not enough memory for voxels of one type. All fields are
    /// unchanged then.
    pub fn set(&mut self, channels: &[Channel], kernels: &mut PreparationKernels, device: &Device) -> Result<(), Error> {
        let Some((first, others)) = channels.split_first().filter(|_| channels.len() <= Channel::MOST) else {
            let problem = format!("there are {}, and a renderer draws 1 to {}", channels.len(), Channel::MOST);
            return Err(Error::Settings { field: "channels", problem });
        };
        let mut fields = self.in_one_frame(channels, kernels, device)?.into_iter();
        self.colors = None;
        self.first_grid = first.volume.description().grid().clone();
        self.first.set(first, fields.next().expect("as many fields as channels"));
        self.others.truncate(others.len());
        for (n, (channel, field)) in others.iter().zip(fields).enumerate() {
            if n == self.others.len() {
                self.others.push(ClassifiedField::new(&channel.volume, &channel.transfer));
            }
            self.others[n].set(channel, field);
        }
        Ok(())
    }

    /// Fields, of which those that are visible have one type of voxels, in one frame.
    fn in_one_frame(
        &mut self,
        channels: &[Channel],
        kernels: &mut PreparationKernels,
        device: &Device,
    ) -> Result<Vec<Field>, Error> {
        let visible: Vec<&Field> =
            channels.iter().filter(|channel| channel.look.visible).map(|channel| &channel.volume.field).collect();
        let grids: Vec<&Grid> = visible.iter().map(|field| field.description().grid()).collect();
        let one_kind = visible.windows(2).all(|pair| pair[0].voxel_kind() == pair[1].voxel_kind());
        self.floats.retain(|kept| !one_kind && visible.iter().any(|source| source.version() == kept.source));
        let frame = if grids.is_empty() { None } else { Some(common_grid(&grids).map_err(|_| too_many_voxels(&visible))?) };
        let frame = frame.filter(|frame| grids.iter().any(|grid| *grid != frame));
        let mut fields = Vec::new();
        for channel in channels {
            let source = &channel.volume.field;
            let field = if !channel.look.visible {
                source.for_renderer()
            } else {
                let field = if one_kind { source.for_renderer() } else { self.as_floats(source, kernels, device)? };
                frame.as_ref().map_or_else(|| field.for_renderer(), |frame| field.in_frame(frame))
            };
            fields.push(field);
        }
        Ok(fields)
    }

    /// The field with voxels that are floats: programs read one type.
    fn as_floats(&mut self, source: &Field, kernels: &mut PreparationKernels, device: &Device) -> Result<Field, Error> {
        if let Some(kept) = self.floats.iter().find(|kept| kept.source == source.version()) {
            return Ok(kept.field.clone());
        }
        let grid = source.description().grid();
        let field = source.resampled(&mut kernels.field, device, grid.index_to_world(), grid, false)?;
        self.floats.push(Floats { source: source.version(), field: field.clone() });
        Ok(field)
    }

    /// All fields, beginning with the first.
    fn all(&self) -> impl Iterator<Item = &ClassifiedField> {
        std::iter::once(&self.first).chain(&self.others)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut ClassifiedField> {
        std::iter::once(&mut self.first).chain(&mut self.others)
    }

    fn visible(&self) -> impl Iterator<Item = &ClassifiedField> {
        self.all().filter(|field| field.look.visible)
    }

    /// A field with the grid of frames: the first visible one, or the first if none is.
    pub fn base(&self) -> &Field {
        &self.visible().next().unwrap_or(&self.first).field
    }

    /// Largest steepness of the transfer functions of visible fields.
    pub fn steepness(&self) -> f64 {
        self.visible().map(ClassifiedField::steepness).fold(0.0, f64::max)
    }

    /// The settings of a frame. Crop boxes count voxels of the first field; where all fields are hidden, nothing is within the box.
    ///
    /// # Errors
    /// For a crop box in a field that is rotated against the common grid.
    pub fn settings(&self, settings: Settings) -> Result<Settings, Error> {
        let mut clipping = settings.clipping;
        let common = self.base().description().grid();
        if self.visible().next().is_none() {
            clipping.crop = Some(CropBox { lowest: DVec3::ONE, highest: DVec3::ZERO });
        } else if let Some(crop) = clipping.crop.as_mut().filter(|_| *common != self.first_grid) {
            if common.direction() != self.first_grid.direction() {
                let problem = "counts voxels of the first channel, whose axes are not those of the finest one: use clip planes";
                return Err(Error::Settings { field: "crop", problem: problem.into() });
            }
            let place = |voxel: DVec3| {
                // An infinite bound stays one.
                let moved = common.world_to_voxel(self.first_grid.index_to_world().transform_point3(voxel.clamp(-FAR, FAR)));
                DVec3::select(voxel.is_finite_mask(), moved, voxel)
            };
            (crop.lowest, crop.highest) = (place(crop.lowest), place(crop.highest));
        }
        let settings = Settings { clipping, ..settings };
        if let Some(labels) = &self.label_colors {
            self.check_label_colors(labels)?;
        }
        self.kind(settings.blend).check(&settings)?;
        Ok(self.colors.as_ref().map_or(settings, |colors| color_settings(settings, colors)))
    }

    fn check_label_colors(&self, labels: &LabelColors) -> Result<(), Error> {
        if self.colors.is_some() || self.visible().count() > 1 {
            let problem =
                "are those of one volume of values, and the renderer draws several, or colours: omit one of both".into();
            return Err(Error::Settings { field: "label_colors", problem });
        }
        labels.grid_over(self.base().description()).map(drop)
    }

    /// What frames of a blend mode draw.
    pub fn kind(&self, blend: Blend) -> FieldKind {
        match (&self.colors, &self.label_colors) {
            (Some(colors), _) => colors.kind,
            _ if self.base().is_framed() || self.all().filter(|field| field.shows(blend)).count() > 1 => FieldKind::Several,
            (_, Some(_)) => FieldKind::LabelColors,
            _ => FieldKind::One,
        }
    }

    /// Whether frames are of several fields or of colours.
    pub fn are_tiled(&self, blend: Blend) -> bool {
        matches!(self.kind(blend), FieldKind::Colors | FieldKind::Labels | FieldKind::Several)
    }

    /// The shapes and the tables of the visible fields, beginning with the one that scenes begin with.
    pub fn sizes(&self) -> Vec<(FieldShape, TableSizes<'_>)> {
        let visible: Vec<_> = self.visible().map(ClassifiedField::sizes).collect();
        if visible.is_empty() { vec![self.first.sizes()] } else { visible }
    }

    /// Runs `work` on the scene of the visible fields.
    ///
    /// # Errors
    /// Those of `work`, and of resampling fields that algorithms need at the voxels of the frame.
    pub fn with_scene<T>(
        &mut self,
        view: View,
        kernels: &mut PreparationKernels,
        light: &mut LightVolumes,
        work: impl FnOnce(&mut Scene) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let (splats, sweeps) = (is_splatted(view.settings), view.settings.sweeps_light());
        let is_framed = self.base().is_framed();
        if is_framed && (splats || sweeps) {
            let visible = std::iter::once(&self.first).chain(&self.others).filter(|field| field.look.visible);
            self.on_frame.update(visible, kernels, view.device)?;
        }
        let Self { first, others, colors, label_colors, on_frame, .. } = self;
        let (own, on_frame): (Vec<_>, Vec<_>) = (std::iter::once(first).chain(others).collect(), on_frame.fields().collect());
        let (mut drawn, absorbers) = match (is_framed, splats) {
            (true, true) => (shown(on_frame, view.settings.blend), Vec::new()),
            (true, false) if sweeps => (shown(own, view.settings.blend), shown(on_frame, view.settings.blend)),
            _ => (shown(own, view.settings.blend), Vec::new()),
        };
        let base = drawn.remove(0);
        let world = base.field.world();
        let settings = base.look.settings(view.settings, world);
        let [others, absorbers] = [drawn, absorbers].map(|fields| others_of(fields, view.settings, world));
        let view = View { settings: &settings, ..view };
        let scene = Scene::new(view, &base.field, &mut base.classification, kernels, light);
        let scene = scene.with_others(others).with_absorbers(absorbers);
        let scene = scene.with_colors(colors.as_ref());
        work(&mut scene.with_label_colors(label_colors.as_ref()))
    }

    /// Drops all data derived from fields and transfer functions.
    pub fn drop_cached(&mut self) {
        self.on_frame = OnFrame::default();
        self.all_mut().for_each(ClassifiedField::drop_cached);
    }
}
