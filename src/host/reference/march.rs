//! Ray casting and pre-integrated slicing, evaluated from their definitions.

#[cfg(feature = "paper")]
mod slicing;

use super::blending::{Values, crossing, opaque};
use super::compositing::{Gathered, opacity_over, picture};
use super::depth_cue::{Fade, faded};
use super::field::Field;
use super::interval::{Part, Region};
use super::label_colors::LabelColors;
use super::shading::{Lighting, ShadingInputs};
use super::shadow_rays::{Reached, ShadowRays};
use super::surfaces::{Cuts, Fragment, Look, Surfaces, over};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Kernel, Ray, Rays};
use crate::settings::{Algorithm, Blend, Settings};
use crate::surface::Surface;
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Ray casting and slicing in `f64`, without table, culling and early ray termination.
pub struct Marched<'a> {
    field: Field,
    step: f64,
    volume: &'a Volume<'a>,
    transfer: &'a TransferFunction,
    settings: &'a Settings,
    shadow_rays: Option<ShadowRays<'a>>,
    label_colors: Option<LabelColors>,
    surfaces: Surfaces<'a>,
}

impl<'a> Marched<'a> {
    /// Creates a renderer for the algorithm of the settings.
    ///
    /// # Panics
    /// If the algorithm is neither ray casting nor slicing.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Self {
        let (kernel, step) = match settings.algorithm {
            Algorithm::Raycast { kernel, step } => (kernel, step),
            Algorithm::Slicing { step } => (Kernel::Linear, step),
            other => panic!("{} does not march along rays", other.name()),
        };
        let field = Field::new(volume, transfer, settings.blend, kernel).with_gradient(settings.gradient_estimator());
        let shadow_rays = ShadowRays::new(volume, transfer, settings);
        let surfaces = Surfaces::new(&[], volume);
        Self { field, step, volume, transfer, settings, shadow_rays, label_colors: None, surfaces }
    }

    /// Mixes the colours of labels into those of the volume: voxel n has entry n, a colour and its weight.
    pub fn with_label_colors(self, labels: &Volume, entries: &[[f64; 4]]) -> Self {
        let label_colors = Some(LabelColors::new(self.volume.grid(), labels, entries));
        Self { label_colors, ..self }
    }

    /// Draws surfaces in and around the volume. Slicing does not.
    pub fn with_surfaces(self, surfaces: &'a [Surface]) -> Self {
        Self { surfaces: Surfaces::new(surfaces, self.volume), ..self }
    }

    /// Renders the picture of a camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?.with_pixel_aspect(self.settings.pixel_aspect, viewport);
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    /// Premultiplied RGBA of one ray; `to_eye` is the reversed direction of the central ray, in grid axes.
    pub fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        match self.settings.blend {
            #[cfg(feature = "paper")]
            Blend::Composite if matches!(self.settings.algorithm, Algorithm::Slicing { .. }) => self.slice(ray, to_eye),
            Blend::Composite => self.cast(ray, to_eye),
            Blend::Iso(iso) => {
                let surface = self.surface(ray, iso, to_eye);
                let (depth, color) = surface.map_or((f64::INFINITY, [0.0; 4]), |(depth, color)| (depth, opaque(color)));
                over(&self.fragments(ray, to_eye), depth, color)
            }
            _ => over(&self.fragments(ray, to_eye), f64::INFINITY, self.values(ray, to_eye)),
        }
    }

    fn fragments(&self, ray: &Ray, to_eye: DVec3) -> Vec<Fragment> {
        let look = Look {
            clipping: &self.settings.clipping,
            shading: self.settings.shading,
            shadow_rays: self.shadow_rays.as_ref(),
            fade: Fade::new(self.volume, self.settings, ray, to_eye),
            to_eye,
        };
        self.surfaces.fragments(ray, &look)
    }

    /// How a sample at a point, given in voxels, looks.
    fn look(&self, point: DVec3) -> ShadingInputs {
        let reached = self.shadow_rays.as_ref().map_or(Reached::ALL, |rays| rays.reached(point));
        ShadingInputs::from_settings(self.settings).lit_by(reached)
    }

    /// Colour of a value at a point, given in voxels, before lighting.
    fn color(&self, value: f64, point: DVec3) -> [f64; 3] {
        let color = self.transfer.color(value);
        self.label_colors.as_ref().map_or(color, |labels| labels.mixed(point, color))
    }

    /// World length of a vector in voxels, and the smallest spacing; both in unit distances.
    fn lengths(&self, vector: DVec3) -> (f64, f64) {
        let spacing = self.volume.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(self.volume.grid().unit());
        ((vector * spacing).length() / unit, spacing.min_element() / unit)
    }

    /// Ray casting with classification after interpolation.
    fn cast(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let fade = Fade::new(self.volume, self.settings, ray, to_eye);
        let fragments = self.fragments(ray, to_eye);
        let (mut cuts, mut gathered) = (Cuts(&fragments), Gathered::new());
        let (per_parameter, smallest) = self.lengths(ray.direction);
        let dt = self.step * smallest;
        for slab in self.slabs(ray, dt / per_parameter) {
            // At the centre of the whole step, even if the step is clipped.
            let p = ray.origin + ray.direction * ((slab.front + slab.back) / 2.0);
            let value = self.field.classified(p);
            let is_visible = self.transfer.opacity(value) > 0.0;
            cuts.split([slab.front, slab.back], slab.part, &mut gathered, |part, gathered| {
                if !is_visible {
                    return;
                }
                let share = part.length();
                let opacity = match self.settings.extinction {
                    Extinction::Exponential => opacity_over(self.transfer, value, dt * share, Extinction::Exponential),
                    Extinction::Linear => opacity_over(self.transfer, value, dt, Extinction::Linear) * share,
                };
                let (color, gradient) = (self.color(value, p), || self.field.gradient(p));
                let (color, opacity) = self.look(p).at(self.volume, gradient, to_eye, color, opacity);
                gathered.add(faded(fade, p, color), opacity);
            });
        }
        cuts.finish(&mut gathered);
        gathered.rgba()
    }

    /// Reduces values from plane to plane.
    fn values(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let mut values = Values::new(self.settings.blend);
        for slab in self.slabs(ray, self.between_planes(ray, to_eye)) {
            // Evaluate the field at the clipped ends, since it is not linear between planes.
            let ends = [slab.part.from, slab.part.to].map(|t| {
                let t = slab.front + t * (slab.back - slab.front);
                self.field.reconstructed(ray.origin + ray.direction * t)
            });
            values.add(ends, slab.part.length());
        }
        values.rgba(self.transfer, &self.field)
    }

    /// Ray parameter and colour of the first iso-surface between two planes.
    fn surface(&self, ray: &Ray, iso: f64, to_eye: DVec3) -> Option<(f64, [f64; 3])> {
        for slab in self.slabs(ray, self.between_planes(ray, to_eye)) {
            let points = slab.points(ray);
            let Some(t) = crossing(points.map(|p| self.field.reconstructed(p)), iso) else { continue };
            if (slab.part.from..=slab.part.to).contains(&t) {
                let color = self.color(iso, points[0].lerp(points[1], t));
                let lit = self.settings.shading.map_or(color, |_| {
                    let [front, back] = points
                        .map(|p| Lighting::for_field(&self.field, self.volume, self.look(p), self.field.gradient(p), to_eye));
                    front.mix(back, t).on(color)
                });
                let fade = Fade::new(self.volume, self.settings, ray, to_eye);
                let depth = slab.front + t * (slab.back - slab.front);
                return Some((depth, faded(fade, points[0].lerp(points[1], t), lit)));
            }
        }
        None
    }

    /// Step of the ray parameter between planes perpendicular to the view.
    fn between_planes(&self, ray: &Ray, to_eye: DVec3) -> f64 {
        let spacing = self.volume.grid().spacing();
        self.step * spacing.min_element() / -(ray.direction * spacing).dot(to_eye)
    }

    /// Slabs of a thickness in ray parameters within the support of the field and the clip region, front to back. One of them starts at
    /// parameter 0.
    fn slabs(&self, ray: &Ray, thickness: f64) -> impl Iterator<Item = Slab> {
        let support = self.field.support(ray);
        let (first, end) = support.map_or((0, 0), |s| ((s.from / thickness).floor() as i64, (s.to / thickness).ceil() as i64));
        let (blend, clipping, radius) = (self.settings.blend, &self.settings.clipping, self.field.kernel().radius());
        let interval = Region::new(self.volume, self.transfer, blend, clipping, f64::from(radius)).intersection(ray);
        (first..end).filter_map(move |n| {
            let (front, back) = (n as f64 * thickness, (n + 1) as f64 * thickness);
            Some(Slab { front, back, part: interval?.part_of(front, back)? })
        })
    }
}

/// A range of ray parameters, and its unclipped part.
struct Slab {
    front: f64,
    back: f64,
    part: Part,
}

impl Slab {
    /// Both ends of the slab before clipping.
    fn points(&self, ray: &Ray) -> [DVec3; 2] {
        [self.front, self.back].map(|t| ray.origin + ray.direction * t)
    }
}
