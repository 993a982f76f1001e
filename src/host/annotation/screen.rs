//! Projection of world points to the screen.

use crate::camera::{Basis, Camera, Projection};
use crate::error::Error;
use crate::viewport::Viewport;
use glam::{DVec2, DVec3};

pub(super) struct Screen {
    camera: Camera,
    basis: Basis,
    viewport: Viewport,
}

/// Near plane of perspective views, as a fraction of the distance to the focal point.
const NEAREST: f64 = 1e-3;

impl Screen {
    pub fn new(camera: &Camera, viewport: Viewport) -> Result<Self, Error> {
        Ok(Self { camera: *camera, basis: camera.basis()?, viewport })
    }

    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Pixels per world unit, if that is uniform.
    pub fn pixels_per_unit(&self) -> Option<f64> {
        match self.camera.projection {
            Projection::Parallel { scale } => Some(f64::from(self.viewport.height) / 2.0 / scale),
            Projection::Perspective { .. } => None,
        }
    }

    /// Whether a surface with this normal at a point faces the camera.
    pub fn faces(&self, point: DVec3, normal: DVec3) -> bool {
        match self.camera.projection {
            Projection::Parallel { .. } => normal.dot(self.basis.forward) < 0.0,
            Projection::Perspective { .. } => normal.dot(self.camera.position - point) > 0.0,
        }
    }

    /// Distance from the plane through the eye.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.camera.position).dot(self.basis.forward)
    }

    /// Projects a line to pixel coordinates, clipped at the near plane. Pixel (0, 0) covers (0, 0) to (1, 1).
    pub fn line(&self, from: DVec3, to: DVec3) -> Option<[DVec2; 2]> {
        if let Projection::Parallel { .. } = self.camera.projection {
            return Some([self.pixel(from), self.pixel(to)]);
        }
        let near = NEAREST * self.camera.position.distance(self.camera.focal_point);
        let (a, b) = (self.depth(from) - near, self.depth(to) - near);
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let cut = from + (to - from) * (a / (a - b));
        let ends = [if a < 0.0 { cut } else { from }, if b < 0.0 { cut } else { to }];
        Some(ends.map(|end| self.pixel(end)))
    }

    /// Projects a point in front of the eye.
    fn pixel(&self, point: DVec3) -> DVec2 {
        let from_middle = point - self.camera.focal_point;
        let (width, height) = (f64::from(self.viewport.width), f64::from(self.viewport.height));
        let per_unit = match self.camera.projection {
            Projection::Parallel { scale } => height / 2.0 / scale,
            Projection::Perspective { field_of_view } => {
                height / 2.0 / (field_of_view.to_radians() / 2.0).tan() / self.depth(point)
            }
        };
        let (x, y) = (from_middle.dot(self.basis.right), from_middle.dot(self.basis.up));
        DVec2::new(width / 2.0 + x * per_unit, height / 2.0 - y * per_unit)
    }
}
