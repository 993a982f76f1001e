//! Kernel of the sheet methods: c·e^{−2r²} of radius 2 (paper §3.1, Fig. 1), truncated at a cylinder along the view.
//!
//! Slabs integrate it along the view; across the view it is the footprint. Both factors integrate to 1. Its lattice sum is 1 ± 1.4 % per
//! axis, ± 4.4 % in three dimensions.

use libm::erf;
use std::f64::consts::{PI, SQRT_2};

/// Radius in voxels at which the kernel is truncated.
pub const GAUSSIAN_RADIUS: f64 = 2.0;

/// Upper bound of the overshoot of lattice sums, 4.4 % in three dimensions, with a margin for rounding.
pub const GAUSSIAN_OVERSHOOT: f64 = 0.05;

/// One-dimensional factor: c₁·e^{−2x²} for |x| < 2, else 0. `x` is in voxels; the integral is 1.
pub fn gaussian(x: f64) -> f64 {
    if x.abs() < GAUSSIAN_RADIUS { (2.0 / PI).sqrt() / erf(SQRT_2 * GAUSSIAN_RADIUS) * (-2.0 * x * x).exp() } else { 0.0 }
}

/// Integral of [`gaussian`] from −∞ to `x`.
pub fn gaussian_integral(x: f64) -> f64 {
    let x = x.clamp(-GAUSSIAN_RADIUS, GAUSSIAN_RADIUS);
    0.5 + 0.5 * erf(SQRT_2 * x) / erf(SQRT_2 * GAUSSIAN_RADIUS)
}

/// Factor c₂ of the footprint c₂·e^{−2r²} for r < 2, so that its integral over the disc is 1.
pub fn gaussian_footprint_factor() -> f64 {
    2.0 / PI / -(-2.0 * GAUSSIAN_RADIUS * GAUSSIAN_RADIUS).exp_m1()
}

/// Footprint c₂·e^{−2r²}. `squared` is r² in voxels.
pub fn gaussian_footprint(squared: f64) -> f64 {
    if squared < GAUSSIAN_RADIUS * GAUSSIAN_RADIUS { gaussian_footprint_factor() * (-2.0 * squared).exp() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// ±1.4 % per axis (Poisson summation: 2·e^{−π²/2}).
    const RIPPLE: f64 = 0.0145;

    #[test]
    fn both_parts_integrate_to_one() {
        let n = 4000;
        let h = 2.0 * GAUSSIAN_RADIUS / f64::from(n);
        let along: f64 = (0..n).map(|i| gaussian(-GAUSSIAN_RADIUS + (f64::from(i) + 0.5) * h) * h).sum();
        assert_abs_diff_eq!(along, 1.0, epsilon = 1e-6);
        let ring = |r: f64| 2.0 * PI * r * gaussian_footprint(r * r);
        let across: f64 = (0..n).map(|i| ring((f64::from(i) + 0.5) * h / 2.0) * h / 2.0).sum();
        assert_abs_diff_eq!(across, 1.0, epsilon = 1e-6);
    }

    #[test]
    fn the_integral_is_the_antiderivative() {
        for i in -19..=19 {
            let (x, h) = (f64::from(i) / 10.0, 1e-5);
            let slope = (gaussian_integral(x + h) - gaussian_integral(x - h)) / (2.0 * h);
            assert_abs_diff_eq!(slope, gaussian(x), epsilon = 1e-7);
        }
        assert_eq!((gaussian_integral(-2.5), gaussian_integral(0.0), gaussian_integral(9.0)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn its_lattice_sum_ripples() {
        let sums = (0..=50).map(|i| (-3..=3).map(|j| gaussian(f64::from(i) / 50.0 - f64::from(j))).sum::<f64>());
        let (lo, hi) = sums.fold((f64::INFINITY, 0.0f64), |(lo, hi), s| (lo.min(s), hi.max(s)));
        assert!(1.0 - RIPPLE < lo && lo < 0.99 && 1.01 < hi && hi < 1.0 + RIPPLE, "{lo} {hi}");
    }
}
