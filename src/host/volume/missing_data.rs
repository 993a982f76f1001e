//! Stored numbers that stand for missing voxels.

/// What a file declares about missing voxels, as numbers of their stored type.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MissingData {
    /// Numbers that stand for no value, such as fill values.
    numbers: Vec<f64>,
    /// The smallest and the largest number of a voxel that is not missing.
    valid: (f64, f64),
}

impl Default for MissingData {
    fn default() -> Self {
        Self { numbers: Vec::new(), valid: (f64::NEG_INFINITY, f64::INFINITY) }
    }
}

impl MissingData {
    /// Missing are voxels with one of `numbers`, and those outside the `valid` range.
    #[cfg(any(feature = "hdf5", feature = "zarr"))]
    pub fn new(numbers: Vec<f64>, valid: (f64, f64)) -> Self {
        Self { numbers, valid }
    }

    /// Itself, if voxels may be missing.
    pub fn declared(&self) -> Option<&Self> {
        Some(self).filter(|missing| **missing != Self::default())
    }

    /// Whether a stored number stands for a missing voxel.
    pub fn has(&self, number: f64) -> bool {
        number < self.valid.0 || number > self.valid.1 || self.numbers.contains(&number)
    }
}
