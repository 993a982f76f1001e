//! The classification: one transfer function over one field. Its tables and integrals, and what of the field it can show.

mod params;
mod splat_list;
mod tables;
mod visibility;

pub(super) use splat_list::{SplatList, Splatted, read_total};
pub(super) use tables::{Integrals, SLAB_VALUES, SegmentNeeds, Table, TableSizes};
pub(super) use visibility::VisibleBlocks;

use super::field::{Field, FieldKernels};
use super::store::{Inputs, Store, Version};
use crate::device::launch::Launcher;
use crate::device::launch::rays::PreintegratedTable;
use crate::device::launch::sheets::{Scan, Splats};
use crate::device::launch::volume::{ShownChunks, ShownSlabs, SlabVisibility};
use crate::transfer::TransferFunction;
use crate::volume::Rescale;

/// Bytes that a classification keeps.
const BUDGET: usize = 256 << 20;

/// A transfer function, and what is made from it and a field.
pub(super) struct Classification {
    /// Of values.
    given: TransferFunction,
    /// Of stored numbers.
    transfer: TransferFunction,
    version: Version,
    store: Store,
    /// In a rehearsal, in place of what the transfer function needs.
    segment_needs: Option<SegmentNeeds>,
}

/// The kernels that make things for frames from a field and a transfer function.
#[derive(Default)]
pub(super) struct PreparationKernels {
    pub field: FieldKernels,
    slab_visibility: Launcher<SlabVisibility>,
    shown_chunks: Launcher<ShownChunks>,
    shown_slabs: Launcher<ShownSlabs>,
    slicing_table: Launcher<PreintegratedTable>,
    splats: Launcher<Splats>,
    scan: Launcher<Scan>,
}

impl Classification {
    /// A transfer function of values, for stored numbers that become values by `rescale`.
    pub fn new(transfer: &TransferFunction, rescale: Rescale) -> Self {
        Self {
            given: transfer.clone(),
            transfer: transfer.of_stored(rescale),
            version: Version::new(),
            store: Store::new(BUDGET),
            segment_needs: None,
        }
    }

    /// The same with nothing made yet, for frames that are not drawn. `needs`: of segments, in place of what the transfer function needs.
    pub fn for_rehearsal(&self, needs: Option<SegmentNeeds>) -> Self {
        let (given, transfer) = (self.given.clone(), self.transfer.clone());
        Self { given, transfer, version: Version::new(), store: Store::new(BUDGET), segment_needs: needs }
    }

    /// Takes another transfer function. What was made from the last one is written again where it is needed.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction, rescale: Rescale) {
        if self.given != *transfer {
            (self.given, self.transfer, self.version) = (transfer.clone(), transfer.of_stored(rescale), Version::new());
        }
    }

    /// Takes a field of another range.
    pub fn set_field(&mut self, field: &Field) {
        (self.transfer, self.version) = (self.given.of_stored(field.description().rescale()), Version::new());
    }

    /// The transfer function of values.
    pub fn transfer_function(&self) -> &TransferFunction {
        &self.given
    }

    /// Whether the background of a field has opacity.
    pub fn shows_background(&self, field: &Field) -> bool {
        self.transfer.opacity(field.stored().background) > 0.0
    }

    /// Drops what was made from the transfer function.
    pub fn make_room(&mut self) {
        self.store.clear();
    }

    fn inputs(&self) -> Inputs {
        Inputs { classification: Some(self.version), field: None }
    }

    fn inputs_with(&self, field: &Field) -> Inputs {
        Inputs { classification: Some(self.version), field: Some(field.version()) }
    }

    /// Values made so far.
    #[cfg(test)]
    pub fn made(&self) -> usize {
        self.store.made
    }
}
