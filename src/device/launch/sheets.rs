//! Kernels of the sheet methods: they list the splatted voxels, sort the splats, and splat them onto sheets.

use super::structs::{Clipping, Float4, SampleParams, ScreenParams, Splat, SplatParams, VolumeView};
use super::{Defines, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::{Buffer, Tuning};

/// Indices of a splatted voxel along u, v, a, and one further number.
pub(crate) type Place = [u16; 4];

/// Pass of a kernel that runs twice: to count, and to fill a list at the offsets computed from the counts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    Count,
    Fill,
}

impl Pass {
    /// Kernel argument.
    pub fn fill(self) -> i32 {
        i32::from(self == Pass::Fill)
    }
}

kernel! {
    /// Lists the splatted voxels.
    Splats = "sheets/splats.cl", splats, "splats";
    SplatsArguments<'a> {
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
        /// See [`Pass`].
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

impl Launch for Splats {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        Defines::new(tuning.vector_width).with_values(voxels).0
    }

    fn items(a: &SplatsArguments, _: &Tuning) -> usize {
        a.view.dims[1] as usize * a.view.dims[2] as usize
    }
}

kernel! {
    /// Turns counts into offsets by a prefix sum.
    Scan = "sheets/scan.cl", scan, "sort";
    ScanArguments<'a> {
        /// `buckets` counts per chunk.
        counts: &'a Buffer<u32>,
        chunks: i32,
        buckets: i32,
        /// Sum of all counts.
        total: &'a Buffer<u64>,
    }
}

impl Launch for Scan {
    type Variant = ();
    const ITEMS: Items = Items::Runs;

    fn defines(tuning: &Tuning, (): ()) -> String {
        Defines::new(1).with("SCAN_GROUP", tuning.scan_group).0
    }

    fn items(_: &ScanArguments, tuning: &Tuning) -> usize {
        tuning.scan_group
    }
}

kernel! {
    /// Projects splats and sorts them by their first sheet.
    SortedSplats = "sheets/sorted_splats.cl", sorted_splats, "sort";
    SortedSplatsArguments<'a> {
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

impl Launch for SortedSplats {
    /// Whether voxels are pre-classified, as for axis-aligned sheets: splats then carry colours and share one bucket.
    type Variant = bool;
    const ITEMS: Items = Items::Tiles;

    fn defines(_: &Tuning, preclassified: bool) -> String {
        Defines::new(1).with_if(preclassified, "PRECLASSIFIED").with_lighting(Rendering::EVERYTHING).0
    }

    fn items(a: &SortedSplatsArguments, _: &Tuning) -> usize {
        a.chunks as usize
    }
}

kernel! {
    /// Lists the splats of each screen tile.
    TiledSplats = "sheets/tiled_splats.cl", tiled_splats, "sort";
    TiledSplatsArguments<'a> {
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

impl Launch for TiledSplats {
    type Variant = ();
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (): ()) -> String {
        let [columns, rows] = tuning.list_tile();
        Defines::new(1).with("TILE_COLUMNS", columns).with("TILE_ROWS", rows).0
    }

    fn items(a: &TiledSplatsArguments, _: &Tuning) -> usize {
        a.chunks as usize
    }
}

fn sheet_defines(tuning: &Tuning, channels: u32, rendering: Rendering) -> Defines {
    let defines = Defines::new(tuning.vector_width).with_rendering(rendering);
    defines.with("TILE_ROWS", tuning.screen_tile_rows).with("LIST_TILES", tuning.list_tiles).with("CHANNELS", channels)
}

kernel! {
    /// Splats onto axis-aligned sheets.
    AxisSheets = "sheets/axis_sheets.cl", axis_sheets, "sheets";
    AxisSheetsArguments<'a> {
        sorted: &'a Buffer<Splat>,
        /// End of each tile's list, per chunk.
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        s: ScreenParams,
        p: SplatParams,
        sample: SampleParams,
        clip: Clipping,
        frame: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for AxisSheets {
    type Variant = Rendering;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, rendering: Rendering) -> String {
        sheet_defines(tuning, 4, rendering).0
    }

    fn items(a: &AxisSheetsArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

kernel! {
    /// Splats onto image-aligned sheets.
    ViewSheets = "sheets/view_sheets.cl", view_sheets, "sheets";
    ViewSheetsArguments<'a> {
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
        clip: Clipping,
        frame: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl ViewSheets {
    /// Intervals between the fractions with slab weights.
    pub const SLAB_STEPS: usize = 256;
}

impl Launch for ViewSheets {
    /// Maximum number of sheets that a splat reaches, and whether the sheets have gradients.
    type Variant = (usize, bool, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (sheets, shading, rendering): Self::Variant) -> String {
        sheet_defines(tuning, if shading { 4 } else { 1 }, rendering)
            .with("SHEETS", sheets)
            .with("SLAB_STEPS", Self::SLAB_STEPS)
            .with_if(true, "PER_RAY_STEP")
            .0
    }

    fn items(a: &ViewSheetsArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}
