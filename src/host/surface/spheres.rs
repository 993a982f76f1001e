//! Spheres.

use super::triangles::check_points;
use crate::error::Error;
use glam::DVec3;

/// Spheres in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Spheres {
    centres: Vec<DVec3>,
    radii: Vec<f64>,
}

impl Spheres {
    /// Spheres of these radii. Those of radius 0 show nothing.
    ///
    /// # Errors
    /// If there is not one radius per centre, a centre is not finite, or a radius is negative or not finite.
    pub fn new(centres: Vec<DVec3>, radii: Vec<f64>) -> Result<Self, Error> {
        check_points(&centres)?;
        check_radii("spheres", &radii, centres.len())?;
        Ok(Self { centres, radii })
    }

    /// Centres in the world.
    pub fn centres(&self) -> &[DVec3] {
        &self.centres
    }

    /// A radius per centre.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }
}

pub(super) fn check_radii(name: &str, radii: &[f64], points: usize) -> Result<(), Error> {
    let error = |problem| Err(Error::Surface { name: name.into(), problem });
    if radii.len() != points {
        return error(format!("{} radii for {points} points", radii.len()));
    }
    match radii.iter().position(|radius| !(radius.is_finite() && *radius >= 0.0)) {
        Some(n) => error(format!("radius {n} is {}: a radius is 0 or positive", radii[n])),
        None => Ok(()),
    }
}
