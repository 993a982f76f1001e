//! Converged volume rendering integral of a reconstructed field or of an analytic function.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::interval::{Interval, Region};
use super::known::Known;
use super::label_colors::LabelColors;
use super::shading::ShadingInputs;
use super::shadow_rays::Reached;
use super::surfaces::{Look, Surfaces};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{GradientEstimator, Kernel, Ray, Rays};
use crate::settings::{Blend, Clipping, GradientOpacity, Shading};
use crate::surface::Surface;
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// An integrand.
pub(super) trait Continuous: Sync {
    /// Value to classify at a point in voxels.
    fn value(&self, p: DVec3) -> f64;
    /// Gradient for shading, per voxel.
    fn gradient(&self, p: DVec3) -> DVec3;
    /// Intersection of a ray with the support.
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

/// Emission and absorption along rays (paper, Eq. 3), in steps of 1/16 of the smallest spacing, with the exact piecewise-linear transfer
/// function. Shading, if enabled, is evaluated at every step.
pub struct Integral<'a> {
    integrand: Box<dyn Continuous + 'a>,
    transfer: &'a TransferFunction,
    volume: &'a Volume<'a>,
    unit_distance: f64,
    label_colors: Option<LabelColors>,
    surfaces: Surfaces<'a>,
    /// Shading. Default: none.
    pub shading: Option<Shading>,
    /// Gradient opacity. Default: none.
    pub gradient_opacity: Option<GradientOpacity>,
    /// Clipping. Default: none.
    pub clipping: Clipping,
}

impl<'a> Integral<'a> {
    /// Integral of the field of the paper's cubic (Eq. 1 and 2). Opacities apply per `unit_distance` in world units, by default the smallest
    /// spacing.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, unit_distance: Option<f64>) -> Self {
        let unit_distance = unit_distance.unwrap_or_else(|| volume.grid().unit());
        let integrand = Box::new(Field::new(volume, transfer, Blend::Composite, Kernel::Cubic));
        Self {
            integrand,
            transfer,
            volume,
            unit_distance,
            label_colors: None,
            surfaces: Surfaces::new(&[], volume),
            shading: None,
            gradient_opacity: None,
            clipping: Clipping::default(),
        }
    }

    /// Uses another reconstruction kernel, with the gradients that fit it most closely.
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        self.with_gradient(kernel, GradientEstimator::for_kernel(kernel))
    }

    /// Uses another reconstruction kernel, and estimates gradients in another way.
    pub fn with_gradient(self, kernel: Kernel, gradient: GradientEstimator) -> Self {
        let field = Field::new(self.volume, self.transfer, Blend::Composite, kernel).with_gradient(gradient);
        Self { integrand: Box::new(field), ..self }
    }

    /// Integrates an analytic function of a position in voxels instead, which the voxels sample. It returns value and gradient per voxel. Its
    /// support ends at the outermost voxels.
    pub fn with_known(self, function: impl Fn(DVec3) -> (f64, DVec3) + Sync + 'a) -> Self {
        Self { integrand: Box::new(Known::new(self.volume.grid(), function)), ..self }
    }

    /// Mixes the colours of labels into those of the volume: voxel n has entry n, a colour and its weight.
    pub fn with_label_colors(self, labels: &Volume, entries: &[[f64; 4]]) -> Self {
        let label_colors = Some(LabelColors::new(self.volume.grid(), labels, entries));
        Self { label_colors, ..self }
    }

    /// Draws surfaces in and around the volume.
    pub fn with_surfaces(self, surfaces: &'a [Surface]) -> Self {
        Self { surfaces: Surfaces::new(surfaces, self.volume), ..self }
    }

    /// Renders the picture of a camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    /// Premultiplied RGBA of one ray; `to_eye` is the reversed direction of the central ray, in grid axes.
    pub fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let region = Region::from_clipping(self.volume, &self.clipping);
        let extent = self.integrand.extent(ray).and_then(|extent| extent.and(region.intersection(ray)?));
        let look = Look { clipping: &self.clipping, shading: self.shading, shadow_rays: None, fade: None, to_eye };
        let mut gathered = Gathered::new();
        // What is left of the interval behind the fragments so far.
        let mut left = extent;
        for fragment in self.surfaces.fragments(ray, &look) {
            if let Some(before) = left.and_then(|left| left.and(Interval { to: fragment.t, ..left })) {
                self.integrate(ray, before, to_eye, &mut gathered);
            }
            gathered.add(fragment.color, fragment.opacity);
            left = left.and_then(|left| left.and(Interval { from: fragment.t, ..left }));
        }
        if let Some(left) = left {
            self.integrate(ray, left, to_eye, &mut gathered);
        }
        gathered.rgba()
    }

    /// Composites an interval of a ray.
    fn integrate(&self, ray: &Ray, Interval { from, to }: Interval, to_eye: DVec3, gathered: &mut Gathered) {
        let spacing = self.volume.grid().spacing();
        let world_per_t = (ray.direction * spacing).length();
        let step = spacing.min_element() / STEPS / world_per_t;
        let steps = ((to - from) / step).ceil().max(1.0);
        let step = (to - from) / steps;
        let dt = step * world_per_t / self.unit_distance;
        let look = ShadingInputs {
            shading: self.shading,
            gradient_opacity: self.gradient_opacity,
            extinction: Extinction::Exponential,
            reached: Reached::ALL,
        };
        for n in 0..steps as usize {
            let p = ray.origin + ray.direction * (from + (n as f64 + 0.5) * step);
            let value = self.integrand.value(p);
            if self.transfer.opacity(value) == 0.0 {
                continue;
            }
            let opacity = -(-self.transfer.extinction(value) * dt).exp_m1();
            let (color, gradient) = (self.transfer.color(value), || self.integrand.gradient(p));
            let color = self.label_colors.as_ref().map_or(color, |labels| labels.mixed(p, color));
            let (color, opacity) = look.at(self.volume, gradient, to_eye, color, opacity);
            gathered.add(color, opacity);
            if gathered.transmittance < 1e-12 {
                break;
            }
        }
    }
}
