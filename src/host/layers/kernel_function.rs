//! The cubic interpolation kernel of the paper (Eq. 2) and its integral.

/// f(x) = 1 − 3|x|² + 2|x|³ for |x| < 1, else 0 (paper, Eq. 2). `x` is in voxels.
///
/// f(x) + f(1−x) = 1 on \[0, 1\], so the lattice sum Σ f(x−i) is one everywhere, and ∫f = 1.
pub fn kernel_function(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 { 1.0 - x * x * (3.0 - 2.0 * x) } else { 0.0 }
}

/// ∫ f from −∞ to `x`: 0 below −1, ½ at 0, 1 above 1.
pub fn kernel_integral(x: f64) -> f64 {
    let c = x.abs().min(1.0);
    let half = c - c.powi(3) + 0.5 * c.powi(4);
    0.5 + half.copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn lattice_sum_is_one_everywhere() {
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let sum: f64 = (-2..=2).map(|j| kernel_function(x - f64::from(j))).sum();
            assert_abs_diff_eq!(sum, 1.0, epsilon = 1e-15);
        }
    }

    #[test]
    fn integral_is_the_antiderivative() {
        let step = 1e-5;
        for i in -12..=12 {
            let x = f64::from(i) / 10.0 + 0.013;
            let slope = (kernel_integral(x + step) - kernel_integral(x - step)) / (2.0 * step);
            assert_abs_diff_eq!(slope, kernel_function(x), epsilon = 1e-8);
        }
        assert_abs_diff_eq!(kernel_integral(-3.0), 0.0);
        assert_abs_diff_eq!(kernel_integral(3.0), 1.0);
    }
}
