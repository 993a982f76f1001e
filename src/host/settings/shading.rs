//! Shading.

use super::lights::{Lights, WHITE, check_color};
use super::number::{ABOVE_0, Number};
use super::studio::{Look, Studio};
use crate::error::Error;

/// Two-sided Blinn–Phong shading from the gradient of the reconstructed field.
///
/// Colours are multiplied by ambient × its colour + diffuse × Σ strength × colour × |n · l| over the lights. Specular highlights add up
/// likewise. The result is clamped to 1. Where the gradient is too weak for a normal, colours stay as they are under white lights, and
/// otherwise are multiplied by the mean colour of all light.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::settings::{Light, Lights, Settings, Shading};
///
/// let left = Light::towards(DVec3::new(-1.0, 0.5, 1.0));
/// let from_the_left = Shading { lights: Lights::new(&[left])?, ..Shading::default() };
/// let settings = Settings { shading: Some(from_the_left), ..Settings::default() };
/// assert_ne!(settings, Settings { shading: None, ..settings });
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Ambient factor, 0 … 100.
    pub ambient: f64,
    /// Red, green and blue of the ambient light, 0 … 1. White by default.
    pub ambient_color: [f64; 3],
    /// Diffuse factor, 0 … 100.
    pub diffuse: f64,
    /// Specular factor of the highlights, which have the colours of the lights, 0 … 100.
    pub specular: f64,
    /// Specular exponent, > 0 and ≤ 10000.
    pub power: f64,
    /// Lights. Default: a headlight at the camera.
    pub lights: Lights,
}

impl Default for Shading {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Shading {
    pub(super) const DEFAULT: Self =
        Self { ambient: 0.2, ambient_color: WHITE, diffuse: 0.7, specular: 0.3, power: 20.0, lights: Lights::AT_CAMERA };
    /// Range of the ambient, the diffuse and the specular factor.
    pub const FACTOR: Number = Number::new("shading", 0.0, 100.0, "ambient, diffuse and specular factors from 0 to 100");
    /// Range of the specular exponent.
    pub const POWER: Number = Number::new("shading", ABOVE_0, 1e4, "a power above 0 and at most 10000");

    /// Checks all ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        check_color("ambient_color", self.ambient_color)?;
        [self.ambient, self.diffuse, self.specular].into_iter().try_for_each(|factor| Self::FACTOR.check(factor))?;
        Self::POWER.check(self.power)
    }

    /// The shading of a look if nothing is given; the plain look has other lights with shadows.
    pub fn default_of(look: Look, shadows: bool) -> Self {
        match look {
            Look::Plain => Self { lights: Lights::default_with(shadows), ..Self::DEFAULT },
            Look::Studio => Studio::SHADING,
        }
    }

    /// Whether all lights are white, the ambient light included.
    #[doc(hidden)]
    pub fn is_white(&self) -> bool {
        self.ambient_color == WHITE && self.lights.as_slice().iter().all(|light| light.color == WHITE)
    }

    /// Shares of the ambient light and of each light in a colour without shading. None without any light.
    #[doc(hidden)]
    pub fn shares(&self) -> Option<(f64, [f64; Lights::MOST])> {
        let lights = self.lights.as_slice();
        let diffuse = std::array::from_fn(|n| lights.get(n).map_or(0.0, |light| self.diffuse * light.strength));
        let sum = self.ambient + diffuse.iter().sum::<f64>();
        (sum > 0.0).then(|| (self.ambient / sum, diffuse.map(|part| part / sum)))
    }

    /// Factor of a colour where gradients are too weak for shading and no light is dimmed: the mean colour of all light.
    #[doc(hidden)]
    pub fn unshaded_color(&self) -> [f64; 3] {
        let Some((ambient, shares)) = self.shares() else { return WHITE };
        let lights = self.lights.as_slice();
        std::array::from_fn(|i| {
            ambient * self.ambient_color[i] + lights.iter().zip(shares).map(|(light, share)| share * light.color[i]).sum::<f64>()
        })
    }
}
