//! Conversion of pixels for display: over a background, to 8 bits. Bit-identical to kernels/display.cl.

use super::Background;
use crate::color::Curve;

/// Opacities below this count as 0, which avoids quotients of denormals: devices may flush those to 0.
const LEAST_OPACITY: f32 = f32::from_bits((127 - 100) << 23);

/// Composites a premultiplied pixel over an opaque colour. The fused multiply-add rounds once.
pub(super) fn over([r, g, b, a]: [f32; 4], color: [f32; 3]) -> [f32; 4] {
    let on = |c: f32, below: f32| (1.0 - a).mul_add(below, c);
    [on(r, color[0]), on(g, color[1]), on(b, color[2]), 1.0]
}

/// Applies a curve to the straight colour of a premultiplied pixel.
pub(super) fn curved([r, g, b, a]: [f32; 4], curve: &Curve) -> [f32; 4] {
    if a.is_nan() || a < LEAST_OPACITY {
        return [r, g, b, a];
    }
    let [r, g, b] = curve.curved([r, g, b].map(|c| c / a));
    [r * a, g * a, b * a, a]
}

/// Composites a premultiplied pixel over an opaque colour, or converts it to straight alpha.
pub(super) fn straight(pixel: [f32; 4], background: Background) -> [f32; 4] {
    let [r, g, b, a] = pixel;
    match background {
        Background::Color(color) => over(pixel, color),
        Background::Transparent if a >= LEAST_OPACITY => [r / a, g / a, b / a, a],
        Background::Transparent => [0.0; 4],
    }
}

/// Converts a premultiplied pixel to 8 bits, over an opaque colour or with straight alpha.
pub(super) fn displayed(pixel: [f32; 4], background: Background) -> [u8; 4] {
    straight(pixel, background).map(byte)
}

/// Converts 0 … 1 to 0 … 255, rounding halves up. Values outside are clamped; NaN becomes 0.
fn byte(c: f32) -> u8 {
    dithered(c, 0.5)
}

/// Converts 0 … 1 to 0 … 255, rounding up from a fraction of 1 − `threshold`. With thresholds spread evenly over 0 … 1, the mean is exact.
pub(super) fn dithered(c: f32, threshold: f32) -> u8 {
    // Float-to-integer casts truncate and saturate.
    c.mul_add(255.0, threshold) as u8
}

/// Converts 0 … 1 to 0 … 65535, as [`byte`].
pub(super) fn word(c: f32) -> u16 {
    c.mul_add(65_535.0, 0.5) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_rounded_up_and_what_is_beyond_is_cut_off() {
        let cases = [
            (0.0, 0),
            (-0.0, 0),
            (1.0, 255),
            (0.3, 77),  // 76.5
            (0.1, 26),  // 25.5
            (0.5, 128), // 127.5
            (0.7, 179), // 178.499997, a half in floats
            (0.25, 64), // 63.75
            (1.0 / 255.0, 1),
            (0.499 / 255.0, 0),
            (254.499 / 255.0, 254),
            (-0.3, 0),
            (-1e30, 0),
            (1.003, 255),
            (1e30, 255),
            (f32::INFINITY, 255),
            (f32::NEG_INFINITY, 0),
            (f32::NAN, 0),
            (f32::from_bits(1), 0),
        ];
        for (value, expected) in cases {
            assert_eq!(byte(value), expected, "{value}");
        }
        for n in 0..=255u8 {
            assert_eq!(byte(f32::from(n) / 255.0), n);
        }
    }

    #[test]
    fn pixels_over_a_colour_and_with_straight_alpha() {
        let half = [0.3, 0.1, 0.0, 0.5];
        assert_eq!(displayed(half, Background::BLACK), [77, 26, 0, 255]);
        assert_eq!(displayed(half, Background::Color([0.0, 0.4, 1.0])), [77, 77, 128, 255]);
        assert_eq!(displayed(half, Background::Transparent), [153, 51, 0, 128]);
        // More colour than opacity; no opacity; negligible opacity.
        assert_eq!(displayed([0.5, 0.25, 0.0, 0.25], Background::Transparent), [255, 255, 0, 64]);
        for nothing in [0.0, -0.5, f32::NAN, LEAST_OPACITY / 2.0] {
            assert_eq!(displayed([0.3, 0.3, 0.3, nothing], Background::Transparent), [0; 4], "{nothing}");
        }
        assert_eq!(displayed([f32::NAN, 0.5, 2.0, 1.0], Background::Transparent), [0, 128, 255, 255]);
    }
}
