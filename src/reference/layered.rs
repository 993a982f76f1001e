//! Layered splatting from its definition.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::shading::shade;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Axis, Correction, LayerSlabs, Ray, Rays, footprint};
use crate::settings::{Classification, Settings};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::{DVec2, DVec3};

/// The layered renderer in `f64`: every footprint integrated, no lattice, no table, no culling, no early termination.
pub struct Layered<'a> {
    pub(super) field: Field,
    pub(super) volume: &'a Volume<'a>,
    pub(super) transfer: &'a TransferFunction,
    pub(super) settings: &'a Settings,
    pub(super) classification: Classification,
    /// Whether pre-integrated segments are cut into fine parts, each dimmed by those before it, as the kernels approach for opaque
    /// transfer functions of several hues. Default: no.
    pub in_parts: bool,
}

/// A ray in the coordinates of its layer axis.
pub(super) struct Crossing {
    pub axis: Axis,
    pub origin: DVec3,
    pub shear: DVec2,
}

impl<'a> Layered<'a> {
    /// A renderer. Of the settings, those that decide where sums are evaluated and what is skipped are ignored.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Self {
        let classification = settings.layered().unwrap_or_default().classification;
        Self { field: Field::new(volume, transfer), volume, transfer, settings, classification, in_parts: false }
    }

    /// The picture of a camera, all rays with one layer axis, or each with its own.
    pub fn render(&self, camera: &Camera, viewport: Viewport, axis: Option<Axis>) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), axis, rays.to_eye)))
    }

    /// Premultiplied RGBA along one ray; `to_eye` is the central ray's direction back to the eye, in the grid's axes.
    pub fn composite(&self, ray: &Ray, axis: Option<Axis>, to_eye: DVec3) -> [f64; 4] {
        let axis = axis.unwrap_or_else(|| Axis::most_parallel(ray.direction));
        let frame = axis.frame();
        let shear = DVec2::from_array(frame.shear(ray.direction));
        let crossing = Crossing { axis, origin: frame.local(ray.origin), shear };
        match self.classification {
            Classification::Post(correction) => self.composite_splats(ray, &crossing, correction, to_eye),
            Classification::Preintegrated { samples_per_layer } => {
                self.composite_points(ray, &crossing, samples_per_layer, to_eye)
            }
        }
    }

    fn composite_splats(&self, ray: &Ray, crossing: &Crossing, correction: Correction, to_eye: DVec3) -> [f64; 4] {
        let frame = crossing.axis.frame();
        let dims = self.local_dims(crossing.axis);
        let samples = f64::from(correction.samples_per_layer());
        let dt = self.sample_length(crossing);
        let slabs = LayerSlabs::new(correction);

        let forward = ray.direction[frame.a] > 0.0;
        let order: Vec<i64> = if forward { (-1..=dims[2]).collect() } else { (-1..=dims[2]).rev().collect() };
        let step = if forward { 1 } else { -1 };
        let mut gathered = Gathered::new();
        for (n, &k) in order.iter().enumerate() {
            // Distance from the eye, in layers: what lies behind it is cut off.
            let from_eye = step as f64 * (k as f64 - crossing.origin.z - ray.start * ray.direction[frame.a]);
            if from_eye <= -0.5 || !self.in_support(crossing, k as f64) {
                continue;
            }
            let [before, own, after] = [k - step, k, k + step].map(|j| self.splat_sum(crossing, j, crossing.at(j as f64)));
            let samples_of_layer = match n {
                0 => &slabs.front,
                _ if n + 1 == order.len() => &slabs.back,
                _ => &slabs.inner,
            };
            let mut start = from_eye - if n == 0 { 0.0 } else { 0.5 };
            for slab in samples_of_layer {
                let end = start + slab.share / samples;
                let ahead = if start < 0.0 { (end / (end - start)).max(0.0) } else { 1.0 };
                start = end;
                let share = slab.share * ahead;
                let value = slab.before * before + slab.own * own + slab.after * after;
                if self.transfer.opacity(value) == 0.0 {
                    continue;
                }
                let opacity = match self.settings.extinction {
                    Extinction::Exponential => -(-self.transfer.extinction(value) * dt * share).exp_m1(),
                    Extinction::Linear => (self.transfer.opacity(value) * dt).min(1.0) * share,
                };
                let mut c = self.transfer.color(value);
                if let Some(shading) = self.settings.shading {
                    let gradient = self.gradient(crossing, k);
                    c = shade(self.volume, shading, c, gradient, to_eye);
                }
                gathered.add(c, opacity);
            }
        }
        gathered.rgba()
    }

    /// Length of a sample, in unit distances.
    pub(super) fn sample_length(&self, crossing: &Crossing) -> f64 {
        let spacing = self.volume.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(spacing.min_element());
        let samples = f64::from(self.classification.samples_per_layer());
        (crossing.shear.extend(1.0) * crossing.axis.frame().local(spacing)).length() / unit / samples
    }

    pub(super) fn local_dims(&self, axis: Axis) -> [i64; 3] {
        let frame = axis.frame();
        [frame.u, frame.v, frame.a].map(|i| self.field.dims()[i])
    }

    /// Whether a sample at layer k, not always whole, counts: always where the background is invisible; else only within the field's support.
    pub(super) fn in_support(&self, crossing: &Crossing, k: f64) -> bool {
        let dims = self.local_dims(crossing.axis);
        let p = crossing.at(k);
        let inside = |p: f64, n: i64| (-1.0..=n as f64).contains(&p);
        self.transfer.opacity(self.field.background()) == 0.0 || (inside(p.x, dims[0]) && inside(p.y, dims[1]))
    }

    /// S_k at (u, v): the sum of all footprints in layer k. Background beyond the layers.
    fn splat_sum(&self, crossing: &Crossing, k: i64, p: DVec2) -> f64 {
        self.splat(crossing, k, p, |field, voxel| field.voxel(voxel))
    }

    fn splat(&self, crossing: &Crossing, k: i64, p: DVec2, density: impl Fn(&Field, [i64; 3]) -> f64) -> f64 {
        let frame = crossing.axis.frame();
        let s = crossing.shear;
        let taps = |p: f64, s: f64| (p - 1.0 - s.abs()).ceil() as i64..=(p + 1.0 + s.abs()).floor() as i64;
        let mut sum = 0.0;
        for j in taps(p.y, s.y) {
            for i in taps(p.x, s.x) {
                let mut voxel = [0; 3];
                (voxel[frame.u], voxel[frame.v], voxel[frame.a]) = (i, j, k);
                sum += density(&self.field, voxel) * footprint(p.x - i as f64, p.y - j as f64, s.x, s.y);
            }
        }
        sum
    }

    /// Gradient in voxel differences: splatted central differences.
    fn gradient(&self, crossing: &Crossing, k: i64) -> DVec3 {
        let p = crossing.at(k as f64);
        DVec3::from_array(std::array::from_fn(|along| {
            self.splat(crossing, k, p, |field, voxel| {
                let (mut next, mut last) = (voxel, voxel);
                next[along] += 1;
                last[along] -= 1;
                (field.voxel(next) - field.voxel(last)) / 2.0
            })
        }))
    }
}

impl Crossing {
    /// Where the ray crosses layer k, or a plane between layers.
    pub(super) fn at(&self, k: f64) -> DVec2 {
        self.origin.truncate() + self.shear * (k - self.origin.z)
    }
}
