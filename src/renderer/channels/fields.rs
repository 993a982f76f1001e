//! The fields of a renderer, each with its classification.

use super::super::classification::{Classification, PreparationKernels, TableSizes};
use super::super::field::{Field, FieldShape, UploadedVolume};
use super::super::light::LightVolumes;
use super::super::scene::{OtherField, Scene, View};
use super::{Channel, Look};
use crate::device::Device;
use crate::error::Error;
use crate::settings::{CropBox, Settings};
use crate::transfer::TransferFunction;
use crate::volume::{Held, Rescale, Stored as StoredNumbers};
use glam::DVec3;
use std::path::Path;

/// A field on the device with its classification.
pub(in crate::renderer) struct ClassifiedField {
    pub field: Field,
    pub classification: Classification,
    pub look: Look,
}

/// The field of a renderer's volume, and those that are drawn together with it.
pub(in crate::renderer) struct Fields {
    pub first: ClassifiedField,
    others: Vec<ClassifiedField>,
}

/// Properties of a field on which tables depend.
#[derive(PartialEq)]
struct Numbers {
    stored: StoredNumbers,
    rescale: Rescale,
    range_is_declared: bool,
}

impl Numbers {
    fn new(field: &Field) -> Self {
        let rescale = field.description().rescale();
        Self { stored: field.stored(), rescale, range_is_declared: field.range_is_declared() }
    }
}

impl ClassifiedField {
    fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let field = volume.field.for_renderer();
        Self { classification: Classification::new(transfer, field.description().rescale()), field, look: Look::default() }
    }

    /// A copy for rehearsals, with empty caches.
    fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
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
        self.classification.set_transfer_function(transfer, self.field.description().rescale());
    }

    fn set(&mut self, channel: &Channel) {
        self.set_field(channel.volume.field.for_renderer());
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

    fn sizes(&self) -> (FieldShape, TableSizes<'_>) {
        (self.field.shape(), TableSizes::from_classification(&self.classification, &self.field))
    }

    fn drop_cached(&mut self) {
        self.field.drop_cached();
        self.classification.drop_cached();
    }
}

impl Fields {
    /// The field of an uploaded volume. Others may share its voxels.
    pub fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        Self { first: ClassifiedField::new(volume, transfer), others: Vec::new() }
    }

    /// Copies for rehearsals, with empty caches.
    pub fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let others = self.others.iter().map(|other| other.for_rehearsal(dimmed)).collect();
        Self { first: self.first.for_rehearsal(dimmed), others }
    }

    /// Replaces all fields.
    ///
    /// # Errors
    /// For other numbers of channels than 1 to [`Channel::MOST`], and channels that are not on one grid. All fields are unchanged then.
    pub fn set(&mut self, channels: &[Channel]) -> Result<(), Error> {
        let Some((first, others)) = channels.split_first().filter(|_| channels.len() <= Channel::MOST) else {
            let problem = format!("there are {}, and a renderer draws 1 to {}", channels.len(), Channel::MOST);
            return Err(Error::Settings { field: "channels", problem });
        };
        others.iter().try_for_each(|other| require_one_grid(&first.volume.field, &other.volume.field))?;
        self.first.set(first);
        self.others.truncate(others.len());
        let known = self.others.len();
        self.others.iter_mut().zip(others).for_each(|(field, channel)| field.set(channel));
        for channel in &others[known..] {
            let mut field = ClassifiedField::new(&channel.volume, &channel.transfer);
            field.set(channel);
            self.others.push(field);
        }
        Ok(())
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

    /// Largest steepness of the transfer functions of visible fields.
    pub fn steepness(&self) -> f64 {
        self.visible().map(ClassifiedField::steepness).fold(0.0, f64::max)
    }

    /// The settings of a frame: where all fields are hidden, nothing is within the crop box.
    pub fn settings(&self, settings: Settings) -> Settings {
        let mut clipping = settings.clipping;
        if self.visible().next().is_none() {
            clipping.crop = Some(CropBox { lowest: DVec3::ONE, highest: DVec3::ZERO });
        }
        Settings { clipping, ..settings }
    }

    /// The shapes and the tables of the visible fields, beginning with the one that scenes begin with.
    pub fn sizes(&self) -> Vec<(FieldShape, TableSizes<'_>)> {
        let visible: Vec<_> = self.visible().map(ClassifiedField::sizes).collect();
        if visible.is_empty() { vec![self.first.sizes()] } else { visible }
    }

    /// Runs `work` on the scene of the visible fields.
    pub fn with_scene<T>(
        &mut self,
        view: View,
        kernels: &mut PreparationKernels,
        light: &mut LightVolumes,
        work: impl FnOnce(&mut Scene) -> T,
    ) -> T {
        let world = self.first.field.world();
        let all_are_hidden = self.visible().next().is_none();
        let mut shown = self.all_mut().enumerate().filter(|(n, field)| field.look.visible || (all_are_hidden && *n == 0));
        let (_, base) = shown.next().expect("the first field is shown if no other is");
        let settings = base.look.settings(view.settings, world);
        let others = shown
            .map(|(_, other)| other)
            .map(|ClassifiedField { field, classification, look }| {
                let settings = look.settings(view.settings, world);
                OtherField { field, classification, settings }
            })
            .collect();
        let view = View { settings: &settings, ..view };
        work(&mut Scene::new(view, &base.field, &mut base.classification, kernels, light).with_others(others))
    }

    /// Drops all data derived from fields and transfer functions.
    pub fn drop_cached(&mut self) {
        self.all_mut().for_each(ClassifiedField::drop_cached);
    }
}

/// Rejects fields that are not on the grid of the first.
fn require_one_grid(first: &Field, other: &Field) -> Result<(), Error> {
    let name = Path::new(other.description().name());
    if other.grid() != first.grid() {
        return Err(Error::volume(name, "its grid is not that of the first channel"));
    }
    Ok(())
}
