//! Lights.

use crate::objects::Object;
use crate::status::Problem;
use layersplat::glam::{DMat3, DVec3};
use layersplat::settings::{Light, Lights};
use std::f64::consts::PI;

/// The luminance of a linear colour (ITU-R BT.709).
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// The light of an object, turned by the linear part of its instance's transform.
///
/// # Errors
/// A direction of length 0.
pub fn directional(object: &Object, turn: DMat3, problems: &mut Vec<Problem>) -> Result<Light, Problem> {
    let vector = object.floats::<3>(c"direction").unwrap_or([0.0, 0.0, -1.0]);
    let direction = turn * DVec3::from_array(vector.map(f64::from));
    if direction.try_normalize().is_none() {
        return Err(Problem::argument(format!("the direction of the light is {vector:?}: it gives no light")));
    }
    let color = object.floats::<3>(c"color").unwrap_or([1.0; 3]);
    if color.iter().any(|c| *c != color[0]) {
        problems.push(Problem::argument("lights are white here: the luminance of the light's colour counts"));
    }
    let diameter = f64::from(object.float(c"angularDiameter").unwrap_or(0.0));
    let strength = luminance(color) * irradiance(object, diameter);
    let light = Light { strength: strength.min(100.0), angle: diameter.to_degrees().min(45.0), ..Light::towards(-direction) };
    Ok(light)
}

/// Irradiance counts before radiance, which needs a solid angle.
fn irradiance(object: &Object, diameter: f64) -> f64 {
    let irradiance = f64::from(object.float(c"irradiance").unwrap_or(1.0));
    match object.float(c"radiance").map(f64::from) {
        Some(radiance) if object.committed.get(c"irradiance").is_none() && diameter > 0.0 => {
            radiance * PI * (diameter / 2.0).sin().powi(2)
        }
        _ => irradiance,
    }
}

/// The strongest lights, as many as the library takes. `None` without any light.
pub fn strongest(mut lights: Vec<Light>, problems: &mut Vec<Problem>) -> Option<Lights> {
    lights.retain(|light| light.strength > 0.0);
    if lights.len() > Lights::MOST {
        let text = format!("{} lights: the {} strongest are taken", lights.len(), Lights::MOST);
        problems.push(Problem::argument(text));
        lights.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        lights.truncate(Lights::MOST);
    }
    Lights::new(&lights).ok()
}
