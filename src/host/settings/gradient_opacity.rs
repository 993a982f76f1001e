//! Gradient opacity.

use crate::error::Error;

/// Factor of the extinction as a function of the gradient magnitude: piecewise linear, constant beyond the outer points. Magnitudes are in
/// values per world unit. It suppresses homogeneous regions and shows boundaries (Levoy, Display of surfaces from volume data, 1988).
///
/// At a point of the field the extinction is τ(value) times the factor, and the opacity per unit distance 1 − (1 − α)^factor; with linear
/// extinction, α times the factor. Sampled layers and rays evaluate the factor at their samples. Pre-integrated segments interpolate it
/// linearly and scale the optical depth by its value at the centroid of the extinction. Slicing uses the factor of the mean gradient.
///
/// ```
/// use layersplat::settings::{GradientOpacity, Settings};
///
/// // Transparent below 5 values per millimetre, unchanged above 20.
/// let edges = GradientOpacity::new(&[(5.0, 0.0), (20.0, 1.0)])?;
/// assert_eq!([0.0, 5.0, 12.5, 80.0].map(|g| edges.at(g)), [0.0, 0.0, 0.5, 1.0]);
/// let settings = Settings { gradient_opacity: Some(edges), ..Settings::default() };
/// assert!(GradientOpacity::new(&[(5.0, 2.0)]).is_err());
/// # let _ = settings;
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientOpacity {
    count: usize,
    points: [(f64, f64); Self::MOST_POINTS],
}

impl GradientOpacity {
    /// Largest number of points.
    pub const MOST_POINTS: usize = 8;

    /// Creates a function from (gradient magnitude, factor) points. Takes 1 to 8 points; magnitudes must be finite, ≥ 0 and ascending,
    /// factors 0 … 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] otherwise.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, Error> {
        let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let within = points.iter().all(|&(length, factor)| (0.0..=f64::MAX).contains(&length) && (0.0..=1.0).contains(&factor));
        if !(1..=Self::MOST_POINTS).contains(&points.len()) || !ascending || !within {
            return Err(Error::OutOfRange {
                name: "gradient_opacity",
                value: format!("{points:?}"),
                expected: "1 to 8 points with ascending gradient magnitudes of at least 0 and factors from 0 to 1",
            });
        }
        // Unused points repeat the last one, which adds nothing.
        let last = points[points.len() - 1];
        Ok(Self { count: points.len(), points: std::array::from_fn(|i| points.get(i).copied().unwrap_or(last)) })
    }

    /// The (gradient magnitude, factor) points.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points[..self.count]
    }

    /// Factor at a gradient magnitude, 0 … 1.
    pub fn at(&self, length: f64) -> f64 {
        let (least, rises) = self.rises();
        least + rises.iter().map(|[from, slope, to]| slope * (length.clamp(*from, *to) - from)).sum::<f64>()
    }

    /// Scales the gradient magnitudes.
    #[doc(hidden)]
    pub fn times(self, scale: f64) -> Self {
        Self { points: self.points.map(|(length, factor)| (length * scale, factor)), ..self }
    }

    /// Factor at 0, and its ramps as (from, slope, to), which kernels sum up.
    #[doc(hidden)]
    pub fn rises(&self) -> (f64, [[f64; 3]; Self::MOST_POINTS - 1]) {
        let rise = |i: usize| {
            let ((from, low), (to, high)) = (self.points[i], self.points[i + 1]);
            if to > from { [from, (high - low) / (to - from), to] } else { [0.0; 3] }
        };
        (self.points[0].1, std::array::from_fn(rise))
    }
}
