//! Fields that end within the grid on which they are drawn.
//!
//! A volume alone ends with its grid. A grid that several share is larger, and around the volume lies its background. Where that is
//! visible, values fall below all others at the end of the volume instead, where the transfer function hides them.

use super::Field;
use crate::transfer::TransferFunction;

/// How far below the smallest value, in shares of the range of values, those begin that are hidden.
const HIDDEN: f64 = 0.05;
/// How many times as far below it the values around are, at most.
pub(super) const STEEPEST: f64 = 5.0;

/// The value at the end of an enclosed volume with this range of values.
pub(super) fn value_at_end(range: (f64, f64)) -> f64 {
    range.0 - HIDDEN * length(range)
}

/// Length of a range of values. Constants have one, too.
fn length((lowest, highest): (f64, f64)) -> f64 {
    match highest - lowest {
        0.0 if lowest == 0.0 => 1.0,
        0.0 => lowest.abs(),
        length => length,
    }
}

impl Field {
    /// The transfer function with which the field is drawn: it hides what lies around an enclosed field.
    pub fn hiding_around(&self, transfer: &TransferFunction) -> TransferFunction {
        if !self.is_enclosed {
            return transfer.clone();
        }
        let range = self.description.range();
        let (lowest, end) = (range.0, value_at_end(range));
        let opacity = transfer.opacity(lowest);
        let around = [(end, 0.0), (end, opacity), (lowest, opacity)];
        let within = transfer.opacities().iter().copied().filter(|&(value, _)| value > lowest);
        transfer
            .with_opacities(around.into_iter().chain(within).collect())
            .expect("values rise, and opacities are those of before")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_end_below_their_value() {
        for (range, end) in [((0.0, 0.0), -0.05), ((4.0, 4.0), 3.8), ((-4.0, -4.0), -4.2), ((2.0, 6.0), 1.8)] {
            approx::assert_abs_diff_eq!(value_at_end(range), end, epsilon = 1e-12);
        }
    }
}
