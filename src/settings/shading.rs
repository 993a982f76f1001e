//! How what is seen is lit.

use crate::error::Error;
use glam::DVec3;

/// Blinn-Phong with one white light, two-sided, from the gradient of the splat sums.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::settings::{Settings, Shading};
///
/// let from_the_left = Shading { light: Some(DVec3::new(-1.0, 0.5, 1.0)), ..Shading::default() };
/// let settings = Settings { shading: Some(from_the_left), ..Settings::default() };
/// assert_ne!(settings, Settings { shading: None, ..settings });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Share of the colour that needs no light.
    pub ambient: f64,
    /// Share that depends on the angle to the light.
    pub diffuse: f64,
    /// Strength of the white highlight.
    pub specular: f64,
    /// Its exponent, > 0.
    pub power: f64,
    /// Direction to the light in world coordinates; `None`: the light is at the camera.
    pub light: Option<DVec3>,
}

impl Default for Shading {
    fn default() -> Self {
        Self { ambient: 0.2, diffuse: 0.7, specular: 0.3, power: 20.0, light: None }
    }
}

impl Shading {
    /// Checks every number.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse = |name, value: &dyn ToString, expected| Err(Error::OutOfRange { name, value: value.to_string(), expected });
        let good = [self.ambient, self.diffuse, self.specular].iter().all(|c| (0.0..=100.0).contains(c));
        if !(good && self.power > 0.0 && self.power <= 1e4) {
            let value = format!("{},{},{},{}", self.ambient, self.diffuse, self.specular, self.power);
            return refuse("shading", &value, "ambient, diffuse and specular from 0 to 100, power above 0 and at most 10000");
        }
        match self.light {
            Some(light) if light.try_normalize().is_none() => refuse("light", &light, "a finite vector other than 0"),
            _ => Ok(()),
        }
    }
}
