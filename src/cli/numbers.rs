//! Numbers as people write them.

/// A number to seven significant digits, as many as 32-bit floats in files have, without trailing zeros.
pub(super) fn shortened(number: f64) -> String {
    let rounded: f64 = format!("{number:.6e}").parse().unwrap_or(number);
    rounded.to_string()
}

/// A colour as `#rrggbb`.
pub(super) fn hex_color(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|c| (c * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
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
        ] {
            assert_eq!(shortened(number), expected);
        }
    }
}
