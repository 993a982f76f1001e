//! Converged volume rendering integral of colours.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::shading::ShadingInputs;
use super::shadow_rays::Reached;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{GradientEstimator, Kernel, Ray, Rays};
use crate::settings::{Blend, Shading};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// Emission and absorption of four interpolated fields: extinction times red, green and blue, and extinction, per smallest spacing. Lit by
/// the gradient of the extinction.
pub struct Colors<'a> {
    fields: [Field; 4],
    extinction: &'a Volume<'a>,
    shading: Option<Shading>,
}

impl<'a> Colors<'a> {
    /// The fields of four volumes on one grid, extinction last. `transfer` is that of the extinction: 0 at 0.
    pub fn new(volumes: [&'a Volume<'a>; 4], transfer: &TransferFunction, kernel: Kernel, gradient: GradientEstimator) -> Self {
        let fields = volumes.map(|volume| Field::new(volume, transfer, Blend::Composite, kernel).with_gradient(gradient));
        Self { fields, extinction: volumes[3], shading: None }
    }

    /// Shades colours, or not.
    pub fn with_shading(self, shading: Option<Shading>) -> Self {
        Self { shading, ..self }
    }

    /// Renders the picture of a camera.
    ///
    /// # Errors
    /// For cameras that are not valid.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.extinction.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let Some(extent) = self.fields[3].support(ray) else { return [0.0; 4] };
        let spacing = self.extinction.grid().spacing();
        let per_t = (ray.direction * spacing).length() / self.extinction.grid().unit();
        let steps = ((extent.to - extent.from) * per_t * STEPS).ceil().max(1.0);
        let step = (extent.to - extent.from) / steps;
        let look = ShadingInputs {
            shading: self.shading,
            gradient_opacity: None,
            extinction: Extinction::Exponential,
            reached: Reached::ALL,
        };
        let mut gathered = Gathered::new();
        for n in 0..steps as usize {
            let p = ray.origin + ray.direction * (extent.from + (n as f64 + 0.5) * step);
            let [r, g, b, extinction] = self.fields.each_ref().map(|field| field.reconstructed(p));
            if extinction > 0.0 {
                let opacity = -(-extinction * step * per_t).exp_m1();
                let color = [r, g, b].map(|c| c / extinction);
                let (color, opacity) = look.at(self.extinction, || self.fields[3].gradient(p), to_eye, color, opacity);
                gathered.add(color, opacity);
            }
        }
        gathered.rgba()
    }
}
