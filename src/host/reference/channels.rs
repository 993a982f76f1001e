//! Converged volume rendering integral of several fields.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::shading::ShadingInputs;
use super::shadow_rays::{Reached, ShadowRays};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{GradientEstimator, Kernel, Ray, Rays};
use crate::settings::{Blend, Settings, Shading};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// Emission and absorption of several fields, each on its own grid: τ = Σ τ_c, and C = Σ τ_c C_c / τ, in steps of 1/16 of the smallest
/// spacing. Opacities are per the smallest spacing of each field.
#[derive(Clone, Default)]
pub struct Sum<'a> {
    fields: Vec<Summand<'a>>,
    shading: Option<Shading>,
    lit_by: Option<&'a Settings>,
}

/// A field of the sum.
#[derive(Clone)]
struct Summand<'a> {
    volume: &'a Volume<'a>,
    transfer: &'a TransferFunction,
    factor: f64,
    field: Field,
    /// How far the field reaches beyond its grid, in voxels.
    reach: f64,
    /// Of a volume of colours: extinction times red, green and blue, and extinction. `field` is the extinction then.
    colors: Option<[Field; 4]>,
}

impl<'a> Sum<'a> {
    /// Adds a field that `kernel` reconstructs, whose extinction is multiplied by `factor`. Rays are cast in the grid of the first.
    pub fn with_field(mut self, volume: &'a Volume<'a>, transfer: &'a TransferFunction, factor: f64, kernel: Kernel) -> Self {
        let field = Field::new(volume, transfer, Blend::Composite, kernel);
        let field = field.with_gradient(GradientEstimator::for_kernel(kernel));
        self.fields.push(Summand { volume, transfer, factor, field, reach: f64::from(kernel.radius()), colors: None });
        self
    }

    /// Adds a volume of colours: extinction times red, green and blue, and extinction, whose `transfer` is 1 - e^(-τ). `kernel` reconstructs
    /// the extinction; colours are interpolated linearly, weighted by it.
    pub fn with_colors(self, volumes: [&'a Volume<'a>; 4], transfer: &'a TransferFunction, factor: f64, kernel: Kernel) -> Self {
        let mut sum = self.with_field(volumes[3], transfer, factor, kernel);
        if let Some(field) = sum.fields.last_mut() {
            field.colors = Some(volumes.map(|volume| Field::new(volume, transfer, Blend::Composite, Kernel::Linear)));
        }
        sum
    }

    /// Adds a field on a grid of its own, as it is resampled: by Catmull-Rom, up to one voxel beyond its grid.
    pub fn with_resampled_field(self, volume: &'a Volume<'a>, transfer: &'a TransferFunction, factor: f64) -> Self {
        let mut sum = self.with_field(volume, transfer, factor, Kernel::CatmullRom);
        if let Some(field) = sum.fields.last_mut() {
            field.reach = 1.0;
        }
        sum
    }

    /// Shades the fields by their own gradients, or not.
    pub fn with_shading(self, shading: Option<Shading>) -> Self {
        Self { shading, ..self }
    }

    /// Shades the fields, with the shadows and the ambient occlusion of these settings: rays to the lights pass through all fields.
    pub fn with_shadows(self, settings: &'a Settings) -> Self {
        Self { shading: settings.shading, lit_by: Some(settings), ..self }
    }

    /// Renders the picture of a camera.
    ///
    /// # Errors
    /// For cameras that are not valid.
    ///
    /// # Panics
    /// Without a field, and if a light that casts shadows moves with the camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.fields[0].volume.grid())?;
        let absorbers: Vec<_> = self.fields.iter().map(|field| (field.volume, field.transfer, field.factor)).collect();
        let shadow_rays = self.lit_by.and_then(|settings| ShadowRays::through(&absorbers, settings));
        let reached = |point| shadow_rays.as_ref().map_or(Reached::ALL, |rays| rays.reached(point));
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye, &reached)))
    }

    /// Premultiplied RGBA of a ray in voxels of the first field; `to_eye` is in its axes. `reached`: the light at a point.
    fn composite(&self, ray: &Ray, to_eye: DVec3, reached: &impl Fn(DVec3) -> Reached) -> [f64; 4] {
        let first = self.fields[0].volume.grid();
        let seen: Vec<_> =
            self.fields.iter().filter_map(|summand| Some((summand, summand.seen_along(ray, to_eye, first)?))).collect();
        let from = seen.iter().map(|(_, seen)| seen.from).fold(f64::INFINITY, f64::min);
        let to = seen.iter().map(|(_, seen)| seen.to).fold(f64::NEG_INFINITY, f64::max);
        if from >= to {
            return [0.0; 4];
        }
        let smallest =
            self.fields.iter().map(|summand| summand.volume.grid().spacing().min_element()).fold(f64::INFINITY, f64::min);
        let world_per_t = (ray.direction * first.spacing()).length();
        let steps = ((to - from) * world_per_t * STEPS / smallest).ceil().max(1.0);
        let step = (to - from) / steps;
        let mut gathered = Gathered::new();
        for n in 0..steps as usize {
            let t = from + (n as f64 + 0.5) * step;
            let (mut depth, mut sum) = (0.0, [0.0; 3]);
            let mut light = None;
            for (summand, seen) in seen.iter().filter(|(_, seen)| (seen.from..=seen.to).contains(&t)) {
                let reached = || *light.get_or_insert_with(|| reached(ray.origin + ray.direction * t));
                let (own, color) = summand.emission(seen, t, step * world_per_t, (self.shading, reached));
                depth += own;
                (0..3).for_each(|c| sum[c] += own * color[c]);
            }
            if depth > 0.0 {
                gathered.add(sum.map(|c| c / depth), -(-depth).exp_m1());
            }
        }
        gathered.rgba()
    }
}

/// A ray in voxels of a field, and where it is within the field.
struct Seen {
    ray: Ray,
    to_eye: DVec3,
    from: f64,
    to: f64,
}

impl Summand<'_> {
    /// A ray of another grid, with the same parameters.
    fn seen_along(&self, ray: &Ray, to_eye: DVec3, grid: &crate::volume::Grid) -> Option<Seen> {
        let own = self.volume.grid();
        let moved = own.index_to_world().inverse() * grid.index_to_world();
        let ray = Ray { origin: moved.transform_point3(ray.origin), direction: moved.transform_vector3(ray.direction), ..*ray };
        let to_eye = own.world_to_grid_axes() * (grid.direction() * to_eye);
        let extent = self.field.within(&ray, self.reach)?;
        Some(Seen { ray, to_eye, from: extent.from, to: extent.to })
    }

    /// Optical depth over a world length, and the colour in the light that reaches it.
    fn emission(
        &self,
        seen: &Seen,
        t: f64,
        length: f64,
        (shading, reached): (Option<Shading>, impl FnOnce() -> Reached),
    ) -> (f64, [f64; 3]) {
        let p = seen.ray.origin + seen.ray.direction * t;
        let value = self.field.classified(p);
        let extinction = self.transfer.extinction(value) * self.factor;
        if extinction == 0.0 {
            return (0.0, [0.0; 3]);
        }
        let look = ShadingInputs { shading, gradient_opacity: None, extinction: Extinction::Exponential, reached: reached() };
        let color = match &self.colors {
            None => self.transfer.color(value),
            Some(fields) => {
                let [r, g, b, weight] = fields.each_ref().map(|field| field.reconstructed(p));
                [r, g, b].map(|c| if weight > 0.0 { c / weight } else { 0.0 })
            }
        };
        let (color, _) = look.at(self.volume, || self.field.gradient(p), seen.to_eye, color, 1.0);
        (extinction * length / self.volume.grid().unit(), color)
    }
}
