//! The studio: scattered light, a sky and a tone curve.

use super::lights::{Light, LightSpace, Lights};
use super::number::Number;
use super::shading::Shading;
use crate::camera::Camera;
use crate::choice::choices;
use crate::color::Tone;
use crate::error::Error;
use glam::DVec3;

/// How a picture is lit, and what its colours mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Look {
    /// Colours of the transfer function as they are, lit by [`Shading`].
    #[default]
    Plain,
    /// Colours are reflectances in linear light. A sky and lights shine into the volume, which scatters their light: [`Studio`].
    Studio,
}

choices! { Look, "look"; Plain = "plain", Studio = "studio" }

/// Light that scatters in the volume.
///
/// The volume is isotropically scattering matter of the albedo with which opaque matter reflects 0.9 times the linear colour. Radiance is
/// computed along 14 ordinates on a grid of cubic cells (kernels/light/scatter_sweep.cl). Where gradients are strong enough for a normal,
/// samples reflect light as a surface does.
///
/// ```
/// use layersplat::settings::{Look, Settings, Studio};
///
/// let settings = Settings::default().with_look(Look::Studio);
/// assert_eq!(settings.studio, Some(Studio::default()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Studio {
    /// The light that comes from all around.
    pub sky: Sky,
    /// Factor of the albedo in the light that cells scatter to each other, 0 … 1. 0: light is scattered once. 1: opaque matter under a sky
    /// reflects its colour; the default is a little less, since white matter with all of its light has little relief.
    pub scattering: f64,
    /// Curve of bright colours in pictures of 8 and 16 bits.
    pub tone: Tone,
    /// Exposure of these pictures in stops, −20 … 20: linear colours are multiplied by 2 to this power.
    pub exposure: f64,
}

impl Default for Studio {
    fn default() -> Self {
        Self { sky: Sky::default(), scattering: 0.95, tone: Tone::Shoulder, exposure: 0.0 }
    }
}

impl Studio {
    /// Range of the scattering.
    pub const SCATTERING: Number = Number::new("scattering", 0.0, 1.0, "a factor from 0 to 1");
    /// Range of the exposure.
    pub const EXPOSURE: Number = Number::new("exposure", -20.0, 20.0, "stops from -20 to 20");

    /// Shading of the studio: a key light and a rim light beside the camera. White that faces the key light is just below white in pictures. Of the coefficients, those of highlights count: the share of light
    /// that surfaces reflect as by a mirror, and the exponent.
    pub const SHADING: Shading = {
        let key = Light { strength: 1.03, color: [1.0, 0.952, 0.886], ..Light::from_camera(DVec3::new(-1.0, 1.1, 0.9)) };
        let rim = Light { strength: 0.4, color: [0.739, 0.826, 1.0], ..Light::from_camera(DVec3::new(1.2, 0.45, -0.5)) };
        Shading { specular: 0.2, power: 30.0, lights: Lights::of_two(key, rim), ..Shading::DEFAULT }
    };

    /// Checks all ranges.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), Error> {
        self.sky.check()?;
        Self::SCATTERING.check(self.scattering)?;
        Self::EXPOSURE.check(self.exposure)
    }
}

/// A sky: radiance by direction, in linear light. A white surface under a sky of 1 has 0.9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Red, green and blue above, 0 … 100.
    pub top: [f64; 3],
    /// Red, green and blue below, 0 … 100.
    pub bottom: [f64; 3],
    /// Factor of both, 0 … 100.
    pub strength: f64,
    /// Direction in which up is, of any length above 0.
    pub up: DVec3,
    /// Coordinates of this direction.
    pub space: LightSpace,
}

impl Default for Sky {
    fn default() -> Self {
        Self { top: [1.8, 1.93, 2.15], bottom: [0.45, 0.38, 0.3], strength: 0.28, up: DVec3::Y, space: LightSpace::Camera }
    }
}

impl Sky {
    /// Range of the strength and of colours.
    pub const STRENGTH: Number = Number::new("sky", 0.0, 100.0, "colours and a strength from 0 to 100");

    /// Radiance from a direction; `up` is its component along the direction in which up is, of unit vectors.
    pub fn radiance(&self, up: f64) -> DVec3 {
        let t = (0.5 + 0.5 * up).clamp(0.0, 1.0);
        let [bottom, top] = [self.bottom, self.top].map(DVec3::from_array);
        self.strength * bottom.lerp(top, t * t * (3.0 - 2.0 * t))
    }

    /// The sky, up in these coordinates: along the z axis of the world, or upwards in the picture.
    pub fn up_in(self, space: LightSpace) -> Self {
        let up = match space {
            LightSpace::World => DVec3::Z,
            LightSpace::Camera => DVec3::Y,
        };
        Self { up, space, ..self }
    }

    /// The sky that stays in the world where `camera` sees it.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn in_world(self, camera: &Camera) -> Result<Self, Error> {
        let LightSpace::Camera = self.space else { return Ok(self) };
        Ok(Self { up: camera.basis()?.in_world(self.up), space: LightSpace::World, ..self })
    }

    fn check(&self) -> Result<(), Error> {
        if self.up.try_normalize().is_none() {
            return Err(Error::OutOfRange { name: "sky", value: self.up.to_string(), expected: "a direction other than 0" });
        }
        let all = self.top.into_iter().chain(self.bottom).chain([self.strength]);
        all.into_iter().try_for_each(|number| Self::STRENGTH.check(number))
    }
}
