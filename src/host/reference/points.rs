//! Point-sampled layers with pre-integrated classification, evaluated from their definition.

use super::blending::{Values, crossing, opaque, refined_crossing};
use super::compositing::{Gathered, opacity_of_depth, opacity_over};
use super::depth_cue::{Fade, faded};
use super::interval::Part;
use super::layered::{Crossing, Layered};
use super::shading::Lighting;
use super::surfaces::{Cuts, Fragment, over};
use crate::layers::{lighting_curve, segment_ends};
use crate::settings::Blend;
use crate::transfer::{Extinction, TransferFunction};
use glam::DVec3;

/// Number of parts of a subdivided segment.
const PARTS: usize = 512;
/// Number of parts for mean values. At a step of the transfer function the error is at most 1/256 of the step; elsewhere much less.
const MEAN_PARTS: usize = 128;

impl Layered<'_> {
    /// Premultiplied RGBA of one ray with `samples_per_layer` samples per layer.
    pub(super) fn composite_points(
        &self,
        crossing: &Crossing,
        samples_per_layer: u32,
        fragments: &[Fragment],
        to_eye: DVec3,
    ) -> [f64; 4] {
        let (mut gathered, mut values) = (Gathered::new(), Values::new(self.settings.blend));
        let mut cuts = Cuts(fragments);
        let segments = self.segments(crossing, samples_per_layer);
        for segment in segments.flat_map(|segment| self.halves(segment, samples_per_layer)) {
            match self.settings.blend {
                Blend::Composite => {
                    cuts.split(segment.parameters, segment.part, &mut gathered, |part, gathered| {
                        let segment = segment.cut(part);
                        if self.in_parts {
                            self.composite_parts(&segment, to_eye, gathered);
                        } else {
                            self.composite_whole(&segment, samples_per_layer, to_eye, gathered);
                        }
                    });
                }
                Blend::Iso(iso) => {
                    if let Some((t, color)) = self.surface(&segment, samples_per_layer, iso, to_eye) {
                        return over(fragments, segment.parameter(t), opaque(color));
                    }
                }
                // Evaluate the field at the clipped ends, since it is not linear between samples.
                _ => {
                    let ends = [segment.part.from, segment.part.to].map(|t| self.field.reconstructed(segment.place(t)));
                    values.add(ends, segment.part.length());
                }
            }
        }
        if self.settings.blend.gathers_values() {
            return over(fragments, f64::INFINITY, values.rgba(self.transfer, &self.field));
        }
        cuts.finish(&mut gathered);
        gathered.rgba()
    }

    /// Unclipped segments, front to back.
    fn segments<'a>(&'a self, crossing: &'a Crossing, samples_per_layer: u32) -> impl Iterator<Item = Segment> + 'a {
        let frame = crossing.axis.frame();
        let [.., layers] = self.local_dims(crossing.axis);
        let (samples, step) = (i64::from(samples_per_layer), crossing.step());
        let kernel = self.field.kernel();
        // The field extends one kernel radius beyond the first and the last layer.
        let radius = i64::from(kernel.radius());
        let count = samples * (layers - 1 + 2 * radius);
        (0..count).filter_map(move |n| {
            let l = if step > 0 { n } else { count - n };
            // Start and end of the segment in layers.
            let [z0, z1] = [l, l + step].map(|l| l as f64 / samples as f64 - radius as f64);
            let part = crossing.part_of(z0, z1)?;
            let points = [z0, z1].map(|z| frame.global(crossing.at(z).extend(z)));
            let [low, high] = segment_ends(kernel, samples_per_layer, (l.min(l + step) % samples) as u32);
            Some(Segment {
                points,
                parameters: [z0, z1].map(|z| crossing.parameter(z)),
                values: points.map(|p| self.field.reconstructed(p)),
                part,
                ends: if step > 0 { [low, high] } else { [high, low] },
                length: self.sample_length(crossing) * part.length(),
                gradients: None,
                fade: crossing.fade,
            })
        })
    }

    /// Splits a visible segment in two if gradients are the derivative of the field and they are needed. The middle value is that of the cubic with the
    /// values and slopes at both ends.
    fn halves(&self, segment: Segment, samples_per_layer: u32) -> Vec<Segment> {
        let lit_at_ends = match self.settings.blend {
            Blend::Composite => true,
            Blend::Iso(_) => samples_per_layer == 1,
            _ => false,
        };
        let looked_at = self.field.has_own_gradients() && self.settings.looks_at_gradients() && lit_at_ends;
        if !looked_at || !self.shows(segment.values) {
            return vec![segment];
        }
        let step = segment.points[1] - segment.points[0];
        let gradients = segment.points.map(|p| self.field.gradient(p));
        let ([front, back], slopes) = (segment.values, gradients.map(|g| g.dot(step)));
        let value = (front + back) / 2.0 + (slopes[0] - slopes[1]) / 8.0;
        let description = self.volume.description();
        let range = description.steepness() * description.grid().spacing().min_element();
        let gradient = gradient_in_the_middle(gradients, back - front, step, range);
        let middle = segment.place(0.5);
        let half = |points, values, gradients, from: f64| {
            let parameters = [from, from + 0.5].map(|t| segment.parameter(t));
            let part = segment.part.within(from, from + 0.5)?;
            let length = segment.length / segment.part.length() / 2.0 * part.length();
            Some(Segment {
                points,
                parameters,
                values,
                part,
                ends: [0.0; 2],
                length,
                gradients: Some(gradients),
                fade: segment.fade,
            })
        };
        let halves = [
            half([segment.points[0], middle], [front, value], [gradients[0], gradient], 0.0),
            half([middle, segment.points[1]], [value, back], [gradient, gradients[1]], 0.5),
        ];
        halves.into_iter().flatten().collect()
    }

    /// Whether visible values lie between two values.
    fn shows(&self, [one, other]: [f64; 2]) -> bool {
        if let Blend::Iso(iso) = self.settings.blend {
            return one.min(other) <= iso && iso <= one.max(other);
        }
        self.transfer.largest_opacity(one.min(other), one.max(other)) > 0.0
    }

    fn lighting(&self, segment: &Segment, to_eye: DVec3) -> Option<[Lighting; 2]> {
        if !self.settings.looks_at_gradients() {
            return None;
        }
        let gradients = segment.gradients.unwrap_or_else(|| segment.points.map(|p| self.field.gradient(p)));
        let lighting =
            |n: usize| Lighting::for_field(&self.field, self.volume, self.look(segment.points[n]), gradients[n], to_eye);
        Some([lighting(0), lighting(1)])
    }

    /// Composites a segment of one colour, lit at the centroid of its visible light.
    fn composite_whole(&self, segment: &Segment, samples_per_layer: u32, to_eye: DVec3, gathered: &mut Gathered) {
        let extinction = self.settings.extinction;
        let Some(mean) = mean(self.transfer, segment, extinction) else { return };
        let depth = mean.attenuation * segment.length;
        let opacity = opacity_of_depth(depth, extinction);
        let (color, opacity) = self.lighting(segment, to_eye).map_or((mean.color, opacity), |ends| {
            // Attenuation within the segment moves the source of light in front of the centroid; exact for constant extinction.
            let dimmed = if depth > 1e-6 { 0.5 - 1.0 / depth + 1.0 / depth.exp_m1() } else { 0.0 };
            let source = mean.centroid - 4.0 * mean.centroid * (1.0 - mean.centroid) * dimmed;
            let lighting = self.along_curve(ends, segment.part.at(source), samples_per_layer);
            let thinned = ends[0].mix(ends[1], segment.part.at(mean.centroid)).thinned(opacity, extinction);
            (segment.faded(segment.part.at(source), lighting.on(mean.color)), thinned)
        });
        gathered.add(color, opacity);
    }

    /// Composites a segment in parts, through the reconstructed field.
    fn composite_parts(&self, segment: &Segment, to_eye: DVec3, gathered: &mut Gathered) {
        let lighting = self.lighting(segment, to_eye);
        for n in 0..PARTS {
            let t = segment.part.at((n as f64 + 0.5) / PARTS as f64);
            let value = self.field.reconstructed(segment.place(t));
            let opacity = opacity_over(self.transfer, value, segment.length / PARTS as f64, self.settings.extinction);
            let color = self.transfer.color(value);
            let lighting = lighting.map(|[front, back]| front.mix(back, t));
            let (color, opacity) = lighting
                .map_or((color, opacity), |lighting| (lighting.on(color), lighting.thinned(opacity, self.settings.extinction)));
            gathered.add(segment.faded(t, color), opacity);
        }
    }

    /// Place in the segment and colour of an iso-surface, if the unclipped part of the segment crosses it.
    fn surface(&self, segment: &Segment, samples_per_layer: u32, iso: f64, to_eye: DVec3) -> Option<(f64, [f64; 3])> {
        let mut t = crossing(segment.values, iso)?;
        let refined = samples_per_layer > 1;
        if refined {
            t = refined_crossing(|t| self.field.reconstructed(segment.place(t)), segment.values[0], iso);
        }
        if !(segment.part.from..=segment.part.to).contains(&t) {
            return None;
        }
        let color = self.transfer.color(iso);
        let lighting = if refined {
            let gradient = self.field.gradient(segment.place(t));
            self.settings.shading.map(|_| Lighting::new(self.volume, self.look(segment.place(t)), gradient, to_eye))
        } else {
            self.lighting(segment, to_eye).map(|ends| self.along_curve(ends, t, samples_per_layer))
        };
        Some((t, segment.faded(t, lighting.map_or(color, |lighting| lighting.on(color)))))
    }

    /// Interpolates lighting between two ends. Between layers of the paper's cubic it follows the curve of the field.
    fn along_curve(&self, [front, back]: [Lighting; 2], t: f64, samples_per_layer: u32) -> Lighting {
        let curve = lighting_curve(self.field.kernel(), samples_per_layer);
        front.mix(back, t + curve * (t * t * (3.0 - 2.0 * t) - t))
    }
}

/// A segment between two samples of a ray.
#[derive(Clone, Copy)]
struct Segment {
    points: [DVec3; 2],
    /// Ray parameters of both ends.
    parameters: [f64; 2],
    /// Values at both ends.
    values: [f64; 2],
    /// Unclipped part. The value changes linearly along the segment.
    part: Part,
    /// Weights of the values at both ends of the part. The remaining weight is distributed evenly over the values between.
    ends: [f64; 2],
    /// Length of the part in unit distances.
    length: f64,
    /// Gradients at both ends, if they differ from those of the field.
    gradients: Option<[DVec3; 2]>,
    fade: Option<Fade>,
}

impl Segment {
    fn place(&self, t: f64) -> DVec3 {
        self.points[0].lerp(self.points[1], t)
    }

    /// Ray parameter at a place.
    fn parameter(&self, t: f64) -> f64 {
        self.parameters[0] + t * (self.parameters[1] - self.parameters[0])
    }

    /// The segment, of which only this part is drawn.
    fn cut(self, part: Part) -> Self {
        Self { part, length: self.length / self.part.length() * part.length(), ..self }
    }

    /// A lit colour, faded by the depth of a place.
    fn faded(&self, t: f64, color: [f64; 3]) -> [f64; 3] {
        faded(self.fade, self.place(t), color)
    }
}

/// Fraction of the gradient correction at the middle that is applied along the segment, per squared voxel: kernels/shared/span_lighting.cl.
const ALONG_THE_WAY: f64 = 0.8;

/// Magnitude of a gradient, relative to the range of values, below which it has no meaningful direction.
const NO_NORMAL: f64 = 1e-3;

/// Gradient in the middle of a segment. It is the mean of both ends, corrected to match the slope of the cubic through both values and
/// slopes. The correction acts along both gradients and, in part, along the segment, to which they may be perpendicular. `range` is
/// that of the values.
fn gradient_in_the_middle([one, other]: [DVec3; 2], apart: f64, step: DVec3, range: f64) -> DVec3 {
    let mean = (one + other) / 2.0;
    let lacking = 1.5 * (apart - mean.dot(step));
    let both = one.length_squared() + other.length_squared() + (NO_NORMAL * range).powi(2);
    let towards = one * one.dot(step) + other * other.dot(step) + step * (ALONG_THE_WAY * step.length_squared() * both);
    mean + towards * (lacking / towards.dot(step))
}

/// Mean attenuation per unit distance of a segment, its attenuation-weighted colour, and the centroid of attenuation, 0 … 1.
struct Mean {
    attenuation: f64,
    color: [f64; 3],
    centroid: f64,
}

/// Mean of a segment; `None` if it is transparent.
fn mean(transfer: &TransferFunction, segment: &Segment, extinction: Extinction) -> Option<Mean> {
    let ([from, to], ends) = (segment.part.ends_of(segment.values), segment.ends);
    let attenuation_at = |value: f64| match extinction {
        Extinction::Exponential => transfer.extinction(value).min(f64::MAX / MEAN_PARTS as f64),
        Extinction::Linear => transfer.opacity(value),
    };
    let parts = if from == to { 1 } else { MEAN_PARTS };
    let even = (1.0 - ends[0] - ends[1]) / parts as f64;
    let between = (0..parts).map(|i| (from + (to - from) * (i as f64 + 0.5) / parts as f64, even));
    let (mut sum, mut color) = (0.0, [0.0; 3]);
    for (value, weight) in between.chain([(from, ends[0]), (to, ends[1])]) {
        let attenuation = attenuation_at(value);
        if attenuation == 0.0 {
            continue;
        }
        sum += weight * attenuation;
        for (c, own) in color.iter_mut().zip(transfer.color(value)) {
            *c += weight * attenuation * own;
        }
    }
    // Model the evenly distributed part as a parabola with the same end values and the same mean.
    let [at_front, at_back] = [from, to].map(attenuation_at);
    let lumps = ends[0] * at_front + ends[1] * at_back;
    let moment = (sum - lumps) / 2.0 + (1.0 - ends[0] - ends[1]) * (at_back - at_front) / 12.0 + ends[1] * at_back;
    let centroid = (moment / sum).clamp(0.0, 1.0);
    (sum > 0.0).then(|| Mean { attenuation: sum, color: color.map(|c| c / sum), centroid })
}
