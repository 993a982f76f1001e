//! The classification: a transfer function applied to a field, with its tables, its integrals, and the visibility of min-max
//! blocks.

#[cfg(feature = "paper")]
mod paper;
mod params;
mod tables;
mod visibility;

#[cfg(feature = "paper")]
pub(super) use paper::{SLAB_VALUES, SplatList, Splatted, slicing_table_size};
pub(super) use tables::{DIMMING, EntryKind, Integrals, Table, TableSizes};
pub(super) use visibility::VisibleBlocks;

use super::field::{Field, FieldKernels};
use super::store::{Inputs, Store, Version};
use crate::device::launch::Launcher;
use crate::device::launch::volume::{ShownChunks, ShownSlabs, SlabVisibility};
use crate::transfer::TransferFunction;

/// Cache budget of a classification in bytes.
const BUDGET: usize = 256 << 20;

/// A transfer function, and data derived from it and a field.
pub(super) struct Classification {
    /// Transfer function of values.
    given: TransferFunction,
    /// Transfer function of stored numbers, which hides what lies beyond the end of the field.
    transfer: TransferFunction,
    /// Factor of the extinction.
    factor: f64,
    version: Version,
    store: Store,
    /// In a rehearsal, replaces [`Integrals::dimmed`] of the transfer function.
    dimmed: Option<bool>,
}

/// Kernels that derive data from a field and a transfer function.
#[derive(Default)]
pub(super) struct PreparationKernels {
    pub field: FieldKernels,
    slab_visibility: Launcher<SlabVisibility>,
    shown_chunks: Launcher<ShownChunks>,
    shown_slabs: Launcher<ShownSlabs>,
    #[cfg(feature = "paper")]
    paper: paper::PaperKernels,
}

impl Classification {
    /// A classification of a field by a transfer function of values.
    pub fn new(transfer: &TransferFunction, field: &Field) -> Self {
        Self {
            given: transfer.clone(),
            transfer: for_numbers(transfer, field),
            factor: 1.0,
            version: Version::new(),
            store: Store::new(BUDGET),
            dimmed: None,
        }
    }

    /// A clone for rehearsals, with an empty cache. `dimmed` replaces [`Integrals::dimmed`] of the
    /// transfer function.
    pub fn for_rehearsal(&self, dimmed: Option<bool>) -> Self {
        let (given, transfer) = (self.given.clone(), self.transfer.clone());
        Self { given, transfer, factor: self.factor, version: Version::new(), store: Store::new(BUDGET), dimmed }
    }

    /// Replaces the transfer function. Derived data are made again on demand.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction, field: &Field) {
        if self.given != *transfer {
            (self.given, self.transfer, self.version) = (transfer.clone(), for_numbers(transfer, field), Version::new());
        }
    }

    /// Factor of the extinction, and of the colours of reduced values.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// Sets the [`factor`](Self::factor). Derived data are made again on demand.
    pub fn set_factor(&mut self, factor: f64) {
        if self.factor != factor {
            (self.factor, self.version) = (factor, Version::new());
        }
    }

    /// Replaces the field by one with other stored numbers.
    pub fn set_field(&mut self, field: &Field) {
        (self.transfer, self.version) = (for_numbers(&self.given, field), Version::new());
    }

    /// The transfer function of values.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.given
    }

    /// Whether the background of a field has opacity.
    pub fn shows_background(&self, field: &Field) -> bool {
        self.transfer.opacity(field.stored().background) > 0.0
    }

    /// Whether any value has opacity.
    pub fn shows_anything(&self) -> bool {
        self.transfer.opacities().iter().any(|(_, opacity)| *opacity > 0.0)
    }

    /// Drops all derived data.
    pub fn drop_cached(&mut self) {
        self.store.clear();
    }

    fn inputs(&self) -> Inputs {
        Inputs { classification: Some(self.version), ..Inputs::default() }
    }

    /// Versions of this classification and a field.
    pub fn inputs_with(&self, field: &Field) -> Inputs {
        Inputs { field: Some(field.version()), ..self.inputs() }
    }

    /// Versions of a field and of this classification of it.
    pub fn versions(&self, field: &Field) -> [Version; 2] {
        [field.version(), self.version]
    }

    /// Number of values made so far.
    #[cfg(test)]
    pub fn made(&self) -> usize {
        self.store.made
    }
}

/// A transfer function of values, as one of the stored numbers of a field.
fn for_numbers(transfer: &TransferFunction, field: &Field) -> TransferFunction {
    field.hiding_beyond(transfer).for_stored_numbers(field.description().rescale())
}
