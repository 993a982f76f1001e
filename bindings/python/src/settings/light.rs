//! Arguments of shading, lights, shadows and ambient occlusion.

use crate::argument::{accepted, either, extracted, refused};
use crate::errors::{Result, unknown};
use layersplat::settings::{AmbientOcclusion, Light, LightSpace, Lights, Shading, Shadows};
use pyo3::Borrowed;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Values by name.
type Values<'py> = BTreeMap<String, Bound<'py, PyAny>>;

/// Shading on or off, or its coefficients.
pub enum Lighting<'py> {
    Switch(bool),
    Coefficients(Values<'py>),
}

/// Shadows on or off, their strength, or strength and forgiveness by name.
pub enum Shadowing<'py> {
    Switch(bool),
    Strength(f64),
    Coefficients(Values<'py>),
}

/// Ambient occlusion on or off, or its coefficients.
pub enum Occluding<'py> {
    Switch(bool),
    Coefficients(Values<'py>),
}

accepted! {
    Lighting<'py>: "True, False, or a dict of ambient, ambient_color, diffuse, specular, power and light";
    Shadowing<'py>: "True, False, a strength from 0 to 1, or a dict of strength and forgiveness";
    Occluding<'py>: "True, False, or a dict of reach and gain";
}

impl<'a, 'py> FromPyObject<'a, 'py> for Lighting<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Lighting::Switch, Lighting::Coefficients)
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Shadowing<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        // Switches first: they are numbers too.
        match object.extract() {
            Ok(on) => Ok(Shadowing::Switch(on)),
            Err(_) => either(object, Shadowing::Strength, Shadowing::Coefficients),
        }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Occluding<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Occluding::Switch, Occluding::Coefficients)
    }
}

impl Lighting<'_> {
    /// Missing coefficients keep their defaults. `lights` are used if none are given; `space` has the axes of given ones.
    pub fn shading(self, lights: Lights, space: LightSpace) -> Result<Option<Shading>> {
        let mut shading = Shading { lights, ..Shading::default() };
        let numbers = match self {
            Lighting::Switch(on) => return Ok(on.then_some(shading)),
            Lighting::Coefficients(numbers) => numbers,
        };
        for (name, value) in numbers {
            match name.as_str() {
                "ambient_color" => shading.ambient_color = extracted("shading['ambient_color']", &value)?,
                "ambient" => shading.ambient = extracted("shading['ambient']", &value)?,
                "diffuse" => shading.diffuse = extracted("shading['diffuse']", &value)?,
                "specular" => shading.specular = extracted("shading['specular']", &value)?,
                "power" => shading.power = extracted("shading['power']", &value)?,
                "light" => shading.lights = given_lights(&value, space)?,
                other => return Err(unknown("shading", other, "ambient, ambient_color, diffuse, specular, power or light")),
            }
        }
        Ok(Some(shading))
    }
}

impl Shadowing<'_> {
    /// Missing coefficients keep their defaults.
    pub fn shadows(self) -> Result<Option<Shadows>> {
        let mut shadows = Shadows::default();
        match self {
            Shadowing::Switch(on) => return Ok(on.then_some(shadows)),
            Shadowing::Strength(strength) => shadows.strength = strength,
            Shadowing::Coefficients(numbers) => {
                for (name, value) in numbers {
                    match name.as_str() {
                        "strength" => shadows.strength = extracted("shadows['strength']", &value)?,
                        "forgiveness" => shadows.forgiveness = extracted("shadows['forgiveness']", &value)?,
                        other => return Err(unknown("shadows", other, "strength or forgiveness")),
                    }
                }
            }
        }
        Ok(Some(shadows))
    }
}

impl Occluding<'_> {
    /// Missing coefficients keep their defaults.
    pub fn occlusion(self) -> Result<Option<AmbientOcclusion>> {
        let mut occlusion = AmbientOcclusion::default();
        let numbers = match self {
            Occluding::Switch(on) => return Ok(on.then_some(occlusion)),
            Occluding::Coefficients(numbers) => numbers,
        };
        for (name, value) in numbers {
            match name.as_str() {
                "reach" => {
                    let reach = extracted("ambient_occlusion['reach']", &value)?;
                    occlusion.reach = Some(reach).filter(|&reach| reach != f64::INFINITY);
                }
                "gain" => occlusion.gain = extracted("ambient_occlusion['gain']", &value)?,
                other => return Err(unknown("ambient_occlusion", other, "reach or gain")),
            }
        }
        Ok(Some(occlusion))
    }
}

/// A light: a direction or None, optionally with a strength, with an angular diameter too, and with a colour too.
fn light(value: &Bound<'_, PyAny>, space: LightSpace) -> PyResult<Light> {
    let Light { strength, angle, color, .. } = Light::AT_CAMERA;
    let (direction, strength, angle, color): (Option<[f64; 3]>, _, _, _) = if let Ok(all) = value.extract() {
        all
    } else if let Ok((direction, strength, angle)) = value.extract() {
        (direction, strength, angle, color)
    } else if let Ok((direction, strength)) = value.extract() {
        (direction, strength, angle, color)
    } else {
        (value.extract()?, strength, angle, color)
    };
    // A light at the camera has no direction whose axes could matter.
    let space = direction.map_or(LightSpace::World, |_| space);
    Ok(Light { direction: direction.map(Into::into), space, strength, angle, color })
}

/// One light, or a list of lights.
fn given_lights(value: &Bound<'_, PyAny>, space: LightSpace) -> Result<Lights> {
    let several = |error: PyErr| match value.extract::<Vec<Bound<'_, PyAny>>>() {
        Ok(several) => several.iter().map(|value| light(value, space)).collect(),
        Err(_) => Err(error),
    };
    let lights = light(value, space).map(|one| vec![one]).or_else(several);
    let accepted = "a direction (x, y, z), None, (direction, strength), (direction, strength, angle), (direction, strength, angle, (r, g, b)), or a \
         list of up to four of these";
    Ok(Lights::new(&lights.map_err(|error| refused("shading['light']", value, error, accepted))?)?)
}
