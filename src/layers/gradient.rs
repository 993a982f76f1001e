//! Estimation of gradients.

use super::kernel::Kernel;
use glam::DVec3;
use serde::Serialize;
use std::str::FromStr;

/// How the gradients for shading and gradient opacity are estimated.
///
/// Data of few bits and thick slices have terraces. Differences of neighbouring voxels, and derivatives of splines even more, show each
/// of them as light and dark. Smoothing across the direction of a difference suppresses them, and noise.
///
/// ```
/// use layersplat::{GradientEstimator, Kernel};
///
/// assert_eq!("sobel".parse(), Ok(GradientEstimator::Sobel));
/// assert!(GradientEstimator::Own.supports(Kernel::BSpline) && !GradientEstimator::Own.supports(Kernel::Linear));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GradientEstimator {
    /// Central differences of the voxels, interpolated by the linear kernel or the paper's cubic; by other kernels of layers linearly.
    Central,
    /// Central differences, smoothed across their direction ([`sobel_smoothing`](Self::sobel_smoothing)) and interpolated linearly: the operator of
    /// Sobel and Feldman (1968) in three dimensions, with the weights 1 2 1.
    Sobel,
    /// The derivative of the kernel.
    Own,
}

impl GradientEstimator {
    /// All estimators.
    pub const ALL: [Self; 3] = [Self::Central, Self::Sobel, Self::Own];

    /// The estimator that fits a kernel most closely: its derivative where that is continuous, else central differences.
    pub fn for_kernel(kernel: Kernel) -> Self {
        if kernel.has_own_slope() { Self::Own } else { Self::Central }
    }

    /// Whether the estimator can be used with a kernel. The B-spline's inputs are coefficients and not voxels, so it has its derivative
    /// only; the derivatives of the linear kernel, of the paper's cubic and of the Gaussian are not continuous, or vanish at every voxel.
    pub fn supports(self, kernel: Kernel) -> bool {
        match self {
            Self::Central => kernel != Kernel::BSpline,
            Self::Sobel => !matches!(kernel, Kernel::BSpline | Kernel::Gaussian),
            Self::Own => kernel.has_own_slope(),
        }
    }

    /// Whether gradients are estimated at the voxels and interpolated linearly, whatever the kernel.
    pub fn is_at_voxels(self, kernel: Kernel) -> bool {
        match self {
            Self::Central => kernel.has_own_slope(),
            Self::Sobel => true,
            Self::Own => false,
        }
    }

    /// Smoothing of [`Sobel`](Self::Sobel) along each axis: the weight of each of the two neighbours of a voxel, which itself has the
    /// rest. `spacing`: of x, y and z.
    ///
    /// The weights are ¼ (1 2 1) along the axis of the smallest spacing h₀. Along an axis of spacing h the neighbours have ¼ (h₀/h)²,
    /// which has the same variance in world units.
    pub fn sobel_smoothing(spacing: DVec3) -> DVec3 {
        let relative = spacing.min_element() / spacing;
        0.25 * relative * relative
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Central => "central",
            Self::Sobel => "sobel",
            Self::Own => "own",
        }
    }
}

impl FromStr for GradientEstimator {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|estimator| estimator.name() == name);
        found.ok_or_else(|| format!("unknown gradient '{name}': use central, sobel or own"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn smoothing_has_the_same_variance_along_all_axes() {
        let spacing = DVec3::new(1.5, 0.5, 1.0);
        let weights = GradientEstimator::sobel_smoothing(spacing);
        let variance = 2.0 * weights * spacing * spacing;
        assert_abs_diff_eq!((variance - variance.y).abs().max_element(), 0.0, epsilon = 1e-15);
        assert_eq!(weights.y, 0.25, "1 2 1 along the smallest spacing");
    }

    #[test]
    fn every_kernel_supports_its_own_estimator() {
        for kernel in Kernel::ALL {
            let estimator = GradientEstimator::for_kernel(kernel);
            assert!(estimator.supports(kernel) && !estimator.is_at_voxels(kernel), "{kernel:?}");
        }
        for estimator in GradientEstimator::ALL {
            assert_eq!(estimator.name().parse(), Ok(estimator));
        }
    }
}
