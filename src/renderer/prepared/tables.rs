//! Tables of a transfer function on the device.

use super::super::cache::{Kept, Key};
use super::Prepared;
use crate::device::launch::layered::Segments;
use crate::device::launch::rays::PreintegratedTableArguments;
use crate::device::launch::structs::{Float4, SampleParams};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Kernel, lighting_curve, segment_ends};
use crate::transfer::{EXTINCTION_CELLS, Extinction, IntegralTable, TransferFunction, TransferTable};
use crate::volume::Stored;
use std::sync::Arc;

/// Values in front and behind that the table of slicing has entries for.
pub(in crate::renderer) const SLAB_VALUES: usize = 256;

/// Error of a segment's colour from which on it is worth three times the time: 20 dB where it happens. Transfer functions with it
/// are opaque and of several hues; aneurism's has 0.07.
const DIMMING: f64 = 0.1;

/// Where values lie in a table.
#[derive(Clone, Copy, Debug)]
pub(in crate::renderer) struct Scale {
    /// Value of the first entry, less the offset.
    pub first: f32,
    /// Entries per value.
    pub per_value: f32,
    /// Index of the last entry.
    pub last: i32,
}

impl Scale {
    /// The parameters of samples that are looked up in this table.
    pub fn set(self, sample: &mut SampleParams) {
        (sample.table_first, sample.table_per_value, sample.table_last) = (self.first, self.per_value, self.last);
    }
}

/// A transfer table.
pub(in crate::renderer) struct Table {
    on_host: TransferTable,
    /// (r, g, b, τ), or with linear extinction (r, g, b, α), per value.
    pub entries: Buffer<Float4>,
    /// How many entries before each one have opacity.
    pub visible_before: Buffer<u32>,
    /// How many entries are before each one.
    pub all_before: Buffer<u32>,
    pub scale: Scale,
    /// First and last entry with opacity; if there is none, the first is beyond the last.
    pub visible_entries: [i32; 2],
    /// See [`crate::TransferFunction::gaussian_background`]; less the offset.
    pub gaussian_background: f32,
}

/// The integrals of a transfer table.
pub(in crate::renderer) struct Integrals {
    /// As bits extinctions by cells; integrals of all nodes; and as bits these nodes' own values.
    pub nodes: Buffer<[i32; 4]>,
    pub scale: Scale,
    /// Values, less the offset, between which lies all opacity.
    pub visible_values: [f32; 2],
    /// Extinction of one unit.
    pub unit: f32,
    /// Whether values can lie beyond the nodes.
    pub cut: bool,
    /// Whether light lost within a layer can change its colour.
    pub dimmed: bool,
}

impl Table {
    /// The parameters of samples that are classified by this table.
    pub fn set(&self, sample: &mut SampleParams) {
        self.scale.set(sample);
        sample.visible = self.visible_entries;
    }
}

impl Integrals {
    /// The parameters of samples between which segments are classified by these integrals, so many per layer.
    pub fn set(&self, sample: &mut SampleParams, kernel: Kernel, per_layer: u32) {
        self.scale.set(sample);
        sample.shown = self.visible_values;
        sample.table_unit = self.unit;
        sample.samples_per_layer = [per_layer as i32, 0, 0];
        for (n, ends) in (0..per_layer).zip(&mut sample.ends) {
            *ends = segment_ends(kernel, per_layer, n).map(|w| w as f32);
        }
        sample.curve = lighting_curve(kernel, per_layer) as f32;
    }

    /// How segments are built from these integrals, so many per layer.
    pub fn segments(&self, extinction: Extinction, kernel: Kernel, per_layer: u32) -> Segments {
        Segments {
            cut: self.cut,
            curved: segment_ends(kernel, per_layer, 0) != [0.0; 2],
            dimmed: self.dimmed && extinction == Extinction::Exponential,
            whole: per_layer == 1,
        }
    }
}

/// What a table depends on: the transfer function's revision, the kind of extinction, and how far the field overshoots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TableKey(u64, Extinction, f64);

impl Key for TableKey {
    type Value = Table;
    const OF_VOXELS: bool = false;
    const OF_TRANSFER: bool = true;
}

impl Kept for Table {
    fn bytes(&self) -> usize {
        self.entries.bytes() + self.visible_before.bytes() + self.all_before.bytes()
    }
}

/// And the shortest segment, in unit distances, of so many per layer.
#[derive(Clone, Copy, PartialEq)]
struct IntegralsKey(TableKey, f64, u32);

impl Key for IntegralsKey {
    type Value = Integrals;
    const OF_VOXELS: bool = false;
    const OF_TRANSFER: bool = true;
}

impl Kept for Integrals {
    fn bytes(&self) -> usize {
        self.nodes.bytes()
    }
}

/// And the thickness of a slab, in unit distances.
#[derive(PartialEq)]
struct SlicingKey(IntegralsKey, f32);

impl Key for SlicingKey {
    type Value = Buffer<Float4>;
    const OF_VOXELS: bool = false;
    const OF_TRANSFER: bool = true;
}

impl Prepared {
    pub(super) fn table_key(&self, extinction: Extinction, kernel: Kernel) -> TableKey {
        TableKey(self.revision, extinction, kernel.field_overshoot())
    }

    fn field_range(&self, kernel: Kernel) -> (f64, f64) {
        field_range(&self.stored, kernel)
    }

    /// The table of the transfer function, for the values of a kernel's field.
    pub fn table(&mut self, device: &Device, extinction: Extinction, kernel: Kernel) -> Result<Arc<Table>, Error> {
        let key = self.table_key(extinction, kernel);
        if let Some(kept) = self.cache.get(&key) {
            return Ok(kept);
        }
        let on_host = TransferTable::new(&self.transfer, self.field_range(kernel), extinction);
        let entries: Vec<Float4> = on_host.entries.iter().map(|&e| Float4(e)).collect();
        let table = Table {
            entries: Buffer::from_slice(device, &entries, "the transfer table")?,
            visible_before: Buffer::from_slice(device, &on_host.visible_before(), "the transfer table")?,
            all_before: Buffer::from_slice(device, &(0..=entries.len() as u32).collect::<Vec<_>>(), "the transfer table")?,
            visible_entries: on_host.visible_entries(),
            scale: self.scale(on_host.first, on_host.per_value, entries.len()),
            gaussian_background: (self.transfer.gaussian_background(self.stored.smallest_value, self.stored.background)
                - self.offset()) as f32,
            on_host,
        };
        Ok(self.cache.keep(key, table))
    }

    /// The integrals of the transfer function for segments of at least `thinnest` unit distances, so many per layer, of a kernel's field.
    pub fn integrals(
        &mut self,
        device: &Device,
        extinction: Extinction,
        kernel: Kernel,
        thinnest: f64,
        per_layer: u32,
    ) -> Result<Arc<Integrals>, Error> {
        let key = IntegralsKey(self.table_key(extinction, kernel), thinnest, per_layer);
        if let Some(kept) = self.cache.get(&key) {
            return Ok(kept);
        }
        let table = self.table(device, extinction, kernel)?;
        let on_host = table.on_host.integrals(thinnest);
        let cut = self.promised || !on_host.spans(self.field_range(kernel));
        let integrals = Integrals {
            nodes: Buffer::from_slice(device, &for_kernels(&on_host, self.offset(), cut), "the table of integrals")?,
            scale: self.scale(on_host.first, on_host.per_value, on_host.nodes.len()),
            visible_values: on_host.visible_values().map(|v| (v - self.offset()) as f32),
            unit: on_host.unit as f32,
            cut,
            dimmed: table.on_host.dimming(thinnest * f64::from(per_layer)) > DIMMING,
        };
        Ok(self.cache.keep(key, integrals))
    }

    /// The integrals and the table of slicing for slabs of a thickness in unit distances.
    pub fn slicing_table(
        &mut self,
        device: &Device,
        extinction: Extinction,
        thickness: f64,
    ) -> Result<(Arc<Integrals>, Arc<Buffer<Float4>>), Error> {
        let integrals = self.integrals(device, extinction, Kernel::Linear, thickness, 1)?;
        let key = SlicingKey(IntegralsKey(self.table_key(extinction, Kernel::Linear), thickness, 1), thickness as f32);
        if let Some(kept) = self.cache.get(&key) {
            return Ok((integrals, kept));
        }
        let table = Buffer::new(device, SLAB_VALUES * SLAB_VALUES, "the pre-integration table")?;
        let nodes = integrals.scale.last + 1;
        let arguments = PreintegratedTableArguments {
            integrals: &integrals.nodes,
            first: CELL_ENTRIES as i32,
            nodes,
            nodes_per_entry: (nodes - 1) as f32 / (SLAB_VALUES - 1) as f32,
            unit: integrals.unit,
            thickness: thickness as f32,
            linear: i32::from(extinction == Extinction::Linear),
            size: SLAB_VALUES as i32,
            out: &table,
        };
        self.launchers.slicing_table.launch(device, (), &arguments)?;
        Ok((integrals, self.cache.keep(key, table)))
    }

    fn scale(&self, first: f64, per_value: f64, entries: usize) -> Scale {
        Scale { first: (first - self.offset()) as f32, per_value: per_value as f32, last: entries as i32 - 1 }
    }
}

/// Range of the values that a kernel can reconstruct, as numbers.
fn field_range(stored: &Stored, kernel: Kernel) -> (f64, f64) {
    let (lo, hi) = stored.field_range();
    let beyond = kernel.field_overshoot() * (hi - lo);
    (lo - beyond, hi + beyond)
}

/// Entries that the table of a transfer function of stored numbers will have.
pub(in crate::renderer) fn table_entries(
    transfer: &TransferFunction,
    stored: &Stored,
    extinction: Extinction,
    kernel: Kernel,
) -> usize {
    TransferTable::new(transfer, field_range(stored, kernel), extinction).entries.len()
}

/// Bytes of the buffers of a table with so many entries.
pub(in crate::renderer) fn table_bytes(entries: usize) -> [usize; 3] {
    let before = (entries + 1) * size_of::<u32>();
    [entries * size_of::<Float4>(), before, before]
}

/// Most bytes of the integrals of a table with so many entries; less where it is mostly opaque.
pub(in crate::renderer) fn integrals_bytes(entries: usize) -> usize {
    2 * (entries + 1) * size_of::<[i32; 4]>() + CELL_ENTRIES * size_of::<[i32; 4]>()
}

/// Entries before the first node: extinctions by cells, and these cells' scale.
const CELL_ENTRIES: usize = 2 * EXTINCTION_CELLS / 4 + 1;

/// What [`Integrals`] have in `nodes`: behind the cells, how many there are per unit of value, the place of 0 among them, and
/// whether values can lie beyond the nodes.
fn for_kernels(table: &IntegralTable, offset: f64, cut: bool) -> Vec<[i32; 4]> {
    let bits = |four: &[f32; 4]| four.map(|c| c.to_bits() as i32);
    let cells = table.extinction_cells();
    let scale = [cells.per_value, (offset - cells.first) * cells.per_value, f64::from(cut), 0.0].map(|n| n as f32);
    let fours = cells.at.as_chunks().0.iter().chain(cells.to_next.as_chunks().0).chain([&scale]);
    fours.map(bits).chain(table.nodes.iter().copied()).chain(table.at_nodes.iter().map(bits)).collect()
}
