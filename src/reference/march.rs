//! Ray casting and pre-integrated slicing from their definitions.

use super::compositing::{Gathered, opacity_of_depth, opacity_over, picture};
use super::field::Field;
use super::shading::shade;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Interpolation, Ray, Rays};
use crate::settings::{Algorithm, Settings};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Parts into which a slab of slicing is cut.
const PARTS: usize = 512;

/// Both ways of marching along rays in `f64`: no table, no culling, no early termination.
pub struct Marched<'a> {
    field: Field,
    volume: &'a Volume<'a>,
    transfer: &'a TransferFunction,
    settings: &'a Settings,
}

impl<'a> Marched<'a> {
    /// A renderer; the settings' algorithm is ray casting or slicing.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Self {
        Self { field: Field::new(volume, transfer), volume, transfer, settings }
    }

    /// The picture of a camera.
    ///
    /// # Panics
    /// With another algorithm.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        Ok(picture(viewport, |x, y| match self.settings.algorithm {
            Algorithm::Raycast { interpolation, step } => self.cast(&rays.at(x, y), interpolation, step, rays.to_eye),
            Algorithm::Slicing { step } => self.slice(&rays.at(x, y), step, rays.to_eye),
            other => panic!("{} does not march along rays", other.name()),
        }))
    }

    /// World size of a vector in voxels, in unit distances; and of the smallest spacing.
    fn lengths(&self, vector: DVec3) -> (f64, f64) {
        let spacing = self.volume.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(spacing.min_element());
        ((vector * spacing).length() / unit, spacing.min_element() / unit)
    }

    fn cast(&self, ray: &Ray, interpolation: Interpolation, step: f64, to_eye: DVec3) -> [f64; 4] {
        let mut gathered = Gathered::new();
        let Some((enter, leave)) = self.field.support(interpolation, ray) else {
            return gathered.rgba();
        };
        let (per_parameter, smallest) = self.lengths(ray.direction);
        let dt = step * smallest;
        let place = |n: i64| (n as f64 + 0.5) * dt / per_parameter;
        let first = (enter * per_parameter / dt).floor() as i64;
        for t in (first..).map(place).skip_while(|&t| t < enter).take_while(|&t| t < leave) {
            let p = ray.origin + ray.direction * t;
            let value = self.field.within_range(self.field.reconstructed(interpolation, p));
            if self.transfer.opacity(value) > 0.0 {
                let opacity = opacity_over(self.transfer, value, dt, self.settings.extinction);
                let mut color = self.transfer.color(value);
                if let Some(shading) = self.settings.shading {
                    color = shade(self.volume, shading, color, self.field.differences(interpolation, p), to_eye);
                }
                gathered.add(color, opacity);
            }
        }
        gathered.rgba()
    }

    fn slice(&self, ray: &Ray, step: f64, to_eye: DVec3) -> [f64; 4] {
        const KERNEL: Interpolation = Interpolation::Trilinear;
        let mut gathered = Gathered::new();
        let Some((enter, leave)) = self.field.support(KERNEL, ray) else {
            return gathered.rgba();
        };
        let spacing = self.volume.grid().spacing();
        let (per_parameter, smallest) = self.lengths(ray.direction);
        let depth_per_parameter = -(ray.direction * spacing).dot(to_eye);
        let between = step * spacing.min_element() / depth_per_parameter;
        let background = self.transfer.opacity(self.field.background()) > 0.0;
        let mut n = (enter / between).floor();
        while n * between < leave {
            let (from, to) = ((n * between).max(ray.start), (n + 1.0) * between);
            n += 1.0;
            let middle = (from + to) / 2.0;
            if background && !(enter..=leave).contains(&middle) {
                continue;
            }
            let [p, q] = [from, to].map(|t| ray.origin + ray.direction * t);
            let values = [p, q].map(|p| self.field.reconstructed(KERNEL, p));
            let Some((extinction, mut color)) = slab(self.transfer, values, step * smallest, self.settings.extinction) else {
                continue;
            };
            let opacity = opacity_of_depth(extinction * (to - from) * per_parameter, self.settings.extinction);
            if let Some(shading) = self.settings.shading {
                let [g, h] = [p, q].map(|p| self.field.differences(KERNEL, p));
                color = shade(self.volume, shading, color, (g + h) / 2.0, to_eye);
            }
            gathered.add(color, opacity);
        }
        gathered.rgba()
    }
}

/// Mean extinction of a slab over which the value changes evenly, and its colour, for a slab of one thickness.
fn slab(transfer: &TransferFunction, [from, to]: [f64; 2], thickness: f64, extinction: Extinction) -> Option<(f64, [f64; 3])> {
    let parts = if from == to { 1 } else { PARTS };
    let share = thickness / parts as f64;
    let mut gathered = Gathered::new();
    let (mut sum, mut weighted) = (0.0, [0.0; 3]);
    for i in 0..parts {
        let value = from + (to - from) * (i as f64 + 0.5) / parts as f64;
        let color = transfer.color(value);
        let part = match extinction {
            Extinction::Exponential => transfer.extinction(value).min(1e6),
            Extinction::Linear => transfer.opacity(value),
        };
        sum += part;
        gathered.add(color, -(-part * share).exp_m1());
        weighted = std::array::from_fn(|c| weighted[c] + part * color[c]);
    }
    let [r, g, b, a] = gathered.rgba();
    (sum > 0.0).then(|| match extinction {
        Extinction::Exponential => (sum / parts as f64, [r / a, g / a, b / a]),
        Extinction::Linear => (sum / parts as f64, weighted.map(|c| c / sum)),
    })
}
