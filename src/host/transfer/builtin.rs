//! Built-in transfer functions, over values 0 … 1.

use super::{ControlPoint, TransferFunction, maps};
use crate::error::Error;

const NAMES: [&str; 4] = ["grey", "fire", "viridis", "cool-warm"];

/// Other names, after those of plotting libraries.
const ALIASES: [(&str, &str); 5] =
    [("gray", "grey"), ("grays", "greys"), ("coolwarm", "cool-warm"), ("jet", "turbo"), ("hot", "fire")];

/// Suffix of a reversed colour map.
const REVERSED: &str = "_r";

/// Names of the transfer functions defined here and of the colour maps. Each also accepts the suffix `_r`.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter().chain(maps::names())
}

/// All names, for error messages.
pub(super) fn listed() -> String {
    format!("{} (append {REVERSED} to reverse)", names().collect::<Vec<_>>().join(", "))
}

/// Opacity rises slowly above a tenth of the range, so that faint regions do not hide the interior.
const OPACITY: [(f64, f64); 4] = [(0.0, 0.0), (0.1, 0.0), (0.5, 0.05), (1.0, 0.5)];

/// The built-in transfer function `name`, over values 0 … 1. Case does not matter, and `_` stands for `-`.
pub(super) fn named(name: &str) -> Option<TransferFunction> {
    let name = name.to_lowercase();
    let (forward, is_reversed) = name.strip_suffix(REVERSED).map_or((&*name, false), |forward| (forward, true));
    let forward = forward.replace('_', "-");
    let forward = ALIASES.iter().find(|(alias, _)| *alias == forward).map_or(&*forward, |(_, name)| *name);
    let colors = colors(forward)?;
    let (name, colors) =
        if is_reversed { (format!("{forward}{REVERSED}"), turned_round(colors)) } else { (forward.to_owned(), colors) };
    Some(TransferFunction::new(&name, colors, OPACITY.to_vec()).expect("ascending"))
}

pub(super) fn unknown(name: &str) -> Error {
    Error::UnknownName { what: "transfer function", name: name.into(), known: nearest_first(name, names(), &listed()) }
}

/// Least Jaro–Winkler similarity of names that are suggested.
const SIMILAR: f64 = 0.8;

/// `listed`, behind the name that is most similar to an unknown one, if any is similar.
pub(super) fn nearest_first(unknown: &str, names: impl Iterator<Item = &'static str>, listed: &str) -> String {
    let unknown = unknown.to_lowercase();
    let similarity = |name: &str| strsim::jaro_winkler(&unknown, name);
    let nearest = names.max_by(|a, b| similarity(a).total_cmp(&similarity(b))).filter(|name| similarity(name) >= SIMILAR);
    nearest.map_or_else(|| listed.to_owned(), |nearest| format!("{nearest} (the nearest name), or one of {listed}"))
}

fn turned_round(colors: Vec<ControlPoint<[f64; 3]>>) -> Vec<ControlPoint<[f64; 3]>> {
    colors.into_iter().rev().map(|(value, color)| (1.0 - value, color)).collect()
}

/// Control points of the colours of `name`, over values 0 … 1.
fn colors(name: &str) -> Option<Vec<ControlPoint<[f64; 3]>>> {
    let points: &[ControlPoint<[f64; 3]>] = match name {
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
        _ => return maps::colors(name),
    };
    Some(points.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_names_span_zero_to_one() {
        for name in names() {
            for name in [name.to_owned(), format!("{name}_r")] {
                let named = named(&name).unwrap();
                assert_eq!((named.range(), named.name()), ((0.0, 1.0), &*name));
            }
        }
        for (name, expected) in
            [("Gray", "grey"), ("JET_r", "turbo_r"), ("hot", "fire"), ("cool_warm", "cool-warm"), ("CoolWarm_r", "cool-warm_r")]
        {
            assert_eq!(named(name).unwrap().name(), expected, "{name}");
        }
        assert!(
            unknown("virdis").to_string().contains("use viridis (the nearest name), or one of grey"),
            "{}",
            unknown("virdis")
        );
        assert!(!unknown("xyzzy").to_string().contains("nearest"));
        assert!(named("pink").is_none() && named("pink_r").is_none() && named("grey_r_r").is_none() && named("_r").is_none());
        assert!(unknown("pink").to_string().contains("viridis, cool-warm, inferno"));
    }

    #[test]
    fn turned_round_colours_run_the_other_way_and_opacity_does_not() {
        for name in names() {
            let (forward, back) = (named(name).unwrap(), named(&format!("{name}_r")).unwrap());
            for i in 0..=64 {
                // Exact in binary, like 1 less it.
                let value = f64::from(i) / 64.0;
                let (a, b) = (forward.color(value), back.color(1.0 - value));
                assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-12), "{name} at {value}: {a:?}, {b:?}");
                assert_eq!(forward.opacity(value), back.opacity(value));
            }
        }
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
