//! Shading and gradient opacity of a sample.

use super::field::Field;
use super::shadow_rays::Reached;
use crate::settings::{GradientOpacity, Settings, Shading};
use crate::transfer::Extinction;
use crate::volume::Volume;
use glam::DVec3;

/// Least magnitude of a gradient.
const LEAST_LENGTH: f64 = 1e-10;

/// Settings that depend on gradients, and the light that reaches a sample.
#[derive(Clone, Copy)]
pub(super) struct ShadingInputs {
    pub shading: Option<Shading>,
    pub gradient_opacity: Option<GradientOpacity>,
    pub extinction: Extinction,
    pub reached: Reached,
}

impl ShadingInputs {
    pub fn from_settings(settings: &Settings) -> Self {
        Self {
            shading: settings.shading,
            gradient_opacity: settings.gradient_opacity,
            extinction: settings.extinction,
            reached: Reached::ALL,
        }
    }

    /// For a sample that less light reaches.
    pub fn lit_by(self, reached: Reached) -> Self {
        Self { reached, ..self }
    }

    /// Colour and opacity of a sample; the gradient is per voxel, `to_eye` in grid axes.
    pub fn at(
        self,
        volume: &Volume,
        gradient: impl FnOnce() -> DVec3,
        to_eye: DVec3,
        color: [f64; 3],
        opacity: f64,
    ) -> ([f64; 3], f64) {
        if self.shading.is_none() && self.gradient_opacity.is_none() {
            return (color, opacity);
        }
        let lighting = Lighting::new(volume, self, gradient(), to_eye);
        (lighting.on(color), lighting.thinned(opacity, self.extinction))
    }
}

/// Constant term of the interpolation weight of lighting, for kernels with analytic gradients: kernels/shared/span_lighting.cl.
const EVEN: f64 = 0.2;

/// Mean of |n.l| where the normal is unknown: kernels/shared/shading.cl.
const MEAN_FACING: f64 = 0.75;

/// Share of lighting by a gradient of this length in value ranges per smallest spacing.
fn fade(length: f64) -> f64 {
    let fade = ((length - 1e-3) * 1e3).clamp(0.0, 1.0);
    fade * fade * (3.0 - 2.0 * fade)
}

/// Lighting of a sample: factors of its red, green and blue, added highlights, interpolation weight (the root of the gradient's magnitude), and factor of its
/// extinction.
#[derive(Clone, Copy)]
pub(super) struct Lighting {
    factor: DVec3,
    highlight: DVec3,
    weight: f64,
    left: f64,
}

impl Lighting {
    const NONE: Self = Self { factor: DVec3::ONE, highlight: DVec3::ZERO, weight: 1e-5, left: 1.0 };

    /// Lighting without a normal: by the light that reaches the sample, as a share of all.
    fn unshaded(shading: Shading, Reached { lights, ambient }: Reached) -> DVec3 {
        let (mut sum, mut all) = (shading.ambient * ambient * DVec3::from(shading.ambient_color), shading.ambient);
        for (light, reached) in shading.lights.as_slice().iter().zip(lights) {
            sum += shading.diffuse * light.strength * reached * DVec3::from(light.color);
            all += shading.diffuse * light.strength;
        }
        if all > 0.0 { sum / all } else { DVec3::ONE }
    }

    /// Blinn–Phong lighting with the fade for weak gradients (math.md, "Conventions"). `gradient` is per voxel, `to_eye` in grid axes.
    pub fn new(volume: &Volume, look: ShadingInputs, gradient: DVec3, to_eye: DVec3) -> Self {
        let grid = volume.grid();
        let left = look.gradient_opacity.map_or(1.0, |opacity| opacity.at((gradient / grid.spacing()).length()));
        let gradient = gradient / grid.spacing() / volume.description().steepness();
        let weight = gradient.length().max(LEAST_LENGTH).sqrt();
        let Some(shading) = look.shading else { return Self { weight, left, ..Self::NONE } };
        let unshaded = Self::unshaded(shading, look.reached);
        let Some(normal) = gradient.try_normalize() else {
            return Self { factor: unshaded, left, ..Self::NONE };
        };
        let fade = fade(gradient.length());
        let Self { factor, highlight, .. } = Self::of_surface(volume, shading, look.reached, normal, to_eye);
        Self { factor: unshaded + fade * (factor - unshaded), highlight: fade * highlight, weight, left }
    }

    /// Blinn–Phong lighting by a certain normal of any length, in grid axes. Without one, by the light that reaches the sample.
    pub fn of_surface(volume: &Volume, shading: Shading, reached: Reached, normal: DVec3, to_eye: DVec3) -> Self {
        let Some(normal) = normal.try_normalize() else {
            return Self { factor: Self::unshaded(shading, reached), ..Self::NONE };
        };
        let (mut factor, mut highlight) = (shading.ambient * reached.ambient * DVec3::from(shading.ambient_color), DVec3::ZERO);
        for (light, reached) in shading.lights.as_slice().iter().zip(reached.lights) {
            let to_light = light.direction.map_or(to_eye, |l| volume.grid().world_to_grid_axes() * l.normalize());
            let half_way = (to_light + to_eye).normalize_or(to_eye);
            let light = light.strength * reached * DVec3::from(light.color);
            factor += shading.diffuse * light * normal.dot(to_light).abs();
            highlight += shading.specular * light * normal.dot(half_way).abs().powf(shading.power);
        }
        Self { factor, highlight, ..Self::NONE }
    }

    /// Lighting for a field. With analytic gradients, interpolation weights are more even.
    pub fn for_field(field: &Field, volume: &Volume, look: ShadingInputs, gradient: DVec3, to_eye: DVec3) -> Self {
        let lighting = Self::new(volume, look, gradient, to_eye);
        let even = if field.has_own_gradients() { EVEN } else { 0.0 };
        Self { weight: even + lighting.weight, ..lighting }
    }

    /// Lit in part by the gradient of this length in value ranges per smallest spacing, otherwise as beside the surface of another label: in so
    /// far as this label is seen `by_surface`, as by a mean normal.
    pub fn in_part(self, lit: f64, length: f64, by_surface: f64, look: ShadingInputs) -> Self {
        let Some(shading) = look.shading else { return self };
        let unlit = Self::unshaded(shading, look.reached);
        let mut beside = shading.ambient * look.reached.ambient * DVec3::from(shading.ambient_color);
        for (light, reached) in shading.lights.as_slice().iter().zip(look.reached.lights) {
            beside += shading.diffuse * light.strength * reached * DVec3::from(light.color) * MEAN_FACING;
        }
        let beside = unlit + by_surface * fade(length) * (beside - unlit);
        Self { factor: beside + lit * (self.factor - beside), highlight: lit * self.highlight, ..self }
    }

    /// Weighted interpolation with another sample.
    pub fn mix(self, other: Self, t: f64) -> Self {
        let even = t;
        let t = t * other.weight / ((1.0 - t) * self.weight + t * other.weight);
        Self {
            factor: self.factor.lerp(other.factor, t),
            highlight: self.highlight.lerp(other.highlight, t),
            weight: self.weight + t * (other.weight - self.weight),
            left: self.left + even * (other.left - self.left),
        }
    }

    /// Applies gradient opacity to an opacity.
    pub fn thinned(self, opacity: f64, extinction: Extinction) -> f64 {
        match extinction {
            Extinction::Exponential => 1.0 - (1.0 - opacity).powf(self.left),
            Extinction::Linear => opacity * self.left,
        }
    }

    /// Factor of the extinction, or of the opacity per unit distance.
    #[cfg(feature = "paper")]
    pub fn left(self) -> f64 {
        self.left
    }

    /// Applies lighting to a colour.
    pub fn on(self, color: [f64; 3]) -> [f64; 3] {
        (DVec3::from(color) * self.factor + self.highlight).min(DVec3::ONE).to_array()
    }
}
