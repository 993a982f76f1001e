//! The converged volume rendering integral.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::interval::{Interval, Region};
use super::shading::shade;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Kernel, Ray, Rays};
use crate::settings::{Blend, Clipping, Shading};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// Emission and absorption along rays through the reconstructed field (paper, Eq. 3), in steps of 1/16 of the smallest
/// spacing, with the piecewise-linear transfer function itself; lit, if so, at every step by central differences of the field
/// over one voxel each way.
pub struct Integral<'a> {
    field: Field,
    transfer: &'a TransferFunction,
    volume: &'a Volume<'a>,
    unit_distance: f64,
    /// What reconstructs the field. Default: the paper's cubic (Eq. 1 and 2).
    pub kernel: Kernel,
    /// How it is lit. Default: not at all.
    pub shading: Option<Shading>,
    /// What of it is shown. Default: all.
    pub clipping: Clipping,
}

impl<'a> Integral<'a> {
    /// The integral for opacities per `unit_distance` (world units; by default the smallest spacing).
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, unit_distance: Option<f64>) -> Self {
        let unit_distance = unit_distance.unwrap_or_else(|| volume.grid().spacing().min_element());
        Self {
            field: Field::new(volume, transfer, Blend::Composite),
            transfer,
            volume,
            unit_distance,
            kernel: Kernel::Cubic,
            shading: None,
            clipping: Clipping::default(),
        }
    }

    /// The picture of a camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    /// Where a ray is in the field, and counts.
    fn interval(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (enter, leave) = self.field.support(self.kernel, ray)?;
        let Interval { from, to } = Region::of_clipping(self.volume, &self.clipping).of(ray)?;
        let (enter, leave) = (enter.max(from), leave.min(to));
        (enter < leave).then_some((enter, leave))
    }

    /// Premultiplied RGBA along one ray; `to_eye` is the central ray's direction back to the eye, in the grid's axes.
    pub fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let Some((enter, leave)) = self.interval(ray) else {
            return [0.0; 4];
        };
        let spacing = self.volume.grid().spacing();
        let world_per_t = (ray.direction * spacing).length();
        let step = spacing.min_element() / STEPS / world_per_t;
        let steps = ((leave - enter) / step).ceil().max(1.0);
        let step = (leave - enter) / steps;
        let dt = step * world_per_t / self.unit_distance;
        let mut gathered = Gathered::new();
        for n in 0..steps as usize {
            let p = ray.origin + ray.direction * (enter + (n as f64 + 0.5) * step);
            let value = self.field.within_range(self.field.reconstructed(self.kernel, p));
            if self.transfer.opacity(value) == 0.0 {
                continue;
            }
            let opacity = -(-self.transfer.extinction(value) * dt).exp_m1();
            let mut color = self.transfer.color(value);
            if let Some(shading) = self.shading {
                color = shade(self.volume, shading, color, self.field.differences(self.kernel, p), to_eye);
            }
            gathered.add(color, opacity);
            if gathered.transmittance < 1e-12 {
                break;
            }
        }
        gathered.rgba()
    }
}
