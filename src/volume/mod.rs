//! Volumes: where voxels lie and what they hold. Readers know nothing of rendering.

mod builtin;
mod grid;
mod raw;
mod statistics;
mod voxels;

pub use builtin::builtin_volume;
pub use grid::Grid;
pub use raw::{Endian, RawOptions};
pub use statistics::{HISTOGRAM_BINS, Statistics};
pub(crate) use voxels::for_voxels;
pub use voxels::{VoxelType, Voxels};

use crate::error::Error;
use std::path::Path;

/// A narrower range of float values would be lost in the device's floats, which have no denormals.
const SMALLEST_RANGE: f64 = 1e-30;
/// Beyond this magnitude a float voxel counts as not finite: sums of a few voxels must not overflow.
const LARGEST_MAGNITUDE: f32 = 1e30;

/// A scalar volume: a grid and its voxels, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct Volume {
    name: String,
    grid: Grid,
    voxels: Voxels,
    range: (f64, f64),
    replaced: usize,
}

impl Volume {
    /// A volume from voxels in memory, x fastest. `name` is shown in messages and reports.
    ///
    /// Float voxels that are NaN, infinite or beyond ±1e30 become the [background](Self::background); how many there
    /// were is kept in [`replaced`](Self::replaced), and a warning is logged.
    pub fn new(name: impl Into<String>, grid: Grid, mut voxels: Voxels) -> Result<Self, Error> {
        let name = name.into();
        if voxels.len() != grid.voxel_count() {
            let (expected, found) = (grid.voxel_count() as u64, voxels.len() as u64);
            return Err(Error::VoxelCount { name, dims: grid.dims(), expected, found });
        }
        let usable = |v: f32| v.abs() <= LARGEST_MAGNITUDE;
        let mut range = voxels.range_where(usable).unwrap_or((0.0, 0.0));
        let replaced = voxels.replace_where_not(usable, range.0.min(0.0) as f32);
        if replaced > 0 {
            range.0 = range.0.min(0.0);
            tracing::warn!("{name}: {replaced} voxels are NaN, infinite or beyond 1e30; they became the background value");
        }
        if range.1 - range.0 > 0.0 && range.1 - range.0 < SMALLEST_RANGE {
            let problem =
                format!("all values lie within {:e}, too close together for a device: scale them up", range.1 - range.0);
            return Err(Error::volume(Path::new(&name), problem));
        }
        Ok(Self { name, grid, voxels, range, replaced })
    }

    /// Opens `builtin:NAME[@SIZE]` or a file: `NAME_XxYxZ_TYPE.raw` or `.raw.gz`, with `options` for what the name
    /// does not tell, or tells wrongly.
    pub fn open(source: impl AsRef<Path>, options: &RawOptions) -> Result<Self, Error> {
        let source = source.as_ref();
        match source.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(builtin) => builtin_volume(builtin, options),
            None => raw::read(source, options),
        }
    }

    /// File name or `builtin:NAME`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the voxels lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The voxels, x fastest.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Smallest and largest voxel value.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }

    /// The value of voxels missing around the volume, where kernels still reach: min(0, smallest value), so that CT
    /// data in Hounsfield units are surrounded by air.
    pub fn background(&self) -> f64 {
        self.range.0.min(0.0)
    }

    /// Range of every interpolated value: that of the voxels and the background.
    pub fn field_range(&self) -> (f64, f64) {
        (self.background(), self.range.1.max(self.background()))
    }

    /// Float voxels that were not finite and became the background.
    pub fn replaced(&self) -> usize {
        self.replaced
    }

    /// Mean and histogram of the voxels.
    pub fn statistics(&self) -> Statistics {
        Statistics::new(&self.voxels, self.range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn voxels_that_are_not_finite_become_the_background() {
        let grid = Grid::new([2, 2, 1], DVec3::ONE).unwrap();
        let volume = Volume::new("t", grid, Voxels::Float32(vec![f32::NAN, 5.0, f32::INFINITY, 7.0])).unwrap();
        assert_eq!((volume.replaced(), volume.background(), volume.range()), (2, 0.0, (0.0, 7.0)));
        let grid = Grid::new([2, 1, 1], DVec3::ONE).unwrap();
        let volume = Volume::new("t", grid, Voxels::Float32(vec![-2e31, -5.0])).unwrap();
        assert_eq!((volume.replaced(), volume.background(), volume.range()), (1, -5.0, (-5.0, -5.0)));
    }

    #[test]
    fn a_wrong_count_or_a_lost_range_is_refused() {
        let grid = Grid::new([2, 2, 2], DVec3::ONE).unwrap();
        assert!(Volume::new("t", grid.clone(), Voxels::Uint8(vec![0; 7])).is_err());
        let tiny = Voxels::Float32((0..8).map(|i| i as f32 * 1e-35).collect());
        assert!(Volume::new("t", grid, tiny).unwrap_err().to_string().contains("scale them up"));
    }
}
