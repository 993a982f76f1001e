//! Presets by kind of data.

use super::{ControlPoint, TransferFunction, Value, hounsfield};
use crate::error::Error;
use crate::volume::Volume;

/// What the values of a preset are.
#[derive(Clone, Copy, PartialEq)]
enum Scale {
    /// Hounsfield units.
    Hounsfield,
    /// 0 for the smallest value and 1 for nearly the largest.
    Share,
}

/// Values that CT scanners store in 12 bits: presets in Hounsfield units are stretched from here onto data in other units.
const CT_RANGE: (f64, f64) = (-1024.0, 3071.0);
/// Percentile at which presets of shares end; few voxels are much brighter.
const BRIGHT: f64 = 99.9;

struct Preset {
    name: &'static str,
    shows: &'static str,
    scale: Scale,
    colors: &'static [ControlPoint<[f64; 3]>],
    opacities: &'static [ControlPoint<f64>],
}

const BONE: [f64; 3] = [0.86, 0.79, 0.62];
const MUSCLE: [f64; 3] = [0.66, 0.27, 0.22];
const SKIN: [f64; 3] = [0.84, 0.62, 0.50];

const PRESETS: [Preset; 8] = [
    Preset {
        name: "ct-bone",
        shows: "CT: bone alone",
        scale: Scale::Hounsfield,
        colors: &[(-1024.0, [0.72, 0.52, 0.38]), (180.0, [0.72, 0.52, 0.38]), (450.0, BONE), (3071.0, [0.92, 0.88, 0.70])],
        opacities: &[(-1024.0, 0.0), (150.0, 0.0), (280.0, 0.3), (500.0, 0.85), (3071.0, 0.95)],
    },
    Preset {
        name: "ct-soft",
        shows: "CT: skin and organs, translucent before bone",
        scale: Scale::Hounsfield,
        colors: &[(-1024.0, SKIN), (-60.0, SKIN), (0.0, MUSCLE), (130.0, MUSCLE), (260.0, BONE), (3071.0, BONE)],
        opacities: &[
            (-1024.0, 0.0),
            (-420.0, 0.0),
            (-250.0, 0.05),
            (-120.0, 0.012),
            (-20.0, 0.02),
            (40.0, 0.14),
            (140.0, 0.16),
            (300.0, 0.7),
            (3071.0, 0.9),
        ],
    },
    Preset {
        name: "ct-lung",
        shows: "CT: lungs with vessels and airways",
        scale: Scale::Hounsfield,
        colors: &[
            (-1024.0, [0.36, 0.55, 0.72]),
            (-880.0, [0.36, 0.55, 0.72]),
            (-600.0, [0.80, 0.52, 0.46]),
            (-200.0, [0.72, 0.24, 0.20]),
            (150.0, [0.72, 0.24, 0.20]),
            (400.0, BONE),
            (3071.0, BONE),
        ],
        opacities: &[
            (-1024.0, 0.0),
            (-930.0, 0.0),
            (-850.0, 0.012),
            (-650.0, 0.02),
            (-520.0, 0.15),
            (-350.0, 0.15),
            (-150.0, 0.004),
            (200.0, 0.004),
            (500.0, 0.04),
            (3071.0, 0.1),
        ],
    },
    Preset {
        name: "ct-angio",
        shows: "CT with contrast agent: vessels and bone",
        scale: Scale::Hounsfield,
        colors: &[
            (-1024.0, [0.62, 0.16, 0.13]),
            (220.0, [0.72, 0.18, 0.14]),
            (420.0, [0.84, 0.34, 0.22]),
            (650.0, BONE),
            (3071.0, BONE),
        ],
        opacities: &[(-1024.0, 0.0), (130.0, 0.0), (220.0, 0.25), (350.0, 0.7), (700.0, 0.8), (3071.0, 0.9)],
    },
    Preset {
        name: "mr",
        shows: "MR: tissue by brightness",
        scale: Scale::Share,
        colors: &[(0.0, [0.45, 0.38, 0.42]), (0.3, [0.62, 0.48, 0.46]), (0.6, [0.78, 0.68, 0.58]), (1.0, [0.86, 0.82, 0.68])],
        opacities: &[(0.0, 0.0), (0.15, 0.0), (0.3, 0.05), (0.55, 0.2), (1.0, 0.5)],
    },
    Preset {
        name: "mr-angio",
        shows: "MR angiography: the brightest vessels",
        scale: Scale::Share,
        colors: &[(0.0, [0.45, 0.12, 0.12]), (0.4, [0.68, 0.18, 0.15]), (0.75, [0.85, 0.42, 0.26]), (1.0, [0.90, 0.72, 0.45])],
        opacities: &[(0.0, 0.0), (0.35, 0.0), (0.5, 0.12), (0.75, 0.6), (1.0, 0.9)],
    },
    Preset {
        name: "microscopy",
        shows: "fluorescence microscopy: bright stain, faint surroundings",
        scale: Scale::Share,
        colors: &[(0.0, [0.04, 0.22, 0.24]), (0.3, [0.08, 0.48, 0.42]), (0.7, [0.36, 0.78, 0.42]), (1.0, [0.88, 0.93, 0.58])],
        opacities: &[(0.0, 0.0), (0.08, 0.0), (0.25, 0.02), (0.6, 0.15), (1.0, 0.6)],
    },
    Preset {
        name: "simulation",
        shows: "simulated fields: low values faint, high values solid",
        scale: Scale::Share,
        colors: &[(0.0, [0.22, 0.26, 0.62]), (0.35, [0.18, 0.58, 0.66]), (0.65, [0.86, 0.74, 0.36]), (1.0, [0.78, 0.26, 0.18])],
        opacities: &[(0.0, 0.0), (0.05, 0.0), (0.2, 0.015), (0.5, 0.06), (0.8, 0.3), (1.0, 0.7)],
    },
];

/// All names, for error messages.
pub(super) fn listed() -> String {
    PRESETS.iter().map(|preset| preset.name).collect::<Vec<_>>().join(", ")
}

impl TransferFunction {
    /// Names of the presets by kind of data, each with what it shows.
    pub fn presets() -> impl Iterator<Item = (&'static str, &'static str)> {
        PRESETS.iter().map(|preset| (preset.name, preset.shows))
    }

    /// A preset by kind of data: one of [`TransferFunction::presets`]. Those of CT are in Hounsfield units where the volume's values are
    /// (air near −1000, soft tissue around 0), and otherwise stretched from −1024 … 3071 onto the volume's range. The others are stretched
    /// from the smallest value to percentile 99.9.
    ///
    /// ```
    /// use layersplat::{OpenOptions, TransferFunction, Volume};
    ///
    /// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
    /// assert!(TransferFunction::preset("simulation", &volume)?.opacity(255.0) > 0.0);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::UnknownName`] if the name does not exist.
    pub fn preset(name: &str, volume: &Volume) -> Result<Self, Error> {
        let Some(preset) = PRESETS.iter().find(|preset| preset.name == name) else {
            return Err(Error::UnknownName { what: "preset", name: name.into(), known: listed() });
        };
        let transfer = Self::new(name, preset.colors.to_vec(), preset.opacities.to_vec())?;
        let (lo, hi) = super::visible_range::visible_range(volume);
        match preset.scale {
            Scale::Hounsfield if hounsfield::is_ct(&volume.overview().statistics(), volume.overview()) => Ok(transfer),
            Scale::Hounsfield => {
                debug_assert_eq!(transfer.range(), CT_RANGE);
                transfer.stretched(lo, hi)
            }
            Scale::Share => {
                let bright = Value::finder(volume)(Value::Percentile(BRIGHT));
                transfer.stretched(lo, if bright > lo { bright } else { hi })
            }
        }
    }

    pub(super) fn is_preset(name: &str) -> bool {
        PRESETS.iter().any(|preset| preset.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn presets_span_their_scale_and_are_not_burnt_out() {
        for preset in &PRESETS {
            let transfer = TransferFunction::new(preset.name, preset.colors.to_vec(), preset.opacities.to_vec()).unwrap();
            let scale = if preset.scale == Scale::Hounsfield { CT_RANGE } else { (0.0, 1.0) };
            assert_eq!(transfer.range(), scale, "{}", preset.name);
            assert_eq!(transfer.opacity(scale.0), 0.0, "{}", preset.name);
            for (_, color) in preset.colors {
                assert!(
                    color.iter().copied().fold(1.0, f64::min) <= crate::transfer::palettes::DIMMEST,
                    "{}: {color:?}",
                    preset.name
                );
            }
        }
    }

    #[test]
    fn presets_of_ct_are_stretched_unless_values_are_hounsfield_units() {
        let grid = Grid::new([8, 8, 8], DVec3::ONE).unwrap();
        let head: Vec<i16> = (0..512).map(|n| [-1000, 40, -1000, 700][n % 4]).collect();
        let volume = Volume::new("head", grid.clone(), head.clone()).unwrap();
        let bone = TransferFunction::preset("ct-bone", &volume).unwrap();
        assert!(bone.opacity(40.0) == 0.0 && bone.opacity(700.0) > 0.8);
        // The same numbers from 0 on, in bytes: nothing there is a Hounsfield unit.
        let bytes: Vec<u8> = head.iter().map(|&v| ((i32::from(v) + 1024) / 16) as u8).collect();
        let stretched = TransferFunction::preset("ct-bone", &Volume::new("bytes", grid, bytes).unwrap()).unwrap();
        assert_eq!(stretched.range(), (1.0, 107.0));
        assert!(TransferFunction::preset("ct-brain", &volume).unwrap_err().to_string().contains("ct-lung"));
    }
}
