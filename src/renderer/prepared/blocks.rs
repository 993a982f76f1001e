//! Min-max blocks, and which of them a transfer function can show.

use super::super::cache::{Kept, Key};
use super::layouts::Weighted;
use super::tables::TableKey;
use super::{Layout, Prepared};
use crate::device::launch::VoxelKind;
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{
    MinMaxArguments, MinMaxBlocks, ShownChunksArguments, ShownSlabsArguments, SlabVisibilityArguments,
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
    fn new(device: &Device, flags: usize, blocks: [i32; 2], chunks: usize) -> Result<Self, Error> {
        const SHOWN: &str = "the slabs that show anything";
        let flags = Buffer::new(device, flags, "the visibility of blocks")?;
        Ok(Self { flags, blocks, shown: Buffer::new(device, 2, SHOWN)?, shows: Buffer::new(device, chunks, SHOWN)? })
    }
}

/// The next float, of those that kernels tell from 0.
fn next_value(value: f32) -> f32 {
    if value == 0.0 { f32::MIN_POSITIVE } else { value.next_up() }
}

/// Of a layer axis and a radius.
#[derive(PartialEq)]
struct BlocksKey(Axis, i32, Weighted);

impl Key for BlocksKey {
    type Value = MinMaxBlocks;
    const OF_VOXELS: bool = true;
}

impl Kept for MinMaxBlocks {
    fn bytes(&self) -> usize {
        self.limits.bytes()
    }
}

/// Of a kernel's field, for a blend mode.
#[derive(PartialEq)]
struct VisibleKey(TableKey, Axis, Kernel, Blend);

impl Key for VisibleKey {
    type Value = VisibleBlocks;
    const OF_VOXELS: bool = true;
    const OF_TRANSFER: bool = true;
}

impl Kept for VisibleBlocks {
    fn bytes(&self) -> usize {
        self.flags.bytes() + self.shown.bytes() + self.shows.bytes()
    }
}

impl Prepared {
    /// Smallest and largest value, less the offset, that can change a ray which already holds the smallest (of minima: the largest) voxel;
    /// `None` where opacity decides.
    pub fn useful_values(&self, blend: Blend) -> Option<[f32; 2]> {
        let [least, largest] = self.voxel_values();
        match self.blend_of_numbers(blend) {
            Blend::Composite => None,
            Blend::Maximum => Some([next_value(least), f32::INFINITY]),
            Blend::Minimum => Some([f32::NEG_INFINITY, -next_value(-largest)]),
            // Only 0 adds nothing to a sum.
            Blend::Average if least < 0.0 => Some([f32::NEG_INFINITY, f32::INFINITY]),
            Blend::Average => Some([next_value(0.0), f32::INFINITY]),
            Blend::Iso(value) => Some([self.stored_value(value) as f32; 2]),
        }
    }

    /// What surrounds the voxels, less the offset: where values are gathered, the smallest one, which no sum of kernels can be told from;
    /// edges go on there.
    pub fn background_of(&self, blend: Blend) -> f32 {
        if blend.gathers_values() { 0.0 } else { self.background().0 }
    }

    /// The blend mode of stored numbers that is one of values.
    pub fn blend_of_numbers(&self, blend: Blend) -> Blend {
        if self.reverses_values() { blend.reversed() } else { blend }
    }

    /// Smallest and largest number of a voxel, less the offset, invalid ones included.
    pub fn voxel_values(&self) -> [f32; 2] {
        let largest = self.stored.range.1 as f32 - self.offset() as f32;
        let (background, _) = self.background();
        if self.holed { [background.min(0.0), background.max(largest)] } else { [0.0, largest] }
    }

    /// Of what a kernel weights.
    fn min_max_blocks(&mut self, device: &Device, axis: Axis, kernel: Kernel) -> Result<Arc<MinMaxBlocks>, Error> {
        let key = BlocksKey(axis, kernel.radius(), Weighted::by(kernel));
        if let Some(kept) = self.cache.get(&key) {
            return Ok(kept);
        }
        let Layout { voxels, view } = self.weighted(device, axis, kernel)?;
        let blocks = match self.cache.take_stale(&key) {
            Some(stale) => stale,
            None => Arc::new(MinMaxBlocks::new(device, self.held_local(axis), voxels.voxel_type())?),
        };
        // Of what is held alone: the outermost blocks of a part are wrong, and no layer that it draws reaches them.
        let view = VolumeView { dims: [view.dims[0], view.dims[1], blocks.numbers.layers], first_a: 0, ..view };
        let arguments = MinMaxArguments::new(&voxels, view, kernel.radius(), &blocks);
        self.launchers.min_max_blocks.launch(device, voxels.kind(), &arguments)?;
        Ok(self.cache.keep(key, blocks))
    }

    /// The blocks of a layer axis in which a kernel's field can show anything. Splatted layers mix the voxels of the paper's cubic.
    pub fn visible_blocks(
        &mut self,
        device: &Device,
        axis: Axis,
        kernel: Kernel,
        extinction: Extinction,
        blend: Blend,
    ) -> Result<Arc<VisibleBlocks>, Error> {
        let key = VisibleKey(self.table_key(extinction, kernel), axis, kernel, blend);
        if let Some(kept) = self.cache.get(&key) {
            return Ok(kept);
        }
        let radius = kernel.radius();
        let blocks = self.min_max_blocks(device, axis, kernel)?;
        let table = self.table(device, extinction, kernel)?;
        let found = match self.cache.take_stale(&key) {
            Some(stale) => stale,
            None => Arc::new(VisibleBlocks::new(
                device,
                blocks.numbers.slab_bytes(radius),
                blocks.numbers.blocks,
                blocks.numbers.chunks(radius),
            )?),
        };
        // Limits are of numbers as they are stored.
        let Layout { voxels, view } = self.weighted(device, axis, kernel)?;
        // What ray casting takes missing voxels for is what its sums overshoot the distance from.
        let gaussian = kernel == Kernel::Gaussian && blend == Blend::Composite;
        let background = if gaussian { table.gaussian_background } else { self.background_of(blend) };
        let [blocks_u, blocks_v] = blocks.numbers.blocks;
        let [least, largest] = self.useful_values(blend).unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
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
        self.launchers.slab_visibility.launch(device, voxels.kind(), &arguments)?;
        self.find_shown_slabs(device, voxels.kind(), &found, &blocks, radius)?;
        Ok(self.cache.keep(key, found))
    }

    /// See [`VisibleBlocks::shown`]: on the device, where it stays, so that no queue is waited for.
    fn find_shown_slabs(
        &mut self,
        device: &Device,
        voxels: VoxelKind,
        found: &VisibleBlocks,
        blocks: &MinMaxBlocks,
        radius: i32,
    ) -> Result<(), Error> {
        let chunks = blocks.numbers.chunks(radius) as i32;
        let shows = &found.shows;
        let arguments =
            ShownChunksArguments { visible: &found.flags, per_layer: blocks.numbers.per_layer() as i32, chunks, shows };
        self.launchers.shown_chunks.launch(device, voxels, &arguments)?;
        let arguments = ShownSlabsArguments { shows, chunks, slabs: blocks.numbers.slabs(radius), shown: &found.shown };
        self.launchers.shown_slabs.launch(device, voxels, &arguments)
    }
}
