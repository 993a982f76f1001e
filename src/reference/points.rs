//! Point-sampled layers with pre-integrated classification, from their definition.

use super::compositing::{Gathered, opacity_of_depth, opacity_over};
use super::layered::{Crossing, Layered};
use super::shading::Lighting;
use crate::layers::{CURVE_SHARE, Interpolation, Ray, segment_ends};
use crate::transfer::{Extinction, TransferFunction};
use glam::DVec3;

/// Parts into which a segment is cut.
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
            // Where the segment begins and ends, in layers.
            let [z0, z1] = [l, l + step].map(|l| l as f64 / samples as f64 - 1.0);
            let from_eye = step as f64 * (z0 - crossing.origin.z - ray.start * ray.direction[frame.a]);
            let cut = (-from_eye * samples as f64).clamp(0.0, 1.0);
            if cut == 1.0 || !self.in_support(crossing, (z0 + z1) / 2.0) {
                continue;
            }
            let n = (if step > 0 { l } else { l - 1 }) % samples;
            let [low, high] = segment_ends(samples_per_layer, n as u32);
            let points = [z0, z1].map(|z| frame.global(crossing.at(z).extend(z)));
            let [from, to] = points.map(|p| self.field.value(p));
            let segment = Segment {
                from: from + cut * (to - from),
                to,
                ends: if step > 0 { [low, high] } else { [high, low] },
                length: dt * (1.0 - cut),
                begin: points[0].lerp(points[1], cut),
                end: points[1],
            };
            let lighting = self.settings.shading.map(|shading| {
                points.map(|p| Lighting::new(self.volume, shading, self.field.differences(Interpolation::Tricubic, p), to_eye))
            });
            if self.in_parts {
                self.composite_parts(&segment, lighting, &mut gathered);
            } else {
                self.composite_whole(&segment, lighting, samples_per_layer, &mut gathered);
            }
        }
        gathered.rgba()
    }

    /// A segment of one colour, lit where most of its light comes from.
    fn composite_whole(
        &self,
        segment: &Segment,
        lighting: Option<[Lighting; 2]>,
        samples_per_layer: u32,
        gathered: &mut Gathered,
    ) {
        let extinction = self.settings.extinction;
        let Some(mean) = mean(self.transfer, segment, extinction) else { return };
        let depth = mean.attenuation * segment.length;
        let opacity = opacity_of_depth(depth, extinction);
        let color = lighting.map_or(mean.color, |[front, back]| {
            // Light comes from before the centroid, by as much as what lies behind is dimmed, if extinction is even.
            let dimmed = if depth > 1e-6 { 0.5 - 1.0 / depth + 1.0 / depth.exp_m1() } else { 0.0 };
            let t = mean.centroid - 4.0 * mean.centroid * (1.0 - mean.centroid) * dimmed;
            let curve = if samples_per_layer == 1 { CURVE_SHARE } else { 0.0 };
            front.mix(back, t + curve * (t * t * (3.0 - 2.0 * t) - t)).on(mean.color)
        });
        gathered.add(color, opacity);
    }

    /// A segment through the field itself, in parts.
    fn composite_parts(&self, segment: &Segment, lighting: Option<[Lighting; 2]>, gathered: &mut Gathered) {
        for n in 0..PARTS {
            let t = (n as f64 + 0.5) / PARTS as f64;
            let value = self.field.value(segment.begin.lerp(segment.end, t));
            let opacity = opacity_over(self.transfer, value, segment.length / PARTS as f64, self.settings.extinction);
            let color = self.transfer.color(value);
            gathered.add(lighting.map_or(color, |[front, back]| front.mix(back, t).on(color)), opacity);
        }
    }
}

/// From one sample of a ray to the next.
struct Segment {
    from: f64,
    to: f64,
    /// Weights of both values; what is left belongs to those between, evenly.
    ends: [f64; 2],
    /// In unit distances.
    length: f64,
    begin: DVec3,
    end: DVec3,
}

/// Of a segment: attenuation per unit distance, the colour weighted with it, and where it lies on the way, 0 … 1.
struct Mean {
    attenuation: f64,
    color: [f64; 3],
    centroid: f64,
}

/// The mean of a segment; `None` if all of it is transparent.
fn mean(transfer: &TransferFunction, segment: &Segment, extinction: Extinction) -> Option<Mean> {
    let Segment { from, to, ends, .. } = *segment;
    let attenuation_at = |value: f64| match extinction {
        Extinction::Exponential => transfer.extinction(value).min(f64::MAX / PARTS as f64),
        Extinction::Linear => transfer.opacity(value),
    };
    let parts = if from == to { 1 } else { PARTS };
    let even = (1.0 - ends[0] - ends[1]) / parts as f64;
    let between = (0..parts).map(|i| (from + (to - from) * (i as f64 + 0.5) / parts as f64, even));
    let (mut sum, mut color) = (0.0, [0.0; 3]);
    for (value, weight) in between.chain([(from, ends[0]), (to, ends[1])]) {
        let attenuation = attenuation_at(value);
        sum += weight * attenuation;
        for (c, own) in color.iter_mut().zip(transfer.color(value)) {
            *c += weight * attenuation * own;
        }
    }
    // The even part as a parabola with the same ends and the same mean.
    let [at_front, at_back] = [from, to].map(attenuation_at);
    let lumps = ends[0] * at_front + ends[1] * at_back;
    let moment = (sum - lumps) / 2.0 + (1.0 - ends[0] - ends[1]) * (at_back - at_front) / 12.0 + ends[1] * at_back;
    let centroid = (moment / sum).clamp(0.0, 1.0);
    (sum > 0.0).then(|| Mean { attenuation: sum, color: color.map(|c| c / sum), centroid })
}
