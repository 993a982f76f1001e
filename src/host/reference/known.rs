//! Analytic functions whose samples are voxels.

use super::integral::Continuous;
use super::interval::Interval;
use crate::layers::Ray;
use crate::volume::Grid;
use glam::DVec3;

/// A function from a position in voxels to its value and its gradient per voxel.
pub(super) struct Known<F> {
    function: F,
    /// Position of the last voxel.
    last: DVec3,
}

impl<F: Fn(DVec3) -> (f64, DVec3) + Sync> Known<F> {
    /// The support is the region between the outermost voxels of a grid.
    pub fn new(grid: &Grid, function: F) -> Self {
        Self { function, last: DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0)) }
    }
}

impl<F: Fn(DVec3) -> (f64, DVec3) + Sync> Continuous for Known<F> {
    fn value(&self, p: DVec3) -> f64 {
        (self.function)(p).0
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        (self.function)(p).1
    }

    fn extent(&self, ray: &Ray) -> Option<Interval> {
        Interval::in_box(ray, DVec3::ZERO, self.last)
    }
}
