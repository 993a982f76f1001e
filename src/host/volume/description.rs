//! Metadata of a volume, without its voxels.

use super::extent::SMALLEST_RANGE;
use super::voxels::{VoxelType, is_valid};
use super::{Grid, Rescale};
use crate::error::Error;
use crate::numbers::shortened;
use std::path::Path;

/// Minimum number of 32-bit float steps within the range, at its larger end, for accurate sums. Devices interpolate by sums of
/// weighted values, which are off by a few tens of steps. With this number, colours of a picture were off by 0.003 (a step of 8
/// bits is 0.004), with 128 by 0.07.
const FINE_STEPS: f64 = 16_384.0;

/// Metadata of a whole volume: name, grid, voxel type, range and background. It does not depend on where the voxels reside. All
/// parts of a volume share it, so that their pictures agree.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Description, Grid, VoxelType};
///
/// // Voxels that reside only on a device.
/// let grid = Grid::new([128; 3], DVec3::ONE)?;
/// let description = Description::new("density", grid, VoxelType::Float32, (0.0, 1.0))?;
/// assert_eq!(description.range(), (0.0, 1.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    pub(super) name: String,
    pub(super) grid: Grid,
    pub(super) voxel_type: VoxelType,
    pub(super) rescale: Rescale,
    /// Smallest and largest valid voxel, as stored.
    pub(super) stored_range: (f64, f64),
    /// Background set by the caller; by default the smallest value.
    pub(super) background: Option<f64>,
    pub(super) invalid_voxels: bool,
    /// What all levels of a data set have in common, of one level with several.
    pub(super) common: Option<Common>,
}

/// What gives all levels of a data set one look: the range and the smallest spacing of the level that stands for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Common {
    pub range: (f64, f64),
    pub spacing: f64,
}

/// Values before rescaling, as kernels see them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub struct Stored {
    /// Smallest and largest stored number.
    pub range: (f64, f64),
    /// Stored number of the smallest value: the largest number if the slope is negative.
    pub smallest_value: f64,
    /// Stored number of the background.
    pub background: f64,
}

impl Stored {
    /// Range of interpolated stored numbers: voxels and background.
    pub fn field_range(&self) -> (f64, f64) {
        with(self.range, self.background)
    }
}

impl Description {
    /// Describes a volume whose voxels are elsewhere or in parts. `stored_range` is the range of all valid voxels as stored. Stored
    /// numbers equal values until [`with_rescale`](Self::with_rescale).
    ///
    /// # Errors
    /// If the range is invalid, exceeds ±1e30, or is too narrow for 32-bit floats.
    pub fn new(name: impl Into<String>, grid: Grid, voxel_type: VoxelType, stored_range: (f64, f64)) -> Result<Self, Error> {
        let (name, (lo, hi)) = (name.into(), stored_range);
        if !(is_valid(lo) && is_valid(hi) && lo <= hi) {
            let expected = "a smallest and a largest number from -1e30 to 1e30";
            return Err(Error::OutOfRange {
                name: "stored range",
                value: format!("{} to {}", shortened(lo), shortened(hi)),
                expected,
            });
        }
        if hi > lo && hi - lo < SMALLEST_RANGE {
            let problem =
                format!("all values lie within {}, too narrow a range for 32-bit floats: scale them up", shortened(hi - lo));
            return Err(Error::volume(Path::new(&name), problem));
        }
        Ok(Self {
            name,
            grid,
            voxel_type,
            rescale: Rescale::default(),
            stored_range,
            background: None,
            invalid_voxels: false,
            common: None,
        })
    }

    /// Sets the [background](Self::background): any finite value whose stored number is at most ±1e30, even outside the range of the voxel type.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for other values.
    pub fn with_background(mut self, value: f64) -> Result<Self, Error> {
        if !(value.is_finite() && is_valid(self.rescale.stored(value))) {
            let expected = "a number of at most 1e30 in magnitude, as stored";
            return Err(Error::OutOfRange { name: "background value", value: shortened(value), expected });
        }
        self.background = Some(value);
        Ok(self)
    }

    /// Declares that some voxels are invalid: NaN, infinite or beyond ±1e30.
    pub fn with_invalid_voxels(self) -> Self {
        Self { invalid_voxels: true, ..self }
    }

    /// Replaces the mapping from stored numbers to values. Resets the background, which was a value of the previous mapping.
    pub fn with_rescale(self, rescale: Rescale) -> Self {
        Self { rescale, background: None, common: None, ..self }
    }

    /// The same field at the voxels of another grid, as floats.
    #[doc(hidden)]
    pub fn resampled(&self, grid: Grid) -> Self {
        Self { voxel_type: VoxelType::Float32, ..self.on_grid(grid) }
    }

    /// The same values, described in a frame on another grid.
    #[doc(hidden)]
    pub fn on_grid(&self, grid: Grid) -> Self {
        Self { grid, ..self.clone() }
    }

    /// Warns of values that 32-bit floats cannot represent or sum accurately. Call it once per volume after reading its voxels;
    /// `invalid` is the number of invalid ones.
    #[doc(hidden)]
    pub fn warn_of_values(&self, invalid: u64) {
        let name = &self.name;
        if invalid > 0 {
            tracing::warn!(
                "{name}: {invalid} voxels are NaN, infinite or beyond 1e30, or missing in the file: they count as the background"
            );
        }
        let (lo, hi) = self.stored_range;
        let largest = lo.abs().max(hi.abs()) as f32;
        let steps = (hi - lo) / f64::from(largest.next_up() - largest);
        if lo < hi && steps < FINE_STEPS {
            tracing::warn!(
                "{name}: its voxels, from {} to {}, are so far from 0 that 32-bit sums of them tell about {steps:.0} values apart: \
                 pictures are coarse; subtract {} from them",
                shortened(lo),
                shortened(hi),
                shortened(lo)
            );
        }
    }

    /// File name or `builtin:NAME`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Position of the voxels in the world.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Type of the stored voxels.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// Mapping from stored numbers to values.
    pub fn rescale(&self) -> Rescale {
        self.rescale
    }

    /// Smallest and largest value of a valid voxel; the value of a stored 0 if no voxel is valid.
    pub fn range(&self) -> (f64, f64) {
        self.rescale.range(self.stored_range)
    }

    /// Range of values over which transfer functions are stretched: that of the voxels, or of the level that stands for all levels of a data
    /// set. Voxels of finer levels may lie outside it.
    pub fn common_range(&self) -> (f64, f64) {
        self.common.map_or_else(|| self.range(), |common| common.range)
    }

    /// The gradient, in values per world unit, that lighting counts as one: the [common range](Self::common_range) within a voxel.
    #[doc(hidden)]
    pub fn steepness(&self) -> f64 {
        let (lo, hi) = self.common_range();
        let spacing = self.common.map_or_else(|| self.grid.spacing().min_element(), |common| common.spacing);
        (if hi > lo { hi - lo } else { 1.0 }) / spacing
    }

    /// Value of invalid voxels and of missing voxels outside the grid, which kernels near the border read. Defaults to the smallest valid
    /// value, of the [common range](Self::common_range).
    pub fn background(&self) -> f64 {
        self.background.unwrap_or(self.common_range().0)
    }

    /// Range of interpolated values: voxels and background.
    pub fn field_range(&self) -> (f64, f64) {
        with(self.range(), self.background())
    }

    /// Whether some voxels are invalid and take the [background](Self::background).
    pub fn has_invalid_voxels(&self) -> bool {
        self.invalid_voxels
    }

    #[doc(hidden)]
    pub fn stored(&self) -> Stored {
        let (lo, hi) = self.stored_range;
        let smallest_value = if self.rescale.slope() < 0.0 { hi } else { lo };
        let background = self.background.or(self.common.map(|common| common.range.0));
        let background = background.map_or(smallest_value, |value| self.rescale.stored(value));
        Stored { range: self.stored_range, smallest_value, background }
    }
}

/// Extends a range to include a value.
fn with((lo, hi): (f64, f64), value: f64) -> (f64, f64) {
    (lo.min(value), hi.max(value))
}
