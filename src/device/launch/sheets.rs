//! Kernels of the sheet methods: which voxels are splatted, in which order, and onto which sheets.

use super::structs::{Clipping, Float4, SampleParams, ScreenParams, Splat, SplatParams, VolumeView};
use super::{Defines, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::{Buffer, Tuning};

/// A voxel that is splatted: its place along u, v, a, and one number more.
pub(crate) type Place = [u16; 4];

/// Whether a kernel only counts, or fills the places that the counts have become.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    Count,
    Fill,
}

impl Pass {
    /// As kernels take it.
    pub fn fill(self) -> i32 {
        i32::from(self == Pass::Fill)
    }
}

kernel! {
    /// Lists the voxels that are splatted.
    Splats = "sheets/splats.cl", splats, "splats";
    SplatsArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// Voxels around a voxel that can make it count; 0: only itself.
        reach: i32,
        /// By how much sums of kernels overshoot.
        slack: f32,
        /// See [`super::volume::SlabVisibilityArguments`].
        table_first: f32,
        table_per_value: f32,
        table_last: i32,
        visible_before: &'a Buffer<u32>,
        /// See [`Pass`].
        fill: i32,
        /// One per row of voxels.
        counts: &'a Buffer<u32>,
        places: &'a Buffer<Place>,
        contents: &'a Buffer<Float4>,
    }
}

impl Splats {
    /// Farthest reach.
    pub const REACH: i32 = 3;
}

impl Launch for Splats {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        Defines::of_values(voxels, tuning.vector_width).0
    }

    fn items(a: &SplatsArguments, _: &Tuning) -> usize {
        a.view.dims[1] as usize * a.view.dims[2] as usize
    }
}

kernel! {
    /// Turns counts into places.
    Scan = "sheets/scan.cl", scan, "sort";
    ScanArguments<'a> {
        /// `buckets` numbers for each of `chunks`.
        counts: &'a Buffer<u32>,
        chunks: i32,
        buckets: i32,
        /// The sum of all.
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
    /// Projects splats and sorts them into the sheets where they begin.
    SortedSplats = "sheets/sorted_splats.cl", sorted_splats, "sort";
    SortedSplatsArguments<'a> {
        places: &'a Buffer<Place>,
        contents: &'a Buffer<Float4>,
        count: i32,
        p: SplatParams,
        /// (r, g, b, τ) per value; read only by a kernel that classifies.
        table: &'a Buffer<Float4>,
        sample: SampleParams,
        /// Of the screen, in pixels.
        width: i32,
        height: i32,
        chunks: i32,
        buckets: i32,
        fill: i32,
        /// `buckets` per chunk.
        counts: &'a Buffer<u32>,
        sorted: &'a Buffer<Splat>,
    }
}

impl Launch for SortedSplats {
    /// Whether voxels are classified before, for axis-aligned sheets, with colours and in one bucket.
    type Variant = bool;
    const ITEMS: Items = Items::Tiles;

    fn defines(_: &Tuning, preclassified: bool) -> String {
        Defines::new(1).with_if(preclassified, "PRECLASSIFIED").with_look(Rendering::EVERYTHING).0
    }

    fn items(a: &SortedSplatsArguments, _: &Tuning) -> usize {
        a.chunks as usize
    }
}

kernel! {
    /// Lists the splats of each tile of the screen.
    TiledSplats = "sheets/tiled_splats.cl", tiled_splats, "sort";
    TiledSplatsArguments<'a> {
        sorted: &'a Buffer<Splat>,
        count: i32,
        p: SplatParams,
        /// Of the screen, in pixels.
        width: i32,
        height: i32,
        tiles_u: i32,
        tiles_v: i32,
        chunks: i32,
        fill: i32,
        /// One per chunk and tile.
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
        /// Where the lists of tiles end, per chunk.
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
        /// Where the lists of tiles end, per chunk.
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        /// A weight per sheet that a splat reaches for each of [`ViewSheets::SLAB_STEPS`] + 1 fractions.
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
    /// Fractions, less one, that slab weights are given for.
    pub const SLAB_STEPS: usize = 256;
}

impl Launch for ViewSheets {
    /// Sheets that a splat reaches at most, and whether these have gradients.
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
