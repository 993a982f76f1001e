//! Layered splatting, evaluated from its definition.

use super::blending::Values;
use super::compositing::{Gathered, picture};
use super::depth_cue::{Fade, faded};
use super::field::Field;
use super::interval::{Interval, Part, Region};
use super::shading::ShadingInputs;
use super::shadow_rays::{Reached, ShadowRays};
use super::surfaces::{Look, Surfaces, over};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Axis, Correction, Kernel, LayerSlabs, Ray, Rays, footprint};
use crate::settings::{Blend, Classification, Settings};
use crate::surface::Surface;
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::{DVec2, DVec3};

/// Opacity above which a sample counts as opaque: its optical depth is finite.
const MOST_OPAQUE: f64 = 1.0 - f64::EPSILON;

/// Layered renderer in `f64`: exact footprints, without lattice, table, culling and early ray termination. Of splatted layers, also of several
/// fields on one grid: τ = Σ τ_c, and C = Σ τ_c C_c / τ.
pub struct Layered<'a> {
    pub(super) field: Field,
    pub(super) volume: &'a Volume<'a>,
    pub(super) transfer: &'a TransferFunction,
    pub(super) settings: &'a Settings,
    pub(super) classification: Classification,
    region: Region,
    shadow_rays: Option<ShadowRays<'a>>,
    /// Factor of the extinction.
    factor: f64,
    /// Fields that are drawn together with this one.
    others: Vec<Layered<'a>>,
    surfaces: Surfaces<'a>,
    /// Whether pre-integrated segments are subdivided, with attenuation between the parts. The kernels approximate this for opaque transfer
    /// functions of several hues. Default: false.
    pub in_parts: bool,
}

/// A ray in the local frame of its layer axis.
pub(super) struct Crossing {
    pub axis: Axis,
    pub origin: DVec3,
    pub shear: DVec2,
    /// Layers per unit of the ray parameter.
    climb: f64,
    /// Unclipped part of the ray.
    interval: Interval,
    pub fade: Option<Fade>,
}

impl<'a> Layered<'a> {
    /// Creates a renderer. Ignores settings for the evaluation of samples and for skipping.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Self {
        let classification = settings.layered().unwrap_or_default().classification;
        let kernel = match classification {
            // Footprints are integrals of the cubic.
            Classification::Post(_) => Kernel::Cubic,
            Classification::Preintegrated { kernel, .. } => kernel,
        };
        let field = Field::new(volume, transfer, settings.blend, kernel).with_gradient(settings.gradient_estimator());
        let region = Region::new(volume, transfer, settings.blend, &settings.clipping, f64::from(kernel.radius()));
        let shadow_rays = ShadowRays::new(volume, transfer, settings);
        Self {
            field,
            volume,
            transfer,
            settings,
            classification,
            region,
            shadow_rays,
            factor: 1.0,
            others: Vec::new(),
            surfaces: Surfaces::new(&[], volume),
            in_parts: false,
        }
    }

    /// Multiplies the extinction by a factor.
    pub fn with_factor(self, factor: f64) -> Self {
        Self { factor, ..self }
    }

    /// Adds the splatted layers of another field on the same grid, with its factor.
    pub fn with_field(mut self, other: Self) -> Self {
        self.others.push(other);
        self
    }

    /// Draws surfaces in and around the volume. Splatted layers do not.
    pub fn with_surfaces(self, surfaces: &'a [Surface]) -> Self {
        Self { surfaces: Surfaces::new(surfaces, self.volume), ..self }
    }

    /// All fields.
    fn fields(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
    }

    /// Renders the picture of a camera. All rays use the layer axis `axis`; with `None`, each ray uses its own.
    pub fn render(&self, camera: &Camera, viewport: Viewport, axis: Option<Axis>) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?.with_pixel_aspect(self.settings.pixel_aspect, viewport);
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), axis, rays.to_eye)))
    }

    /// Premultiplied RGBA of one ray; `to_eye` is the reversed direction of the central ray, in grid axes.
    pub fn composite(&self, ray: &Ray, axis: Option<Axis>, to_eye: DVec3) -> [f64; 4] {
        let axis = axis.unwrap_or_else(|| Axis::most_parallel(ray.direction));
        let frame = axis.frame();
        let shear = DVec2::from_array(frame.shear(ray.direction));
        let fade = Fade::new(self.volume, self.settings, ray, to_eye);
        let look = Look {
            clipping: &self.settings.clipping,
            shading: self.settings.shading,
            shadow_rays: self.shadow_rays.as_ref(),
            fade,
            to_eye,
        };
        let fragments = self.surfaces.fragments(ray, &look);
        let Some(interval) = self.region.intersection(ray) else { return over(&fragments, f64::INFINITY, [0.0; 4]) };
        let crossing = Crossing { axis, origin: frame.local(ray.origin), shear, climb: ray.direction[frame.a], interval, fade };
        match self.classification {
            Classification::Post(correction) => self.composite_splats(&crossing, correction, to_eye),
            Classification::Preintegrated { samples_per_layer, .. } => {
                self.composite_points(&crossing, samples_per_layer, &fragments, to_eye)
            }
        }
    }

    /// How a sample at a point, given in voxels, looks.
    pub(super) fn look(&self, point: DVec3) -> ShadingInputs {
        let reached = self.shadow_rays.as_ref().map_or(Reached::ALL, |rays| rays.reached(point));
        ShadingInputs::from_settings(self.settings).lit_by(reached)
    }

    fn composite_splats(&self, crossing: &Crossing, correction: Correction, to_eye: DVec3) -> [f64; 4] {
        let [.., last] = self.local_dims(crossing.axis);
        let samples = f64::from(correction.samples_per_layer());
        let slabs = LayerSlabs::new(correction);
        let step = crossing.step();
        let order: Vec<i64> = if step > 0 { (-1..=last).collect() } else { (-1..=last).rev().collect() };
        let (mut gathered, mut values) = (Gathered::new(), Values::new(self.settings.blend));
        for (n, &k) in order.iter().enumerate() {
            let samples_of_layer = match n {
                0 => &slabs.front,
                _ if n + 1 == order.len() => &slabs.back,
                _ => &slabs.inner,
            };
            // Position relative to the layer's plane, in layers along the ray.
            let mut start = if n == 0 { 0.0 } else { -0.5 };
            let mut sums = None;
            for slab in samples_of_layer {
                let end = start + slab.share / samples;
                let part = crossing.part_of(k as f64 + step as f64 * start, k as f64 + step as f64 * end);
                start = end;
                let Some(part) = part else { continue };
                let sums = sums.get_or_insert_with(|| {
                    let of_field =
                        |field: &Self| [k - step, k, k + step].map(|j| field.splat_sum(crossing, j, crossing.at(j as f64)));
                    self.fields().map(of_field).collect::<Vec<_>>()
                });
                let value = |[before, own, after]: &[f64; 3]| slab.before * before + slab.own * own + slab.after * after;
                let of_fields: Vec<f64> = sums.iter().map(value).collect();
                if self.settings.blend == Blend::Composite {
                    self.composite_sample(crossing, k, &of_fields, slab.share, part, to_eye, &mut gathered);
                } else {
                    values.add_sample(of_fields[0], slab.share, part);
                }
            }
        }
        if self.settings.blend == Blend::Composite { gathered.rgba() } else { values.rgba(self.transfer, &self.field) }
    }

    /// Composites a part of a sample of layer k, in which the fields have these values; `share` is its thickness relative to a whole sample.
    #[expect(clippy::too_many_arguments, reason = "all are properties of a sample")]
    fn composite_sample(
        &self,
        crossing: &Crossing,
        k: i64,
        values: &[f64],
        share: f64,
        part: Part,
        to_eye: DVec3,
        gathered: &mut Gathered,
    ) {
        let share = share * part.length();
        // All samples of a layer are lit at its plane.
        let point = crossing.axis.frame().global(crossing.at(k as f64).extend(k as f64));
        let (mut depth, mut sum) = (0.0, [0.0; 3]);
        for (field, &value) in self.fields().zip(values).filter(|(field, value)| field.transfer.opacity(**value) > 0.0) {
            let dt = field.sample_length(crossing) * field.factor;
            let opacity = match self.settings.extinction {
                Extinction::Exponential => -(-field.transfer.extinction(value) * dt * share).exp_m1(),
                Extinction::Linear => (field.transfer.opacity(value) * dt).min(1.0) * share,
            };
            let (color, gradient) = (field.transfer.color(value), || field.gradient(crossing, k));
            let (color, opacity) = self.look(point).at(field.volume, gradient, to_eye, color, opacity);
            let own = match self.settings.extinction {
                Extinction::Exponential => -(-opacity.min(MOST_OPAQUE)).ln_1p(),
                Extinction::Linear => opacity,
            };
            let color = faded(crossing.fade, point, color);
            (0..3).for_each(|c| sum[c] += own * color[c]);
            depth += own;
        }
        if depth > 0.0 {
            let opacity = match self.settings.extinction {
                Extinction::Exponential => -(-depth).exp_m1(),
                Extinction::Linear => depth.min(share),
            };
            gathered.add(sum.map(|c| c / depth), opacity);
        }
    }

    /// Length of a sample in unit distances.
    pub(super) fn sample_length(&self, crossing: &Crossing) -> f64 {
        let spacing = self.volume.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(self.volume.grid().unit());
        let samples = f64::from(self.classification.samples_per_layer());
        (crossing.shear.extend(1.0) * crossing.axis.frame().local(spacing)).length() / unit / samples
    }

    pub(super) fn local_dims(&self, axis: Axis) -> [i64; 3] {
        let frame = axis.frame();
        [frame.u, frame.v, frame.a].map(|i| self.field.dims()[i])
    }

    /// S_k at (u, v): sum of all footprints in layer k, with background outside.
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

    /// Gradient per voxel: splatted central differences, or smoothed ones at the voxels of the layer, interpolated.
    fn gradient(&self, crossing: &Crossing, k: i64) -> DVec3 {
        let p = crossing.at(k as f64);
        if self.field.has_gradients_at_voxels() {
            return self.field.gradient(crossing.axis.frame().global(p.extend(k as f64)));
        }
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
    /// Crossing of the ray with layer k or, for fractional k, a plane between layers.
    pub(super) fn at(&self, k: f64) -> DVec2 {
        self.origin.truncate() + self.shear * (k - self.origin.z)
    }

    /// Order of the layers along the ray: 1 or −1.
    pub fn step(&self) -> i64 {
        if self.climb > 0.0 { 1 } else { -1 }
    }

    /// Ray parameter of a position on the layer axis.
    pub fn parameter(&self, z: f64) -> f64 {
        (z - self.origin.z) / self.climb
    }

    /// Unclipped part of the segment between two positions on the layer axis.
    pub fn part_of(&self, front: f64, back: f64) -> Option<Part> {
        self.interval.part_of(self.parameter(front), self.parameter(back))
    }
}
