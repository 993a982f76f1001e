//! Numbers as people write them.

pub(super) use crate::numbers::shortened;

/// A number of bytes to two digits or more: `8.8 TB`.
pub(super) fn bytes_in_words(bytes: u64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let found = units.iter().map(|(size, unit)| (bytes as f64 / size, unit)).find(|(number, _)| *number >= 1.0);
    match found {
        None => format!("{bytes} bytes"),
        Some((number, unit)) if number < 10.0 => format!("{number:.1} {unit}"),
        Some((number, unit)) => format!("{number:.0} {unit}"),
    }
}

/// A colour as `#rrggbb`.
pub(super) fn hex_color(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|c| (c * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}
