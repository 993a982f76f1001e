//! ParaView's colour spaces for interpolation. They use ParaView's constants: another white point or another gamut mapping would
//! produce different colours.

use std::f64::consts::PI;

pub(in crate::transfer) type Triple = [f64; 3];

/// Colour space in which colours between two control points are interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ColorSpace {
    Rgb,
    /// Hue, saturation, value. Hues take the shorter arc, or never cross red.
    Hsv {
        shorter_way: bool,
    },
    /// CIELAB.
    Lab,
    /// CIEDE2000 paths; CIELAB here, as a fallback for functions with too many points.
    Ciede2000,
    /// Diverging map in polar CIELAB, through white if the hues of both ends differ (Moreland 2009).
    Diverging,
    /// Constant, with the colour of the next point.
    Step,
}

impl ColorSpace {
    /// The colour at fraction `share` between two colours.
    pub fn mixed(self, from: Triple, to: Triple, share: f64) -> Triple {
        match self {
            ColorSpace::Rgb => mix(from, to, share),
            ColorSpace::Hsv { shorter_way } => mixed_hues(hsv(from), hsv(to), shorter_way, share),
            ColorSpace::Lab | ColorSpace::Ciede2000 => rgb_of_lab(mix(lab(from), lab(to), share)),
            ColorSpace::Diverging => rgb_of_lab(lab_of_polar(diverging(polar(lab(from)), polar(lab(to)), share))),
            ColorSpace::Step => to,
        }
    }
}

fn mix(from: Triple, to: Triple, share: f64) -> Triple {
    std::array::from_fn(|c| from[c] + (to[c] - from[c]) * share)
}

/// Hue (0 … 1, red at both ends), saturation and value. The hue of grey is 0.
fn hsv([r, g, b]: Triple) -> Triple {
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let span = most - least;
    if span <= 0.0 {
        return [0.0, 0.0, most];
    }
    let sixths = if r == most {
        (g - b) / span
    } else if g == most {
        2.0 + (b - r) / span
    } else {
        4.0 + (r - g) / span
    };
    [(sixths / 6.0).rem_euclid(1.0), span / most, most]
}

fn rgb_of_hsv([hue, saturation, value]: Triple) -> Triple {
    // Each channel is at its maximum over two sixths of the circle and at its minimum over two others.
    let channel = |turned: f64| {
        let away = ((hue + turned) * 6.0).rem_euclid(6.0);
        let share = (2.0 - (away - 3.0).abs()).clamp(0.0, 1.0);
        value * (1.0 - saturation * share)
    };
    [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)]
}

fn mixed_hues(mut from: Triple, mut to: Triple, shorter_way: bool, share: f64) -> Triple {
    if shorter_way && (from[0] - to[0]).abs() > 0.5 {
        let larger = if from[0] > to[0] { &mut from } else { &mut to };
        larger[0] -= 1.0;
    }
    rgb_of_hsv(mix(from, to, share))
}

/// XYZ of the white point.
const WHITE: Triple = [0.9505, 1.0, 1.089];
/// Linear sRGB to XYZ and the inverse, row-major.
const TO_XYZ: [Triple; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
const FROM_XYZ: [Triple; 3] = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

fn times(matrix: [Triple; 3], v: Triple) -> Triple {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// L* 0 … 100, a* and b*.
pub(in crate::transfer) fn lab(rgb: Triple) -> Triple {
    let light = rgb.map(|c| if c > 0.04045 { ((c + 0.055) / 1.055).powf(2.4) } else { c / 12.92 });
    let xyz = times(TO_XYZ, light);
    let [x, y, z] = std::array::from_fn(|c| {
        let share = xyz[c] / WHITE[c];
        if share > 0.008856 { share.cbrt() } else { 7.787 * share + 16.0 / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// CIELAB to sRGB in 0 … 1. Colours above 1 are scaled down in all channels; negative channels are clamped.
fn rgb_of_lab([l, a, b]: Triple) -> Triple {
    let y = (l + 16.0) / 116.0;
    let roots = [y + a / 500.0, y, y - b / 200.0];
    let xyz = std::array::from_fn(|c| {
        let cube = roots[c].powi(3);
        WHITE[c] * if cube > 0.008856 { cube } else { (roots[c] - 16.0 / 116.0) / 7.787 }
    });
    let rgb = times(FROM_XYZ, xyz).map(|c| if c > 0.0031308 { 1.055 * c.powf(1.0 / 2.4) - 0.055 } else { 12.92 * c });
    let brightest = rgb.into_iter().fold(1.0, f64::max);
    rgb.map(|c| (c / brightest).max(0.0))
}

/// Magnitude, saturation (the angle from grey) and hue (an angle).
fn polar([l, a, b]: Triple) -> Triple {
    let magnitude = (l * l + a * a + b * b).sqrt();
    let saturation = if magnitude > 0.001 { (l / magnitude).clamp(-1.0, 1.0).acos() } else { 0.0 };
    let hue = if saturation > 0.001 { b.atan2(a) } else { 0.0 };
    [magnitude, saturation, hue]
}

fn lab_of_polar([magnitude, saturation, hue]: Triple) -> Triple {
    [magnitude * saturation.cos(), magnitude * saturation.sin() * hue.cos(), magnitude * saturation.sin() * hue.sin()]
}

/// Angle from the grey axis below which a colour counts as grey.
const GREY: f64 = 0.05;
/// Difference of hues above which white is inserted between them.
const DISTINCT: f64 = 0.33 * PI;
/// Least magnitude of the inserted white.
const WHITEST: f64 = 88.0;

fn diverging(mut from: Triple, mut to: Triple, mut share: f64) -> Triple {
    let between = (from[2] - to[2]).abs();
    if from[1] > GREY && to[1] > GREY && between.min(2.0 * PI - between) > DISTINCT {
        let white = [from[0].max(to[0]).max(WHITEST), 0.0, 0.0];
        if share < 0.5 {
            (to, share) = (white, 2.0 * share);
        } else {
            (from, share) = (white, 2.0 * share - 1.0);
        }
    }
    if from[1] < GREY && to[1] > GREY {
        from[2] = hue_of_grey(to, from[0]);
    } else if to[1] < GREY && from[1] > GREY {
        to[2] = hue_of_grey(from, to[0]);
    }
    mix(from, to, share)
}

/// Hue for a grey of magnitude `grey`, so that colours change evenly towards the given one. The hue is rotated away from the given
/// one, except from purple towards red.
fn hue_of_grey([magnitude, saturation, hue]: Triple, grey: f64) -> f64 {
    if magnitude >= grey - 0.1 {
        return hue;
    }
    let spin = saturation * (grey * grey - magnitude * magnitude).sqrt() / (magnitude * saturation.sin());
    if hue > -0.3 * PI { hue + spin } else { hue - spin }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constants have four digits, so their matrices are inverse to four digits only.
    const CONSTANTS: f64 = 5e-4;

    fn near(a: Triple, b: Triple, tolerance: f64) -> bool {
        (0..3).all(|c| (a[c] - b[c]).abs() <= tolerance)
    }

    #[test]
    fn there_and_back() {
        for i in 0..729 {
            let rgb = [i % 9, i / 9 % 9, i / 81].map(|c| f64::from(c) / 8.0);
            assert!(near(rgb_of_hsv(hsv(rgb)), rgb, 1e-12), "{rgb:?}: {:?}", hsv(rgb));
            assert!(near(rgb_of_lab(lab(rgb)), rgb, CONSTANTS), "{rgb:?}: {:?}", lab(rgb));
            assert!(near(rgb_of_lab(lab_of_polar(polar(lab(rgb)))), rgb, CONSTANTS), "{rgb:?}");
        }
    }

    /// sRGB primaries and grey under D65, from published colour tables, which use matrices with more digits.
    #[test]
    fn lab_of_known_colours() {
        for (rgb, expected) in [
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ] {
            assert!(near(lab(rgb), expected, 0.04), "{rgb:?}: {:?}", lab(rgb));
        }
    }

    #[test]
    fn hues_go_round_one_way_or_the_other() {
        let (purple, orange) = ([1.0, 0.0, 0.5], [1.0, 0.5, 0.0]);
        assert!(near(ColorSpace::Hsv { shorter_way: true }.mixed(purple, orange, 0.5), [1.0, 0.0, 0.0], 1e-12));
        assert!(near(ColorSpace::Hsv { shorter_way: false }.mixed(purple, orange, 0.5), [0.0, 1.0, 1.0], 1e-12));
    }

    #[test]
    fn diverging_passes_white() {
        let middle = ColorSpace::Diverging.mixed([0.23, 0.3, 0.75], [0.7, 0.02, 0.15], 0.5);
        let (most, least) = (middle.into_iter().fold(0.0, f64::max), middle.into_iter().fold(1.0, f64::min));
        assert!(least > 0.85 && most - least < 0.01, "{middle:?}");
    }
}
