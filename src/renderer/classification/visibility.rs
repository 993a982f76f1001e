//! Which min-max blocks of a field a transfer function can show.

use super::super::field::{Field, Layout};
use super::super::store::{Key, Stored};
use super::tables::TableKey;
use super::{Classification, PreparationKernels};
use crate::device::launch::VoxelKind;
use crate::device::launch::volume::{
    BlockNumbers, MinMaxBlocks, ShownChunksArguments, ShownSlabsArguments, SlabVisibilityArguments,
};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, GAUSSIAN_OVERSHOOT, Kernel};
use crate::settings::Blend;
use crate::transfer::Extinction;
use std::sync::Arc;

/// Which blocks of the layers that are held can show anything.
pub(in crate::renderer) struct VisibleBlocks {
    /// A bit per block and slab (kernels/volume/slab_visibility.cl).
    pub flags: Buffer<u8>,
    /// Blocks along u and v.
    pub blocks: [i32; 2],
    /// First and last slab of the chunks in which any block can, counted from the first layer that is held; the first is beyond the last
    /// if there is none.
    pub shown: Buffer<i32>,
    /// Which chunks of slabs show anything: where the outermost ones are found.
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

    fn bytes_of(numbers: &BlockNumbers, radius: i32) -> usize {
        numbers.slab_bytes(radius) + SHOWN_SLABS * size_of::<i32>() + numbers.chunks(radius).max(1)
    }
}

/// The first and the last.
const SHOWN_SLABS: usize = 2;

/// Of a kernel's field, for a blend mode.
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
    /// The blocks of a layer axis in which a kernel's field can show anything. Splatted layers mix the voxels of the paper's cubic.
    pub fn visible_blocks(
        &mut self,
        kernels: &mut PreparationKernels,
        device: &Device,
        field: &Field,
        (axis, kernel): (Axis, Kernel),
        extinction: Extinction,
        blend: Blend,
    ) -> Result<Arc<VisibleBlocks>, Error> {
        let (key, inputs) = (VisibleKey(TableKey::new(extinction, kernel), axis, kernel, blend), self.inputs_with(field));
        if let Some(kept) = self.store.get(device, &key, inputs)? {
            return Ok(kept);
        }
        let radius = kernel.radius();
        let blocks = field.min_max_blocks(&mut kernels.field, device, axis, kernel)?;
        let table = self.table(device, field, extinction, kernel)?;
        let bytes = VisibleBlocks::bytes_of(&blocks.numbers, radius);
        let found = match self.store.reuse(device, &key, inputs, bytes) {
            Some(reused) if reused.blocks == blocks.numbers.blocks => reused,
            _ => Arc::new(VisibleBlocks::new(device, &blocks.numbers, radius)?),
        };
        // Limits are of numbers as they are stored.
        let Layout { voxels, view } = field.weighted(&mut kernels.field, device, axis, kernel)?;
        // What ray casting takes missing voxels for is what its sums overshoot the distance from.
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

/// Finds [`VisibleBlocks::shown`] on the device, where it stays, so that no queue is waited for.
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
