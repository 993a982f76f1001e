//! What is known of a whole volume without its voxels.

use super::voxels::{VoxelType, is_valid};
use super::{Grid, Rescale};
use crate::error::Error;
use std::path::Path;

/// A narrower range of float values would be lost in the device's floats, which have no denormals.
const SMALLEST_RANGE: f64 = 1e-30;
/// Steps of a 32-bit float within the range, at its larger end, from which on its sums are fine enough. Devices interpolate by sums of
/// weighted values, which are off by a few tens of steps: with this many, colours of a picture were off by 0.003 (a step of 8 bits is
/// 0.004), with 128 by 0.07.
const FINE_STEPS: f64 = 16_384.0;

/// A whole volume, whoever holds its voxels: all of them, a part, or a device. Everything that pictures of parts must agree in comes
/// from here.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Description, Grid, VoxelType};
///
/// // Of voxels that only a device has.
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
    /// What was set; the smallest value otherwise.
    pub(super) background: Option<f64>,
    pub(super) invalid_voxels: bool,
}

/// Values as numbers that would be stored, as kernels see them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stored {
    /// Smallest and largest number.
    pub range: (f64, f64),
    /// Of the smallest value, which has the largest number if the slope is negative.
    pub smallest_value: f64,
    /// Of the background.
    pub background: f64,
}

impl Stored {
    /// Range of every interpolated number: that of the voxels and the background.
    pub fn field_range(&self) -> (f64, f64) {
        with(self.range, self.background)
    }
}

impl Description {
    /// What is known of a volume whose voxels lie elsewhere, or in parts. `stored_range` is that of all valid voxels, as stored; stored
    /// numbers are values until [`with_rescale`](Self::with_rescale).
    ///
    /// # Errors
    /// A range that is no range, or too narrow for a device.
    pub fn new(name: impl Into<String>, grid: Grid, voxel_type: VoxelType, stored_range: (f64, f64)) -> Result<Self, Error> {
        let (name, (lo, hi)) = (name.into(), stored_range);
        if !(is_valid(lo) && is_valid(hi) && lo <= hi) {
            let expected = "a smallest and a largest number from -1e30 to 1e30";
            return Err(Error::OutOfRange { name: "stored range", value: format!("{lo} to {hi}"), expected });
        }
        if hi > lo && hi - lo < SMALLEST_RANGE {
            let problem = format!("all values lie within {:e}, too close together for a device: scale them up", hi - lo);
            return Err(Error::volume(Path::new(&name), problem));
        }
        Ok(Self { name, grid, voxel_type, rescale: Rescale::default(), stored_range, background: None, invalid_voxels: false })
    }

    /// The same with another [background](Self::background): any finite value up to ±1e30, whether voxels can have it or not.
    pub fn with_background(mut self, value: f64) -> Result<Self, Error> {
        if !(is_valid(value) && is_valid(self.rescale.stored(value))) {
            let expected = "a number from -1e30 to 1e30";
            return Err(Error::OutOfRange { name: "background value", value: value.to_string(), expected });
        }
        self.background = Some(value);
        Ok(self)
    }

    /// The same where some voxels are invalid, wherever they lie: NaN, infinite or beyond ±1e30.
    pub fn with_invalid_voxels(self) -> Self {
        Self { invalid_voxels: true, ..self }
    }

    /// The same stored numbers with other values. A background that was set before is forgotten: it was one of the old values.
    pub fn with_rescale(self, rescale: Rescale) -> Self {
        Self { rescale, background: None, ..self }
    }

    /// Warns of values that 32-bit floats cannot hold or add up: to be called once for each volume whose voxels were looked at, of which
    /// so many are invalid.
    pub(crate) fn warn_of_values(&self, invalid: u64) {
        let name = &self.name;
        if invalid > 0 {
            tracing::warn!("{name}: {invalid} voxels are NaN, infinite or beyond 1e30: they count as the background");
        }
        let (lo, hi) = self.stored_range;
        let largest = lo.abs().max(hi.abs()) as f32;
        let steps = (hi - lo) / f64::from(largest.next_up() - largest);
        if lo < hi && steps < FINE_STEPS {
            tracing::warn!(
                "{name}: its voxels, from {lo} to {hi}, are so far from 0 that 32-bit sums of them tell about {steps:.0} values apart: \
                 pictures are coarse; subtract {lo} from them"
            );
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

    /// Type of the voxels as stored.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// How stored numbers become values.
    pub fn rescale(&self) -> Rescale {
        self.rescale
    }

    /// Smallest and largest value of a valid voxel; that of a stored 0 if there is none.
    pub fn range(&self) -> (f64, f64) {
        self.rescale.range(self.stored_range)
    }

    /// The value of invalid voxels, and of those missing around the volume, where kernels still reach: the smallest valid value
    /// unless another was given.
    pub fn background(&self) -> f64 {
        self.background.unwrap_or(self.range().0)
    }

    /// Range of every interpolated value: that of the voxels and the background.
    pub fn field_range(&self) -> (f64, f64) {
        with(self.range(), self.background())
    }

    /// Whether some voxels are invalid, and count as [background](Self::background).
    pub fn has_invalid_voxels(&self) -> bool {
        self.invalid_voxels
    }

    pub(crate) fn stored(&self) -> Stored {
        let (lo, hi) = self.stored_range;
        let smallest_value = if self.rescale.slope() < 0.0 { hi } else { lo };
        let background = self.background.map_or(smallest_value, |value| self.rescale.stored(value));
        Stored { range: self.stored_range, smallest_value, background }
    }
}

/// A range with one more value in it.
fn with((lo, hi): (f64, f64), value: f64) -> (f64, f64) {
    (lo.min(value), hi.max(value))
}
