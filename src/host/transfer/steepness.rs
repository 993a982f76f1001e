//! How steeply opacity changes with the value.

use super::{ControlPoint, TransferFunction};
use std::collections::VecDeque;

/// Fraction of the range of the data by which values typically change between two neighbouring samples of a ray where materials meet. Ramps
/// and peaks of opacity that are narrower depend on how samples are placed (docs/dev/fidelity.md).
const TYPICAL_CHANGE: f64 = 1.0 / 32.0;

impl TransferFunction {
    /// The largest change of opacity, 0 … 1, between two values of the data that differ by at most 1/32 of `range`, the smallest and the
    /// largest value of the field ([`Description::field_range`](crate::volume::Description::field_range)).
    ///
    /// A step has its height. A ramp over the whole range has 1/32. Where this is large, opaque surfaces have hard edges, and thin shells
    /// lie between two samples that are both transparent.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// let surface = TransferFunction::new("surface", vec![(0.0, [1.0; 3])], vec![(99.0, 0.0), (100.0, 1.0)])?;
    /// assert_eq!(surface.steepness((0.0, 255.0)), 1.0);
    /// assert_eq!(surface.steepness((0.0, 90.0)), 0.0);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn steepness(&self, (lo, hi): (f64, f64)) -> f64 {
        let typical = TYPICAL_CHANGE * (hi - lo);
        let first = self.opacities.partition_point(|p| p.0 < lo);
        let points = &self.opacities[first..first + self.opacities[first..].partition_point(|p| p.0 <= hi)];
        // The change is linear in both values until one passes a control point, so it is largest with one of them at such a point.
        let to_ends = points.iter().flat_map(|&(x, opacity)| {
            [(x - typical).max(lo), (x + typical).min(hi)].map(|end| (self.opacity(end) - opacity).abs())
        });
        // There may be no control point in range, or none so near.
        let of_ends = (self.opacity(hi) - self.opacity((hi - typical).max(lo))).abs();
        let mirrored: Vec<_> = points.iter().map(|&(x, opacity)| (x, -opacity)).collect();
        to_ends.fold(of_ends.max(largest_rise(points, typical)).max(largest_rise(&mirrored, typical)), f64::max)
    }
}

/// The largest rise from one of the ascending `points` to a later one at most `distance` behind it; 0 if none rises. Points whose opacity is
/// reached again later, by a smaller one, are dropped: the time is linear in the number of points.
fn largest_rise(points: &[ControlPoint<f64>], distance: f64) -> f64 {
    // Ascending by value and by opacity.
    let mut lowest: VecDeque<ControlPoint<f64>> = VecDeque::new();
    let mut largest = 0.0f64;
    for &(x, opacity) in points {
        while lowest.back().is_some_and(|p| p.1 >= opacity) {
            lowest.pop_back();
        }
        lowest.push_back((x, opacity));
        while lowest[0].0 < x - distance {
            lowest.pop_front();
        }
        largest = largest.max(opacity - lowest[0].1);
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn steepness(opacities: Vec<(f64, f64)>) -> f64 {
        TransferFunction::new("t", vec![(0.0, [1.0; 3])], opacities).unwrap().steepness((0.0, 64.0))
    }

    #[test]
    fn ramps_steps_and_peaks_have_their_closed_forms() {
        for (opacities, expected) in [
            (vec![(0.0, 0.3)], 0.0),
            (vec![(0.0, 0.0), (64.0, 1.0)], 1.0 / 32.0),
            (vec![(-64.0, 0.0), (128.0, 0.9)], 0.3 / 32.0),
            (vec![(10.0, 0.0), (14.0, 1.0)], 0.5),
            (vec![(10.0, 0.0), (10.0, 0.7)], 0.7),
            (vec![(10.0, 0.2), (10.5, 0.8), (11.0, 0.2)], 0.6),
            // From half-way up the first ramp to half-way up the second.
            (vec![(10.0, 0.0), (11.0, 0.4), (11.8, 0.4), (15.8, 1.0)], 0.43),
        ] {
            assert_abs_diff_eq!(steepness(opacities.clone()), expected, epsilon = 1e-12);
            let mirrored = opacities.into_iter().rev().map(|(x, opacity)| (64.0 - x, opacity)).collect();
            assert_abs_diff_eq!(steepness(mirrored), expected, epsilon = 1e-12);
        }
    }

    #[test]
    fn what_no_value_reaches_does_not_count() {
        for step in [-1.0, 65.0] {
            assert_eq!(steepness(vec![(step, 0.0), (step, 1.0)]), 0.0);
        }
        let flat = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(5.0, 0.0), (5.0, 1.0)]).unwrap();
        assert_eq!((flat.steepness((3.0, 3.0)), flat.steepness((5.0, 5.0))), (0.0, 1.0));
    }
}
