//! What is known of a whole volume without its voxels.

use super::voxels::{VoxelType, is_valid};
use super::{Grid, Rescale};
use crate::error::Error;

/// A whole volume, whoever holds its voxels: all of them, a part, or a device. Everything that pictures of parts must agree in comes
/// from here.
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

    pub(crate) fn stored(&self) -> Stored {
        let (lo, hi) = self.stored_range;
        let smallest_value = if self.rescale.slope() < 0.0 { hi } else { lo };
        let background = self.background.map_or(smallest_value, |value| self.rescale.stored(value));
        Stored { range: self.stored_range, smallest_value, background }
    }

    pub(super) fn set_background(&mut self, value: f64) -> Result<(), Error> {
        if !(is_valid(value) && is_valid(self.rescale.stored(value))) {
            let expected = "a number from -1e30 to 1e30";
            return Err(Error::OutOfRange { name: "background value", value: value.to_string(), expected });
        }
        self.background = Some(value);
        Ok(())
    }
}

/// A range with one more value in it.
fn with((lo, hi): (f64, f64), value: f64) -> (f64, f64) {
    (lo.min(value), hi.max(value))
}
