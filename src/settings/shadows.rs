//! Shadows and ambient occlusion.

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
    /// Factor of the transmittance, 1 … 1000. 1 is exact single scattering. Up to 2 it applies to look-ups and needs no new sweep.
    pub forgiveness: f64,
}

impl Default for Shadows {
    fn default() -> Self {
        Self { strength: 1.0, forgiveness: 4.0 }
    }
}

impl Shadows {
    /// Checks both ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        let Shadows { strength, forgiveness } = *self;
        if !(0.0..=1.0).contains(&strength) {
            let expected = "a strength from 0 to 1";
            return Err(Error::OutOfRange { name: "shadow_strength", value: strength.to_string(), expected });
        }
        if !(1.0..=1000.0).contains(&forgiveness) {
            let expected = "a factor from 1 to 1000";
            return Err(Error::OutOfRange { name: "shadow_forgiveness", value: forgiveness.to_string(), expected });
        }
        Ok(())
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
    /// Checks both ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        if let Some(reach) = self.reach.filter(|reach| !(*reach > 0.0 && reach.is_finite())) {
            let expected = "a finite length above 0, or inf";
            return Err(Error::OutOfRange { name: "ao_reach", value: reach.to_string(), expected });
        }
        if !(1.0..=1000.0).contains(&self.gain) {
            let expected = "a factor from 1 to 1000";
            return Err(Error::OutOfRange { name: "ambient_occlusion", value: self.gain.to_string(), expected });
        }
        Ok(())
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

impl LightGrid {
    /// All resolutions, from the finest.
    pub const ALL: [Self; 3] = [Self::Full, Self::Half, Self::Quarter];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            LightGrid::Full => "full",
            LightGrid::Half => "half",
            LightGrid::Quarter => "quarter",
        }
    }

    /// Voxels per value and axis, of ambient occlusion.
    pub(crate) fn voxels(self) -> usize {
        match self {
            LightGrid::Full => 1,
            LightGrid::Half => 2,
            LightGrid::Quarter => 4,
        }
    }
}
