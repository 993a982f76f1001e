//! Opacity by the gradient.

use crate::error::Error;

/// What is left of the extinction where the field changes by so much: piecewise linear in the length of its gradient, in the volume's values
/// per world distance, and constant beyond the outer points. It shows where materials meet and hides what lies even between (Levoy, Display
/// of surfaces from volume data, 1988).
///
/// At a point of the field the extinction is τ(value) times this factor, the opacity per unit distance 1 − (1 − α)^factor (with linear
/// extinction, α times it). Layers and rays that are sampled find it at their samples; between the two samples of a pre-integrated segment it
/// changes evenly, so the segment's optical depth is taken times the factor where its extinction has its centroid, and slicing takes that of
/// the mean gradient.
///
/// ```
/// use layersplat::settings::{GradientOpacity, Settings};
///
/// // Nothing below 5 values per millimetre, all from 20 on.
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
    /// Points that it may have.
    pub const MOST_POINTS: usize = 8;

    /// From points (length of the gradient, factor): one to eight of them, lengths finite, from 0 on and ascending, factors from 0 to 1.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, Error> {
        let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let within = points.iter().all(|&(length, factor)| (0.0..=f64::MAX).contains(&length) && (0.0..=1.0).contains(&factor));
        if !(1..=Self::MOST_POINTS).contains(&points.len()) || !ascending || !within {
            return Err(Error::OutOfRange {
                name: "gradient_opacity",
                value: format!("{points:?}"),
                expected: "1 to 8 points, lengths of gradients from 0 on and ascending, factors from 0 to 1",
            });
        }
        // Those that are none repeat the last: nothing lies between.
        let last = points[points.len() - 1];
        Ok(Self { count: points.len(), points: std::array::from_fn(|i| points.get(i).copied().unwrap_or(last)) })
    }

    /// The points.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points[..self.count]
    }

    /// The factor, 0 … 1, at a length.
    pub fn at(&self, length: f64) -> f64 {
        let (least, rises) = self.rises();
        least + rises.iter().map(|[from, slope, to]| slope * (length.clamp(*from, *to) - from)).sum::<f64>()
    }

    /// The same where lengths of gradients are so many times as large.
    pub(crate) fn times(self, scale: f64) -> Self {
        Self { points: self.points.map(|(length, factor)| (length * scale, factor)), ..self }
    }

    /// The factor at 0, and what it rises by as (from, per length, to), as kernels sum it up.
    pub(crate) fn rises(&self) -> (f64, [[f64; 3]; Self::MOST_POINTS - 1]) {
        let rise = |i: usize| {
            let ((from, low), (to, high)) = (self.points[i], self.points[i + 1]);
            if to > from { [from, (high - low) / (to - from), to] } else { [0.0; 3] }
        };
        (self.points[0].1, std::array::from_fn(rise))
    }
}
