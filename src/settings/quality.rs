//! Quality presets.

use super::{Classification, Evaluation, Footprints, LayerAxis, Layered, Settings};
use crate::layers::{Correction, Density, Kernel};
use serde::Serialize;
use std::str::FromStr;

/// Quality presets.
///
/// `draft`, `standard` and `high` are pre-integrated: closer to the integral than splat sums with sub-layers, in a third of the time
/// (docs/dev/fidelity.md, docs/dev/performance.md).
///
/// ```
/// use layersplat::{Quality, Settings};
///
/// assert_eq!("high".parse::<Quality>(), Ok(Quality::High));
/// assert_eq!(Quality::Standard.settings(), Settings::default());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// One sample per voxel and layer: the fastest.
    Draft,
    /// [`Density::Relaxed`], one sample per layer: the best compromise of quality and time.
    #[default]
    Standard,
    /// [`Density::Fine`], two samples per layer, interpolating B-spline: 3 to 6 dB closer to the original signal (docs/dev/kernels.md).
    High,
    /// Exactly the paper's method: per pixel, with its footprint set and constant κ.
    Paper,
}

impl Quality {
    /// All presets.
    pub const ALL: [Self; 4] = [Quality::Draft, Quality::Standard, Quality::High, Quality::Paper];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::High => "high",
            Quality::Paper => "paper",
        }
    }

    /// Classification after interpolation, with the best correction for the rendering time of this preset.
    pub fn splatted(self) -> Classification {
        Classification::Post(match self {
            Quality::Draft | Quality::Paper => Correction::Constant,
            Quality::Standard => Correction::SubLayers(2),
            Quality::High => Correction::SubLayers(4),
        })
    }

    /// Settings of the preset, with layered rendering.
    pub fn settings(self) -> Settings {
        self.layered().into()
    }

    /// Options of layered rendering of the preset.
    pub fn layered(self) -> Layered {
        let lattice = |density, kernel, samples_per_layer| {
            (Evaluation::Lattice(density), Footprints::Exact, Classification::Preintegrated { kernel, samples_per_layer })
        };
        let (evaluation, footprints, classification) = match self {
            Quality::Draft => lattice(Density::Fixed(1), Kernel::Cubic, 1),
            Quality::Standard => lattice(Density::Relaxed, Kernel::Cubic, 1),
            Quality::High => lattice(Density::Fine, Kernel::BSpline, 2),
            Quality::Paper => (Evaluation::Direct, Footprints::Set, self.splatted()),
        };
        Layered { layer_axis: LayerAxis::Auto, evaluation, classification, footprints, adapts_to_opacity: true }
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Quality::ALL.into_iter().find(|quality| quality.name() == name);
        found.ok_or_else(|| format!("unknown quality '{name}': use draft, standard, high or paper"))
    }
}
