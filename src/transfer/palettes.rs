//! Palettes of automatic transfer functions. Their colours differ in hue and in lightness, and light does not burn them out: the default
//! shading multiplies a colour by up to 0.9 and adds up to 0.3 of white, so a colour with a channel of at most [`DIMMEST`] never becomes
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
            [0.82, 0.71, 0.50],
            [0.36, 0.55, 0.72],
            [0.72, 0.35, 0.24],
            [0.53, 0.72, 0.52],
            [0.42, 0.22, 0.44],
            [0.12, 0.36, 0.36],
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
            [0.30, 0.72, 0.60],
            [0.45, 0.15, 0.50],
            [0.10, 0.32, 0.25],
        ],
        shells: [[0.38, 0.16, 0.56], [0.13, 0.56, 0.56], [0.96, 0.87, 0.25]],
    },
    Palette {
        name: "tissue",
        single: [0.80, 0.58, 0.48],
        materials: [
            [0.82, 0.71, 0.50],
            [0.66, 0.26, 0.22],
            [0.84, 0.62, 0.48],
            [0.36, 0.42, 0.62],
            [0.38, 0.18, 0.30],
            [0.20, 0.30, 0.28],
        ],
        shells: [[0.42, 0.20, 0.24], [0.80, 0.44, 0.34], [0.94, 0.84, 0.62]],
    },
    Palette {
        name: "grey",
        single: [0.64; 3],
        materials: [[0.70; 3], [0.47; 3], [0.31; 3], [0.58; 3], [0.20; 3], [0.39; 3]],
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

pub(super) fn names() -> impl Iterator<Item = &'static str> {
    PALETTES.iter().map(|palette| palette.name)
}
