//! Palettes of automatic transfer functions. Their colours differ in hue and in lightness, and light does not burn them out: the default
//! shading multiplies a colour by up to 0.9 and adds up to 0.3 of white, so a colour with a channel of at most `DIMMEST` never becomes
//! white.

use crate::error::Error;

type Color = [f64; 3];

/// Upper limit of the smallest channel of each colour.
#[cfg(test)]
pub(super) const DIMMEST: f64 = 0.7;

/// Colours for any number of classes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Palette {
    pub name: &'static str,
    /// The colour of a single material.
    single: Color,
    /// Colours of several materials, the innermost first.
    materials: [Color; 6],
    /// Colours of nested shells of a smooth field, from the outermost to the innermost.
    shells: [Color; 3],
}

/// The palettes; the first is the default.
const PALETTES: [Palette; 4] = [
    Palette {
        name: "calm",
        single: [0.73, 0.67, 0.57],
        materials: [
            [0.79, 0.68, 0.47],
            [0.66, 0.42, 0.33],
            [0.36, 0.55, 0.72],
            [0.62, 0.84, 0.80],
            [0.36, 0.18, 0.42],
            [0.14, 0.36, 0.30],
        ],
        shells: [[0.38, 0.52, 0.86], [0.25, 0.66, 0.60], [0.93, 0.76, 0.38]],
    },
    Palette {
        name: "vivid",
        single: [0.20, 0.58, 0.68],
        materials: [
            [0.97, 0.84, 0.30],
            [0.13, 0.42, 0.80],
            [0.86, 0.36, 0.12],
            [0.45, 0.85, 0.80],
            [0.40, 0.10, 0.48],
            [0.08, 0.36, 0.22],
        ],
        shells: [[0.38, 0.16, 0.56], [0.13, 0.56, 0.56], [0.96, 0.87, 0.25]],
    },
    Palette {
        name: "tissue",
        single: [0.80, 0.58, 0.48],
        materials: [
            [0.79, 0.68, 0.47],
            [0.62, 0.24, 0.20],
            [0.90, 0.66, 0.62],
            [0.40, 0.46, 0.70],
            [0.36, 0.14, 0.32],
            [0.10, 0.26, 0.22],
        ],
        shells: [[0.42, 0.20, 0.24], [0.80, 0.44, 0.34], [0.94, 0.84, 0.62]],
    },
    Palette {
        name: "grey",
        single: [0.64; 3],
        materials: [[0.70; 3], [0.475; 3], [0.27; 3], [0.585; 3], [0.37; 3], [0.17; 3]],
        shells: [[0.28; 3], [0.48; 3], [0.70; 3]],
    },
];

impl Palette {
    /// The palette of a name.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if there is none.
    pub fn named(name: &str) -> Result<Self, Error> {
        PALETTES.into_iter().find(|palette| palette.name == name).ok_or_else(|| Error::UnknownName {
            what: "palette",
            name: name.into(),
            known: names().collect::<Vec<_>>().join(", "),
        })
    }

    /// Colours of `count` materials, from the outermost to the innermost.
    pub fn materials(&self, count: usize) -> Vec<Color> {
        match count {
            1 => vec![self.single],
            _ => (0..count).rev().map(|n| self.materials[n % self.materials.len()]).collect(),
        }
    }

    /// Colours of `count` nested shells, from the outermost to the innermost.
    pub fn shells(&self, count: usize) -> Vec<Color> {
        if count == 1 {
            return vec![self.single];
        }
        let at = |n: usize| {
            let position = n as f64 / (count - 1) as f64 * (self.shells.len() - 1) as f64;
            let first = (position as usize).min(self.shells.len() - 2);
            let (a, b, t) = (self.shells[first], self.shells[first + 1], position - first as f64);
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
        };
        (0..count).map(at).collect()
    }
}

impl Default for Palette {
    fn default() -> Self {
        PALETTES[0]
    }
}

/// The palettes' names and colours of materials, from the innermost.
pub(super) fn colors() -> impl Iterator<Item = (&'static str, [Color; 6])> {
    PALETTES.iter().map(|palette| (palette.name, palette.materials))
}

pub(super) fn names() -> impl Iterator<Item = &'static str> {
    PALETTES.iter().map(|palette| palette.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::format::lab;

    /// Simulations of colour vision without long- and without medium-wave cones, for linear RGB (Viénot, Brettel & Mollon 1999).
    const DEFICIENCIES: [[[f64; 3]; 3]; 2] = [
        [[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]],
        [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]],
    ];

    fn seen_with(matrix: [[f64; 3]; 3], color: Color) -> Color {
        let linear = color.map(|c| c.powf(2.2));
        matrix.map(|row| (0..3).map(|c| row[c] * linear[c]).sum::<f64>().clamp(0.0, 1.0).powf(1.0 / 2.2))
    }

    /// Distance in CIELAB.
    fn difference(a: Color, b: Color) -> f64 {
        let (a, b) = (lab(a), lab(b));
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    }

    /// Smallest difference in CIELAB of two colours that stand for different things; 2.3 is just noticeable.
    const DISTINCT: f64 = 10.0;

    #[test]
    fn colours_are_distinct_for_all_observers() {
        for palette in PALETTES {
            for colors in (2..=6).map(|count| palette.materials(count)).chain((2..=3).map(|count| palette.shells(count))) {
                for (n, &a) in colors.iter().enumerate() {
                    for &b in &colors[..n] {
                        let all = DEFICIENCIES.map(|matrix| difference(seen_with(matrix, a), seen_with(matrix, b)));
                        let least = all.into_iter().fold(difference(a, b), f64::min);
                        assert!(least > DISTINCT, "{}: {a:?} and {b:?} differ by {least}", palette.name);
                    }
                }
            }
        }
        // Red and green of the same lightness are alike to those without medium-wave cones.
        let [red, green] = [[0.75, 0.35, 0.2], [0.45, 0.53, 0.2]].map(|color| seen_with(DEFICIENCIES[1], color));
        assert!(difference(red, green) < DISTINCT, "{}", difference(red, green));
    }

    #[test]
    fn light_burns_no_colour_out() {
        for palette in PALETTES {
            for color in palette.materials.iter().chain(&palette.shells).chain([&palette.single]) {
                assert!(color.iter().copied().fold(1.0, f64::min) <= DIMMEST, "{}: {color:?}", palette.name);
            }
        }
        assert_eq!(Palette::named("calm").unwrap(), Palette::default());
        assert!(Palette::named("pink").unwrap_err().to_string().contains("vivid"));
    }
}
