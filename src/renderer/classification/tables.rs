//! Tables of a transfer function on the device.

use super::super::field::{Field, Layout};
use super::super::store::{Key, Stored};
use super::{Classification, PreparationKernels};
use crate::device::launch::layered::Segments;
use crate::device::launch::structs::Float4;
use crate::device::{Buffer, Device, Produced};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use crate::settings::Settings;
use crate::transfer::{EXTINCTION_CELLS, Extinction, IntegralTable, TransferFunction, TransferTable};
use crate::volume::{Description, Stored as StoredNumbers};
use std::borrow::Cow;
use std::sync::Arc;

const TABLE: &str = "the transfer table";
const INTEGRALS: &str = "the table of integrals";

/// Threshold of the colour error of a segment at which correcting it is worth three times the time: 20 dB locally. Transfer
/// functions that exceed it are opaque and of several hues; that of aneurism has 0.07.
pub(in crate::renderer) const DIMMING: f64 = 0.1;

/// Mapping from values to table indices.
#[derive(Clone, Copy, Debug)]
pub(in crate::renderer) struct Scale {
    /// Value of the first entry with the offset subtracted.
    pub first: f32,
    /// Entries per unit of value.
    pub per_value: f32,
    /// Index of the last entry.
    pub last: i32,
}

impl Scale {
    fn new(field: &Field, first: f64, per_value: f64, entries: usize) -> Self {
        Self { first: (first - field.offset()) as f32, per_value: per_value as f32, last: entries as i32 - 1 }
    }
}

/// A transfer table.
pub(in crate::renderer) struct Table {
    pub on_host: TransferTable,
    /// (r, g, b, τ), or with linear extinction (r, g, b, α), per value.
    pub entries: Buffer<Float4>,
    /// Number of entries with opacity before each entry.
    pub visible_before: Buffer<u32>,
    /// Number of entries before each entry.
    pub all_before: Buffer<u32>,
    pub scale: Scale,
    /// First and last entry with opacity; the first exceeds the last if there is none.
    pub visible_entries: [i32; 2],
    /// See [`crate::TransferFunction::gaussian_background`]; with the offset subtracted.
    pub gaussian_background: f32,
}

/// Segment integrals of a transfer table.
pub(in crate::renderer) struct Integrals {
    /// Extinctions by cell, as bits; the integrals of all nodes; the values at these nodes, as bits.
    pub nodes: Buffer<[i32; 4]>,
    pub scale: Scale,
    /// Range of the values with opacity, with the offset subtracted.
    pub visible_values: [f32; 2],
    /// Extinction of one unit.
    pub unit: f32,
    /// Whether values can lie outside the nodes.
    pub cut: bool,
    /// Whether absorption within a layer can change its colour noticeably. Programs are built for it.
    pub dimmed: bool,
}

impl Integrals {
    /// Segment permutation for these integrals with `per_layer` samples per layer.
    pub fn segments(&self, extinction: Extinction, per_layer: u32) -> Segments {
        Segments { dimmed: self.dimmed && extinction == Extinction::Exponential, whole: per_layer == 1 }
    }
}

/// What the entries of a table hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct EntryKind {
    pub extinction: Extinction,
    /// Colours are reflectances in linear light, as the studio needs them.
    pub is_linear_light: bool,
}

impl EntryKind {
    pub fn new(settings: &Settings) -> Self {
        Self { extinction: settings.extinction, is_linear_light: settings.studio.is_some() }
    }
}

/// Key: what entries hold, overshoot of the field beyond the voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TableKey(EntryKind, f64);

impl Key for TableKey {
    type Value = Table;
}

impl Stored for Table {
    fn bytes(&self) -> usize {
        self.entries.bytes() + self.visible_before.bytes() + self.all_before.bytes()
    }
}

/// Key: table, shortest segment in unit distances, samples per layer.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct IntegralsKey(pub TableKey, pub f64, pub u32);

impl Key for IntegralsKey {
    type Value = Integrals;
}

impl Stored for Integrals {
    fn bytes(&self) -> usize {
        self.nodes.bytes()
    }
}

impl TableKey {
    pub fn new(kind: EntryKind, kernel: Kernel) -> Self {
        Self(kind, kernel.field_overshoot())
    }
}

impl Classification {
    /// The transfer table for the values of a kernel's field.
    pub fn table(&mut self, device: &Device, field: &Field, kind: EntryKind, kernel: Kernel) -> Result<Arc<Table>, Error> {
        let (key, inputs) = (TableKey::new(kind, kernel), self.inputs());
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok(kept);
        }
        let stored = field.stored();
        let on_host = TransferTable::new(&self.transfer, field_range(&stored, kernel), kind.extinction).scaled(self.factor);
        let on_host = if kind.is_linear_light { on_host.in_linear_light() } else { on_host };
        let entries: Vec<Float4> = on_host.entries.iter().map(|&e| Float4(e)).collect();
        let table = Table {
            entries: Buffer::from_slice(device, &entries, TABLE)?,
            visible_before: Buffer::from_slice(device, &on_host.visible_before(), TABLE)?,
            all_before: Buffer::from_slice(device, &(0..=entries.len() as u32).collect::<Vec<_>>(), TABLE)?,
            visible_entries: on_host.visible_entries(),
            scale: Scale::new(field, on_host.first, on_host.per_value, entries.len()),
            gaussian_background: (self.transfer.gaussian_background(stored.smallest_value, stored.background) - field.offset())
                as f32,
            on_host,
        };
        Ok(self.store.keep(key, inputs, Produced::by_host(), table))
    }

    /// The uploaded layout as input of the Gaussian kernel, with a background of its own for missing voxels.
    pub fn gaussian_layout(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        kind: EntryKind,
    ) -> Result<Layout, Error> {
        let mut layout = field.layout(&mut kernels.field, device, Axis::Z)?;
        layout.view.background = self.table(device, field, kind, Kernel::Gaussian)?.gaussian_background;
        Ok(layout)
    }

    /// Segment integrals of a kernel's field, for segments of at least `thinnest` unit distances and `per_layer` segments per
    /// layer.
    pub fn integrals(
        &mut self,
        device: &Device,
        field: &Field,
        kind: EntryKind,
        kernel: Kernel,
        (thinnest, per_layer): (f64, u32),
    ) -> Result<Arc<Integrals>, Error> {
        let (key, inputs) = (IntegralsKey(TableKey::new(kind, kernel), thinnest, per_layer), self.inputs());
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok(kept);
        }
        let table = self.table(device, field, kind, kernel)?;
        let on_host = table.on_host.integrals(thinnest);
        let integrals = Integrals {
            nodes: Buffer::from_slice(device, &for_kernels(&on_host, field.offset()), INTEGRALS)?,
            scale: Scale::new(field, on_host.first, on_host.per_value, on_host.nodes.len()),
            visible_values: on_host.visible_values().map(|v| (v - field.offset()) as f32),
            unit: on_host.unit as f32,
            cut: field.range_is_declared() || !on_host.spans(field_range(&field.stored(), kernel)),
            dimmed: self.dimmed.unwrap_or_else(|| table.on_host.dimming(thinnest * f64::from(per_layer)) > DIMMING),
        };
        Ok(self.store.keep(key, inputs, Produced::by_host(), integrals))
    }
}

/// Range of the stored numbers that a kernel can reconstruct.
fn field_range(stored: &StoredNumbers, kernel: Kernel) -> (f64, f64) {
    let (lo, hi) = stored.field_range();
    let beyond = kernel.field_overshoot() * (hi - lo);
    (lo - beyond, hi + beyond)
}

/// Sizes of the tables of a transfer function, for resource declarations.
pub(in crate::renderer) struct TableSizes<'t> {
    transfer: Cow<'t, TransferFunction>,
    stored: StoredNumbers,
}

impl<'t> TableSizes<'t> {
    /// Sizes for a transfer function of values and a volume.
    pub fn new(transfer: &TransferFunction, description: &Description) -> Self {
        Self { transfer: Cow::Owned(transfer.for_stored_numbers(description.rescale())), stored: description.stored() }
    }

    /// Sizes for a classification of a field.
    pub fn from_classification(classification: &'t Classification, field: &Field) -> Self {
        Self { transfer: Cow::Borrowed(&classification.transfer), stored: field.stored() }
    }

    /// Number of entries of the transfer table of a kernel's field.
    pub fn entries(&self, kernel: Kernel) -> usize {
        TransferTable::entry_count(&self.transfer, field_range(&self.stored, kernel))
    }

    /// Bytes of each buffer of a table with this number of entries.
    pub fn table(entries: usize) -> [(&'static str, usize); 3] {
        let before = (entries + 1) * size_of::<u32>();
        [(TABLE, entries * size_of::<Float4>()), (TABLE, before), (TABLE, before)]
    }

    /// Upper limit in bytes of the integrals of a table with this number of entries; fewer if it is mostly opaque.
    pub fn integrals(entries: usize) -> (&'static str, usize) {
        (INTEGRALS, (2 * (entries + 1) + CELL_ENTRIES) * size_of::<[i32; 4]>())
    }
}

/// Entries before the first node: extinctions by cell, and the scale of the cells.
pub(super) const CELL_ENTRIES: usize = 2 * EXTINCTION_CELLS / 4 + 1;

/// Contents of [`Integrals::nodes`]. The cells are followed by their scale: cells per unit of value, and the position of value 0.
fn for_kernels(table: &IntegralTable, offset: f64) -> Vec<[i32; 4]> {
    let bits = |four: &[f32; 4]| four.map(|c| c.to_bits() as i32);
    let cells = table.extinction_cells();
    let scale = [cells.per_value, (offset - cells.first) * cells.per_value, 0.0, 0.0].map(|n| n as f32);
    let fours = cells.at.as_chunks().0.iter().chain(cells.to_next.as_chunks().0).chain([&scale]);
    fours.map(bits).chain(table.nodes.iter().copied()).chain(table.at_nodes.iter().map(bits)).collect()
}
