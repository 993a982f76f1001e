//! How a colour is lit.

use super::field::Field;
use crate::settings::Shading;
use crate::volume::Volume;
use glam::DVec3;

/// Length of a gradient that is none.
const LEAST_LENGTH: f64 = 1e-10;

/// What a colour is multiplied by, and what highlight is added to it; and what it counts in a mixture, the root of the gradient's length.
#[derive(Clone, Copy)]
pub(super) struct Lighting {
    factor: f64,
    highlight: f64,
    weight: f64,
}

impl Lighting {
    const NONE: Self = Self { factor: 1.0, highlight: 0.0, weight: 1e-5 };

    /// Blinn-Phong with the fade for weak gradients (math.md, "Conventions"). `gradient` in voxel differences; `to_eye` in the
    /// grid's axes.
    pub fn new(volume: &Volume, shading: Shading, gradient: DVec3, to_eye: DVec3) -> Self {
        let grid = volume.grid();
        let (lo, hi) = volume.range();
        let range = if hi > lo { hi - lo } else { 1.0 };
        let gradient = gradient * grid.spacing().min_element() / grid.spacing() / range;
        let Some(normal) = gradient.try_normalize() else {
            return Self::NONE;
        };
        let light = shading.light.map_or(to_eye, |l| grid.world_to_grid_axes() * l.normalize());
        let half_way = (light + to_eye).normalize_or(to_eye);
        let fade = ((gradient.length() - 1e-3) * 1e3).clamp(0.0, 1.0);
        let fade = fade * fade * (3.0 - 2.0 * fade);
        let factor = shading.ambient + shading.diffuse * normal.dot(light).abs();
        let highlight = shading.specular * normal.dot(half_way).abs().powf(shading.power);
        let weight = gradient.length().max(LEAST_LENGTH).sqrt();
        Self { factor: 1.0 + fade * (factor - 1.0), highlight: fade * highlight, weight }
    }

    /// The same, where gradients are the field's own: what is mixed with it counts evenly.
    pub fn of(field: &Field, volume: &Volume, shading: Shading, gradient: DVec3, to_eye: DVec3) -> Self {
        let lighting = Self::new(volume, shading, gradient, to_eye);
        if field.kernel().has_own_slope() { Self { weight: 1.0, ..lighting } } else { lighting }
    }

    /// Between this and another.
    pub fn mix(self, other: Self, t: f64) -> Self {
        let t = t * other.weight / ((1.0 - t) * self.weight + t * other.weight);
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self {
            factor: mix(self.factor, other.factor),
            highlight: mix(self.highlight, other.highlight),
            weight: mix(self.weight, other.weight),
        }
    }

    /// A colour in it.
    pub fn on(self, color: [f64; 3]) -> [f64; 3] {
        color.map(|c| (c * self.factor + self.highlight).min(1.0))
    }
}

/// A colour as lit by a gradient.
pub(super) fn shade(volume: &Volume, shading: Shading, color: [f64; 3], gradient: DVec3, to_eye: DVec3) -> [f64; 3] {
    Lighting::new(volume, shading, gradient, to_eye).on(color)
}
