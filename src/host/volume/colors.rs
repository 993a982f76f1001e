//! Colours of labels and channels that have none: well separated, for the colour-blind as far as their number allows.

/// Colours that differ for all kinds of colour vision: B. Wong, Color blindness, Nature Methods 8 (2011), without black.
const FIRST: [[u8; 3]; 7] =
    [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [0, 114, 178], [213, 94, 0], [204, 121, 167]];

/// Colours of channels, which add. The first two add to white, and differ for all kinds of colour vision.
const CHANNELS: [[f64; 3]; 8] = [
    [0.0, 1.0, 0.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.1, 0.3, 1.0],
    [1.0, 0.5, 0.0],
    [1.0, 1.0, 1.0],
];

/// Steps of an additive sequence that fills a square evenly (M. Roberts' R2: inverse powers of the plastic number).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// Range of lightness of generated colours: legible on black and on white.
const LIGHTNESS: [f64; 2] = [0.45, 0.9];
/// Largest chroma of generated colours.
const CHROMA: f64 = 0.19;

/// Colour of a label, by its id alone.
pub(super) fn of_label(id: u32) -> [f64; 3] {
    match FIRST.get((id as usize).wrapping_sub(1)) {
        Some(color) => color.map(|byte| f64::from(byte) / 255.0),
        None => generated(id),
    }
}

/// Colour of the `n`th channel without one.
pub(super) fn of_channel(n: usize) -> [f64; 3] {
    CHANNELS.get(n).copied().unwrap_or_else(|| generated(n as u32))
}

/// Any number of colours. Lightness differs as well as hue, as all kinds of colour vision tell it.
fn generated(n: u32) -> [f64; 3] {
    let [lightness, hue] = STEPS.map(|step| (f64::from(n) * step).fract());
    let lightness = LIGHTNESS[0] + (LIGHTNESS[1] - LIGHTNESS[0]) * lightness;
    let (sin, cos) = (hue * std::f64::consts::TAU).sin_cos();
    // The most saturated colour of this lightness and hue that screens show.
    let shares = (0..=16).rev().map(|n| f64::from(n) / 16.0 * CHROMA);
    let mut colors = shares.map(|chroma| from_oklab([lightness, chroma * cos, chroma * sin]));
    let found = colors.find(|color| color.iter().all(|c| (0.0..=1.0).contains(c)));
    found.unwrap_or([lightness; 3]).map(|linear| encoded(linear.clamp(0.0, 1.0)))
}

/// Linear sRGB of a colour in Oklab (B. Ottosson, A perceptual color space for image processing, 2020).
fn from_oklab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let cones = [
        lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b,
    ]
    .map(|cone| cone.powi(3));
    let row = |weights: [f64; 3]| (0..3).map(|i| weights[i] * cones[i]).sum();
    [
        row([4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2]),
        row([-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5]),
        row([-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0]),
    ]
}

/// sRGB's encoding of a linear component.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Parses `#rrggbb` or `rrggbb`.
pub(super) fn from_hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let is_hex = digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    let byte = |n: usize| u8::from_str_radix(&digits[2 * n..2 * n + 2], 16).ok().map(|byte| f64::from(byte) / 255.0);
    is_hex.then(|| Some([byte(0)?, byte(1)?, byte(2)?])).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulated colour vision in linear sRGB, rows of matrices: none, protanopia, deuteranopia (F. Viénot, H. Brettel, J. Mollon, Digital
    /// video colourmaps for checking the legibility of displays by dichromats, 1999; for the primaries of sRGB).
    const VISIONS: [[[f64; 3]; 3]; 3] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.112_38, 0.887_62, 0.0], [0.112_38, 0.887_62, 0.0], [0.004_01, -0.004_01, 1.0]],
        [[0.292_75, 0.707_25, 0.0], [0.292_75, 0.707_25, 0.0], [-0.022_34, 0.022_34, 1.0]],
    ];

    fn oklab(color: [f64; 3], vision: [[f64; 3]; 3]) -> [f64; 3] {
        let linear = color.map(|c| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055f64).powf(2.4) });
        let seen = vision.map(|row| (0..3).map(|i| row[i] * linear[i]).sum::<f64>().clamp(0.0, 1.0));
        let row = |weights: [f64; 3], of: [f64; 3]| (0..3).map(|i| weights[i] * of[i]).sum::<f64>();
        let cones = [
            row([0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9], seen),
            row([0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6], seen),
            row([0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5], seen),
        ]
        .map(f64::cbrt);
        [
            row([0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8], cones),
            row([1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9], cones),
            row([0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0], cones),
        ]
    }

    /// Smallest distance in Oklab of any two colours, as the worst of `VISIONS` sees them.
    fn separation(colors: &[[f64; 3]]) -> f64 {
        let mut least = f64::INFINITY;
        for vision in VISIONS {
            let seen: Vec<[f64; 3]> = colors.iter().map(|&color| oklab(color, vision)).collect();
            for (n, a) in seen.iter().enumerate() {
                let apart = |b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
                least = seen[..n].iter().map(apart).fold(least, f64::min);
            }
        }
        least
    }

    #[test]
    fn first_colours_differ_for_all_kinds_of_colour_vision() {
        let labels: Vec<_> = (1..=7).map(of_label).collect();
        assert!(separation(&labels) > 0.07, "{}", separation(&labels));
        let pair = separation(&[of_channel(0), of_channel(1)]);
        assert!(pair > 0.15, "{pair}");
        // Red and green of one lightness do not.
        assert!(separation(&[[0.8, 0.2, 0.2], [0.45, 0.45, 0.2]]) < 0.07);
    }

    #[test]
    fn many_colours_are_all_different_and_shown_by_screens() {
        let many: Vec<_> = (1..=300).map(of_label).collect();
        assert!(many.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
        let bytes = |color: &[f64; 3]| color.map(|c| (c * 255.0).round() as u8);
        let different: std::collections::HashSet<_> = many.iter().map(bytes).collect();
        assert_eq!(different.len(), many.len());
        assert_eq!(of_label(4_000_000_000), of_label(4_000_000_000));
        assert!((0..20).all(|n| of_channel(n).iter().all(|c| (0.0..=1.0).contains(c))));
    }

    #[test]
    fn grey_survives_both_ways() {
        for lightness in [0.2, 0.5, 0.9] {
            let back = oklab(from_oklab([lightness, 0.0, 0.0]).map(encoded), VISIONS[0]);
            assert!((back[0] - lightness).abs() < 1e-5 && back[1].abs() < 1e-5 && back[2].abs() < 1e-5, "{back:?}");
        }
    }

    #[test]
    fn six_digits_are_a_colour() {
        assert_eq!(from_hex("#ff0080"), Some([1.0, 0.0, 128.0 / 255.0]));
        assert_eq!(from_hex("00FF00"), Some([0.0, 1.0, 0.0]));
        for bad in ["", "#", "ff00", "#ff00801", "+f0080", "gg0000", "äää"] {
            assert_eq!(from_hex(bad), None, "{bad}");
        }
    }
}
