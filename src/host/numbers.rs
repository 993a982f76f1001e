//! Numbers as people write them.

/// Magnitudes that are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-9..1e15;

/// A number to seven significant digits, as many as 32-bit floats in files have, without trailing zeros. Very large and very small ones have
/// an exponent.
pub fn shortened(number: f64) -> String {
    let rounded: f64 = format!("{number:.6e}").parse().unwrap_or(number);
    let is_plain = rounded == 0.0 || !rounded.is_finite() || PLAIN.contains(&rounded.abs());
    if is_plain { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_tails() {
        for (number, expected) in [
            (f64::from(0.9f32), "0.9"),
            (-1024.0, "-1024"),
            (0.1 + 0.2, "0.3"),
            (1234567.0, "1234567"),
            (0.0, "0"),
            (2.5e-9, "0.0000000025"),
            (1.234_567_89e33, "1.234568e33"),
            (-1e-60, "-1e-60"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(shortened(number), expected);
        }
    }
}
