//! What is kept on the device of a transfer function.

use super::splat_list::{SplatList, Splatted};
use crate::device::launch::params::Float4;
use crate::device::launch::{Occupancy, Reach};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::GAUSSIAN_OVERSHOOT;
use crate::transfer::{Extinction, IntegralTable, TransferFunction, TransferTable};

/// How far samples at points reach for voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointReach {
    /// Rays lean at most one voxel per layer, or samples are looked up by their own cell.
    Near,
    /// Some rays lean more.
    Leaning,
    /// By their own cell, reconstructed with a Gaussian of radius 2.
    Gaussian,
}

impl PointReach {
    /// What its occupancy covers.
    pub fn occupancy(self) -> Reach {
        match self {
            PointReach::Near | PointReach::Leaning => Reach::POINTS,
            PointReach::Gaussian => Reach::GAUSSIAN,
        }
    }

    /// Blocks to either side that are in reach.
    pub fn around(self) -> i32 {
        i32::from(self == PointReach::Leaning)
    }

    /// By how much sums overshoot the voxels' distance from the background.
    pub fn slack(self) -> f32 {
        if self == PointReach::Gaussian { GAUSSIAN_OVERSHOOT as f32 } else { 0.0 }
    }
}

/// What tables for samples at points depend on.
#[derive(Clone, Copy)]
pub(super) struct PointRays {
    pub reach: PointReach,
    /// Shortest stretch between two samples, in unit distances, where stretches are pre-integrated.
    pub thinnest: Option<f64>,
    /// Such stretches per layer.
    pub samples: u32,
}

/// A transfer table on the device, with the blocks that it can show per layer axis.
pub(super) struct Table {
    pub extinction: Extinction,
    pub on_host: TransferTable,
    /// See [`TransferFunction::gaussian_background`]; less the offset, which is the smallest value.
    pub gaussian_background: f32,
    pub entries: Buffer<Float4>,
    pub visible_before: Buffer<u32>,
    /// Value of the first entry, less the offset, entries per value, index of the last entry.
    pub scale: (f32, f32, i32),
    /// First and last entry with opacity; if there is none, the first is beyond the last.
    pub visible_entries: [i32; 2],
    pub visible: [Option<Buffer<u8>>; 3],
    /// Bits per [`PointReach`] and layer axis.
    pub slabs_visible: [[Option<SlabsVisible>; 3]; 3],
    pub integrals: Option<Integrals>,
    /// The table of slicing, with the thickness of a slab that it is for.
    pub slabs: Option<(f32, Buffer<Float4>)>,
    /// What axis-aligned sheets splat, per layer axis.
    pub axis_splats: [Option<SplatList>; 3],
    /// What image-aligned sheets splat.
    pub view_splats: Option<(Splatted, SplatList)>,
}

/// Which blocks of which slabs can show anything.
pub(super) struct SlabsVisible {
    /// See kernels/slab_visibility.cl.
    pub bits: Buffer<u8>,
    /// First and last slab of the chunks in which any block can; the first is beyond the last if there is none.
    pub slabs: [i32; 2],
}

/// Error of a stretch's colour from which on it is worth three times the time: 20 dB where it happens. Transfer functions with it
/// are opaque and of several hues; aneurism's has 0.07.
const DIMMING: f64 = 0.1;

/// The integrals of a transfer table on the device.
pub(super) struct Integrals {
    pub thinnest: f64,
    pub samples: u32,
    /// Integrals of all nodes, then their own values, as bits.
    pub nodes: Buffer<[i32; 4]>,
    /// See [`Table::scale`].
    pub scale: (f32, f32, i32),
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
    pub fn upload(
        device: &Device,
        transfer: &TransferFunction,
        field_range: (f64, f64),
        offset: f64,
        extinction: Extinction,
    ) -> Result<Self, Error> {
        let table = TransferTable::new(transfer, field_range, extinction);
        let entries: Vec<Float4> = table.entries.iter().map(|&e| Float4(e)).collect();
        Ok(Self {
            extinction,
            entries: Buffer::from_slice(device, &entries, "the transfer table")?,
            visible_before: Buffer::from_slice(device, &table.visible_before(), "the transfer table")?,
            visible_entries: table.visible_entries(),
            scale: ((table.first - offset) as f32, table.per_value as f32, entries.len() as i32 - 1),
            on_host: table,
            gaussian_background: (transfer.gaussian_background(offset, field_range.0) - offset) as f32,
            visible: [None, None, None],
            slabs_visible: Default::default(),
            integrals: None,
            slabs: None,
            axis_splats: [None, None, None],
            view_splats: None,
        })
    }
}

impl SlabsVisible {
    pub fn new(device: &Device, bits: Buffer<u8>, occupancy: &Occupancy) -> Result<Self, Error> {
        let per_chunk = occupancy.blocks[0] as usize * occupancy.blocks[1] as usize;
        let chunks = occupancy.layers as usize / 8 + 1;
        let mut bytes = vec![0; chunks * per_chunk];
        bits.read(device, &mut bytes)?;
        let any = |chunk: &[u8]| chunk.iter().any(|&b| b != 0);
        let ends = bytes.chunks(per_chunk).position(any).zip(bytes.chunks(per_chunk).rposition(any));
        let slabs = ends.map_or([0, -1], |(first, last)| [8 * first as i32, (8 * last as i32 + 7).min(occupancy.layers)]);
        Ok(Self { bits, slabs })
    }
}

impl Integrals {
    pub fn upload(
        device: &Device,
        on_host: &TransferTable,
        field_range: (f64, f64),
        offset: f64,
        thinnest: f64,
        samples: u32,
    ) -> Result<Self, Error> {
        let table = on_host.integrals(thinnest);
        Ok(Self {
            thinnest,
            samples,
            nodes: Buffer::from_slice(device, &integrals_and_values(&table), "the table of integrals")?,
            scale: ((table.first - offset) as f32, table.per_value as f32, table.nodes.len() as i32 - 1),
            visible_values: table.visible_values().map(|v| (v - offset) as f32),
            unit: table.unit as f32,
            cut: !table.spans(field_range),
            dimmed: on_host.dimming(thinnest * f64::from(samples)) > DIMMING,
        })
    }
}

/// Integrals of all nodes, then their own values, as bits.
fn integrals_and_values(table: &IntegralTable) -> Vec<[i32; 4]> {
    let values = table.at_nodes.iter().map(|at| at.map(|c| c.to_bits() as i32));
    table.nodes.iter().copied().chain(values).collect()
}
