//! Reconstruction kernels.

use super::gaussian::gaussian;
use super::kernel_function::kernel_function;
use crate::choice::choices;
use serde::{Deserialize, Serialize};

/// A separable reconstruction kernel.
///
/// ```
/// use layersplat::Kernel;
///
/// // The cubic interpolates: its weight is 1 at the voxel itself and 0 at the next one.
/// assert_eq!([0.0, 1.0].map(|distance| Kernel::Cubic.weight(distance)), [1.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(into = "&'static str", try_from = "String")]
pub enum Kernel {
    /// 1 − |x|, radius 1: C⁰.
    Linear,
    /// The paper's cubic (Eq. 2), radius 1: C¹, with a zero gradient at every voxel.
    Cubic,
    /// Cubic convolution of Keys (1981) with a = −½, radius 2; the Catmull–Rom spline (1974). Interpolates voxels, with central
    /// differences as slopes.
    CatmullRom,
    /// Cubic B-spline, radius 2, applied to coefficients from [`prefilter`](fn@super::prefilter), so that it interpolates voxels (Unser
    /// 1999): C².
    BSpline,
    /// The sheet methods' Gaussian, radius 2. Does not interpolate; its weights sum to about 1 only.
    Gaussian,
}

choices! {
    Kernel, "kernel";
    Cubic = "cubic" | "tricubic",
    Linear = "linear" | "trilinear",
    CatmullRom = "catmull-rom",
    BSpline = "bspline",
    Gaussian = "gaussian",
}

impl Kernel {
    /// Kernels for sampling layers: their weights sum to one everywhere.
    pub const OF_LAYERS: [Kernel; 4] = [Kernel::Cubic, Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline];

    /// Half the width of the support, in voxels.
    pub fn radius(self) -> i32 {
        match self {
            Kernel::Linear | Kernel::Cubic => 1,
            Kernel::CatmullRom | Kernel::BSpline | Kernel::Gaussian => 2,
        }
    }

    /// One-dimensional weight at a distance in voxels.
    pub fn weight(self, x: f64) -> f64 {
        let d = x.abs();
        match self {
            Kernel::Linear => (1.0 - d).max(0.0),
            Kernel::Cubic => kernel_function(x),
            Kernel::CatmullRom if d < 1.0 => 1.0 + d * d * (1.5 * d - 2.5),
            Kernel::CatmullRom if d < 2.0 => 2.0 + d * (-4.0 + d * (2.5 - 0.5 * d)),
            Kernel::BSpline if d < 1.0 => 2.0 / 3.0 + d * d * (0.5 * d - 1.0),
            Kernel::BSpline if d < 2.0 => (2.0 - d).powi(3) / 6.0,
            Kernel::CatmullRom | Kernel::BSpline => 0.0,
            Kernel::Gaussian => gaussian(x),
        }
    }

    /// One-dimensional derivative weight for gradients, at a distance in voxels. For Catmull–Rom and B-spline it is the derivative of the
    /// kernel. The others use central differences of the field over ±1 voxel: the derivative of Eq. 2 vanishes at every voxel, and that
    /// of the linear kernel is discontinuous.
    pub fn slope(self, x: f64) -> f64 {
        let d = x.abs();
        match self {
            Kernel::Linear | Kernel::Cubic | Kernel::Gaussian => (self.weight(x + 1.0) - self.weight(x - 1.0)) / 2.0,
            Kernel::CatmullRom if d < 1.0 => x * (4.5 * d - 5.0),
            Kernel::CatmullRom if d < 2.0 => x.signum() * (-4.0 + d * (5.0 - 1.5 * d)),
            Kernel::BSpline if d < 1.0 => x * (1.5 * d - 2.0),
            Kernel::BSpline if d < 2.0 => x.signum() * (2.0 - d).powi(2) / -2.0,
            Kernel::CatmullRom | Kernel::BSpline => 0.0,
        }
    }

    /// Whether [`slope`](Self::slope) is the derivative of the kernel.
    pub fn has_own_slope(self) -> bool {
        matches!(self, Kernel::CatmullRom | Kernel::BSpline)
    }

    /// Overshoot of the weighted sum beyond the range of its inputs (coefficients, for the B-spline), as a fraction of that range: half the
    /// excess over one of the sum of absolute weights. Weights of the Gaussian do not sum to one; see
    /// [`GAUSSIAN_OVERSHOOT`](super::GAUSSIAN_OVERSHOOT).
    pub fn overshoot(self) -> f64 {
        match self {
            // At most 1.25 per axis, half-way between voxels.
            Kernel::CatmullRom => (1.25f64.powi(3) - 1.0) / 2.0,
            Kernel::Linear | Kernel::Cubic | Kernel::BSpline | Kernel::Gaussian => 0.0,
        }
    }

    /// Overshoot of the field beyond the range of the voxels, as a fraction of that range.
    pub fn field_overshoot(self) -> f64 {
        match self {
            // Absolute voxel weights of an interpolating cubic spline sum to at most 1.5491 per axis, half-way between voxels.
            Kernel::BSpline => (1.5491f64.powi(3) - 1.0) / 2.0,
            other => other.overshoot(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Positions between voxels.
    fn places() -> impl Iterator<Item = f64> {
        (0..=100).map(|i| f64::from(i) / 100.0)
    }

    #[test]
    fn lattice_sums_are_one_everywhere_and_of_slopes_nothing() {
        for kernel in Kernel::OF_LAYERS {
            for x in places() {
                let sum = |of: fn(Kernel, f64) -> f64| -> f64 { (-4..=4).map(|j| of(kernel, x - f64::from(j))).sum() };
                assert_abs_diff_eq!(sum(Kernel::weight), 1.0, epsilon = 1e-14);
                assert_abs_diff_eq!(sum(Kernel::slope), 0.0, epsilon = 1e-14);
            }
        }
    }

    #[test]
    fn slopes_are_derivatives_where_they_are_the_kernels_own() {
        for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.has_own_slope()) {
            for x in places().map(|x| 5.0 * x - 2.5) {
                let h = 1e-6;
                let derivative = (kernel.weight(x + h) - kernel.weight(x - h)) / (2.0 * h);
                assert_abs_diff_eq!(kernel.slope(x), derivative, epsilon = 1e-5);
            }
        }
    }

    /// All kernels give slope 1 for a linear ramp. Kernels that reproduce parabolas give 2x for x².
    #[test]
    fn slopes_of_polynomials() {
        for kernel in Kernel::OF_LAYERS {
            for x in places() {
                let slope = |f: fn(f64) -> f64| -> f64 { (-4..=4).map(f64::from).map(|j| f(j) * kernel.slope(x - j)).sum() };
                assert_abs_diff_eq!(slope(|j| j), 1.0, epsilon = 1e-13);
                if matches!(kernel, Kernel::CatmullRom | Kernel::BSpline) {
                    assert_abs_diff_eq!(slope(|j| j * j), 2.0 * x, epsilon = 1e-13);
                }
            }
        }
    }

    #[test]
    fn supports_and_overshoots() {
        for kernel in Kernel::ALL {
            let r = f64::from(kernel.radius());
            assert_eq!((kernel.weight(r), kernel.weight(-r - 0.3)), (0.0, 0.0), "{kernel:?}");
            assert_ne!(kernel.weight(r - 0.1), 0.0, "{kernel:?}");
        }
        for kernel in Kernel::OF_LAYERS {
            let magnitudes = |x: f64| -> f64 { (-4..=4).map(|j| kernel.weight(x - f64::from(j)).abs()).sum() };
            let most = places().map(magnitudes).fold(0.0, f64::max);
            assert_abs_diff_eq!(kernel.overshoot(), (most.powi(3) - 1.0) / 2.0, epsilon = 1e-12);
        }
    }
}
