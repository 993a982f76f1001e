//! Estimation of gradients.

use super::kernel::Kernel;
use glam::DVec3;
use serde::{Serialize, Serializer};
use std::fmt;
use std::ops::RangeInclusive;
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
/// assert_eq!("gaussian:0.7".parse(), Ok(GradientEstimator::Gaussian(0.7)));
/// assert!(GradientEstimator::Own.supports(Kernel::BSpline) && !GradientEstimator::Own.supports(Kernel::Linear));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GradientEstimator {
    /// Central differences of the voxels, interpolated by the linear kernel or the paper's cubic; for other kernels of layers linearly.
    Central,
    /// Central differences, smoothed across their direction ([`smoothing_across`](Self::smoothing_across)) and interpolated linearly: the operator of
    /// Sobel and Feldman (1968) in three dimensions, with the weights 1 2 1.
    Sobel,
    /// Derivatives of a Gaussian, interpolated linearly. Its standard deviation is in voxels of the smallest spacing,
    /// [`SIGMAS`](Self::SIGMAS). They are central differences, which have a standard deviation of 1/√3 voxels along their direction by
    /// themselves, of voxels that are smoothed by the rest. Smoothing ends at three standard deviations; there is none along axes where the
    /// standard deviation is below 0.3 voxels.
    Gaussian(f64),
    /// The derivative of the kernel.
    Own,
}

impl GradientEstimator {
    /// All estimators; the Gaussian with a standard deviation of one voxel.
    pub const ALL: [Self; 4] = [Self::Central, Self::Sobel, Self::Gaussian(1.0), Self::Own];
    /// Standard deviations of the Gaussian, in voxels of the smallest spacing.
    pub const SIGMAS: RangeInclusive<f64> = 0.3..=2.0;

    /// The estimator that fits a kernel most closely: its derivative where that is continuous, else central differences.
    pub fn for_kernel(kernel: Kernel) -> Self {
        if kernel.has_own_slope() { Self::Own } else { Self::Central }
    }

    /// Whether the estimator can be used with a kernel. The Gaussian kernel has central differences only; the derivatives of the linear
    /// kernel, of the paper's cubic and of the Gaussian are not continuous, or vanish at every voxel.
    pub fn supports(self, kernel: Kernel) -> bool {
        match self {
            Self::Central => true,
            Self::Sobel | Self::Gaussian(_) => kernel != Kernel::Gaussian,
            Self::Own => kernel.has_own_slope(),
        }
    }

    /// Whether gradients are estimated at the voxels and interpolated linearly, whatever the kernel.
    pub fn is_at_voxels(self, kernel: Kernel) -> bool {
        match self {
            Self::Central => kernel.has_own_slope(),
            Self::Sobel | Self::Gaussian(_) => true,
            Self::Own => false,
        }
    }

    /// Number of voxels on either side that smoothing of the voxels reaches, along the axis of the smallest spacing.
    pub fn smoothing_radius(self) -> usize {
        match self {
            Self::Gaussian(sigma) => smoothing_radius(sigma),
            _ => 0,
        }
    }

    /// Checks the standard deviation of the Gaussian. The error says what is expected.
    #[doc(hidden)]
    pub fn check(self) -> Result<(), String> {
        match self {
            Self::Gaussian(sigma) if !Self::SIGMAS.contains(&sigma) => Err(format!(
                "gaussian:{sigma} is out of range: use a standard deviation from {:?} to {:?} voxels",
                Self::SIGMAS.start(),
                Self::SIGMAS.end()
            )),
            _ => Ok(()),
        }
    }

    /// Smoothing across the direction of a difference, along each axis: the weight of each of the two neighbours of a voxel, which itself has
    /// the rest. `spacing`: of x, y and z.
    ///
    /// For Sobel the weights are ¼ (1 2 1) along the axis of the smallest spacing h₀. Along an axis of spacing h the neighbours have
    /// ¼ (h₀/h)², which has the same variance in world units. For the Gaussian they have half of the variance that smoothed voxels do not
    /// have: at most that of central differences.
    pub fn smoothing_across(self, spacing: DVec3) -> DVec3 {
        let relative = spacing.min_element() / spacing;
        match self {
            Self::Sobel => 0.25 * relative * relative,
            Self::Gaussian(sigma) => (sigma * relative)
                .to_array()
                .map(|sigma| {
                    let variance = (sigma * sigma).min(OF_DIFFERENCES);
                    if sigma < LEAST_SIGMA { 0.0 } else { 0.5 * variance }
                })
                .into(),
            _ => DVec3::ZERO,
        }
    }

    /// Name on the command line, where SIGMA is the standard deviation of the Gaussian.
    pub fn name(self) -> &'static str {
        match self {
            Self::Central => "central",
            Self::Sobel => "sobel",
            Self::Gaussian(_) => "gaussian:SIGMA",
            Self::Own => "own",
        }
    }
}

/// Variance of a central difference along its direction, in squared voxels: its spectrum is that of the derivative times sin(ω)/ω =
/// 1 - ω²/6 + ….
const OF_DIFFERENCES: f64 = 1.0 / 3.0;
/// Standard deviation in voxels below which an axis is not smoothed.
const LEAST_SIGMA: f64 = 0.3;

/// Number of voxels on either side that smoothing reaches.
fn smoothing_radius(sigma: f64) -> usize {
    if sigma * sigma <= OF_DIFFERENCES { 0 } else { (3.0 * sigma) as usize }
}

/// Taps, from the centre outwards, that smooth voxels so that their central differences have this standard deviation in voxels along their
/// direction. They are the discrete Gaussian of Lindeberg (1990), e^{-t} I_n(t), of variance t, and end at three standard deviations; the
/// sum over both sides is one.
#[doc(hidden)]
pub fn smoothing(sigma: f64) -> Vec<f64> {
    let t = (sigma * sigma - OF_DIFFERENCES).max(0.0);
    let taps: Vec<f64> = (0..=smoothing_radius(sigma)).map(|n| bessel(n as i32, t)).collect();
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.into_iter().map(|tap| tap / sum).collect()
}

/// The modified Bessel function I_n(t) for 0 ≤ t ≤ 4, by its power series.
fn bessel(n: i32, t: f64) -> f64 {
    let first = (1..=n).fold(1.0, |product, i| product * 0.5 * t / f64::from(i));
    /// The rest is below the precision of f64.
    const TERMS: i32 = 30;
    let (sum, _) = (1..TERMS).fold((first, first), |(sum, term), k| {
        let next = term * 0.25 * t * t / f64::from(k * (k + n));
        (sum + next, next)
    });
    sum
}

/// As on the command line.
impl fmt::Display for GradientEstimator {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Gaussian(sigma) => write!(f, "gaussian:{sigma}"),
            _ => f.write_str(self.name()),
        }
    }
}

impl Serialize for GradientEstimator {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl FromStr for GradientEstimator {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = match name.strip_prefix("gaussian:") {
            Some(sigma) => sigma.parse().ok().map(Self::Gaussian),
            None => Self::ALL.into_iter().find(|estimator| estimator.name() == name),
        };
        let found = found.ok_or_else(|| format!("unknown gradient '{name}': use central, sobel, gaussian:SIGMA or own"))?;
        found.check().map(|()| found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn sobel_has_the_same_variance_along_all_axes() {
        let spacing = DVec3::new(1.5, 0.5, 1.0);
        let weights = GradientEstimator::Sobel.smoothing_across(spacing);
        let variance = 2.0 * weights * spacing * spacing;
        assert_abs_diff_eq!((variance - variance.y).abs().max_element(), 0.0, epsilon = 1e-15);
        assert_eq!(weights.y, 0.25, "1 2 1 along the smallest spacing");
    }

    /// Across and along, the smoothing of voxels and that of the difference have the variance together.
    #[test]
    fn the_gaussian_has_its_variance() {
        /// Part of the variance beyond three standard deviations.
        const CUT_OFF: f64 = 0.05;
        for sigma in [0.3, 0.5, 0.58, 0.7, 1.0, 1.5, 2.0] {
            let taps = smoothing(sigma);
            let smoothed: f64 = (1..).zip(&taps[1..]).map(|(n, tap)| 2.0 * f64::from(n * n) * tap).sum();
            let across = 2.0 * GradientEstimator::Gaussian(sigma).smoothing_across(DVec3::ONE).x;
            let relative = (smoothed + across) / (sigma * sigma);
            assert!((1.0 - CUT_OFF..=1.0 + 1e-12).contains(&relative), "{sigma}: {relative}");
        }
        let thick = GradientEstimator::Gaussian(1.0).smoothing_across(DVec3::new(1.0, 2.5, 4.0));
        assert!(thick.x == 1.0 / 6.0 && (thick.y - 0.08).abs() < 1e-12 && thick.z == 0.0, "{thick}");
    }

    #[test]
    fn every_kernel_supports_its_own_estimator() {
        for kernel in Kernel::ALL {
            let estimator = GradientEstimator::for_kernel(kernel);
            assert!(estimator.supports(kernel) && !estimator.is_at_voxels(kernel), "{kernel:?}");
        }
        for estimator in GradientEstimator::ALL {
            assert_eq!(estimator.to_string().parse(), Ok(estimator));
        }
        for refused in ["gaussian", "gaussian:", "gaussian:x", "gaussian:0.29", "gaussian:2.1", "gaussian:nan", "gaussian:inf"] {
            assert!(refused.parse::<GradientEstimator>().is_err(), "{refused}");
        }
    }

    #[test]
    fn smoothing_keeps_what_is_flat_and_ends_at_three_deviations() {
        for sigma in [0.3, 0.57, 0.58, 0.7, 1.0, 2.0] {
            let taps = smoothing(sigma);
            assert_abs_diff_eq!(taps[0] + 2.0 * taps[1..].iter().sum::<f64>(), 1.0, epsilon = 1e-15);
            assert_eq!(taps.len(), 1 + if sigma < 0.5774 { 0 } else { (3.0 * sigma) as usize });
        }
        assert!(smoothing(2.0).len() - 1 <= super::super::PREFILTER_RADIUS, "kernels have taps for the prefilter's radius");
        // Tables of I_0(1) and I_3(2).
        assert_abs_diff_eq!(bessel(0, 1.0), 1.266_065_877_752_008, epsilon = 1e-14);
        assert_abs_diff_eq!(bessel(3, 2.0), 0.212_739_959_239_853, epsilon = 1e-14);
    }
}
