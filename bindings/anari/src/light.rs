//! Lights.

use crate::objects::Object;
use crate::status::Problem;
use layersplat::glam::{DMat3, DVec3};
use layersplat::settings::{Light, Lights};
use std::f64::consts::PI;

/// The luminance of a linear colour (ITU-R BT.709).
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// A colour as its largest component and the colour of which that is 1. Negative components count as 0; black has white's hue.
pub fn strength_and_hue(color: [f32; 3]) -> (f64, [f64; 3]) {
    let color = color.map(|c| f64::from(c).max(0.0));
    let strength = color.into_iter().fold(0.0, f64::max);
    if strength > 0.0 { (strength, color.map(|c| c / strength)) } else { (0.0, [1.0; 3]) }
}

/// The light of an object, turned by the linear part of its instance's transform.
///
/// # Errors
/// A direction of length 0.
pub fn directional(object: &Object, turn: DMat3) -> Result<Light, Problem> {
    let vector = object.floats::<3>(c"direction").unwrap_or([0.0, 0.0, -1.0]);
    let direction = turn * DVec3::from_array(vector.map(f64::from));
    if direction.try_normalize().is_none() {
        return Err(Problem::argument(format!("the direction of the light is {vector:?}: it gives no light")));
    }
    let (share, color) = strength_and_hue(object.floats::<3>(c"color").unwrap_or([1.0; 3]));
    let diameter = f64::from(object.float(c"angularDiameter").unwrap_or(0.0));
    let strength = (share * irradiance(object, diameter)).min(100.0);
    Ok(Light { strength, angle: diameter.to_degrees().min(45.0), color, ..Light::towards(-direction) })
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
        let brightness = |light: &Light| light.strength * luminance(light.color);
        lights.sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
        lights.truncate(Lights::MOST);
    }
    Lights::new(&lights).ok()
}
