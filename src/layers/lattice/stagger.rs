//! Columns whose samples lie between the rows of others.

use glam::DMat3;

/// Steps of a row: columns far from the first are still told to 1e-5 of a row.
const STEPS: f64 = 4_294_967_296.0;

/// By how much of a row the samples of each column lie behind the rows of the lattice. Where a view is not rolled, a column of pixels is a
/// column of the lattice in all layers, but the pixels of the next one lie higher or lower on the volume: so samples can lie on pixels along
/// both axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stagger {
    /// Of the first column, in 2⁻³² of a row.
    pub first: u32,
    /// From each column to the next, whole rows left out.
    pub per_column: u32,
}

impl Stagger {
    /// With which each pixel has a sample, where the places of pixels on a lattice (see [`super::Lattice::from_screen`]) are a sample apart
    /// along both axes, and columns of samples lie on columns or rows of pixels.
    pub(super) fn onto_pixels(from_screen: &DMat3) -> Self {
        let [x, y, origin] = from_screen.to_cols_array_2d();
        let (along, other) = if x[0].abs() > y[0].abs() { (x, y) } else { (y, x) };
        let per_column = along[1] / along[0];
        // In the middle of a row of pixels, where column 0 is.
        let first = origin[1] + 0.5 * other[1] - per_column * (origin[0] + 0.5 * other[0]);
        Self { first: steps(first), per_column: steps(per_column) }
    }

    /// Of a column, 0 … 1.
    pub fn of(self, column: u32) -> f64 {
        f64::from(self.first.wrapping_add(self.per_column.wrapping_mul(column))) / STEPS
    }
}

/// Of what is left of a number above the whole one below it.
fn steps(rows: f64) -> u32 {
    // A whole row by rounding is none.
    ((rows - rows.floor()) * STEPS).round() as u64 as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn columns_far_away_are_staggered_as_the_first() {
        let stagger = Stagger { first: steps(-0.25), per_column: steps(3.3) };
        for column in [0, 1, 7, 16_384] {
            assert_abs_diff_eq!(stagger.of(column), (0.75 + 0.3 * f64::from(column)).rem_euclid(1.0), epsilon = 1e-5);
        }
        assert_eq!(steps(1.0 - 1e-12), 0);
    }
}
