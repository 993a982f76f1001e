//! What points and cells of shapes have.

use crate::error::Error;
use crate::transfer::TransferFunction;

/// The colour map of values by default.
pub const DEFAULT_COLORS: &str = "viridis";

/// An entry per point, or per cell: a triangle, a sphere or a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Per<T> {
    /// Interpolated between points.
    Point(Vec<T>),
    /// Constant within a cell.
    Cell(Vec<T>),
}

impl<T> Per<T> {
    /// All entries.
    pub fn entries(&self) -> &[T] {
        match self {
            Per::Point(entries) | Per::Cell(entries) => entries,
        }
    }
}

impl Per<f32> {
    /// The smallest and the largest finite value, if there are any.
    pub fn range(&self) -> Option<[f32; 2]> {
        let finite = self.entries().iter().copied().filter(|value| value.is_finite());
        finite.map(|value| [value; 2]).reduce(|[lo, hi], [value, _]| [lo.min(value), hi.max(value)])
    }

    /// A built-in colour map over the range of the values.
    ///
    /// # Errors
    /// If there is no map of this name.
    pub fn colored_by(&self, name: &str) -> Result<TransferFunction, Error> {
        let [lo, hi] = self.range().unwrap_or_default().map(f64::from);
        // A single value, or none, has the colour in the middle. Large ones have no neighbours at a distance of 1.
        let around = (lo.abs() * f64::from(f32::EPSILON)).max(1.0);
        let [lo, hi] = if lo < hi { [lo, hi] } else { [lo - around, lo + around] };
        TransferFunction::builtin_over(name, lo, hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_value_has_the_colour_in_the_middle() {
        for value in [0.0, -3.5, 2.567_052e17, f32::MAX] {
            let (lo, hi) = Per::Point(vec![value; 2]).colored_by("viridis").unwrap().range();
            assert!(lo < f64::from(value) && f64::from(value) < hi, "{value}: {lo} to {hi}");
        }
    }
}
