//! Bundles of settings.

use super::{Classification, Evaluation, Footprints, LayerAxis, Layered, Settings};
use crate::layers::{Correction, Density, Kernel};
use serde::Serialize;
use std::str::FromStr;

/// Bundles of settings.
///
/// `draft`, `standard` and `high` are pre-integrated: nearer to the integral than splat sums with sub-layers, in a third
/// of the time (docs/fidelity.md, docs/performance.md).
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
    /// [`Density::Relaxed`], one sample per layer: what is best for the time.
    #[default]
    Standard,
    /// [`Density::Fine`], two samples per layer, of the interpolating B-spline: 3 to 6 dB nearer to what was sampled (docs/kernels.md).
    High,
    /// The paper to the letter: per pixel, its footprint set, constant κ.
    Paper,
}

impl Quality {
    /// Classification after interpolation, with the correction that is best for the time of this bundle.
    pub fn splatted(self) -> Classification {
        Classification::Post(match self {
            Quality::Draft | Quality::Paper => Correction::Constant,
            Quality::Standard => Correction::SubLayers(2),
            Quality::High => Correction::SubLayers(4),
        })
    }

    /// The settings of the bundle: layered rendering.
    pub fn settings(self) -> Settings {
        self.layered().into()
    }

    /// The choices of layered rendering in the bundle.
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
        Layered { layer_axis: LayerAxis::Auto, evaluation, classification, footprints }
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "draft" => Ok(Quality::Draft),
            "standard" => Ok(Quality::Standard),
            "high" => Ok(Quality::High),
            "paper" => Ok(Quality::Paper),
            _ => Err(format!("unknown quality '{name}': use draft, standard, high or paper")),
        }
    }
}
