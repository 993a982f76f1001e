//! Quality presets.

use super::{Classification, Evaluation, Footprints, LayerAxis, Layered, Settings};
use crate::choice::choices;
use crate::layers::{Correction, Density, Kernel};
use serde::{Deserialize, Serialize};

/// Quality presets.
///
/// `draft`, `standard` and `high` are pre-integrated: closer to the integral than splat sums with sub-layers, in a third of the time
/// (docs/dev/fidelity.md, docs/dev/performance.md).
///
/// ```
/// use layersplat::{Quality, Settings};
///
/// assert_eq!("high".parse::<Quality>()?, Quality::High);
/// assert_eq!(Quality::Standard.settings(), Settings::default());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(into = "&'static str", try_from = "String")]
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

choices! { Quality, "quality"; Draft = "draft", Standard = "standard", High = "high", Paper = "paper" }

impl Quality {
    /// Classification after interpolation, with the best correction for the rendering time of this preset.
    pub const fn splatted(self) -> Classification {
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
    pub const fn layered(self) -> Layered {
        const fn lattice(density: Density, kernel: Kernel, samples_per_layer: u32) -> (Evaluation, Footprints, Classification) {
            (Evaluation::Lattice(density), Footprints::Exact, Classification::Preintegrated { kernel, samples_per_layer })
        }
        let (evaluation, footprints, classification) = match self {
            Quality::Draft => lattice(Density::Fixed(1), Kernel::Cubic, 1),
            Quality::Standard => lattice(Density::Relaxed, Kernel::Cubic, 1),
            Quality::High => lattice(Density::Fine, Kernel::BSpline, 2),
            Quality::Paper => (Evaluation::Direct, Footprints::Set, self.splatted()),
        };
        Layered { layer_axis: LayerAxis::Auto, evaluation, classification, footprints, adapts_to_opacity: true }
    }
}
