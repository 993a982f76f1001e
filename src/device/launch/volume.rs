//! Kernels that prepare a volume: its layouts, its min-max blocks, and which of these can be seen.

use super::{Defines, Floats, Items, Launch, VoxelBuffer, kernel, structs::VolumeView};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::layers::PREFILTER_RADIUS;
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

kernel! {
    /// The B-spline's coefficients along x.
    PrefilterRows = "volume/prefilter_rows.cl", prefilter_rows, "prefilter";
    PrefilterRowsArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// Taken from every voxel.
        offset: f32,
        /// See [`prefilter`](crate::layers::prefilter).
        taps: &'a Buffer<f32>,
        /// Of the axis: the first voxel that is held, how many are, and how many there are.
        first: i32,
        held: i32,
        whole: i32,
        rows: i32,
        /// As many as `voxels`.
        coefficients: Floats<'a>,
    }
}

fn prefilter_defines(tuning: &Tuning, voxel_type: VoxelType) -> String {
    Defines::of_voxels(voxel_type, tuning.vector_width).with("PREFILTER_RADIUS", PREFILTER_RADIUS).0
}

impl Launch for PrefilterRows {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxel_type: VoxelType) -> String {
        prefilter_defines(tuning, voxel_type)
    }

    fn items(a: &PrefilterRowsArguments, _: &Tuning) -> usize {
        a.rows as usize
    }
}

kernel! {
    /// And along y or z, in place.
    PrefilterColumns = "volume/prefilter_columns.cl", prefilter_columns, "prefilter";
    PrefilterColumnsArguments<'a> {
        coefficients: Floats<'a>,
        taps: &'a Buffer<f32>,
        first: i32,
        held: i32,
        whole: i32,
        /// From one number of a column to the next.
        stride: u64,
        /// Of neighbouring columns, in a line of so many.
        chunks: i32,
        width: i32,
        lines: i32,
        line_stride: u64,
    }
}

impl Launch for PrefilterColumns {
    type Variant = ();
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (): ()) -> String {
        prefilter_defines(tuning, VoxelType::Float32)
    }

    fn items(a: &PrefilterColumnsArguments, _: &Tuning) -> usize {
        a.chunks as usize * a.lines as usize
    }
}

/// Blocks of voxels, and how far samples reach for voxels around theirs, within a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Reach {
    pub below: i32,
    pub above: i32,
    /// Rows of a block.
    pub rows: i32,
}

impl Reach {
    /// Splat sums of three layers, |s| ≤ 1: 1 + |s| around their crossings, |s| to either side.
    pub const SPLATS: Reach = Reach { below: 3, above: 4, rows: 8 };

    /// Point samples at either end of a slab, |s| ≤ 1, of a kernel of a radius.
    pub const fn points(radius: i32) -> Reach {
        Reach { below: radius, above: radius + 1, rows: 4 }
    }
}

/// Smallest and largest value in reach of each block of a layer axis.
pub(crate) struct MinMaxBlocks {
    /// As many as [`BlockNumbers::limits`].
    pub limits: VoxelBuffer,
    pub numbers: BlockNumbers,
}

impl MinMaxBlocks {
    /// Uninitialised ones for a volume of `dims` voxels along u, v, a.
    pub fn new(device: &Device, dims: [usize; 3], voxel_type: VoxelType, reach: Reach) -> Result<Self, Error> {
        let numbers = BlockNumbers::of(dims, reach);
        Ok(Self { limits: VoxelBuffer::new(device, numbers.limits(), voxel_type, "the min-max blocks")?, numbers })
    }
}

/// How many blocks a layer axis has.
#[derive(Clone, Copy)]
pub(crate) struct BlockNumbers {
    /// Blocks along u and v, a margin of one on each side included.
    pub blocks: [i32; 2],
    /// Voxels along the layer axis.
    pub layers: i32,
}

impl BlockNumbers {
    /// Voxels per block and in-layer axis: `BLOCK` in kernels/shared/volume.cl.
    const BLOCK: usize = 8;

    /// Of a volume of `dims` voxels along u, v, a.
    pub fn of(dims: [usize; 3], reach: Reach) -> Self {
        let blocks = [dims[0].div_ceil(Self::BLOCK) + 2, dims[1].div_ceil(reach.rows as usize) + 2];
        Self { blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 }
    }

    /// Voxels that [`FillMinMaxBlocks`] writes, two per block and layer.
    pub fn limits(&self) -> usize {
        2 * self.per_layer() * self.layers as usize
    }

    /// Flags that [`Visibility`] writes: one per block and layer −1 … n.
    pub fn flags(&self) -> usize {
        self.per_layer() * (self.layers as usize + 2)
    }

    /// Bytes that [`SlabVisibility`] writes, a bit per block and slab, and seven more: kernels read eight blocks at once.
    pub fn slab_bytes(&self, radius: i32) -> usize {
        self.per_layer() * self.chunks(radius) + 7
    }

    /// Blocks of a layer.
    pub fn per_layer(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize
    }

    /// The spaces between layers that a kernel of a radius fills.
    pub fn slabs(&self, radius: i32) -> i32 {
        self.layers + 2 * radius - 1
    }

    /// Groups of eight slabs.
    pub fn chunks(&self, radius: i32) -> usize {
        self.slabs(radius).unsigned_abs().div_ceil(8) as usize
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
        limits: &'a VoxelBuffer,
    }
}

impl<'a> MinMaxArguments<'a> {
    pub fn new(voxels: &'a VoxelBuffer, view: VolumeView, reach: Reach, blocks: &'a MinMaxBlocks) -> Self {
        let ([blocks_u, blocks_v], limits) = (blocks.numbers.blocks, &blocks.limits);
        let Reach { below, above, rows: block_rows } = reach;
        Self { voxels, view, blocks_u, blocks_v, block_rows, below, above, limits }
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
        /// [`BlockNumbers::flags`] bytes.
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
        /// Of the kernel.
        radius: i32,
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
        /// By how much sums overshoot: shares of the distance between the largest and the smallest number in reach, and of that from the
        /// background.
        overshoot: f32,
        slack: f32,
        /// [`BlockNumbers::slab_bytes`].
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
