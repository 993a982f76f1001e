//! Fields that end within the grid on which they are drawn.
//!
//! A volume alone ends with its grid. A grid that several share is larger, and around the volume lies its background. Where that is
//! visible, values fall below all others at the end of the volume instead, and the transfer function hides them.

use super::Field;
use crate::transfer::TransferFunction;

/// How far below all values, in shares of their range, the value at the end is.
const BELOW: f64 = 0.05;
/// How many times as far from the background as the value at the end those beyond are, at most.
pub(super) const STEEPEST: f64 = 5.0;

/// The value at the end of a volume with this range of values and this background. Lower ones are hidden.
pub(super) fn value_at_end((lowest, highest): (f64, f64), background: f64) -> f64 {
    let lowest = lowest.min(background);
    let length = match highest - lowest {
        0.0 if lowest == 0.0 => 1.0,
        0.0 => lowest.abs(),
        length => length,
    };
    lowest - BELOW * length
}

impl Field {
    /// The transfer function with which the field is drawn: it hides what lies beyond the end of the field.
    pub fn hiding_beyond(&self, transfer: &TransferFunction) -> TransferFunction {
        let Some(end) = self.end else { return transfer.clone() };
        let hidden = [(end, 0.0), (end, transfer.opacity(end))];
        let shown = transfer.opacities().iter().copied().filter(|&(value, _)| value > end);
        transfer.with_opacities(hidden.into_iter().chain(shown).collect()).expect("values ascend, and opacities are valid")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_lie_below_all_values_and_the_background() {
        let cases = [((0.0, 0.0), 0.0, -0.05), ((4.0, 4.0), 4.0, 3.8), ((-4.0, -4.0), -4.0, -4.2), ((2.0, 6.0), 2.0, 1.8)];
        for (range, background, end) in cases.into_iter().chain([((2.0, 6.0), 9.0, 1.8), ((0.0, 1.0), -99.0, -104.0)]) {
            approx::assert_abs_diff_eq!(value_at_end(range, background), end, epsilon = 1e-12);
        }
    }
}
