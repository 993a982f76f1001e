//! Coefficients of the interpolating cubic B-spline.
//!
//! The prefilter convolves the voxels along each axis, mirrored at the borders, with √3 z^|k|, z = √3 − 2 (Unser, Aldroubi & Eden 1993).
//! It is truncated, so that a coefficient depends on nearby voxels only and parts of a volume get the coefficients of the whole.

/// Filter taps on either side. The error of a coefficient is at most 6.6e-6 of the largest deviation of a voxel from the mean, per axis:
/// truncation omits 2√3 |z|^11 / (1 − |z|) = 2.4e-6, and normalisation scales the rest, whose magnitudes sum to 3, by 1.4e-6.
pub const PREFILTER_RADIUS: usize = 10;

/// Taps of the symmetric filter, from the centre outwards. The sum over both sides is one.
pub fn prefilter() -> [f64; PREFILTER_RADIUS + 1] {
    let pole = 3f64.sqrt() - 2.0;
    let cut: [f64; PREFILTER_RADIUS + 1] = std::array::from_fn(|k| pole.powi(k as i32));
    let sum = cut[0] + 2.0 * cut[1..].iter().sum::<f64>();
    cut.map(|tap| tap / sum)
}

#[cfg(test)]
mod tests {
    use super::super::Kernel;
    use super::*;
    use approx::assert_abs_diff_eq;

    /// As documented.
    const CUT_OFF: f64 = 6.6e-6;

    /// Spline of a unit impulse: its coefficients are the filter; it is 1 at the impulse and 0 at all other voxels.
    #[test]
    fn the_spline_through_a_single_voxel() {
        let taps = prefilter();
        let coefficient = |i: i32| taps.get(i.unsigned_abs() as usize).copied().unwrap_or(0.0);
        for at in -12..=12 {
            let value: f64 = (at - 1..=at + 1).map(|i| coefficient(i) * Kernel::BSpline.weight(f64::from(at - i))).sum();
            assert_abs_diff_eq!(value, if at == 0 { 1.0 } else { 0.0 }, epsilon = CUT_OFF);
        }
    }

    #[test]
    fn what_is_flat_stays_flat() {
        let taps = prefilter();
        assert_abs_diff_eq!(taps[0] + 2.0 * taps[1..].iter().sum::<f64>(), 1.0, epsilon = 1e-15);
        assert_abs_diff_eq!(taps[0], 3f64.sqrt(), epsilon = CUT_OFF);
    }
}
