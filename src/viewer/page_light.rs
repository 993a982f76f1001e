//! Lights and the studio, as the page changes them.

use crate::settings::{Light, LightSpace, Sky, Studio, WHITE};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A light.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PageLight {
    /// Direction towards the light; `None`: at the camera.
    pub direction: Option<[f64; 3]>,
    /// 0 … 100.
    pub strength: f64,
    /// Angular diameter in degrees, 0 … 45.
    pub angle: f64,
    /// Red, green and blue, 0 … 1. Links of earlier versions have none: white.
    #[serde(default = "white")]
    pub color: [f64; 3],
}

/// The studio as the page changes it. Its lights are those of the look.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PageStudio {
    /// Direction in which up is for the sky, along the axes of the lights.
    pub sky_up: [f64; 3],
    /// Factor of the light that scatters again, 0 … 1.
    pub scattering: f64,
    /// Exposure in stops, −20 … 20.
    pub exposure: f64,
}

fn white() -> [f64; 3] {
    WHITE
}

impl PageLight {
    pub(super) fn of(light: &Light) -> Self {
        let Light { strength, angle, color, .. } = *light;
        Self { direction: light.direction.map(|d| d.to_array()), strength, angle, color }
    }

    pub(super) fn light(&self) -> Light {
        let direction = self.direction.map(DVec3::from_array);
        Light { direction, strength: self.strength, angle: self.angle, color: self.color, ..Light::AT_CAMERA }
    }
}

impl PageStudio {
    /// The studio of settings.
    pub fn of(studio: &Studio) -> Self {
        Self { sky_up: studio.sky.up.to_array(), scattering: studio.scattering, exposure: studio.exposure }
    }

    /// The studio of the page over what it does not change.
    pub(super) fn over(&self, base: Studio, space: LightSpace) -> Studio {
        let sky = Sky { up: self.sky_up.into(), space, ..base.sky };
        Studio { sky, scattering: self.scattering, exposure: self.exposure, ..base }
    }
}
