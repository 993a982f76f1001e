//! The fields of a renderer, each with its classification.

use super::super::classification::PreparationKernels;
use super::super::colors::{ColorFields, UploadedColors};
use super::super::field::{Field, UploadedVolume};
use super::super::label_colors::LabelColors;
use super::super::store::Version;
use super::Channel;
use super::classified::ClassifiedField;
use super::common_grid::common_grid;
use super::on_frame::OnFrame;
use crate::device::Device;
use crate::error::Error;
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Held};

/// The field of a renderer's volume, and those that are drawn together with it.
pub(in crate::renderer) struct Fields {
    pub first: ClassifiedField,
    pub(super) others: Vec<ClassifiedField>,
    /// The other fields of colours, if the first field is one.
    pub(super) colors: Option<ColorFields>,
    /// Colours of labels over the first field.
    pub(super) label_colors: Option<LabelColors>,
    /// Grid of the first field's own voxels.
    pub(super) first_grid: Grid,
    floats: Vec<Floats>,
    /// The visible fields at the voxels of the frame, for algorithms that need them there.
    pub(super) on_frame: OnFrame,
}

/// A field whose voxels have become floats.
struct Floats {
    source: Version,
    field: Field,
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
    pub(super) fn all(&self) -> impl Iterator<Item = &ClassifiedField> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// Drops all data derived from fields and transfer functions.
    pub fn drop_cached(&mut self) {
        self.on_frame = OnFrame::default();
        std::iter::once(&mut self.first).chain(&mut self.others).for_each(ClassifiedField::drop_cached);
    }
}
