//! Light sources.

use crate::error::Error;
use glam::DVec3;

/// A white directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// World direction towards the light, of any length above 0; `None` for a headlight at the camera.
    pub direction: Option<DVec3>,
    /// Factor of its diffuse and specular light, 0 … 100.
    pub strength: f64,
}

impl Light {
    /// A headlight of strength 1.
    pub const AT_CAMERA: Self = Self { direction: None, strength: 1.0 };

    /// A light of strength 1 from a world direction.
    pub fn towards(direction: DVec3) -> Self {
        Self { direction: Some(direction), strength: 1.0 }
    }

    fn check(&self) -> Result<(), Error> {
        let refuse = |value: String, expected| Err(Error::OutOfRange { name: "light", value, expected });
        match self.direction {
            Some(direction) if direction.try_normalize().is_none() => {
                refuse(direction.to_string(), "a finite vector other than 0")
            }
            _ if !(0.0..=100.0).contains(&self.strength) => refuse(self.strength.to_string(), "a strength from 0 to 100"),
            _ => Ok(()),
        }
    }
}

/// One to four lights whose contributions add up. Default: a headlight.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::settings::{Light, Lights};
///
/// let key = Light::towards(DVec3::new(-1.0, 1.0, 1.0));
/// let fill = Light { strength: 0.3, ..Light::AT_CAMERA };
/// assert_eq!(Lights::new(&[key, fill])?.as_slice().len(), 2);
/// assert!(Lights::new(&[Light::towards(DVec3::ZERO)]).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lights {
    count: usize,
    lights: [Light; Self::MOST],
}

impl Default for Lights {
    fn default() -> Self {
        Self::AT_CAMERA
    }
}

impl Lights {
    /// Largest number of lights.
    pub const MOST: usize = 4;
    /// A headlight of strength 1.
    pub const AT_CAMERA: Self = Self { count: 1, lights: [Light::AT_CAMERA; Self::MOST] };

    /// Creates a list of one to four lights.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for another number of lights, a direction that is 0 or not finite, or a strength outside 0 … 100.
    pub fn new(lights: &[Light]) -> Result<Self, Error> {
        if !(1..=Self::MOST).contains(&lights.len()) {
            return Err(Error::OutOfRange {
                name: "light",
                value: format!("{} lights", lights.len()),
                expected: "1 to 4 lights",
            });
        }
        lights.iter().try_for_each(Light::check)?;
        // Unused entries are arbitrary, but must compare equal.
        Ok(Self { count: lights.len(), lights: std::array::from_fn(|i| lights.get(i).copied().unwrap_or(Light::AT_CAMERA)) })
    }

    /// The lights, in the given order.
    pub fn as_slice(&self) -> &[Light] {
        &self.lights[..self.count]
    }
}
