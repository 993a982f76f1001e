//! Light that reaches a point, marched along rays to the lights and to the sky. Light volumes on the device approximate it.

use super::compositing::opacity_of_depth;
use super::field::Field;
use super::interval::{Interval, Region};
use crate::layers::{Kernel, Ray};
use crate::settings::{LightSpace, Settings};
use crate::transfer::{Extinction, TransferFunction};
use crate::volume::{Grid, Volume};
use glam::{DAffine3, DVec3};

/// Step along shadow rays, in smallest spacings.
const STEP: f64 = 0.4;
/// Directions to the sky, and those that stand for a light of some angular diameter.
const SKY: usize = 48;
const DISC: usize = 32;
/// Optical depth from which nothing of the light is left.
const OPAQUE: f64 = 40.0;

/// The share of each light and of the ambient light that reaches a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reached {
    pub lights: [f64; 4],
    pub ambient: f64,
}

impl Reached {
    /// Nothing casts shadows.
    pub const ALL: Self = Self { lights: [1.0; 4], ambient: 1.0 };
}

/// Rays from samples to the lights, through the fields of a scene.
pub(super) struct ShadowRays<'a> {
    /// Points are in voxels of the first.
    absorbers: Vec<Absorber<'a>>,
    settings: &'a Settings,
}

/// A field that absorbs light.
struct Absorber<'a> {
    /// The field of the paper's cubic, in which light is swept on the device.
    field: Field,
    volume: &'a Volume<'a>,
    transfer: &'a TransferFunction,
    /// Factor of the extinction.
    factor: f64,
    region: Region,
    /// From voxels of the first field.
    to_voxels: DAffine3,
}

impl<'a> ShadowRays<'a> {
    /// Shadow rays for settings with shadows or ambient occlusion; `None` for others.
    ///
    /// # Panics
    /// If a light moves with the camera: convert it with [`crate::settings::Light::in_world`].
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Option<Self> {
        Self::through(&[(volume, transfer, 1.0)], settings)
    }

    /// The same through several fields, each with its transfer function and the factor of its extinction.
    pub fn through(fields: &[(&'a Volume<'a>, &'a TransferFunction, f64)], settings: &'a Settings) -> Option<Self> {
        if !settings.sweeps_light() {
            return None;
        }
        let lights = settings.shading.unwrap_or_default().lights;
        assert!(
            lights.as_slice().iter().all(|light| light.space == LightSpace::World),
            "the reference knows lights of the world only"
        );
        let absorber = |&(volume, transfer, factor): &(&'a Volume<'a>, &'a TransferFunction, f64)| {
            let field = Field::new(volume, transfer, settings.blend, Kernel::Cubic).with_gradient(settings.gradient_estimator());
            let region = Region::new(volume, transfer, settings.blend, &settings.clipping, f64::from(Kernel::Cubic.radius()));
            let (own, first) = (volume.grid(), fields[0].0.grid());
            let same = own == first;
            let to_voxels = if same { DAffine3::IDENTITY } else { own.index_to_world().inverse() * first.index_to_world() };
            Absorber { field, volume, transfer, factor, region, to_voxels }
        };
        Some(Self { absorbers: fields.iter().map(absorber).collect(), settings })
    }

    /// The light that reaches a point, given in voxels.
    pub fn reached(&self, point: DVec3) -> Reached {
        let mut reached = Reached::ALL;
        let (shadows, occlusion) = (self.settings.shadows, self.settings.ambient_occlusion);
        let lights = self.settings.shading.unwrap_or_default().lights;
        for (share, light) in reached.lights.iter_mut().zip(lights.as_slice()) {
            let (Some(shadows), Some(direction)) = (shadows, light.direction) else { continue };
            let to_light = self.grid().world_to_grid_axes() * direction.normalize();
            let directions = on_disc(to_light, light.angle);
            let mean = self.mean(point, &directions, None);
            *share = 1.0 - shadows.strength * (1.0 - (shadows.forgiveness * mean).min(1.0));
        }
        if let Some(occlusion) = occlusion {
            reached.ambient = (occlusion.gain * self.mean(point, &on_sphere(), occlusion.reach)).min(1.0);
        }
        reached
    }

    fn mean(&self, point: DVec3, directions: &[DVec3], reach: Option<f64>) -> f64 {
        directions.iter().map(|&direction| self.transmittance(point, direction, reach)).sum::<f64>() / directions.len() as f64
    }

    fn grid(&self) -> &Grid {
        self.absorbers[0].volume.grid()
    }

    /// Transmittance from a point towards a direction (unit vector in grid axes). With a reach, the shadow that light has gathered from afar
    /// is smaller by e^(−step/reach) after each step.
    fn transmittance(&self, point: DVec3, direction: DVec3, reach: Option<f64>) -> f64 {
        let spacing = self.grid().spacing();
        let ray = Ray { origin: point, direction: direction / spacing, start: 0.0 };
        let within: Vec<_> = self.absorbers.iter().map(|absorber| absorber.interval(&ray)).collect();
        let all = within.iter().flatten();
        let first = all.clone().map(|interval| interval.from).fold(f64::INFINITY, f64::min).max(0.0);
        let last = all.map(|interval| interval.to).fold(f64::NEG_INFINITY, f64::max);
        let step = STEP * spacing.min_element();
        let count = ((last - first) / step).ceil().max(0.0) as usize;
        let recovered = reach.map_or(1.0, |reach| (-step / reach).exp());
        let mut transmittance = 1.0;
        // From the light to the point, as light travels.
        for n in (0..count).rev() {
            let from = first + n as f64 * step;
            let length = (last - from).min(step);
            let t = from + length / 2.0;
            let place = ray.origin + ray.direction * t;
            let met =
                self.absorbers.iter().zip(&within).filter(|(_, interval)| interval.is_some_and(|i| i.from <= t && t <= i.to));
            let depth = met.map(|(absorber, _)| absorber.depth(place, length, self.settings)).sum::<f64>();
            let left = 1.0 - opacity_of_depth(depth, self.settings.extinction);
            transmittance = 1.0 - recovered * (1.0 - transmittance * left);
            if transmittance < (-OPAQUE).exp() && reach.is_none() {
                return 0.0;
            }
        }
        transmittance
    }
}

impl Absorber<'_> {
    /// Where a ray, in voxels of the first field, is within this one.
    fn interval(&self, ray: &Ray) -> Option<Interval> {
        let (origin, direction) = (self.to_voxels.transform_point3(ray.origin), self.to_voxels.transform_vector3(ray.direction));
        let ray = Ray { origin, direction, ..*ray };
        self.field.support(&ray).and_then(|support| self.region.intersection(&ray)?.and(support))
    }

    /// Optical depth, or alpha times length, of a short step around a place. `length` is in the first field's world.
    fn depth(&self, place: DVec3, length: f64, settings: &Settings) -> f64 {
        let place = self.to_voxels.transform_point3(place);
        let value = self.field.classified(place);
        let opacity = self.transfer.opacity(value);
        if opacity == 0.0 {
            return 0.0;
        }
        let spacing = self.volume.grid().spacing();
        let length = length / settings.unit_distance.unwrap_or(self.volume.grid().unit());
        let left = settings.gradient_opacity.map_or(1.0, |thin| thin.at((self.field.gradient(place) / spacing).length()));
        let per_length = match settings.extinction {
            Extinction::Exponential => self.transfer.extinction(value),
            Extinction::Linear => opacity,
        };
        per_length * length * left * self.factor
    }
}

/// Points of a spiral, evenly over the unit sphere.
fn on_sphere() -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let point = |n: usize| {
        let z = 1.0 - (2.0 * n as f64 + 1.0) / SKY as f64;
        let (sin, cos) = (golden * n as f64).sin_cos();
        DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
    };
    (0..SKY).map(point).collect()
}

/// Directions evenly over a disc of some angular diameter in degrees.
fn on_disc(centre: DVec3, diameter: f64) -> Vec<DVec3> {
    if diameter == 0.0 {
        return vec![centre];
    }
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let (right, up) = centre.any_orthonormal_pair();
    let direction = |n: usize| {
        let radius = ((n as f64 + 0.5) / DISC as f64).sqrt() * (diameter.to_radians() / 2.0).tan();
        let (sin, cos) = (golden * n as f64).sin_cos();
        (centre + radius * (cos * right + sin * up)).normalize()
    };
    (0..DISC).map(direction).collect()
}
