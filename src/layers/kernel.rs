//! Kernels that reconstruct the field between voxels.

use super::gaussian::gaussian;
use super::kernel_function::kernel_function;
use serde::Serialize;

/// A separable reconstruction kernel.
///
/// ```
/// use layersplat::Kernel;
///
/// // The cubic weighs a voxel's own place with 1, and the next one with 0.
/// assert_eq!([0.0, 1.0].map(|distance| Kernel::Cubic.weight(distance)), [1.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// 1 − |x|, radius 1; the field is continuous.
    Linear,
    /// The paper's cubic (Eq. 2), radius 1: smooth, but flat at every voxel.
    Cubic,
    /// The cubic convolution of Keys (1981) with a = −½, radius 2, which Catmull & Rom (1974) found as a spline: the field meets every
    /// voxel, with the slope between its neighbours.
    CatmullRom,
    /// The cubic B-spline, radius 2, on coefficients ([`prefilter`](fn@super::prefilter)) with which the field meets every voxel (Unser 1999):
    /// twice differentiable.
    #[serde(rename = "bspline")]
    BSpline,
    /// The sheet methods' Gaussian, radius 2.
    Gaussian,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Kernel; 5] = [Kernel::Cubic, Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline, Kernel::Gaussian];
    /// Those that layers can be sampled with: their weights sum to one everywhere.
    pub const OF_LAYERS: [Kernel; 4] = [Kernel::Cubic, Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::Linear => "linear",
            Kernel::Cubic => "cubic",
            Kernel::CatmullRom => "catmull-rom",
            Kernel::BSpline => "bspline",
            Kernel::Gaussian => "gaussian",
        }
    }

    /// Half the width of its support, in voxels.
    pub fn radius(self) -> i32 {
        match self {
            Kernel::Linear | Kernel::Cubic => 1,
            Kernel::CatmullRom | Kernel::BSpline | Kernel::Gaussian => 2,
        }
    }

    /// Its value at a distance in voxels along one axis.
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

    /// What gradients weight voxels with along the axis of the difference: the kernel's own derivative where that is of use, else that
    /// of central differences of the field over one voxel each way. (Eq. 2's own vanishes at every voxel, a linear one's jumps.)
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

    /// Whether [`slope`](Self::slope) is its own derivative.
    pub fn has_own_slope(self) -> bool {
        matches!(self, Kernel::CatmullRom | Kernel::BSpline)
    }

    /// How far sums of what it weights (of the B-spline, coefficients) can lie beyond the largest and below the smallest, as a share of the
    /// distance between these: half of what the magnitudes of all weights sum to beyond one. The Gaussian's do not sum to one; see
    /// [`GAUSSIAN_OVERSHOOT`](super::GAUSSIAN_OVERSHOOT).
    pub fn overshoot(self) -> f64 {
        match self {
            // At most 1.25 per axis, in the middle between two voxels.
            Kernel::CatmullRom => (1.25f64.powi(3) - 1.0) / 2.0,
            Kernel::Linear | Kernel::Cubic | Kernel::BSpline | Kernel::Gaussian => 0.0,
        }
    }

    /// How far the field can lie beyond the largest and below the smallest voxel, as a share of the distance between these.
    pub fn field_overshoot(self) -> f64 {
        match self {
            // The weights of voxels in an interpolating cubic spline: at most 1.5491 per axis, in the middle between two.
            Kernel::BSpline => (1.5491f64.powi(3) - 1.0) / 2.0,
            other => other.overshoot(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Places between voxels.
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

    /// Slopes of a ramp are one, whichever they are; of x² they are 2x where the kernel knows parabolas.
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
