//! The converged volume rendering integral: of the field that a kernel reconstructs, or of a function that is known everywhere.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::interval::{Interval, Region};
use super::known::Known;
use super::shading::Look;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Kernel, Ray, Rays};
use crate::settings::{Blend, Clipping, GradientOpacity, Shading};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// What is integrated.
pub(super) trait Continuous: Sync {
    /// What is classified at a point in voxels.
    fn value(&self, p: DVec3) -> f64;
    /// What it is lit by, in voxel differences.
    fn gradient(&self, p: DVec3) -> DVec3;
    /// Where a ray before its eye meets anything.
    fn extent(&self, ray: &Ray) -> Option<Interval>;
}

impl Continuous for Field {
    fn value(&self, p: DVec3) -> f64 {
        self.classified(p)
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        Field::gradient(self, p)
    }

    fn extent(&self, ray: &Ray) -> Option<Interval> {
        self.support(ray)
    }
}

/// Emission and absorption along rays (paper, Eq. 3), in steps of 1/16 of the smallest spacing, with the piecewise-linear transfer
/// function itself; lit, if so, at every step by the gradient.
pub struct Integral<'a> {
    integrand: Box<dyn Continuous + 'a>,
    transfer: &'a TransferFunction,
    volume: &'a Volume<'a>,
    unit_distance: f64,
    /// How it is lit. Default: not at all.
    pub shading: Option<Shading>,
    /// What gradients leave of the extinction. Default: all.
    pub gradient_opacity: Option<GradientOpacity>,
    /// What of it is shown. Default: all.
    pub clipping: Clipping,
}

impl<'a> Integral<'a> {
    /// The integral of the field that the paper's cubic reconstructs (Eq. 1 and 2), for opacities per `unit_distance` (world units; by
    /// default the smallest spacing).
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, unit_distance: Option<f64>) -> Self {
        let unit_distance = unit_distance.unwrap_or_else(|| volume.grid().spacing().min_element());
        let integrand = Box::new(Field::new(volume, transfer, Blend::Composite, Kernel::Cubic));
        Self { integrand, transfer, volume, unit_distance, shading: None, gradient_opacity: None, clipping: Clipping::default() }
    }

    /// The same of the field that another kernel reconstructs.
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        let integrand = Box::new(Field::new(self.volume, self.transfer, Blend::Composite, kernel));
        Self { integrand, ..self }
    }

    /// The same of a function of a place in voxels, of which the voxels are samples: its value, and its gradient in voxel differences.
    /// It ends with the outer voxels.
    pub fn with_known(self, function: impl Fn(DVec3) -> (f64, DVec3) + Sync + 'a) -> Self {
        Self { integrand: Box::new(Known::new(self.volume.grid(), function)), ..self }
    }

    /// The picture of a camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    /// Premultiplied RGBA along one ray; `to_eye` is the central ray's direction back to the eye, in the grid's axes.
    pub fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let region = Region::of_clipping(self.volume, &self.clipping);
        let extent = self.integrand.extent(ray).and_then(|extent| extent.and(region.of(ray)?));
        let Some(Interval { from, to }) = extent else { return [0.0; 4] };
        let spacing = self.volume.grid().spacing();
        let world_per_t = (ray.direction * spacing).length();
        let step = spacing.min_element() / STEPS / world_per_t;
        let steps = ((to - from) / step).ceil().max(1.0);
        let step = (to - from) / steps;
        let dt = step * world_per_t / self.unit_distance;
        let look = Look { shading: self.shading, gradient_opacity: self.gradient_opacity, extinction: Extinction::Exponential };
        let mut gathered = Gathered::new();
        for n in 0..steps as usize {
            let p = ray.origin + ray.direction * (from + (n as f64 + 0.5) * step);
            let value = self.integrand.value(p);
            if self.transfer.opacity(value) == 0.0 {
                continue;
            }
            let opacity = -(-self.transfer.extinction(value) * dt).exp_m1();
            let (color, gradient) = (self.transfer.color(value), || self.integrand.gradient(p));
            let (color, opacity) = look.at(self.volume, gradient, to_eye, color, opacity);
            gathered.add(color, opacity);
            if gathered.transmittance < 1e-12 {
                break;
            }
        }
        gathered.rgba()
    }
}
