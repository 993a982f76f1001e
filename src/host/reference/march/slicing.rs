//! Pre-integrated slicing.

use super::super::compositing::{Gathered, opacity_of_depth};
use super::super::depth_cue::{Fade, faded};
use super::super::shading::ShadingInputs;
use super::Marched;
use crate::layers::Ray;
use crate::transfer::{Extinction, TransferFunction};
use glam::DVec3;

/// Integration steps per slab.
const PARTS: usize = 512;

impl Marched<'_> {
    /// The colour of a ray.
    pub(super) fn slice(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let fade = Fade::new(self.volume, self.settings, ray, to_eye);
        let mut gathered = Gathered::new();
        let (per_parameter, smallest) = self.lengths(ray.direction);
        for slab in self.slabs(ray, self.between_planes(ray, to_eye)) {
            let points = slab.points(ray);
            let values = slab.part.ends_of(points.map(|p| self.field.reconstructed(p)));
            let Some((mean, color)) = slab_between(self.transfer, values, self.step * smallest, self.settings.extinction) else {
                continue;
            };
            let length = slab.part.length() * (slab.back - slab.front) * per_parameter;
            let opacity = opacity_of_depth(mean * length, self.settings.extinction);
            let gradient = || points.map(|p| self.field.gradient(p)).into_iter().sum::<DVec3>() / 2.0;
            let (color, opacity) = ShadingInputs::from_settings(self.settings).at(self.volume, gradient, to_eye, color, opacity);
            gathered.add(faded(fade, (points[0] + points[1]) / 2.0, color), opacity);
        }
        gathered.rgba()
    }
}

/// Mean extinction and colour of a slab over which the value changes linearly; the colour is for a slab of `thickness`.
fn slab_between(
    transfer: &TransferFunction,
    [from, to]: [f64; 2],
    thickness: f64,
    extinction: Extinction,
) -> Option<(f64, [f64; 3])> {
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
