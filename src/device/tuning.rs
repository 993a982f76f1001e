//! All tuning values and vendor quirks.

use super::kind::DeviceKind;
use crate::error::Error;
use crate::volume::VoxelType;
use serde::Serialize;

/// Kernels keep one bit per tile row in an int.
const MAX_TILE_ROWS: u32 = 30;
/// No device gains from larger work-groups.
const MAX_GROUP: usize = 4096;

/// Work-items per group where they share data, which must fit into 32 KiB of local memory.
const MAX_SHARING_GROUP: usize = 256;

/// Work decomposition of the lattice kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LatticeSchedule {
    /// One work-item per tile, in vectors. Values shared by the samples are computed once.
    Tiles,
    /// One work-item per sample, in registers. A work-group shares the visibility of its rays.
    Samples,
}

/// Columns and rows of samples per patch of neighbouring work-items: see kernels/layered/sample_tile.cl.
const PATCH: [u32; 2] = [8, 4];

/// Build and launch parameters of the kernels on a device.
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
    /// Vector lanes in the lattice kernels: 16, 8, 4 or 1.
    pub vector_width: u32,
    /// Rows per tile in lattices of splatted layers, 1 to 30.
    pub tile_rows: u32,
    /// Rows per tile in lattices of point-sampled layers, 1 to 30.
    pub point_tile_rows: u32,
    /// Work decomposition of the lattice kernels.
    pub lattice_schedule: LatticeSchedule,
    /// Columns and rows of samples per work-group with [`LatticeSchedule::Samples`]: multiples of 8 and 4.
    pub sample_tile: [u32; 2],
    /// Rows of pixels per screen tile in the vector kernels without a lattice, 1 to 30.
    pub screen_tile_rows: u32,
    /// Chunks of the splat list that are sorted in parallel.
    pub splat_chunks: usize,
    /// Screen tiles along each axis that share one splat list, 1 to 30.
    pub list_tiles: u32,
    /// Work-items of the prefix sum over splat counts, 1 to 256.
    pub scan_group: usize,
    /// Pixels per block of the warp along x and y. CPUs copy sixteen at once.
    pub block: [u32; 2],
    /// Neighbouring tiles of a lattice that are rendered one after another, 1 to 4096. The runs of these tiles are spread over the picture.
    pub tile_run: u32,
    /// Work-group size of kernels with a work-item per tile, 1 to 256.
    pub tile_group: usize,
    /// Work-group size of loop-free and per-pixel kernels.
    pub pixel_group: usize,
    /// Whether profiling events report times. If not, stages run one at a time and the wall clock measures them.
    pub event_times: bool,
}

impl Tuning {
    /// Values for a kind of device on a platform. `native_width` is the native vector width in floats, and `threads` the number of compute
    /// units.
    pub fn new(kind: DeviceKind, platform: &str, native_width: u32, threads: u32) -> Self {
        let rusticl = platform.to_lowercase().contains("rusticl");
        // rusticl's event times are all zero.
        let event_times = !rusticl;
        // On a CPU too, rusticl vectorises across work-items and scalarises explicit vectors, which takes minutes for 16 lanes.
        let kind = if rusticl { DeviceKind::Gpu } else { kind };
        match kind {
            // One tile per work-item and one work-item per group, since CPU runtimes distribute groups over threads. Explicit
            // float16 runs at 74 GFLOP/s per core on PoCL, a scalar loop at 6. Intel's runtime reports a preferred width of 1
            // but is fastest with 16. So narrower vectors are used only if the native width is 4 or 8.
            DeviceKind::Cpu | DeviceKind::Other => Self {
                vector_width: if matches!(native_width, 4 | 8) { native_width } else { 16 },
                // Perspective views take 0.75 to 0.9 of the time with 8 rows.
                tile_rows: 16,
                // Each tile resamples three more voxel rows than it has samples. `engine` takes 8.4 ms with 12 rows, 8.1 with 16
                // or 24, 9.0 with 8, 10.5 with 4. Fewer tiles balance worse over threads.
                point_tile_rows: 16,
                lattice_schedule: LatticeSchedule::Tiles,
                sample_tile: [8, 8],
                screen_tile_rows: 16,
                splat_chunks: 32,
                list_tiles: 1,
                scan_group: 1,
                // Each block interpolates lattice lines anew: 16 x 8 takes 4 % longer for large voxels.
                block: [32, 8],
                // Neighbouring tiles share voxels: single tiles cost 0 to 6 % of CPU time, but balance many threads better
                // (benches/cores).
                tile_run: if threads <= 2 { 8 } else { 1 },
                tile_group: 1,
                pixel_group: 64,
                event_times,
            },
            // The state of a work-item must fit into its registers: one lane, one row. Ray casting needed 251 registers with
            // vectors of 4, and needs 60 to 125 with scalars (scripts/gpu-static).
            DeviceKind::Gpu => Self {
                vector_width: 1,
                tile_rows: 1,
                point_tile_rows: 1,
                lattice_schedule: LatticeSchedule::Samples,
                sample_tile: [8, 8],
                screen_tile_rows: 1,
                // One list per pixel would need gigabytes of counts.
                splat_chunks: 512,
                list_tiles: 8,
                scan_group: 256,
                block: [1, 1],
                tile_run: 1,
                tile_group: 32,
                pixel_group: 64,
                event_times,
            },
        }
    }

    /// Rows by which columns of a tile may be longer than others, where columns of pixels lean.
    pub(crate) const RAGGED_ROWS: u32 = 2;

    /// Rows of a tile where columns of pixels lean, for tiles with this number of rows otherwise: kernels add some, and number the rows of a
    /// tile in 32 bits.
    pub(crate) fn pixel_tile_rows(rows: u32) -> u32 {
        rows.min(MAX_TILE_ROWS - Self::RAGGED_ROWS)
    }

    /// Work-group size with [`LatticeSchedule::Samples`].
    pub(super) fn sample_group(&self) -> usize {
        self.sample_tile[0] as usize * self.sample_tile[1] as usize
    }

    /// Columns and rows of pixels that share one splat list.
    #[cfg(feature = "paper")]
    pub(crate) fn list_tile(&self) -> [u32; 2] {
        [self.vector_width, self.screen_tile_rows].map(|pixels| pixels * self.list_tiles)
    }

    /// Rows per work-item when a layout is transposed. CPUs reuse whole cache lines; GPUs coalesce reads of neighbouring
    /// work-items.
    pub(super) fn transposed_rows(&self, voxel_type: VoxelType) -> usize {
        if self.vector_width == 1 { 1 } else { 64 / voxel_type.bytes() }
    }

    /// Rejects values with which kernels cannot be built or launched.
    pub(super) fn check(&self) -> Result<(), Error> {
        let reject =
            |name, value: &dyn std::fmt::Display, expected| Err(Error::OutOfRange { name, value: value.to_string(), expected });
        if !matches!(self.vector_width, 1 | 4 | 8 | 16) {
            return reject("vector width", &self.vector_width, "1, 4, 8 or 16");
        }
        for rows in [self.tile_rows, self.point_tile_rows, self.screen_tile_rows, self.list_tiles] {
            if !(1..=MAX_TILE_ROWS).contains(&rows) {
                return reject("tile size", &rows, "1 to 30 rows or tiles");
            }
        }
        if (0..2).any(|i| self.sample_tile[i] == 0 || !self.sample_tile[i].is_multiple_of(PATCH[i])) {
            let [columns, rows] = self.sample_tile;
            return reject("sample tile", &format!("{columns}x{rows}"), "multiples of 8 and 4");
        }
        let sample_group = (self.sample_tile[0] as usize).saturating_mul(self.sample_tile[1] as usize);
        let [columns, rows] = self.block.map(|pixels| pixels as usize);
        let sizes = [sample_group, columns, rows, self.tile_run as usize, self.pixel_group, self.splat_chunks];
        for group in [self.tile_group, self.scan_group] {
            if !(1..=MAX_SHARING_GROUP).contains(&group) {
                return reject("tile or scan group", &group, "1 to 256");
            }
        }
        match sizes.iter().find(|&&n| n == 0 || n > MAX_GROUP) {
            Some(n) => reject("block, run, group or chunk size", n, "1 to 4096"),
            None => Ok(()),
        }
    }
}
