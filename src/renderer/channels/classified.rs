//! A field with its classification.

use super::super::classification::{Classification, TableSizes};
use super::super::field::{Field, FieldShape, UploadedVolume};
use super::{Channel, ChannelLook, PackedColors};
use crate::device::Device;
use crate::error::Error;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::{Held, Rescale, Stored as StoredNumbers};

/// A field on the device with its classification.
pub(in crate::renderer) struct ClassifiedField {
    pub field: Field,
    pub classification: Classification,
    pub look: ChannelLook,
    /// Colours of its voxels, among several.
    pub colors: Option<PackedColors>,
}

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
    pub(super) fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        let field = volume.field.for_renderer();
        Self { classification: Classification::new(transfer, &field), field, look: ChannelLook::default(), colors: None }
    }

    /// A copy for rehearsals, with empty caches.
    pub(super) fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let (field, classification) = (self.field.for_rehearsal(), self.classification.for_rehearsal(dimmed));
        Self { field, classification, look: self.look, colors: self.colors.clone() }
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

    pub(super) fn set(&mut self, channel: &Channel, field: Field) {
        self.set_field(field);
        self.set_transfer_function(&channel.transfer);
        self.classification.set_factor(channel.look.factor);
        self.look = channel.look;
        self.colors = channel.colors.clone();
    }

    /// Invalidates the tables if the stored numbers of the field have changed.
    fn reclassify(&mut self, before: Numbers) {
        if Numbers::new(&self.field) != before {
            self.classification.set_field(&self.field);
        }
    }

    /// Steepness of the transfer function over the values of the whole volume.
    pub(super) fn steepness(&self) -> f64 {
        self.classification.transfer_function().steepness(self.field.description().field_range())
    }

    /// Whether the field can change a picture.
    pub(super) fn shows(&self, blend: Blend) -> bool {
        let opaque = || self.look.factor > 0.0 && self.classification.shows_anything();
        self.look.visible && (blend != Blend::Composite || opaque())
    }

    /// Whether a picture has colours of its voxels, rather than surfaces at a value.
    pub(super) fn shows_colors(&self, blend: Blend) -> bool {
        self.colors.is_some() && self.shows(blend) && !(matches!(blend, Blend::Iso(_)) && self.look.iso.is_some())
    }

    pub(super) fn sizes(&self) -> (FieldShape, TableSizes<'_>) {
        (self.field.shape(), TableSizes::from_classification(&self.classification, &self.field))
    }

    pub(super) fn drop_cached(&mut self) {
        self.field.drop_cached();
        self.classification.drop_cached();
    }
}
