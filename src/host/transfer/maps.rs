//! Colour maps, by the names that plotting libraries use.

use super::ControlPoint;
use colorous::Gradient;

/// Perceptually uniform maps first, then other sequential maps, then diverging maps.
const MAPS: [(&str, Gradient); 34] = [
    ("inferno", colorous::INFERNO),
    ("magma", colorous::MAGMA),
    ("plasma", colorous::PLASMA),
    ("cividis", colorous::CIVIDIS),
    ("turbo", colorous::TURBO),
    ("cubehelix", colorous::CUBEHELIX),
    ("warm", colorous::WARM),
    ("cool", colorous::COOL),
    ("blues", colorous::BLUES),
    ("greens", colorous::GREENS),
    ("greys", colorous::GREYS),
    ("oranges", colorous::ORANGES),
    ("purples", colorous::PURPLES),
    ("reds", colorous::REDS),
    ("bugn", colorous::BLUE_GREEN),
    ("bupu", colorous::BLUE_PURPLE),
    ("gnbu", colorous::GREEN_BLUE),
    ("orrd", colorous::ORANGE_RED),
    ("pubu", colorous::PURPLE_BLUE),
    ("pubugn", colorous::PURPLE_BLUE_GREEN),
    ("purd", colorous::PURPLE_RED),
    ("rdpu", colorous::RED_PURPLE),
    ("ylgn", colorous::YELLOW_GREEN),
    ("ylgnbu", colorous::YELLOW_GREEN_BLUE),
    ("ylorbr", colorous::YELLOW_ORANGE_BROWN),
    ("ylorrd", colorous::YELLOW_ORANGE_RED),
    ("spectral", colorous::SPECTRAL),
    ("brbg", colorous::BROWN_GREEN),
    ("piyg", colorous::PINK_GREEN),
    ("prgn", colorous::PURPLE_GREEN),
    ("puor", colorous::PURPLE_ORANGE),
    ("rdbu", colorous::RED_BLUE),
    ("rdylbu", colorous::RED_YELLOW_BLUE),
    ("rdylgn", colorous::RED_YELLOW_GREEN),
];

/// Entries sampled per map, and the stride between control points. 3 divides 255, so both ends are control points.
const ENTRIES: usize = 256;
const EVERY: usize = 3;

pub(super) fn names() -> impl Iterator<Item = &'static str> {
    MAPS.iter().map(|(name, _)| *name)
}

/// Colours of a map over 0 … 1; the case of the name is ignored.
pub(super) fn colors(name: &str) -> Option<Vec<ControlPoint<[f64; 3]>>> {
    let gradient = MAPS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?.1;
    let point = |entry: usize| {
        let color = gradient.eval_rational(entry, ENTRIES).as_array();
        (entry as f64 / (ENTRIES - 1) as f64, color.map(|channel| f64::from(channel) / 255.0))
    };
    Some((0..ENTRIES).step_by(EVERY).map(point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::interpolate;

    /// Half an 8-bit step for the rounded control points and half for the expected values, and as much again for the distance between
    /// lines and curve.
    const ROUNDED: f64 = 2.0 / 255.0;

    #[test]
    fn all_entries_lie_on_the_lines_between() {
        for (name, gradient) in MAPS {
            let points = colors(name).unwrap();
            assert_eq!((points[0].0, points[points.len() - 1].0), (0.0, 1.0));
            for entry in 0..ENTRIES {
                let mix = |a: [f64; 3], b: [f64; 3], t: f64| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
                let between: [f64; 3] = interpolate(&points, entry as f64 / 255.0, mix);
                let own = gradient.eval_rational(entry, ENTRIES).as_array();
                for (between, own) in between.into_iter().zip(own) {
                    assert!((between - f64::from(own) / 255.0).abs() <= ROUNDED, "{name} at {entry}: {between} for {own}");
                }
            }
        }
    }

    /// First, middle and last colours, from matplotlib 3.10.
    #[test]
    fn names_are_those_of_other_libraries() {
        for (name, first, last) in [
            ("inferno", [0, 0, 4], [252, 255, 164]),
            ("magma", [0, 0, 4], [252, 253, 191]),
            ("plasma", [13, 8, 135], [240, 249, 33]),
            ("Blues", [247, 251, 255], [8, 48, 107]),
            ("RdBu", [103, 0, 31], [5, 48, 97]),
        ] {
            let points = colors(name).unwrap();
            for (point, expected) in [(points[0], first), (points[points.len() - 1], last)] {
                for c in 0..3 {
                    assert!((point.1[c] * 255.0 - f64::from(expected[c])).abs() <= 1.0, "{name}: {point:?} for {expected:?}");
                }
            }
        }
        assert!(colors("jet").is_none() && MAPS.iter().all(|(name, _)| *name == name.to_ascii_lowercase()));
    }
}
