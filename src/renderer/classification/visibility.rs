//! Visibility of min-max blocks, for empty-space skipping.

use super::super::field::{Field, Layout};
use super::super::store::{Key, Stored};
use super::tables::{EntryKind, TableKey};
use super::{Classification, PreparationKernels};
use crate::device::launch::VoxelKind;
use crate::device::launch::volume::{
    BlockNumbers, MinMaxBlocks, ShownChunksArguments, ShownSlabsArguments, SlabVisibilityArguments,
};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, GAUSSIAN_OVERSHOOT, Kernel};
use crate::settings::Blend;
use std::sync::Arc;

/// Visibility of the blocks in the layers on the device.
pub(in crate::renderer) struct VisibleBlocks {
    /// One bit per block and slab (kernels/volume/slab_visibility.cl).
    pub flags: Buffer<u8>,
    /// Number of blocks along u and v.
    pub blocks: [i32; 2],
    /// First and last slab of the chunks with visible blocks, counted from the first layer on the device; the first exceeds the
    /// last if there is none.
    pub shown: Buffer<i32>,
    /// Visibility of chunks of slabs, from which `shown` is found.
    shows: Buffer<u8>,
}

impl VisibleBlocks {
    fn new(device: &Device, numbers: &BlockNumbers, radius: i32) -> Result<Self, Error> {
        const SHOWN: &str = "the visible slabs";
        Ok(Self {
            flags: Buffer::new(device, numbers.slab_bytes(radius), "the visibility of blocks")?,
            blocks: numbers.blocks,
            shown: Buffer::new(device, SHOWN_SLABS, SHOWN)?,
            shows: Buffer::new(device, numbers.chunks(radius), SHOWN)?,
        })
    }

    /// No blocks, for kernels that visit everything.
    pub fn unculled(device: &Device) -> Result<Self, Error> {
        const UNUSED: &str = "the visibility of blocks";
        let (flags, shown, shows) =
            (Buffer::new(device, 1, UNUSED)?, Buffer::new(device, SHOWN_SLABS, UNUSED)?, Buffer::new(device, 1, UNUSED)?);
        Ok(Self { flags, blocks: [0; 2], shown, shows })
    }

    fn bytes_needed(numbers: &BlockNumbers, radius: i32) -> usize {
        numbers.slab_bytes(radius) + SHOWN_SLABS * size_of::<i32>() + numbers.chunks(radius).max(1)
    }
}

/// Length of [`VisibleBlocks::shown`].
const SHOWN_SLABS: usize = 2;

/// Key: table, layer axis, kernel, blend mode.
#[derive(PartialEq)]
struct VisibleKey(TableKey, Axis, Kernel, Blend);

impl Key for VisibleKey {
    type Value = VisibleBlocks;
}

impl Stored for VisibleBlocks {
    fn bytes(&self) -> usize {
        self.flags.bytes() + self.shown.bytes() + self.shows.bytes()
    }
}

impl Classification {
    /// Visibility of the blocks of a layer axis for a kernel's field. Splatted layers use the paper's cubic kernel.
    pub fn visible_blocks(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        (axis, kernel): (Axis, Kernel),
        kind: EntryKind,
        blend: Blend,
    ) -> Result<Arc<VisibleBlocks>, Error> {
        let (key, inputs) = (VisibleKey(TableKey::new(kind, kernel), axis, kernel, blend), self.inputs_with(field));
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok(kept);
        }
        let radius = kernel.radius();
        let blocks = field.min_max_blocks(&mut kernels.field, device, axis, kernel)?;
        let table = self.table(device, field, kind, kernel)?;
        let bytes = VisibleBlocks::bytes_needed(&blocks.numbers, radius);
        let found = match self.store.reuse(device, &key, inputs, bytes) {
            Some(reused) if reused.blocks == blocks.numbers.blocks => reused,
            _ => Arc::new(VisibleBlocks::new(device, &blocks.numbers, radius)?),
        };
        // Block limits are numbers as stored, before the offset is subtracted.
        let Layout { voxels, view } = field.weighted(&mut kernels.field, device, axis, kernel)?;
        // The overshoot is relative to the background that ray casting uses for missing voxels.
        let gaussian = kernel == Kernel::Gaussian && blend == Blend::Composite;
        let background = if gaussian { table.gaussian_background } else { field.background_for(blend) };
        let [blocks_u, blocks_v] = blocks.numbers.blocks;
        let [least, largest] = field.useful_values(blend).unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
        let arguments = SlabVisibilityArguments {
            limits: &blocks.limits,
            blocks_u,
            blocks_v,
            layers: blocks.numbers.layers,
            radius,
            background,
            offset: view.offset,
            least,
            largest,
            table_first: table.scale.first,
            table_per_value: table.scale.per_value,
            table_last: table.scale.last,
            visible_before: if blend == Blend::Composite { &table.visible_before } else { &table.all_before },
            overshoot: kernel.overshoot() as f32,
            slack: if kernel == Kernel::Gaussian { GAUSSIAN_OVERSHOOT as f32 } else { 0.0 },
            visible: &found.flags,
        };
        kernels.slab_visibility.launch(device, voxels.kind(), &arguments)?;
        find_shown_slabs(kernels, device, voxels.kind(), &found, &blocks, radius)?;
        Ok(self.store.keep(key, inputs, device.produced()?, found))
    }
}

/// Computes [`VisibleBlocks::shown`] on the device without reading it back, so that no queue is waited for.
fn find_shown_slabs(
    kernels: &mut PreparationKernels,
    device: &Device,
    voxels: VoxelKind,
    found: &VisibleBlocks,
    blocks: &MinMaxBlocks,
    radius: i32,
) -> Result<(), Error> {
    let chunks = blocks.numbers.chunks(radius) as i32;
    let shows = &found.shows;
    let arguments = ShownChunksArguments { visible: &found.flags, per_layer: blocks.numbers.per_layer() as i32, chunks, shows };
    kernels.shown_chunks.launch(device, voxels, &arguments)?;
    let arguments = ShownSlabsArguments { shows, chunks, slabs: blocks.numbers.slabs(radius), shown: &found.shown };
    kernels.shown_slabs.launch(device, voxels, &arguments)
}
