//! Kernels of the systems that the paper compares with. Those of sheets list the splatted voxels, sort the splats, and splat them. Slicing
//! marches rays through a table over two values.

use super::rays::{TableMarchArguments, march_defines};
use super::structs::{Float4, RayEnds, SampleParams, ScreenParams, Splat, SplatParams, VolumeView};
use super::{Defines, Items, Output, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

/// Indices of a splatted voxel along u, v, a, and one further number.
pub(crate) type Place = [u16; 4];

kernel! {
    /// Lists the splatted voxels.
    Splats = "paper/splats.cl", splats, "splats", Items::Tiles;
    defines |tuning, voxels: VoxelKind| Defines::new(tuning.vector_width).with_values(voxels);
    items |a, _| a.view.dims[1] as usize * a.view.dims[2] as usize;
    arguments SplatsArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// Neighbourhood radius in voxels within which visible values make a voxel count; 0: only the voxel itself.
        reach: i32,
        /// Relative overshoot of sums of kernels.
        slack: f32,
        /// See [`super::volume::SlabVisibilityArguments`].
        table_first: f32,
        table_per_value: f32,
        table_last: i32,
        visible_before: &'a Buffer<u32>,
        /// See [`Pass`](super::surfaces::Pass).
        fill: i32,
        /// One per voxel row.
        counts: &'a Buffer<u32>,
        places: &'a Buffer<Place>,
        contents: &'a Buffer<Float4>,
    }
}

impl Splats {
    /// Maximum `reach`.
    pub const REACH: i32 = 3;
}

kernel! {
    /// Projects splats and sorts them by their first sheet.
    SortedSplats = "paper/sorted_splats.cl", sorted_splats, "sort", Items::Tiles;
    // Whether voxels are pre-classified, as for axis-aligned sheets: splats then carry colours and share one bucket.
    defines |_, preclassified: bool| Defines::new(1).with_if(preclassified, "PRECLASSIFIED").with_lighting(Rendering::EVERYTHING);
    items |a, _| a.chunks as usize;
    arguments SortedSplatsArguments<'a> {
        places: &'a Buffer<Place>,
        contents: &'a Buffer<Float4>,
        count: i32,
        p: SplatParams,
        /// (r, g, b, τ) per value; read only by kernels that classify.
        table: &'a Buffer<Float4>,
        sample: SampleParams,
        /// Screen size in pixels.
        width: i32,
        height: i32,
        chunks: i32,
        buckets: i32,
        fill: i32,
        /// `buckets` counts per chunk.
        counts: &'a Buffer<u32>,
        sorted: &'a Buffer<Splat>,
    }
}

kernel! {
    /// Lists the splats of each screen tile.
    TiledSplats = "paper/tiled_splats.cl", tiled_splats, "sort", Items::Tiles;
    defines |tuning, (): ()| {
        let [columns, rows] = tuning.list_tile();
        Defines::new(1).with("TILE_COLUMNS", columns).with("TILE_ROWS", rows)
    };
    items |a, _| a.chunks as usize;
    arguments TiledSplatsArguments<'a> {
        sorted: &'a Buffer<Splat>,
        count: i32,
        p: SplatParams,
        /// Screen size in pixels.
        width: i32,
        height: i32,
        tiles_u: i32,
        tiles_v: i32,
        chunks: i32,
        fill: i32,
        /// One count per chunk and tile.
        counts: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
    }
}

fn sheet_defines(tuning: &Tuning, channels: u32, rendering: Rendering) -> Defines {
    let defines = Defines::new(tuning.vector_width).with_rendering(rendering);
    defines.with("TILE_ROWS", tuning.screen_tile_rows).with("LIST_TILES", tuning.list_tiles).with("CHANNELS", channels)
}

kernel! {
    /// Splats onto axis-aligned sheets.
    AxisSheets = "paper/axis_sheets.cl", axis_sheets, "sheets", Items::Tiles;
    defines |tuning, rendering: Rendering| sheet_defines(tuning, 4, rendering);
    items |a, _| tiles(a.s.tiles);
    arguments AxisSheetsArguments<'a> {
        sorted: &'a Buffer<Splat>,
        /// End of each tile's list, per chunk.
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        s: ScreenParams,
        p: SplatParams,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

kernel! {
    /// Splats onto image-aligned sheets.
    ViewSheets = "paper/view_sheets.cl", view_sheets, "sheets", Items::Tiles;
    // Maximum number of sheets that a splat reaches, and whether the sheets have gradients.
    defines |tuning, (sheets, shading, rendering): (usize, bool, Rendering)| sheet_defines(tuning, if shading { 4 } else { 1 }, rendering)
        .with("SHEETS", sheets)
        .with("SLAB_STEPS", Self::SLAB_STEPS)
        .with_if(true, "PER_RAY_STEP");
    items |a, _| tiles(a.s.tiles);
    arguments ViewSheetsArguments<'a> {
        sorted: &'a Buffer<Splat>,
        /// End of each tile's list, per chunk.
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        /// Per sheet that a splat reaches: a weight for each of [`ViewSheets::SLAB_STEPS`] + 1 fractions.
        slabs: &'a Buffer<f32>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        s: ScreenParams,
        p: SplatParams,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

impl ViewSheets {
    /// Intervals between the fractions with slab weights.
    pub const SLAB_STEPS: usize = 256;
}

kernel! {
    /// Slices the trilinear field, with pre-integrated slabs.
    Slicing = "paper/slicing.cl", march, "slicing", Items::Tiles;
    defines |tuning, (voxels, rendering): (VoxelKind, Rendering)| {
        march_defines(tuning, voxels, rendering).with_kernel(Kernel::Linear)
    };
    items |a, _| tiles(a.march.s.tiles);
    arguments TableMarchArguments
}

kernel! {
    /// Computes the pre-integrated table of slicing.
    PreintegratedTable = "paper/preintegrated_table.cl", preintegrated_table, "table", Items::Pixels;
    defines |_, (): ()| Defines::new(1);
    items |a, _| a.size as usize * a.size as usize;
    arguments PreintegratedTableArguments<'a> {
        integrals: &'a Buffer<[i32; 4]>,
        /// Index of the first node in `integrals`.
        first: i32,
        /// Number of nodes in `integrals`.
        nodes: i32,
        /// Nodes per table entry.
        nodes_per_entry: f32,
        /// Extinction of one unit of `integrals`.
        unit: f32,
        /// Slab thickness in unit distances.
        thickness: f32,
        linear: i32,
        /// Number of front values, and of back values.
        size: i32,
        /// `size`² entries.
        out: &'a Buffer<Float4>,
    }
}
