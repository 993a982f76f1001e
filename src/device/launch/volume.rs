//! Kernels that prepare a volume: its layouts, its min-max blocks, and which of these can be seen.

pub(crate) use super::blocks::{BlockNumbers, MinMaxBlocks};
use super::{Defines, Floats, Items, Launch, VoxelBuffer, VoxelKind, kernel, many, structs::VolumeView};
use crate::device::{Buffer, Tuning};
use crate::layers::PREFILTER_RADIUS;
use crate::volume::VoxelType;

/// Of the program that prepares volumes of a kind.
fn prepare_defines(tuning: &Tuning, voxels: VoxelKind) -> String {
    Defines::of_values(voxels, tuning.vector_width).with("TRANSPOSED_ROWS", tuning.transposed_rows()).0
}

kernel! {
    /// Makes the layout of layer axis x.
    Transpose = "volume/prepare.cl", transpose, "transpose";
    TransposeArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// In voxels: where the first one lies, and from row to row and layer to layer.
        first: i64,
        pitch_y: i64,
        pitch_z: i64,
        dims_x: i32,
        dims_y: i32,
        dims_z: i32,
        /// Without gaps.
        transposed: &'a VoxelBuffer,
    }
}

impl Launch for Transpose {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prepare_defines(tuning, voxels)
    }

    fn items(a: &TransposeArguments, tuning: &Tuning) -> usize {
        (a.dims_x as usize).div_ceil(tuning.transposed_rows()) * a.dims_y as usize
    }
}

kernel! {
    /// The B-spline's coefficients along x.
    PrefilterRows = "volume/prefilter_rows.cl", prefilter_rows, "prefilter";
    PrefilterRowsArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// Of layer axis z.
        view: VolumeView,
        /// See [`prefilter`](crate::layers::prefilter).
        taps: &'a Buffer<f32>,
        /// Of the axis: the first voxel that is held, how many are, and how many there are.
        first: i32,
        held: i32,
        whole: i32,
        rows_per_layer: i32,
        rows: i32,
        /// As many as `voxels`.
        coefficients: Floats<'a>,
    }
}

fn prefilter_defines(tuning: &Tuning, voxels: VoxelKind) -> String {
    let defines = Defines::of_values(voxels, tuning.vector_width).with("PREFILTER_RADIUS", PREFILTER_RADIUS);
    defines.with("GROUP", tuning.tile_group).0
}

impl Launch for PrefilterRows {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prefilter_defines(tuning, voxels)
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
        prefilter_defines(tuning, VoxelKind { voxel_type: VoxelType::Float32, far: false, unchecked: false })
    }

    fn items(a: &PrefilterColumnsArguments, _: &Tuning) -> usize {
        a.chunks as usize * a.lines as usize
    }
}

kernel! {
    /// Fills [`MinMaxBlocks`].
    FillMinMaxBlocks = "volume/prepare.cl", min_max_blocks, "min-max blocks";
    MinMaxArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        blocks_u: i32,
        blocks_v: i32,
        /// Of the kernel.
        radius: i32,
        limits: &'a VoxelBuffer,
    }
}

impl<'a> MinMaxArguments<'a> {
    pub fn new(voxels: &'a VoxelBuffer, view: VolumeView, radius: i32, blocks: &'a MinMaxBlocks) -> Self {
        let ([blocks_u, blocks_v], limits) = (blocks.numbers.blocks, &blocks.limits);
        Self { voxels, view, blocks_u, blocks_v, radius, limits }
    }
}

impl Launch for FillMinMaxBlocks {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prepare_defines(tuning, voxels)
    }

    fn items(a: &MinMaxArguments, _: &Tuning) -> usize {
        many(a.blocks_u as usize * a.blocks_v as usize * a.view.dims[2] as usize)
    }
}

kernel! {
    /// Finds the blocks of each slab that can show anything.
    SlabVisibility = "volume/prepare.cl", slab_visibility, "visibility";
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
        /// By how much sums overshoot: shares of the distance between the largest and the smallest number in reach, and of that from the
        /// background.
        overshoot: f32,
        slack: f32,
        /// [`BlockNumbers::slab_bytes`].
        visible: &'a Buffer<u8>,
    }
}

impl Launch for SlabVisibility {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prepare_defines(tuning, voxels)
    }

    fn items(a: &SlabVisibilityArguments, _: &Tuning) -> usize {
        many(a.visible.len())
    }
}

kernel! {
    /// Finds the chunks of slabs in which any block can show anything.
    ShownChunks = "volume/prepare.cl", shown_chunks, "visibility";
    ShownChunksArguments<'a> {
        /// From [`SlabVisibility`].
        visible: &'a Buffer<u8>,
        /// Blocks of a layer.
        per_layer: i32,
        chunks: i32,
        /// A byte per chunk.
        shows: &'a Buffer<u8>,
    }
}

impl Launch for ShownChunks {
    /// Of the volume whose slabs they are: it is prepared by the same program.
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prepare_defines(tuning, voxels)
    }

    fn items(a: &ShownChunksArguments, _: &Tuning) -> usize {
        a.chunks as usize
    }
}

kernel! {
    /// Finds the outermost slabs of these.
    ShownSlabs = "volume/prepare.cl", shown_slabs, "visibility";
    ShownSlabsArguments<'a> {
        shows: &'a Buffer<u8>,
        chunks: i32,
        slabs: i32,
        /// The first and the last, counted from the first layer that is held.
        shown: &'a Buffer<i32>,
    }
}

impl Launch for ShownSlabs {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        prepare_defines(tuning, voxels)
    }

    fn items(_: &ShownSlabsArguments, _: &Tuning) -> usize {
        1
    }
}

kernel! {
    /// Finds the range of voxels that nobody has looked at.
    ValueRange = "volume/value_range.cl", value_range, "range";
    ValueRangeArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// Of layer axis z.
        view: VolumeView,
        /// In which rows are shared out.
        parts: i32,
        /// Of each part: smallest and largest valid voxel, and how many are invalid.
        least: &'a Buffer<f32>,
        largest: &'a Buffer<f32>,
        invalid: &'a Buffer<u32>,
    }
}

impl Launch for ValueRange {
    type Variant = VoxelType;
    const ITEMS: Items = Items::Tiles;

    fn defines(_: &Tuning, voxel_type: VoxelType) -> String {
        Defines::of_voxels(voxel_type, 1).0
    }

    fn items(a: &ValueRangeArguments, _: &Tuning) -> usize {
        a.parts as usize
    }
}
