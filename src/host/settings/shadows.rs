//! Shadows and ambient occlusion.

use super::number::{ABOVE_0, Number};
use crate::choice::choices;
use crate::error::Error;

/// Shadows of the lights: the light that reaches a sample is dimmed by what lies between the sample and the light.
///
/// The transmittance T to a light is swept through the volume once per light and transfer function, and looked up by each sample. A light
/// at the camera casts no visible shadow and is not swept: its transmittance counts as 1.
///
/// Dense matter shadows itself, which darkens every lit surface. The first part of the optical depth is therefore forgiven:
/// T′ = min(1, `forgiveness`·T). Samples use T″ = 1 − `strength`·(1 − T′).
///
/// ```
/// use layersplat::settings::{Lights, Settings, Shading, Shadows};
///
/// let lights = Lights::BESIDE_CAMERA;
/// let shading = Some(Shading { lights, ..Shading::default() });
/// let settings = Settings { shading, shadows: Some(Shadows::default()), ..Settings::default() };
/// assert_eq!(settings.shadows.unwrap().forgiveness, 4.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadows {
    /// Share of the shadows, 0 … 1. It applies to look-ups: changing it needs no new sweep.
    pub strength: f64,
    /// Factor of the transmittance, 1 … 1000. 1 is exact single scattering.
    pub forgiveness: f64,
}

impl Default for Shadows {
    fn default() -> Self {
        Self { strength: 1.0, forgiveness: 4.0 }
    }
}

impl Shadows {
    /// Range of the strength.
    pub const STRENGTH: Number = Number::new("shadow_strength", 0.0, 1.0, "a strength from 0 to 1");
    /// Range of the forgiveness.
    pub const FORGIVENESS: Number = Number::new("shadow_forgiveness", 1.0, 1000.0, "a factor from 1 to 1000");

    /// Checks both ranges.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), Error> {
        Self::STRENGTH.check(self.strength)?;
        Self::FORGIVENESS.check(self.forgiveness)
    }
}

/// Ambient occlusion: the ambient part of the light is dimmed where little of the surroundings is open.
///
/// The openness O is the mean transmittance over all directions, from 14 sweeps. The ambient light is multiplied by
/// A = min(1, `gain`·O).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// World distance over which occlusion decreases to 1/e; `None`: no limit.
    pub reach: Option<f64>,
    /// Factor of the openness, 1 … 1000. Default: 3, since a point of an opaque plane sees half of the sky at most.
    pub gain: f64,
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        Self { reach: None, gain: 3.0 }
    }
}

impl AmbientOcclusion {
    /// Range of the reach.
    pub const REACH: Number = Number::new("ao_reach", ABOVE_0, f64::MAX, "inf or a length above 0");
    /// Range of the gain.
    pub const GAIN: Number = Number::new("ambient_occlusion", 1.0, 1000.0, "a factor from 1 to 1000");

    /// Checks both ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.reach.map_or(Ok(()), |reach| Self::REACH.check(reach))?;
        Self::GAIN.check(self.gain)
    }
}

/// Resolution of the light volumes of shadows and ambient occlusion.
///
/// Below full resolution, surfaces that are nearly parallel to the light show contour rings: it is meant for frames that follow the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightGrid {
    /// One value per voxel.
    #[default]
    Full,
    /// One value per 2³ voxels.
    Half,
    /// One value per 4³ voxels, for ambient occlusion. Shadows have half the resolution then.
    Quarter,
}

choices! { LightGrid, "light_grid"; Full = "full", Half = "half", Quarter = "quarter" }

impl LightGrid {
    /// Voxels per value and axis, of ambient occlusion.
    #[doc(hidden)]
    pub fn voxels(self) -> usize {
        match self {
            LightGrid::Full => 1,
            LightGrid::Half => 2,
            LightGrid::Quarter => 4,
        }
    }
}
