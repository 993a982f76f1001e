//! Light sources.

use super::number::Number;
use crate::camera::Camera;
use crate::choice::choices;
use crate::error::Error;
use glam::DVec3;

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction towards the light, of any length above 0; `None` for a headlight at the camera.
    pub direction: Option<DVec3>,
    /// Coordinates of the direction.
    pub space: LightSpace,
    /// Factor of its diffuse and specular light, 0 … 100.
    pub strength: f64,
    /// Angular diameter in degrees, 0 … 45: how soft the edges of its shadows are. Shading treats it as a point at infinity.
    pub angle: f64,
    /// Red, green and blue, 0 … 1: factors of its diffuse and specular light. White by default.
    pub color: [f64; 3],
}

/// White, as red, green and blue.
#[doc(hidden)]
pub const WHITE: [f64; 3] = [1.0; 3];

/// Checks that red, green and blue are from 0 to 1.
pub(super) fn check_color(name: &'static str, color: [f64; 3]) -> Result<(), Error> {
    if color.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Ok(());
    }
    Err(Error::OutOfRange { name, value: format!("{color:?}"), expected: "red, green and blue from 0 to 1" })
}

/// Coordinates of the direction to a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSpace {
    /// World axes: the light stays in the world while the camera moves.
    #[default]
    World,
    /// (right, up, towards the viewer): the light moves with the camera.
    Camera,
}

choices! { LightSpace, "light_space"; World = "world", Camera = "camera" }

impl Light {
    /// Range of the strength.
    pub const STRENGTH: Number = Number::new("light", 0.0, 100.0, "a strength from 0 to 100");
    /// Range of the angular diameter.
    pub const ANGLE: Number = Number::new("light", 0.0, 45.0, "an angular diameter from 0 to 45 degrees");
    /// A white headlight of strength 1.
    pub const AT_CAMERA: Self = Self { direction: None, space: LightSpace::World, strength: 1.0, angle: 0.0, color: WHITE };

    /// A white light of strength 1 from a world direction.
    pub const fn towards(direction: DVec3) -> Self {
        Self { direction: Some(direction), ..Self::AT_CAMERA }
    }

    /// A white light of strength 1 that moves with the camera, from a direction (right, up, towards the viewer).
    pub const fn from_camera(direction: DVec3) -> Self {
        Self { space: LightSpace::Camera, ..Self::towards(direction) }
    }

    /// The light that stays in the world where `camera` sees it. A headlight stays a headlight.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn in_world(self, camera: &Camera) -> Result<Self, Error> {
        let LightSpace::Camera = self.space else { return Ok(self) };
        let basis = camera.basis()?;
        Ok(Self { direction: self.direction.map(|l| basis.in_world(l)), space: LightSpace::World, ..self })
    }

    fn check(&self) -> Result<(), Error> {
        if let Some(direction) = self.direction.filter(|direction| direction.try_normalize().is_none()) {
            let expected = "a finite vector other than 0";
            return Err(Error::OutOfRange { name: "light", value: direction.to_string(), expected });
        }
        Self::STRENGTH.check(self.strength)?;
        Self::ANGLE.check(self.angle)?;
        check_color("light", self.color)
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
    /// A light of strength 1 beside and above the camera, with which shadows are visible: from (−1, 1, 1) in camera space.
    pub const BESIDE_CAMERA: Self = {
        let mut lights = [Light::AT_CAMERA; Self::MOST];
        lights[0] = Light::from_camera(DVec3::new(-1.0, 1.0, 1.0));
        Self { count: 1, lights }
    };

    /// Two lights.
    pub(super) const fn of_two(one: Light, other: Light) -> Self {
        let mut lights = [Light::AT_CAMERA; Self::MOST];
        lights[0] = one;
        lights[1] = other;
        Self { count: 2, lights }
    }

    /// The lights of the plain look if none are given. A light at the camera casts no visible shadow.
    pub const fn default_with(shadows: bool) -> Self {
        if shadows { Self::BESIDE_CAMERA } else { Self::AT_CAMERA }
    }

    /// Creates a list of one to four lights.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for another number of lights, a direction that is 0 or not finite, or a number outside its range.
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

    /// The lights that stay in the world where `camera` sees them.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn in_world(mut self, camera: &Camera) -> Result<Self, Error> {
        for light in &mut self.lights[..self.count] {
            *light = light.in_world(camera)?;
        }
        Ok(self)
    }

    /// The lights, in the given order.
    pub fn as_slice(&self) -> &[Light] {
        &self.lights[..self.count]
    }
}
