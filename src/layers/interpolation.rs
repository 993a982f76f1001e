//! Kernels that reconstruct the field between voxels.

use super::gaussian::gaussian;
use super::kernel_function::kernel_function;
use serde::Serialize;

/// A separable reconstruction kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// 1 − |x|, radius 1.
    Trilinear,
    /// The paper's cubic (Eq. 2), radius 1.
    Tricubic,
    /// The sheet methods' Gaussian, radius 2.
    Gaussian,
}

impl Interpolation {
    /// Half the width of its support, in voxels.
    pub fn radius(self) -> i32 {
        match self {
            Interpolation::Trilinear | Interpolation::Tricubic => 1,
            Interpolation::Gaussian => 2,
        }
    }

    /// Its value at a distance in voxels along one axis.
    pub fn weight(self, x: f64) -> f64 {
        match self {
            Interpolation::Trilinear => (1.0 - x.abs()).max(0.0),
            Interpolation::Tricubic => kernel_function(x),
            Interpolation::Gaussian => gaussian(x),
        }
    }
}
