//! Every tuning value and every vendor quirk.

use super::kind::DeviceKind;
use crate::error::Error;
use serde::Serialize;

/// Kernels keep a bit per row of a tile in an int.
const MOST_TILE_ROWS: u32 = 30;
/// More are of no use to any device.
const LARGEST_GROUP: usize = 4096;

/// What its work-items share must fit into the memory of a group: 32 KiB.
const LARGEST_SHARING_GROUP: usize = 256;

/// Who draws what of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LatticeSchedule {
    /// A work-item a tile, in vectors: what samples have in common is found once.
    Tiles,
    /// A work-item a sample, in registers: a group shares what its rays can see.
    Samples,
}

/// Columns and rows of samples that neighbouring work-items take: kernels/layered/sample_tile.cl.
const NEIGHBOURS: [u32; 2] = [8, 4];

/// How kernels are built and launched on a device.
///
/// ```
/// use layersplat::device::Tuning;
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// let narrow = device.with_tuning(Tuning { vector_width: 4, ..*device.tuning() })?;
/// assert_eq!(narrow.tuning().vector_width, 4);
/// assert!(device.with_tuning(Tuning { vector_width: 3, ..*device.tuning() }).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Tuning {
    /// Lanes of a vector in the lattice kernels (16, 8, 4 or 1).
    pub vector_width: u32,
    /// Vectors per tile along u in the parallel lattice.
    pub tile_vectors: u32,
    /// Rows per tile of the lattices of splatted layers.
    pub tile_rows: u32,
    /// Rows per tile of the lattice of point-sampled layers.
    pub point_tile_rows: u32,
    /// Who draws what of a lattice.
    pub lattice_schedule: LatticeSchedule,
    /// Columns and rows of it per group, where a work-item draws a sample: multiples of 8 and 4.
    pub sample_tile: [u32; 2],
    /// Rows per tile of screen pixels, for the kernels that draw without a lattice in vectors.
    pub screen_tile_rows: u32,
    /// Parts of a list of splats that are sorted at the same time.
    pub splat_chunks: usize,
    /// Tiles of screen pixels, along both axes, that have one list of splats.
    pub list_tiles: u32,
    /// Work-items that add up counts of splats.
    pub scan_group: usize,
    /// Pixels of a block in the warp, along x and y: processors copy sixteen at once.
    pub block: [u32; 2],
    /// Work-items per group of the tile kernels.
    pub tile_group: usize,
    /// Work-items per group of the loop-free and per-pixel kernels.
    pub pixel_group: usize,
    /// Whether profiling events hold times; if not, stages are timed by the wall clock, one at a time.
    pub event_times: bool,
}

impl Tuning {
    /// The values for a kind of device on a platform, whose native vectors are of `native_width` floats.
    pub fn new(kind: DeviceKind, platform: &str, native_width: u32) -> Self {
        let rusticl = platform.to_lowercase().contains("rusticl");
        // rusticl's event times are all zero.
        let event_times = !rusticl;
        // On a processor too it makes vectors of work-items, and takes explicit ones apart: those of 16 take it minutes to compile.
        let kind = if rusticl { DeviceKind::Gpu } else { kind };
        match kind {
            // A tile to a work-item and a work-item to a group: groups are what CPU runtimes hand to threads. Explicit
            // float16 runs at 74 GFLOP/s per core on PoCL, a scalar loop at 6. Intel's runtime says it prefers a width
            // of 1 but wants 16, so narrower vectors are taken only where the device names a native width of 4 or 8.
            DeviceKind::Cpu | DeviceKind::Other => Self {
                vector_width: if matches!(native_width, 4 | 8) { native_width } else { 16 },
                tile_vectors: if matches!(native_width, 4) { 4 } else { 1 },
                // Perspectives take 0.75 to 0.9 of the time that they take with 8.
                tile_rows: 16,
                // Rows of voxels are resampled once per tile, three more than its samples need: engine takes 8.4 ms with
                // 12 rows, 8.1 with 16 or 24, 9.0 with 8, 10.5 with 4. Fewer tiles are harder to share.
                point_tile_rows: 16,
                lattice_schedule: LatticeSchedule::Tiles,
                sample_tile: [8, 8],
                screen_tile_rows: 16,
                splat_chunks: 32,
                list_tiles: 1,
                scan_group: 1,
                // Lines of the lattice are mixed for each block anew: 16 x 8 take 4 % longer where voxels are large.
                block: [32, 8],
                tile_group: 1,
                pixel_group: 64,
                event_times,
            },
            // What a work-item holds must fit into its registers: one lane, one row. In vectors of 4, rays that are cast took 251
            // of them; by themselves they take 60 to 125 (scripts/gpu-static).
            DeviceKind::Gpu => Self {
                vector_width: 1,
                tile_vectors: 1,
                tile_rows: 1,
                point_tile_rows: 1,
                lattice_schedule: LatticeSchedule::Samples,
                sample_tile: [8, 8],
                screen_tile_rows: 1,
                // A list for each pixel would take gigabytes of counts.
                splat_chunks: 512,
                list_tiles: 8,
                scan_group: 256,
                block: [1, 1],
                tile_group: 32,
                pixel_group: 64,
                event_times,
            },
        }
    }

    /// Work-items of a group that draw a sample each.
    pub(super) fn sample_group(&self) -> usize {
        self.sample_tile[0] as usize * self.sample_tile[1] as usize
    }

    /// Columns and rows of screen pixels that have one list of splats.
    pub(crate) fn list_tile(&self) -> [u32; 2] {
        [self.vector_width, self.screen_tile_rows].map(|pixels| pixels * self.list_tiles)
    }

    /// Rows of a transposed layout that a work-item makes: processors gather lines of the cache, graphics processors read side by side.
    pub(super) fn transposed_rows(&self) -> usize {
        if self.vector_width == 1 { 1 } else { 16 }
    }

    /// Samples of a parallel tile along u.
    pub(crate) fn tile_columns(&self) -> u32 {
        self.vector_width * self.tile_vectors
    }

    /// Refuses what kernels cannot be built or started with.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse =
            |name, value: &dyn std::fmt::Display, expected| Err(Error::OutOfRange { name, value: value.to_string(), expected });
        if !matches!(self.vector_width, 1 | 4 | 8 | 16) {
            return refuse("vector width", &self.vector_width, "1, 4, 8 or 16");
        }
        for rows in [self.tile_rows, self.point_tile_rows, self.screen_tile_rows, self.tile_vectors, self.list_tiles] {
            if !(1..=MOST_TILE_ROWS).contains(&rows) {
                return refuse("tile size", &rows, "1 to 30 rows, vectors or tiles");
            }
        }
        if (0..2).any(|i| self.sample_tile[i] == 0 || !self.sample_tile[i].is_multiple_of(NEIGHBOURS[i])) {
            let [columns, rows] = self.sample_tile;
            return refuse("sample tile", &format!("{columns}x{rows}"), "a multiple of 8 by one of 4");
        }
        let sample_group = (self.sample_tile[0] as usize).saturating_mul(self.sample_tile[1] as usize);
        let sizes = [sample_group, self.block[0] as usize, self.block[1] as usize, self.pixel_group, self.splat_chunks];
        for group in [self.tile_group, self.scan_group] {
            if !(1..=LARGEST_SHARING_GROUP).contains(&group) {
                return refuse("tile or scan group", &group, "1 to 256");
            }
        }
        match sizes.iter().find(|&&n| n == 0 || n > LARGEST_GROUP) {
            Some(n) => refuse("block, group or chunk size", n, "1 to 4096"),
            None => Ok(()),
        }
    }
}
