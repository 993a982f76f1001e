//! Kernels of surfaces: their cells are listed per tile of the screen, rays are intersected with them, and the fragments composited with the
//! volume between them.

use super::structs::{Float4, RayEnds, SampleParams, SurfaceSet, SurfaceView, WarpParams};
use super::{Defines, Items, LightBuffers, Rendering, kernel, large_grid};
use crate::device::{Buffer, Tuning};

/// Columns and rows of pixels that share a list of cells.
pub(crate) const SURFACE_TILE: u32 = 16;
/// Colours of the values of a set.
pub(crate) const SURFACE_COLORS: usize = 1024;
/// Fragments that are kept per pixel: SLOTS of kernels/surfaces/fragment_states.cl.
pub(crate) const FRAGMENTS: usize = 4;

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
    /// Turns counts into offsets by a prefix sum.
    Scan = "surfaces/scan.cl", scan, "sort", Items::Runs;
    defines |tuning, (): ()| Defines::new(1).with("SCAN_GROUP", tuning.scan_group);
    items |_, tuning| tuning.scan_group;
    arguments ScanArguments<'a> {
        /// `buckets` counts per chunk.
        counts: &'a Buffer<u32>,
        chunks: i32,
        buckets: i32,
        /// Sum of all counts.
        total: &'a Buffer<u64>,
    }
}

fn defines() -> Defines {
    wide_defines(1)
}

/// For kernels that compute in vectors of `width` lanes.
fn wide_defines(width: u32) -> Defines {
    Defines::new(width).with("SURFACE_TILE", SURFACE_TILE).with("SURFACE_COLORS", SURFACE_COLORS)
}

kernel! {
    /// Places the points of a set in the coordinates of the view.
    PlacePoints = "surfaces/place_points.cl", place_points, "surfaces", Items::Pixels;
    defines |_, (): ()| defines();
    items |a, _| large_grid(a.count as usize);
    arguments PlacePointsArguments<'a> {
        /// Points and radii of all sets.
        own: &'a Buffer<Float4>,
        sets: &'a Buffer<SurfaceSet>,
        set: i32,
        first: i32,
        count: i32,
        view: SurfaceView,
        points: &'a Buffer<Float4>,
        /// Their places on the screen, in 1/256 of a pixel.
        rounded: &'a Buffer<[i32; 2]>,
    }
}

kernel! {
    /// Lists the cells that can cover a tile.
    Bins = "surfaces/bins.cl", bins, "surfaces", Items::Tiles;
    defines |_, (): ()| defines();
    items |a, _| a.chunks as usize;
    arguments BinsArguments<'a> {
        points: &'a Buffer<Float4>,
        rounded: &'a Buffer<[i32; 2]>,
        /// Points, and set and kind.
        cells: &'a Buffer<[i32; 4]>,
        count: i32,
        view: SurfaceView,
        chunks: i32,
        /// See [`Pass`].
        fill: i32,
        /// Pixels that each cell can cover: first and last column and row.
        bounds: &'a Buffer<[u16; 4]>,
        counts: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
    }
}

kernel! {
    /// Finds the next fragments of each pixel.
    Fragments = "surfaces/fragments.cl", fragments, "surfaces", Items::Tiles;
    // Whether the cells of tiles are sorted.
    defines |tuning, (rendering, sorted): (Rendering, bool)| {
        let lit = defines().with_lighting(rendering).with_if(rendering.light_volume, "LIFTED_LIGHT");
        lit.with("RASTER", raster(tuning)).with_if(sorted, "SORTED")
    };
    items |a, tuning| surface_blocks(&a.view, tuning);
    arguments FragmentsArguments<'a> {
        points: &'a Buffer<Float4>,
        cells: &'a Buffer<[i32; 4]>,
        sets: &'a Buffer<SurfaceSet>,
        /// Colours or values.
        attributes: &'a Buffer<f32>,
        normals: &'a Buffer<Float4>,
        /// Colours of values, [`SURFACE_COLORS`] per set that has them.
        tables: &'a Buffer<Float4>,
        rounded: &'a Buffer<[i32; 2]>,
        bounds: &'a Buffer<[u16; 4]>,
        /// Scanned counts of [`Bins`], and the lists.
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        /// Of [`SortCells`], if they are sorted.
        nearest: &'a Buffer<f32>,
        farthest: &'a Buffer<f32>,
        chunks: i32,
        /// 1: the first fragments of all pixels.
        first: i32,
        view: SurfaceView,
        sample: SampleParams,
        /// What cuts surfaces, in the coordinates of the view.
        ray_ends: RayEnds,
        light: LightBuffers<'a>,
        /// [`FRAGMENTS`] per pixel.
        depths: &'a Buffer<f32>,
        colors: &'a Buffer<[u16; 4]>,
        /// Of the last fragment.
        crossings: &'a Buffer<u32>,
        states: &'a Buffer<u8>,
    }
}

kernel! {
    /// Bounds the number of fragments of a ray.
    CountFragments = "surfaces/count_fragments.cl", count_fragments, "surfaces", Items::Tiles;
    defines |tuning, (): ()| defines().with("RASTER", raster(tuning));
    items |a, tuning| surface_blocks(&a.view, tuning);
    arguments CountFragmentsArguments<'a> {
        points: &'a Buffer<Float4>,
        cells: &'a Buffer<[i32; 4]>,
        sets: &'a Buffer<SurfaceSet>,
        rounded: &'a Buffer<[i32; 2]>,
        bounds: &'a Buffer<[u16; 4]>,
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        view: SurfaceView,
        /// Most translucent fragments of a ray, per block ([`surface_blocks`]).
        most: &'a Buffer<u32>,
    }
}

kernel! {
    /// Sorts the cells of each tile by depth.
    SortCells = "surfaces/sort_cells.cl", sort_cells, "surfaces", Items::Tiles;
    defines |_, (): ()| defines();
    items |a, _| super::tiles(a.view.tiles);
    arguments SortCellsArguments<'a> {
        points: &'a Buffer<Float4>,
        cells: &'a Buffer<[i32; 4]>,
        sets: &'a Buffer<SurfaceSet>,
        rounded: &'a Buffer<[i32; 2]>,
        bounds: &'a Buffer<[u16; 4]>,
        ends: &'a Buffer<u32>,
        lists: &'a Buffer<u32>,
        chunks: i32,
        view: SurfaceView,
        /// Per entry of the lists: the nearest crossing of the cell, and the farthest one up to it.
        nearest: &'a Buffer<f32>,
        farthest: &'a Buffer<f32>,
    }
}

/// Number of blocks of pixels that work-items have.
pub(crate) fn surface_blocks(view: &SurfaceView, tuning: &Tuning) -> usize {
    let per_tile = (SURFACE_TILE / raster(tuning)) as usize;
    super::tiles(view.tiles) * per_tile * per_tile
}

/// Columns and rows of pixels of a work-item: on GPUs, arrays of more would not be in registers.
fn raster(tuning: &Tuning) -> u32 {
    if tuning.vector_width > 1 { SURFACE_TILE } else { 1 }
}

kernel! {
    /// Composites fragments and the volume between them.
    OverFragments = "surfaces/over_fragments.cl", over_fragments, "surfaces", Items::Tiles;
    defines |tuning, depths: bool| wide_defines(tuning.vector_width).with_if(depths, "DEPTHS");
    items |a, _| a.view.size[1] as usize;
    arguments OverFragmentsArguments<'a> {
        view: SurfaceView,
        /// Of the lattice whose samples are the pixels, if there is one.
        lattice: WarpParams,
        /// What of rays is in the volume, in the coordinates of the view.
        volume_ends: RayEnds,
        /// Transmittance of opaque rays.
        opaque: f32,
        /// 1: all fragments are in front of the volume.
        over_all: i32,
        /// 1: nothing has been composited.
        first: i32,
        drawn: &'a Buffer<Float4>,
        depths: &'a Buffer<f32>,
        colors: &'a Buffer<[u16; 4]>,
        states: &'a Buffer<u8>,
        /// Number of the next fragment, and what the ray waits for.
        next: &'a Buffer<u8>,
        picture: &'a Buffer<Float4>,
        cuts: &'a Buffer<[f32; 2]>,
        sample_cuts: &'a Buffer<[f32; 2]>,
        /// Per row of pixels: 1 if fragments are to be found, and between which layers of the lattice intervals are to be drawn.
        pending: &'a Buffer<Float4>,
    }
}
