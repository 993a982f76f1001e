//! Staggered columns: columns shifted by fractions of a row.

use glam::DMat3;

/// Steps per row: distant columns are accurate to 1e-5 of a row.
const STEPS: f64 = 4_294_967_296.0;

/// Shift of each column in fractions of a row; this project's own.
///
/// In views that are not rolled, a column of pixels is a column of the lattice in all layers. Adjacent columns of pixels are shifted
/// against each other on the volume. Staggering lets samples coincide with pixels along both axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stagger {
    /// Shift of the first column, in 2⁻³² of a row.
    pub first: u32,
    /// Shift from each column to the next, modulo a row.
    pub per_column: u32,
}

impl Stagger {
    /// The stagger that places a sample of each column wherever a row of pixels crosses it, or a column of pixels where columns of samples
    /// are nearer to rows of pixels. `from_screen` is the matrix of [`super::Lattice::from_screen`]; rows of samples must be as far apart as
    /// these crossings. Where columns of samples are at columns (or rows) of pixels, this is a sample at every pixel.
    pub(super) fn onto_pixels(from_screen: &DMat3) -> Self {
        let [x, y, origin] = from_screen.to_cols_array_2d();
        let (along, other) = if x[0].abs() > y[0].abs() { (x, y) } else { (y, x) };
        let per_column = along[1] / along[0];
        // At the centre of a row of pixels, for column 0.
        let first = origin[1] + 0.5 * other[1] - per_column * (origin[0] + 0.5 * other[0]);
        Self { first: steps(first), per_column: steps(per_column) }
    }

    /// Shift of a column, 0 … 1.
    pub fn shift(self, column: u32) -> f64 {
        f64::from(self.first.wrapping_add(self.per_column.wrapping_mul(column))) / STEPS
    }
}

/// Fractional part in steps.
fn steps(rows: f64) -> u32 {
    // A fraction that rounds up to a whole row wraps to 0.
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
            assert_abs_diff_eq!(stagger.shift(column), (0.75 + 0.3 * f64::from(column)).rem_euclid(1.0), epsilon = 1e-5);
        }
        assert_eq!(steps(1.0 - 1e-12), 0);
    }
}
