//! Kernels that prepare a volume: layouts, prefilter, min-max blocks and their visibility.

pub(crate) use super::blocks::{BlockNumbers, MinMaxBlocks};
use super::structs::{ResampleParams, VolumeView};
use super::{Defines, Floats, Items, Rendering, VoxelBuffer, VoxelKind, kernel, large_grid};
use crate::device::{Buffer, Tuning};
use crate::layers::{Kernel, PREFILTER_RADIUS};
use crate::volume::VoxelType;

/// Options of the program that prepares volumes.
fn prepare_defines(tuning: &Tuning, voxels: VoxelKind) -> Defines {
    Defines::new(tuning.vector_width).with_values(voxels).with("TRANSPOSED_ROWS", tuning.transposed_rows(voxels.voxel_type))
}

kernel! {
    /// Creates the layout of layer axis x.
    Transpose = "volume/prepare.cl", transpose, "transpose", Items::Pixels;
    defines |tuning, voxels: VoxelKind| prepare_defines(tuning, voxels);
    items |a, tuning| (a.dims_x as usize).div_ceil(tuning.transposed_rows(a.voxels.voxel_type())) * a.dims_y as usize;
    arguments TransposeArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// Offset of the first voxel, and pitches of rows and layers, in voxels.
        first: i64,
        pitch_y: i64,
        pitch_z: i64,
        dims_x: i32,
        dims_y: i32,
        dims_z: i32,
        /// Tightly packed.
        transposed: &'a VoxelBuffer,
    }
}

kernel! {
    /// Filters voxels along x: computes B-spline coefficients, or smooths.
    PrefilterRows = "volume/prefilter_rows.cl", prefilter_rows, "prefilter", Items::Tiles;
    defines |tuning, (voxels, outside): (VoxelKind, Outside)| prefilter_defines(tuning, voxels, outside);
    items |a, _| a.rows as usize;
    arguments PrefilterRowsArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// View of layer axis z.
        view: VolumeView,
        /// [`PREFILTER_RADIUS`] + 1, from the centre outwards.
        taps: &'a Buffer<f32>,
        /// Along the axis: index of the first voxel in the buffer, number of voxels there, and in the whole volume.
        first: i32,
        held: i32,
        whole: i32,
        rows_per_layer: i32,
        rows: i32,
        /// One per voxel.
        filtered: Floats<'a>,
    }
}

kernel! {
    /// Samples a field at the voxels of another grid.
    Resample = "volume/resample.cl", resample, "resample", Items::Tiles;
    // The kernel that reconstructs the field, too.
    defines |tuning, (voxels, kernel): (VoxelKind, Kernel)| {
        let defines = Defines::new(tuning.vector_width).with_voxels(voxels).with_kernel(kernel);
        defines
            .with_rendering(Rendering {
                gradient_opacity: false,
                several_lights: false,
                colored_lights: false,
                depth_cue: false,
                ..Rendering::EVERYTHING
            })
    };
    items |a, _| a.p.dims[1] as usize * a.p.dims[2] as usize;
    arguments ResampleArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// View of layer axis z.
        view: VolumeView,
        p: ResampleParams,
        /// One per voxel of the other grid.
        resampled: Floats<'a>,
    }
}

/// Voxels outside the volume, as a filter sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Outside {
    Mirrored,
    Background,
}

/// Filtered voxels.
const FLOATS: VoxelKind = VoxelKind { voxel_type: VoxelType::Float32, far: false, unchecked: false };

fn prefilter_defines(tuning: &Tuning, voxels: VoxelKind, outside: Outside) -> Defines {
    let defines = Defines::new(tuning.vector_width).with_values(voxels).with("PREFILTER_RADIUS", PREFILTER_RADIUS);
    defines.with("GROUP", tuning.tile_group).with_if(outside == Outside::Background, "BACKGROUND_OUTSIDE")
}

kernel! {
    /// Filters along y or z, in place.
    PrefilterColumns = "volume/prefilter_columns.cl", prefilter_columns, "prefilter", Items::Tiles;
    defines |tuning, outside: Outside| prefilter_defines(tuning, FLOATS, outside);
    items |a, _| a.chunks as usize * a.lines as usize;
    arguments PrefilterColumnsArguments<'a> {
        filtered: Floats<'a>,
        taps: &'a Buffer<f32>,
        first: i32,
        held: i32,
        whole: i32,
        /// Distance of consecutive numbers of a column.
        stride: u64,
        /// Chunks of neighbouring columns per line.
        chunks: i32,
        /// Columns per line.
        width: i32,
        lines: i32,
        line_stride: u64,
        /// For [`Outside::Background`], less the offset.
        background: f32,
    }
}

kernel! {
    /// Fills [`MinMaxBlocks`].
    FillMinMaxBlocks = "volume/prepare.cl", min_max_blocks, "min-max blocks", Items::Pixels;
    defines |tuning, voxels: VoxelKind| prepare_defines(tuning, voxels);
    items |a, tuning| {
        let rows = a.blocks_v as usize * a.view.dims[2] as usize;
        large_grid(if tuning.vector_width == 1 { a.blocks_u as usize * rows } else { rows })
    };
    arguments MinMaxArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        blocks_u: i32,
        blocks_v: i32,
        /// Kernel radius in voxels.
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

kernel! {
    /// Finds the blocks of each slab that may be visible.
    SlabVisibility = "volume/prepare.cl", slab_visibility, "visibility", Items::Pixels;
    defines |tuning, voxels: VoxelKind| prepare_defines(tuning, voxels);
    items |a, tuning| {
        let width = tuning.vector_width as usize;
        if width == 1 {
            return large_grid(a.visible.len());
        }
        let (per_layer, slabs) = (a.blocks_u as usize * a.blocks_v as usize, (a.layers + 2 * a.radius - 1) as usize);
        large_grid(per_layer.div_ceil(width) * slabs.div_ceil(8))
    };
    arguments SlabVisibilityArguments<'a> {
        limits: &'a VoxelBuffer,
        blocks_u: i32,
        blocks_v: i32,
        layers: i32,
        /// Kernel radius in voxels.
        radius: i32,
        background: f32,
        offset: f32,
        /// Range of values that the blend mode can use, minus the offset.
        least: f32,
        largest: f32,
        /// Value of the first table entry, minus the offset.
        table_first: f32,
        /// Entries per value.
        table_per_value: f32,
        /// Index of the last entry.
        table_last: i32,
        /// Prefix sum of visible entries, of `table_last` + 2 counts.
        visible_before: &'a Buffer<u32>,
        /// Overshoot of interpolated values: as a share of the value range in reach, and as a share of the distance to the
        /// background.
        overshoot: f32,
        slack: f32,
        /// [`BlockNumbers::slab_bytes`] bytes.
        visible: &'a Buffer<u8>,
    }
}

kernel! {
    /// Finds the groups of eight slabs with any visible block.
    ShownChunks = "volume/prepare.cl", shown_chunks, "visibility", Items::Pixels;
    // The voxels of the volume, which the same program prepares.
    defines |tuning, voxels: VoxelKind| prepare_defines(tuning, voxels);
    items |a, _| a.chunks as usize;
    arguments ShownChunksArguments<'a> {
        /// Output of [`SlabVisibility`].
        visible: &'a Buffer<u8>,
        /// Blocks per layer.
        per_layer: i32,
        chunks: i32,
        /// One byte per chunk.
        shows: &'a Buffer<u8>,
    }
}

kernel! {
    /// Finds the first and the last visible slab.
    ShownSlabs = "volume/prepare.cl", shown_slabs, "visibility", Items::Tiles;
    defines |tuning, voxels: VoxelKind| prepare_defines(tuning, voxels);
    items |_, _| 1;
    arguments ShownSlabsArguments<'a> {
        shows: &'a Buffer<u8>,
        chunks: i32,
        slabs: i32,
        /// First and last visible slab, relative to the first layer in the buffer.
        shown: &'a Buffer<i32>,
    }
}

kernel! {
    /// Computes the value range of voxels that were not validated.
    ValueRange = "volume/value_range.cl", value_range, "range", Items::Tiles;
    defines |_, voxel_type: VoxelType| Defines::new(1).with_voxel_type(voxel_type);
    items |a, _| a.parts as usize;
    arguments ValueRangeArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// View of layer axis z.
        view: VolumeView,
        /// Number of parts among which rows are distributed.
        parts: i32,
        /// Per part: minimum and maximum of the valid voxels, and number of invalid voxels.
        least: &'a Buffer<f32>,
        largest: &'a Buffer<f32>,
        invalid: &'a Buffer<u32>,
    }
}
