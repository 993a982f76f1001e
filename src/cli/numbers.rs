//! Numbers as people write them.

pub(super) use crate::numbers::shortened;

/// A colour as `#rrggbb`.
pub(super) fn hex_color(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|c| (c * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}
