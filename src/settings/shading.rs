//! How what is seen is lit.

use super::lights::Lights;
use crate::error::Error;

/// Blinn-Phong with white lights, two-sided, from the gradient of the splat sums. A colour is multiplied by ambient + diffuse × the sum over
/// the lights of strength × |n · l|; highlights add up like that; what is seen ends at 1.
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
    /// Share of the colour that needs no light.
    pub ambient: f64,
    /// Share that depends on the angles to the lights.
    pub diffuse: f64,
    /// Strength of the white highlights.
    pub specular: f64,
    /// Its exponent, > 0.
    pub power: f64,
    /// Default: one at the camera.
    pub lights: Lights,
}

impl Default for Shading {
    fn default() -> Self {
        Self { ambient: 0.2, diffuse: 0.7, specular: 0.3, power: 20.0, lights: Lights::AT_CAMERA }
    }
}

impl Shading {
    /// Checks every number.
    pub(super) fn check(&self) -> Result<(), Error> {
        let good = [self.ambient, self.diffuse, self.specular].iter().all(|c| (0.0..=100.0).contains(c));
        if good && self.power > 0.0 && self.power <= 1e4 {
            return Ok(());
        }
        Err(Error::OutOfRange {
            name: "shading",
            value: format!("{},{},{},{}", self.ambient, self.diffuse, self.specular, self.power),
            expected: "ambient, diffuse and specular from 0 to 100, power above 0 and at most 10000",
        })
    }
}
