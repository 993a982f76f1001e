//! Exact coefficients of the interpolating cubic B-spline, without the truncation of the device's filter.

/// Converts voxels, x fastest, to the coefficients of the interpolating spline, along x, y and z.
pub(super) fn interpolate(dims: [usize; 3], voxels: &mut [f64]) {
    let mut stride = 1;
    for n in dims {
        let mut line = vec![0.0; n];
        for start in (0..voxels.len()).filter(|i| i / stride % n == 0) {
            (0..n).for_each(|i| line[i] = voxels[start + i * stride]);
            interpolate_line(&mut line);
            (0..n).for_each(|i| voxels[start + i * stride] = line[i]);
        }
        stride *= n;
    }
}

/// Converts one line: solves c₍ᵢ₋₁₎ + 4cᵢ + c₍ᵢ₊₁₎ = 6fᵢ, mirrored at both ends, by forward elimination and back substitution. A line of
/// one voxel is its own coefficient.
fn interpolate_line(line: &mut [f64]) {
    let n = line.len();
    if n == 1 {
        return;
    }
    // Superdiagonal of each row after elimination, with a unit diagonal. Mirroring doubles c₁ in the first row.
    let mut next = vec![0.5; n];
    line[0] *= 1.5;
    for i in 1..n {
        let last = if i + 1 == n { 2.0 } else { 1.0 };
        next[i] = 1.0 / (4.0 - last * next[i - 1]);
        line[i] = (6.0 * line[i] - last * line[i - 1]) * next[i];
    }
    for i in (0..n - 1).rev() {
        line[i] -= next[i] * line[i + 1];
    }
}

/// Index of a voxel on a line of n, mirrored at the ends as often as needed.
pub(super) fn mirrored(i: i64, n: i64) -> i64 {
    let period = (2 * n - 2).max(1);
    let i = i.rem_euclid(period);
    i.min(period - i).min(n - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::{Kernel, PREFILTER_RADIUS, prefilter};
    use approx::assert_abs_diff_eq;

    /// For deviations up to 1 from the mean: truncation omits 2.4e-6 ([`PREFILTER_RADIUS`]); normalisation scales each tap by 1.4e-6, which
    /// adds three times that, the sum of the absolute taps.
    const CUT_OFF: f64 = 6.6e-6;
    const LENGTHS: [usize; 8] = [1, 2, 3, 4, 7, 12, 25, 60];

    /// Pseudo-random numbers from −1 to 1.
    fn line(n: usize) -> Vec<f64> {
        (0..n).map(|i| (i as f64 * 2.7 + 0.3 * (i * i % 7) as f64).sin()).collect()
    }

    fn coefficients(line: &[f64]) -> Vec<f64> {
        let mut coefficients = line.to_vec();
        interpolate_line(&mut coefficients);
        coefficients
    }

    fn at(line: &[f64], i: i64) -> f64 {
        line[mirrored(i, line.len() as i64) as usize]
    }

    #[test]
    fn mirror_images() {
        assert_eq!([-3, -2, -1, 0, 1, 2, 3, 4, 5].map(|i| mirrored(i, 3)), [1, 2, 1, 0, 1, 2, 1, 0, 1]);
        assert_eq!([-2, -1, 0, 1, 2, 3].map(|i| mirrored(i, 2)), [0, 1, 0, 1, 0, 1]);
        assert_eq!([-2, -1, 0, 1, 2].map(|i| mirrored(i, 1)), [0; 5]);
    }

    #[test]
    fn the_spline_meets_every_voxel() {
        for n in LENGTHS {
            let (line, coefficients) = (line(n), coefficients(&line(n)));
            let off = |c: &[f64]| {
                let spline = |i: i64| -> f64 { (-1..=1).map(|d| at(c, i + d) * Kernel::BSpline.weight(d as f64)).sum() };
                (0..n).map(|i| (spline(i as i64) - line[i]).abs()).fold(0.0, f64::max)
            };
            assert!(off(&coefficients) < 1e-13, "{n} voxels: {}", off(&coefficients));
            assert!(n == 1 || off(&line) > 0.02, "{n} voxels must differ from their coefficients: {}", off(&line));
        }
    }

    #[test]
    fn the_filter_that_ends_has_nearly_the_same() {
        let taps = prefilter();
        let filtered = |line: &[f64], i: i64, radius: i64| -> f64 {
            (-radius..=radius).map(|k| taps[k.unsigned_abs() as usize] * at(line, i + k)).sum()
        };
        for n in LENGTHS {
            let (line, coefficients) = (line(n), coefficients(&line(n)));
            let off = |radius: i64| {
                let differences = (0..n).map(|i| (coefficients[i] - filtered(&line, i as i64, radius)).abs());
                differences.fold(0.0, f64::max)
            };
            assert!(off(PREFILTER_RADIUS as i64) < CUT_OFF, "{n} voxels: {}", off(PREFILTER_RADIUS as i64));
            // A filter that is a few taps shorter is detected.
            assert!(n == 1 || off(PREFILTER_RADIUS as i64 - 3) > CUT_OFF, "{n} voxels: {}", off(PREFILTER_RADIUS as i64 - 3));
        }
    }

    /// Along all axes: the coefficients of a product of lines are the products of their coefficients.
    #[test]
    fn axes_are_filtered_one_by_one() {
        let dims = [5, 1, 4];
        let lines = dims.map(line);
        let filtered = lines.each_ref().map(|line| coefficients(line));
        let product = |lines: &[Vec<f64>; 3]| -> Vec<f64> {
            let [x, y, z] = dims;
            (0..x * y * z).map(|n| lines[0][n % x] * lines[1][n / x % y] * lines[2][n / (x * y)]).collect()
        };
        let mut found = product(&lines);
        interpolate(dims, &mut found);
        for (found, expected) in found.iter().zip(product(&filtered)) {
            assert_abs_diff_eq!(*found, expected, epsilon = 1e-13);
        }
    }
}
