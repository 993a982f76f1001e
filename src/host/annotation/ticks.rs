//! Round tick values of a range.

/// Tick values from `lo` to `hi` with at most `most` (2 or more) steps, and their labels. Steps are 1, 2 or 5 times a power of ten.
pub(super) fn ticks(lo: f64, hi: f64, most: usize) -> Vec<(f64, String)> {
    let range = hi - lo;
    if !(range.is_finite() && range > 0.0) {
        return vec![(lo, written(lo, lo.abs().max(1.0)))];
    }
    let step = round_up(range / most as f64);
    let first = (lo / step - 1e-9).ceil();
    let count = ((hi / step + 1e-9).floor() - first).max(-1.0) as i64 + 1;
    let values = (0..count).map(|n| (first + n as f64) * step);
    values.map(|value| (value.clamp(lo, hi), written(value, step))).collect()
}

/// Smallest number of the form 1, 2 or 5 times a power of ten that is at least `number`, which must be positive.
pub(super) fn round_up(number: f64) -> f64 {
    let power = 10f64.powf(number.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    // Tolerate rounding errors.
    power * factors.into_iter().find(|factor| factor * power >= number * (1.0 - 1e-9)).unwrap_or(10.0)
}

/// Formats a number with the digits that multiples of `step` need.
pub(super) fn written(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    // Multiples near 0 may come out as −0 or 1e−17.
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    if (1e-4..1e6).contains(&size) && step >= 1e-4 {
        let decimals = (-(step * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 6.0) as usize;
        return format!("{value:.decimals$}");
    }
    let digits = (size.log10().floor() - (step * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 6.0) as usize;
    if value == 0.0 { "0".into() } else { format!("{value:.digits$e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lo: f64, hi: f64) -> Vec<String> {
        ticks(lo, hi, 6).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn labels_are_round() {
        assert_eq!(labels(0.0, 255.0), ["0", "50", "100", "150", "200", "250"]);
        assert_eq!(labels(-1024.0, 3071.0), ["-1000", "0", "1000", "2000", "3000"]);
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(-0.03, 0.05), ["-0.02", "0.00", "0.02", "0.04"]);
        assert_eq!(labels(0.0, 3e7), ["0", "5e6", "1.0e7", "1.5e7", "2.0e7", "2.5e7", "3.0e7"]);
        assert_eq!(labels(1e-7, 4e-7), ["1.0e-7", "1.5e-7", "2.0e-7", "2.5e-7", "3.0e-7", "3.5e-7", "4.0e-7"]);
        assert_eq!(labels(5.0, 5.0).len(), 1);
    }

    #[test]
    fn ticks_lie_in_their_range_and_are_few() {
        for (lo, hi) in [(0.0, 1e-30), (-7.3, 19.2), (1e6, 1e6 + 1.0), (-1e300, 1e300), (0.1, 0.3)] {
            let ticks = ticks(lo, hi, 6);
            assert!((1..=8).contains(&ticks.len()), "{lo} to {hi}: {ticks:?}");
            assert!(ticks.iter().all(|(value, _)| (lo..=hi).contains(value)) && ticks.is_sorted_by(|a, b| a.0 < b.0));
        }
        assert_eq!((round_up(3.0), round_up(0.02), round_up(99.0)), (5.0, 0.02, 100.0));
    }
}
