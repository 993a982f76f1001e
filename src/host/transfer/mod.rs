//! Transfer functions: piecewise-linear colour and opacity of a data value.

mod automatic;
mod builtin;
mod channels;
mod dimming;
mod format;
mod grey_ramp;
mod hounsfield;
mod integrals;
mod maps;
mod opacity;
mod palettes;
mod phantom;
mod presets;
mod sources;
mod steepness;
mod table;
mod test_signal;
mod value;
mod visible_range;

pub use format::FileFormat;
pub use integrals::{EXTINCTION_CELLS, ExtinctionCells, IntegralTable};
pub use table::{Extinction, TransferTable};
pub use value::Value;

use crate::error::Error;
use crate::volume::{Rescale, Volume};

/// A control point: a data value and its colour or opacity.
pub type ControlPoint<T> = (f64, T);

/// Colour and opacity of a data value. Both are piecewise linear between control points and constant beyond them. Two points at the
/// same value make a step; the value itself takes the later one.
///
/// ```
/// use layersplat::TransferFunction;
///
/// let colors = vec![(0.0, [0.0, 0.0, 1.0]), (100.0, [1.0, 0.0, 0.0])];
/// let transfer = TransferFunction::new("cold to warm", colors, vec![(20.0, 0.0), (100.0, 0.5)])?;
/// assert_eq!(transfer.color(50.0), [0.5, 0.0, 0.5]);
/// assert_eq!(transfer.opacity(60.0), 0.25);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    name: String,
    colors: Vec<ControlPoint<[f64; 3]>>,
    opacities: Vec<ControlPoint<f64>>,
}

impl TransferFunction {
    /// Creates a transfer function from control points. `colors` are RGB in 0 … 1. `opacities` are 0 … 1 per unit distance: an opacity
    /// α corresponds to the extinction τ = −ln(1−α).
    ///
    /// # Errors
    /// [`Error::Transfer`] if either list is empty, values are not finite or not ascending, or entries lie outside 0 … 1.
    pub fn new(
        name: impl Into<String>,
        colors: Vec<ControlPoint<[f64; 3]>>,
        opacities: Vec<ControlPoint<f64>>,
    ) -> Result<Self, Error> {
        let name = name.into();
        let check = |what: &str, points: Vec<(f64, &[f64])>| {
            let bad = |(x, y): &&(f64, &[f64])| !x.is_finite() || !y.iter().all(|v| (0.0..=1.0).contains(v));
            let problem = if points.is_empty() {
                "has no points: give at least one".into()
            } else if let Some((x, y)) = points.iter().find(bad) {
                format!("maps {x} to {y:?}: values must be finite and entries from 0 to 1")
            } else if let Some(pair) = points.windows(2).find(|p| p[1].0 < p[0].0) {
                format!("has {} after {}: points must be sorted by value", pair[1].0, pair[0].0)
            } else {
                return Ok(());
            };
            Err(Error::Transfer { name: name.clone(), problem: format!("{what} {problem}") })
        };
        check("the colour function", colors.iter().map(|(x, c)| (*x, c.as_slice())).collect())?;
        check("the opacity function", opacities.iter().map(|(x, a)| (*x, std::slice::from_ref(a))).collect())?;
        Ok(Self { name, colors, opacities })
    }

    /// Maps the range of control points linearly onto `lo … hi`.
    ///
    /// # Errors
    /// If `lo` is not below `hi`, or all control points have the same value.
    pub fn stretched(&self, lo: f64, hi: f64) -> Result<Self, Error> {
        if !(lo.is_finite() && hi.is_finite() && lo < hi) {
            let value = format!("{lo},{hi}");
            return Err(Error::OutOfRange { name: "transfer range", value, expected: "LO,HI with LO below HI" });
        }
        let (from, to) = self.range();
        if from >= to {
            let problem = "has a single value and cannot be stretched onto a range".into();
            return Err(Error::Transfer { name: self.name.clone(), problem });
        }
        // The weighted sum reproduces both ends exactly.
        let map = |x: f64| {
            let t = (x - from) / (to - from);
            lo * (1.0 - t) + hi * t
        };
        Ok(Self {
            name: self.name.clone(),
            colors: self.colors.iter().map(|&(x, c)| (map(x), c)).collect(),
            opacities: self.opacities.iter().map(|&(x, a)| (map(x), a)).collect(),
        })
    }

    /// The transfer function of stored voxel values, before `rescale`.
    #[doc(hidden)]
    pub fn for_stored_numbers(&self, rescale: Rescale) -> Self {
        fn mapped<T: Copy>(points: &[ControlPoint<T>], rescale: Rescale) -> Vec<ControlPoint<T>> {
            let mut points: Vec<ControlPoint<T>> = points.iter().map(|&(x, y)| (rescale.stored(x), y)).collect();
            if rescale.slope() < 0.0 {
                points.reverse();
                // At a step the upper value's side counts. Reversal puts it first, so move the other side up.
                for i in 1..points.len() {
                    if points[i].0 == points[i - 1].0 {
                        points[i].0 = points[i].0.next_up();
                    }
                }
            }
            points
        }
        if rescale == Rescale::default() {
            return self.clone();
        }
        Self { name: self.name.clone(), colors: mapped(&self.colors, rescale), opacities: mapped(&self.opacities, rescale) }
    }

    /// Multiplies all opacities by `factor`, 0 … 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `factor` lies outside 0 … 1.
    pub fn faded(&self, factor: f64) -> Result<Self, Error> {
        if !(0.0..=1.0).contains(&factor) {
            return Err(Error::OutOfRange { name: "opacity factor", value: factor.to_string(), expected: "0 to 1" });
        }
        let opacities = self.opacities.iter().map(|&(x, a)| (x, a * factor)).collect();
        Ok(Self { opacities, ..self.clone() })
    }

    /// Control points of the colours, ascending by value.
    pub fn colors(&self) -> &[ControlPoint<[f64; 3]>] {
        &self.colors
    }

    /// Control points of the opacities per unit distance, ascending by value.
    pub fn opacities(&self) -> &[ControlPoint<f64>] {
        &self.opacities
    }

    /// Name of the transfer function, or path of its file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Smallest and largest value of all control points.
    pub fn range(&self) -> (f64, f64) {
        let (colors, opacities) = (&self.colors, &self.opacities);
        let last = colors[colors.len() - 1].0.max(opacities[opacities.len() - 1].0);
        (colors[0].0.min(opacities[0].0), last)
    }

    /// Opacity per unit distance at a value, 0 … 1.
    pub fn opacity(&self, value: f64) -> f64 {
        interpolate(&self.opacities, value, |a, b, t| a + (b - a) * t)
    }

    /// The largest opacity of any value from `lo` to `hi`.
    pub fn largest_opacity(&self, lo: f64, hi: f64) -> f64 {
        let between = self.opacities.iter().filter(|p| (lo..=hi).contains(&p.0)).map(|p| p.1);
        between.fold(self.opacity(lo).max(self.opacity(hi)), f64::max)
    }

    /// Colour (RGB, 0 … 1) at a value.
    pub fn color(&self, value: f64) -> [f64; 3] {
        interpolate(&self.colors, value, |a, b, t| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t))
    }

    /// Colour at the value of the largest opacity; of several such values, in their middle.
    pub fn most_opaque_color(&self) -> [f64; 3] {
        let largest = self.opacities.iter().map(|p| p.1).fold(0.0, f64::max);
        let mut values = self.opacities.iter().filter(|p| p.1 >= largest).map(|p| p.0);
        let first = values.next().expect("there is a control point");
        self.color((first + values.next_back().unwrap_or(first)) / 2.0)
    }

    /// Extinction τ = −ln(1−α) per unit distance: 0 … ∞.
    pub fn extinction(&self, value: f64) -> f64 {
        -(-self.opacity(value)).ln_1p()
    }

    /// Value of missing voxels for Gaussian kernels: the smallest valid value if it is transparent, else the background.
    ///
    /// Weights of a Gaussian sum to about 1 only. The error is up to 4 % of the difference between a value and this one, so a
    /// transparent value hides it.
    pub fn gaussian_background(&self, smallest: f64, background: f64) -> f64 {
        if self.opacity(smallest) > 0.0 { background } else { smallest }
    }

    /// Number of *effective splats* (the paper's term): voxels whose value has an opacity above 0.
    pub fn effective_splats(&self, volume: &Volume) -> u64 {
        let background = volume.background();
        let visible = |sum: &mut u64, value: Option<f64>, count| {
            *sum += if self.opacity(value.unwrap_or(background)) > 0.0 { count } else { 0 };
        };
        let mut count = [volume.sum_blocks(visible).into_iter().sum()];
        volume.count_all(&mut count);
        count[0]
    }

    /// Smallest distance between different values of control points.
    fn smallest_gap(&self) -> Option<f64> {
        let gap = |values: Vec<f64>| values.windows(2).map(|w| w[1] - w[0]).filter(|&g| g > 0.0).min_by(f64::total_cmp);
        let colors = gap(self.colors.iter().map(|p| p.0).collect());
        let opacities = gap(self.opacities.iter().map(|p| p.0).collect());
        [colors, opacities].into_iter().flatten().min_by(f64::total_cmp)
    }
}

fn interpolate<T: Copy>(points: &[ControlPoint<T>], value: f64, mix: impl Fn(T, T, f64) -> T) -> T {
    let next = points.partition_point(|p| p.0 <= value);
    match (next.checked_sub(1).map(|i| points[i]), points.get(next)) {
        (Some((x0, y0)), Some(&(x1, y1))) => mix(y0, y1, (value - x0) / (x1 - x0)),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => unreachable!("a transfer function has at least one point"),
    }
}

/// Left-hand limit of the function: at a step, the first of its points there.
fn approached<T: Copy>(points: &[ControlPoint<T>], value: f64, mix: impl Fn(T, T, f64) -> T) -> T {
    match points.iter().find(|point| point.0 == value) {
        Some(&(_, first)) => first,
        None => interpolate(points, value, mix),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn ramp() -> TransferFunction {
        TransferFunction::new("t", vec![(0.0, [0.0; 3]), (10.0, [1.0, 0.5, 0.0])], vec![(2.0, 0.0), (6.0, 0.8)]).unwrap()
    }

    #[test]
    fn linear_between_points_and_constant_beyond() {
        let t = ramp();
        assert_eq!(t.range(), (0.0, 10.0));
        for (value, opacity) in [(-5.0, 0.0), (2.0, 0.0), (4.0, 0.4), (6.0, 0.8), (99.0, 0.8)] {
            assert_abs_diff_eq!(t.opacity(value), opacity, epsilon = 1e-15);
        }
        assert_eq!(t.color(5.0), [0.5, 0.25, 0.0]);
    }

    #[test]
    fn the_most_opaque_color_is_in_the_middle_of_its_values() {
        assert_eq!(ramp().most_opaque_color(), ramp().color(6.0));
        let wide = ramp().with_opacities(vec![(0.0, 0.1), (3.0, 0.4), (7.0, 0.4), (9.0, 0.2)]).unwrap();
        assert_eq!(wide.most_opaque_color(), ramp().color(5.0));
    }

    #[test]
    fn opacity_to_extinction_and_back() {
        for i in 0..100 {
            let opacity = f64::from(i) / 100.0;
            let t = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, opacity)]).unwrap();
            assert_abs_diff_eq!(1.0 - (-t.extinction(0.0)).exp(), opacity, epsilon = 1e-15);
        }
        let opaque = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 1.0)]).unwrap();
        assert_eq!(opaque.extinction(0.0), f64::INFINITY);
    }

    #[test]
    fn a_repeated_value_is_a_step() {
        let t = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (5.0, 0.0), (5.0, 1.0)]).unwrap();
        assert_eq!((t.opacity(4.999), t.opacity(5.0), t.opacity(6.0)), (0.0, 1.0, 1.0));
    }

    #[test]
    fn segmenting_hits_both_ends() {
        let t = ramp().stretched(-1024.0, 2986.0).unwrap();
        assert_eq!(t.range(), (-1024.0, 2986.0));
        assert_abs_diff_eq!(t.opacity(-1024.0 + 0.4 * 4010.0), 0.4, epsilon = 1e-12);
        assert!(ramp().stretched(1.0, 1.0).is_err());
        assert!(ramp().stretched(f64::NAN, 1.0).is_err());
    }

    #[test]
    fn stored_numbers_look_as_their_values() {
        let step =
            TransferFunction::new("t", vec![(0.0, [0.0; 3]), (9.0, [1.0; 3])], vec![(0.0, 0.2), (6.0, 0.3), (6.0, 0.8)]).unwrap();
        for rescale in [(2.0, 0.0), (2.0, -4.0), (-2.0, 0.0), (-0.5, 1.0)].map(|(m, b)| Rescale::new(m, b).unwrap()) {
            let stored = step.for_stored_numbers(rescale);
            // Including the step itself.
            for value in [-1.0, 0.0, 3.5, 5.99, 6.0, 6.01, 9.0, 11.0] {
                assert_abs_diff_eq!(stored.opacity(rescale.stored(value)), step.opacity(value), epsilon = 1e-12);
                assert_abs_diff_eq!(stored.color(rescale.stored(value))[0], step.color(value)[0], epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn fading_scales_opacities() {
        let faded = ramp().faded(0.25).unwrap();
        assert_abs_diff_eq!(faded.opacity(6.0), 0.2, epsilon = 1e-15);
        assert_eq!(faded.color(5.0), ramp().color(5.0));
        assert!(ramp().faded(1.5).is_err() && ramp().faded(f64::NAN).is_err());
    }

    #[test]
    fn bad_points_are_refused() {
        let new = |opacities| TransferFunction::new("t", vec![(0.0, [1.0; 3])], opacities);
        assert!(new(vec![]).is_err());
        assert!(new(vec![(1.0, 0.5), (0.0, 0.5)]).is_err());
        assert!(new(vec![(0.0, 1.5)]).is_err());
        assert!(new(vec![(f64::NAN, 0.5)]).is_err());
    }
}
