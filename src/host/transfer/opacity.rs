//! Opacity functions from points, a window or triangular peaks.

use super::{ControlPoint, TransferFunction, approached, interpolate};
use crate::error::Error;

impl TransferFunction {
    /// Replaces the opacities. Values must be finite and ascending, opacities in 0 … 1 per unit distance.
    ///
    /// # Errors
    /// [`Error::Transfer`] if `opacities` is empty or violates these conditions.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// let grey = TransferFunction::new("grey", vec![(0.0, [0.0; 3]), (255.0, [1.0; 3])], vec![(0.0, 0.1)])?;
    /// let shell = grey.with_opacities(vec![(80.0, 0.0), (100.0, 0.6), (120.0, 0.0)])?;
    /// assert_eq!((shell.opacity(90.0), shell.opacity(200.0)), (0.3, 0.0));
    /// assert_eq!(shell.colors(), grey.colors());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn with_opacities(&self, opacities: Vec<ControlPoint<f64>>) -> Result<Self, Error> {
        Self::new(self.name.clone(), self.colors.clone(), opacities)
    }

    /// Applies a window level and width (CT). Colours span the window. Opacity rises linearly from 0 at `level - width / 2` to 1 at
    /// `level + width / 2`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `width` is not above 0 or either number is not finite.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// let grey = TransferFunction::new("grey", vec![(0.0, [0.0; 3]), (1.0, [1.0; 3])], vec![(0.0, 0.1)])?;
    /// let bone = grey.windowed(400.0, 1000.0)?;
    /// assert_eq!((bone.opacity(-100.0), bone.opacity(400.0), bone.opacity(900.0)), (0.0, 0.5, 1.0));
    /// assert_eq!(bone.color(400.0), [0.5; 3]);
    /// assert!(grey.windowed(400.0, 0.0).is_err());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn windowed(&self, level: f64, width: f64) -> Result<Self, Error> {
        let (lo, hi) = (level - width / 2.0, level + width / 2.0);
        if !(lo.is_finite() && hi.is_finite() && lo < hi) {
            let value = format!("{level},{width}");
            return Err(Error::OutOfRange { name: "window", value, expected: "LEVEL,WIDTH with WIDTH above 0" });
        }
        let (first, last) = (self.colors[0], self.colors[self.colors.len() - 1]);
        let colors = if first.0 < last.0 {
            // Without the opacities: their values may lie outside the range of the colours.
            self.with_opacities(vec![(first.0, 0.0), (last.0, 1.0)])?.stretched(lo, hi)?.colors
        } else {
            vec![(lo, first.1), (hi, last.1)]
        };
        Self::new(self.name.clone(), colors, vec![(lo, 0.0), (hi, 1.0)])
    }

    /// Adds a triangular opacity peak: `opacity` at `value`, falling linearly to 0 at `value ± width / 2`. The larger of the peak and
    /// the previous opacity is used.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `width` is not above 0, `opacity` lies outside 0 … 1, or a number is not finite.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// let clear = TransferFunction::new("red", vec![(0.0, [1.0, 0.0, 0.0])], vec![(0.0, 0.0)])?;
    /// let shells = clear.with_tent(80.0, 10.0, 0.4)?.with_tent(150.0, 20.0, 0.9)?;
    /// assert_eq!([77.5, 80.0, 100.0, 150.0].map(|v| shells.opacity(v)), [0.2, 0.4, 0.0, 0.9]);
    /// assert!(clear.with_tent(80.0, -1.0, 0.4).is_err());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn with_tent(&self, value: f64, width: f64, opacity: f64) -> Result<Self, Error> {
        let (lo, hi) = (value - width / 2.0, value + width / 2.0);
        if !(lo.is_finite() && hi.is_finite() && lo < value && value < hi && (0.0..=1.0).contains(&opacity)) {
            let given = format!("{value},{width},{opacity}");
            let expected = "V,WIDTH,OPACITY with WIDTH above 0 and OPACITY from 0 to 1";
            return Err(Error::OutOfRange { name: "tent", value: given, expected });
        }
        let tent = [(lo, 0.0), (value, opacity), (hi, 0.0)];
        self.with_opacities(larger(&self.opacities, &tent))
    }
}

/// Maximum of two piecewise-linear functions: piecewise linear, with points at those of both functions and at their crossings.
fn larger(a: &[ControlPoint<f64>], b: &[ControlPoint<f64>]) -> Vec<ControlPoint<f64>> {
    let mut values: Vec<f64> = a.iter().chain(b).map(|p| p.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut points: Vec<ControlPoint<f64>> = Vec::new();
    let mut before: Option<(f64, f64, f64)> = None;
    for value in values {
        let (a_below, b_below) = (below(a, value), below(b, value));
        points.extend(before.and_then(|from| crossing(from, (value, a_below, b_below))));
        points.push((value, a_below.max(b_below)));
        let (a_here, b_here) = (at(a, value), at(b, value));
        if a_here.max(b_here) != a_below.max(b_below) {
            points.push((value, a_here.max(b_here)));
        }
        before = Some((value, a_here, b_here));
    }
    points
}

/// Crossing of two lines between two values, each given as (value, a, b); `None` if they cross at an end or not at all.
fn crossing(from: (f64, f64, f64), to: (f64, f64, f64)) -> Option<ControlPoint<f64>> {
    let (first, last) = (from.1 - from.2, to.1 - to.2);
    let share = (first * last < 0.0).then(|| first / (first - last))?;
    let value = from.0 + (to.0 - from.0) * share;
    (from.0 < value && value < to.0).then(|| (value, (from.1 + (to.1 - from.1) * share).clamp(0.0, 1.0)))
}

fn at(points: &[ControlPoint<f64>], value: f64) -> f64 {
    interpolate(points, value, |a, b, t| a + (b - a) * t)
}

fn below(points: &[ControlPoint<f64>], value: f64) -> f64 {
    approached(points, value, |a, b, t| a + (b - a) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(opacities: Vec<(f64, f64)>) -> TransferFunction {
        TransferFunction::new("t", vec![(10.0, [0.0, 0.5, 1.0]), (20.0, [1.0, 0.5, 0.0])], opacities).unwrap()
    }

    /// Rounding error of a few sums and products of numbers up to 1.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn a_tent_over_anything_is_the_larger_of_both_everywhere() {
        for opacities in [
            vec![(0.0, 0.0)],
            vec![(0.0, 1.0)],
            vec![(0.0, 0.2), (100.0, 0.8)],
            vec![(20.0, 0.0), (20.0, 0.7), (45.0, 0.7), (45.0, 0.1), (60.0, 0.1)],
            vec![(50.0, 0.9), (50.0, 0.0)],
            vec![(50.0, 0.0), (50.0, 0.3), (50.0, 0.9)],
        ] {
            let own = function(opacities.clone());
            let with = own.with_tent(50.0, 30.0, 0.6).unwrap();
            for i in 0..=4000 {
                let value = -20.0 + f64::from(i) * 0.035;
                let tent = 0.6 * (1.0 - (value - 50.0).abs() / 15.0).max(0.0);
                let expected = own.opacity(value).max(tent);
                assert!((with.opacity(value) - expected).abs() < ROUNDING, "{opacities:?} at {value}");
            }
        }
    }

    #[test]
    fn a_window_has_all_colours_and_even_opacity() {
        let windowed = function(vec![(-1000.0, 0.3)]).windowed(40.0, 400.0).unwrap();
        assert_eq!(windowed.range(), (-160.0, 240.0));
        assert_eq!((windowed.color(-500.0), windowed.color(240.0)), ([0.0, 0.5, 1.0], [1.0, 0.5, 0.0]));
        assert_eq!([-161.0, -60.0, 40.0, 140.0, 999.0].map(|v| windowed.opacity(v)), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let one = TransferFunction::new("t", vec![(3.0, [0.25; 3])], vec![(0.0, 1.0)]).unwrap();
        assert_eq!(one.windowed(0.0, 2.0).unwrap().color(0.0), [0.25; 3]);
    }

    #[test]
    fn bad_windows_tents_and_points_are_refused() {
        let own = function(vec![(0.0, 0.5)]);
        for (level, width) in [(0.0, 0.0), (0.0, -5.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (1e300, 1.0)] {
            let message = own.windowed(level, width).unwrap_err().to_string();
            assert!(message.contains("window") && message.contains("above 0"), "{message}");
        }
        for (value, width, opacity) in
            [(0.0, 0.0, 0.5), (0.0, 1.0, 1.5), (0.0, 1.0, f64::NAN), (1e300, 1.0, 0.5), (f64::NAN, 1.0, 0.5)]
        {
            assert!(own.with_tent(value, width, opacity).unwrap_err().to_string().contains("tent"));
        }
        assert!(own.with_opacities(vec![]).is_err() && own.with_opacities(vec![(1.0, 0.0), (0.0, 1.0)]).is_err());
    }
}
