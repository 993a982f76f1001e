//! The converged volume rendering integral.

use super::field::Field;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Ray, Rays, Viewport};
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use glam::DVec3;
use rayon::prelude::*;

/// Steps per smallest spacing.
const STEPS: f64 = 16.0;

/// Emission and absorption along rays through the tricubic reconstruction (paper, Eq. 1 to 3), unshaded, in steps of
/// 1/16 of the smallest spacing, with the piecewise-linear transfer function itself.
pub struct Integral<'a> {
    field: Field,
    transfer: &'a TransferFunction,
    volume: &'a Volume,
    unit_distance: f64,
}

impl<'a> Integral<'a> {
    /// The integral for opacities per `unit_distance` (world units; by default the smallest spacing).
    pub fn new(volume: &'a Volume, transfer: &'a TransferFunction, unit_distance: Option<f64>) -> Self {
        let unit_distance = unit_distance.unwrap_or_else(|| volume.grid().spacing().min_element());
        Self { field: Field::new(volume), transfer, volume, unit_distance }
    }

    /// The picture of a camera.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        let pixels = (0..viewport.pixels())
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % viewport.width as usize, i / viewport.width as usize);
                self.composite(&rays.at(x as f64 + 0.5, y as f64 + 0.5)).map(|c| c as f32)
            })
            .collect();
        Ok(Frame::new(viewport, pixels))
    }

    /// Premultiplied RGBA along one ray.
    pub fn composite(&self, ray: &Ray) -> [f64; 4] {
        let Some((enter, leave)) = self.support(ray) else {
            return [0.0; 4];
        };
        let spacing = self.volume.grid().spacing();
        let world_per_t = (ray.direction * spacing).length();
        let step = spacing.min_element() / STEPS / world_per_t;
        let steps = ((leave - enter) / step).ceil().max(1.0);
        let step = (leave - enter) / steps;
        let dt = step * world_per_t / self.unit_distance;
        let mut color = [0.0; 3];
        let mut transmittance = 1.0;
        for n in 0..steps as usize {
            let value = self.field.value(ray.origin + ray.direction * (enter + (n as f64 + 0.5) * step));
            if self.transfer.opacity(value) == 0.0 {
                continue;
            }
            let opacity = -(-self.transfer.extinction(value) * dt).exp_m1();
            for (sum, c) in color.iter_mut().zip(self.transfer.color(value)) {
                *sum += transmittance * opacity * c;
            }
            transmittance *= 1.0 - opacity;
            if transmittance < 1e-12 {
                break;
            }
        }
        [color[0], color[1], color[2], 1.0 - transmittance]
    }

    /// Where a ray is in the field's support, [−1, n] per axis, as parameters of the ray.
    fn support(&self, ray: &Ray) -> Option<(f64, f64)> {
        let size = DVec3::from_array(self.field.dims().map(|n| n as f64));
        let (mut enter, mut leave) = (ray.start, f64::INFINITY);
        for i in 0..3 {
            let (o, d) = (ray.origin[i], ray.direction[i]);
            if d == 0.0 {
                if o <= -1.0 || o >= size[i] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-1.0 - o) / d, (size[i] - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (leave > enter).then_some((enter, leave))
    }
}
