//! Kernels that prepare a volume: its layouts, its min-max blocks, and which of these can be seen.

use super::{Defines, Items, Launch, VoxelBuffer, kernel, structs::VolumeView};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::volume::VoxelType;

kernel! {
    /// Makes the layout of layer axis x.
    Transpose = "volume/transpose.cl", transpose, "transpose";
    TransposeArguments<'a> {
        voxels: &'a VoxelBuffer,
        dims_x: i32,
        dims_y: i32,
        dims_z: i32,
        /// As long as `voxels`.
        transposed: &'a VoxelBuffer,
    }
}

impl Launch for Transpose {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, voxel_type: VoxelType) -> String {
        Defines::of_voxels(voxel_type, 1).0
    }

    fn items(a: &TransposeArguments, _: &Tuning) -> usize {
        a.dims_x as usize * a.dims_z as usize
    }
}

/// Blocks of voxels, and how far samples reach for voxels around theirs, within a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Reach {
    pub below: i32,
    pub above: i32,
    /// How many layers to either side.
    pub around: i32,
    /// Rows of a block.
    pub rows: i32,
}

impl Reach {
    /// Splat sums of three layers, |s| ≤ 1: 1 + |s| around their crossings, |s| to either side.
    pub const SPLATS: Reach = Reach { below: 3, above: 4, around: 0, rows: 8 };
    /// Point samples at either end of a slab, |s| ≤ 1.
    pub const POINTS: Reach = Reach { below: 1, above: 2, around: 0, rows: 4 };
    /// Points between two layers, reconstructed with a kernel of radius 2.
    pub const GAUSSIAN: Reach = Reach { below: 1, above: 2, around: 1, rows: 4 };
}

/// Smallest and largest value in reach of each block of a layer axis.
pub(crate) struct MinMaxBlocks {
    /// Two voxels per block and layer.
    pub limits: VoxelBuffer,
    /// Blocks along u and v, a margin of one on each side included.
    pub blocks: [i32; 2],
    /// Voxels along the layer axis.
    pub layers: i32,
}

impl MinMaxBlocks {
    /// Voxels per block and in-layer axis: `BLOCK` in kernels/shared/volume.cl.
    const BLOCK: usize = 8;

    /// Uninitialised ones for a volume of `dims` voxels along u, v, a.
    pub fn new(device: &Device, dims: [usize; 3], voxel_type: VoxelType, reach: Reach) -> Result<Self, Error> {
        let blocks = [dims[0].div_ceil(Self::BLOCK) + 2, dims[1].div_ceil(reach.rows as usize) + 2];
        let limits = VoxelBuffer::new(device, 2 * blocks[0] * blocks[1] * dims[2], voxel_type, "the min-max blocks")?;
        Ok(Self { limits, blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 })
    }

    /// Flags that [`Visibility`] writes: one per block and layer −1 … n.
    pub fn flags(&self) -> usize {
        self.per_layer() * (self.layers as usize + 2)
    }

    /// Bytes that [`SlabVisibility`] writes, a bit per block and slab 0 … n, and seven more: kernels read eight blocks at once.
    pub fn slab_bytes(&self) -> usize {
        self.per_layer() * self.chunks() + 7
    }

    /// Blocks of a layer.
    pub fn per_layer(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize
    }

    /// Groups of eight slabs.
    pub fn chunks(&self) -> usize {
        self.layers as usize / 8 + 1
    }
}

kernel! {
    /// Fills [`MinMaxBlocks`].
    FillMinMaxBlocks = "volume/min_max_blocks.cl", min_max_blocks, "min-max blocks";
    MinMaxArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        blocks_u: i32,
        blocks_v: i32,
        /// See [`Reach`].
        block_rows: i32,
        below: i32,
        above: i32,
        around: i32,
        limits: &'a VoxelBuffer,
    }
}

impl<'a> MinMaxArguments<'a> {
    pub fn new(voxels: &'a VoxelBuffer, view: VolumeView, reach: Reach, blocks: &'a MinMaxBlocks) -> Self {
        let ([blocks_u, blocks_v], limits) = (blocks.blocks, &blocks.limits);
        let Reach { below, above, around, rows: block_rows } = reach;
        Self { voxels, view, blocks_u, blocks_v, block_rows, below, above, around, limits }
    }
}

impl Launch for FillMinMaxBlocks {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, voxel_type: VoxelType) -> String {
        Defines::of_voxels(voxel_type, 1).0
    }

    fn items(a: &MinMaxArguments, _: &Tuning) -> usize {
        a.blocks_u as usize * a.blocks_v as usize * a.view.dims[2] as usize
    }
}

kernel! {
    /// Finds the blocks that can show anything with splatted layers.
    Visibility = "volume/visibility.cl", visibility, "visibility";
    VisibilityArguments<'a> {
        limits: &'a VoxelBuffer,
        blocks_u: i32,
        blocks_v: i32,
        layers: i32,
        /// Less the offset.
        background: f32,
        /// Taken from every voxel.
        offset: f32,
        /// Values that the blend mode can use, less the offset.
        least: f32,
        largest: f32,
        /// Value of the first table entry, less the offset.
        table_first: f32,
        /// Entries per value.
        table_per_value: f32,
        /// Index of the last entry.
        table_last: i32,
        /// How many entries before each one are visible; last + 2 counts.
        visible_before: &'a Buffer<u32>,
        /// [`MinMaxBlocks::flags`] bytes.
        visible: &'a Buffer<u8>,
    }
}

impl Launch for Visibility {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, voxel_type: VoxelType) -> String {
        Defines::of_voxels(voxel_type, 1).0
    }

    fn items(a: &VisibilityArguments, _: &Tuning) -> usize {
        a.visible.len()
    }
}

kernel! {
    /// Finds the blocks that can show anything with point-sampled layers.
    SlabVisibility = "volume/slab_visibility.cl", slab_visibility, "visibility";
    SlabVisibilityArguments<'a> {
        limits: &'a VoxelBuffer,
        blocks_u: i32,
        blocks_v: i32,
        layers: i32,
        background: f32,
        offset: f32,
        /// Values that the blend mode can use, less the offset.
        least: f32,
        largest: f32,
        /// Value of the first table entry, less the offset.
        table_first: f32,
        /// Entries per value.
        table_per_value: f32,
        /// Index of the last entry.
        table_last: i32,
        /// How many entries before each one are visible; last + 2 counts.
        visible_before: &'a Buffer<u32>,
        /// Blocks to either side that are in reach.
        around: i32,
        /// By how much sums of kernels overshoot.
        slack: f32,
        /// [`MinMaxBlocks::slab_bytes`].
        visible: &'a Buffer<u8>,
    }
}

impl Launch for SlabVisibility {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, voxel_type: VoxelType) -> String {
        Defines::of_voxels(voxel_type, 1).0
    }

    fn items(a: &SlabVisibilityArguments, _: &Tuning) -> usize {
        a.visible.len()
    }
}
