//! Built-in transfer functions, over 0 … 1.

use super::TransferFunction;
use crate::error::Error;

pub(super) const NAMES: [&str; 4] = ["grey", "fire", "viridis", "cool-warm"];

/// Opacity rises slowly from a tenth of the range on, so that what is faint does not hide what is inside.
const OPACITY: [(f64, f64); 4] = [(0.0, 0.0), (0.1, 0.0), (0.5, 0.05), (1.0, 0.5)];

pub(super) fn named(name: &str) -> Result<TransferFunction, Error> {
    let colors: &[(f64, [f64; 3])] = match name {
        "grey" => &[(0.0, [0.0; 3]), (1.0, [1.0; 3])],
        "fire" => &[(0.0, [0.1, 0.0, 0.0]), (0.4, [0.9, 0.1, 0.0]), (0.75, [1.0, 0.75, 0.1]), (1.0, [1.0; 3])],
        "viridis" => &[
            (0.0, [0.267, 0.005, 0.329]),
            (0.25, [0.230, 0.322, 0.546]),
            (0.5, [0.128, 0.567, 0.551]),
            (0.75, [0.369, 0.789, 0.383]),
            (1.0, [0.993, 0.906, 0.144]),
        ],
        "cool-warm" => &[(0.0, [0.23, 0.30, 0.75]), (0.5, [0.87, 0.87, 0.87]), (1.0, [0.71, 0.016, 0.15])],
        _ => {
            return Err(Error::UnknownName { what: "transfer function", name: name.into(), known: NAMES.join(", ") });
        }
    };
    TransferFunction::new(name, colors.to_vec(), OPACITY.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_names_span_zero_to_one() {
        for name in NAMES {
            assert_eq!(named(name).unwrap().range(), (0.0, 1.0));
        }
        assert!(named("pink").is_err());
    }

    #[test]
    fn red_green_and_blue_half_way_between_two_points() {
        for (name, value, expected) in [
            ("fire", 0.575, [0.95, 0.425, 0.05]),
            ("viridis", 0.125, [0.2485, 0.1635, 0.4375]),
            ("cool-warm", 0.25, [0.55, 0.585, 0.81]),
        ] {
            let color = named(name).unwrap().color(value);
            assert!((0..3).all(|c| (color[c] - expected[c]).abs() < 1e-12), "{name}: {color:?}");
        }
    }
}
