//! Shading.

use super::lights::Lights;
use crate::error::Error;

/// Two-sided Blinn–Phong shading with white lights, from the gradient of the reconstructed field.
///
/// Colours are multiplied by ambient + diffuse × Σ strength × |n · l| over the lights. Specular highlights add up likewise. The result is
/// clamped to 1.
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
    /// Diffuse factor, 0 … 100.
    pub diffuse: f64,
    /// Specular factor of the white highlights, 0 … 100.
    pub specular: f64,
    /// Specular exponent, > 0 and ≤ 10000.
    pub power: f64,
    /// Lights. Default: a headlight at the camera.
    pub lights: Lights,
}

impl Default for Shading {
    fn default() -> Self {
        Self { ambient: 0.2, diffuse: 0.7, specular: 0.3, power: 20.0, lights: Lights::AT_CAMERA }
    }
}

impl Shading {
    /// Checks all ranges.
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
