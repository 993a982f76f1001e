//! Point-sampled layers with pre-integrated classification, from their definition.

use super::compositing::{Gathered, opacity_of_depth};
use super::layered::{Crossing, Layered};
use super::shading::shade;
use crate::layers::{Ray, stretch_ends};
use crate::transfer::{Extinction, TransferFunction};
use glam::{DVec2, DVec3};

/// Parts into which a stretch's values are cut for its mean.
const PARTS: usize = 512;

impl Layered<'_> {
    /// Premultiplied RGBA along one ray, sampled `samples_per_layer` times per layer.
    pub(super) fn composite_points(&self, ray: &Ray, crossing: &Crossing, samples_per_layer: u32, to_eye: DVec3) -> [f64; 4] {
        let frame = crossing.axis.frame();
        let dims = self.local_dims(crossing.axis);
        let samples = i64::from(samples_per_layer);
        let dt = self.sample_length(crossing);
        let step = if ray.direction[frame.a] > 0.0 { 1 } else { -1 };
        let mut gathered = Gathered::new();
        for n in 0..samples * (dims[2] + 1) {
            let l = if step > 0 { n } else { samples * (dims[2] + 1) - n };
            // Where the stretch begins and ends, in layers.
            let [z0, z1] = [l, l + step].map(|l| l as f64 / samples as f64 - 1.0);
            let from_eye = step as f64 * (z0 - crossing.origin.z - ray.start * ray.direction[frame.a]);
            let cut = (-from_eye * samples as f64).clamp(0.0, 1.0);
            if cut == 1.0 || !self.in_support(crossing, (z0 + z1) / 2.0) {
                continue;
            }
            let [from, to] = [z0, z1].map(|z| self.field_at(crossing, z, crossing.at(z)));
            let n = (if step > 0 { l } else { l - 1 }) % samples;
            let [low, high] = stretch_ends(samples_per_layer, n as u32);
            let ends = if step > 0 { [low, high] } else { [high, low] };
            let values = [from + cut * (to - from), to];
            let Some((attenuation, mut c)) = mean(self.transfer, values, ends, self.settings.extinction) else {
                continue;
            };
            let opacity = opacity_of_depth(attenuation * dt * (1.0 - cut), self.settings.extinction);
            if let Some(shading) = self.settings.shading {
                let ends = [z0, z1].map(|z| self.gradient_at(crossing, z));
                c = shade(self.volume, shading, c, frame.global((ends[0] + ends[1]) / 2.0), to_eye);
            }
            gathered.add(c, opacity);
        }
        gathered.rgba()
    }

    fn field_at(&self, crossing: &Crossing, z: f64, p: DVec2) -> f64 {
        self.field.value(crossing.axis.frame().global(p.extend(z)))
    }

    /// Central differences along u, v and a at a plane; along a at the ray's own crossings, less what its own shift
    /// contributes.
    fn gradient_at(&self, crossing: &Crossing, z: f64) -> DVec3 {
        let p = crossing.at(z);
        let in_plane = |d: DVec2| (self.field_at(crossing, z, p + d) - self.field_at(crossing, z, p - d)) / 2.0;
        let (u, v) = (in_plane(DVec2::X), in_plane(DVec2::Y));
        let [before, after] = [z - 1.0, z + 1.0].map(|z| self.field_at(crossing, z, crossing.at(z)));
        DVec3::new(u, v, (after - before) / 2.0 - crossing.shear.x * u - crossing.shear.y * v)
    }
}

/// Mean attenuation and the colour, weighted with it, over the values from one to another, with weights of these two;
/// `None` if all is transparent.
fn mean(transfer: &TransferFunction, [from, to]: [f64; 2], ends: [f64; 2], extinction: Extinction) -> Option<(f64, [f64; 3])> {
    let mut sum = 0.0;
    let mut color = [0.0; 3];
    let parts = if from == to { 1 } else { PARTS };
    let even = (1.0 - ends[0] - ends[1]) / parts as f64;
    let between = (0..parts).map(|i| (from + (to - from) * (i as f64 + 0.5) / parts as f64, even));
    for (value, weight) in between.chain([(from, ends[0]), (to, ends[1])]) {
        let attenuation = match extinction {
            Extinction::Exponential => transfer.extinction(value).min(f64::MAX / PARTS as f64),
            Extinction::Linear => transfer.opacity(value),
        };
        sum += weight * attenuation;
        for (c, own) in color.iter_mut().zip(transfer.color(value)) {
            *c += weight * attenuation * own;
        }
    }
    (sum > 0.0).then(|| (sum, color.map(|c| c / sum)))
}
