//! Rays of a viewport, in voxel units.

use super::axis::AxisFrame;
use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// A ray: points `origin + t·direction` for `t > start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point on the ray near the volume, in voxels.
    pub origin: DVec3,
    /// Direction away from the eye in voxels, not normalised.
    pub direction: DVec3,
    /// Start of the ray: −∞ in a parallel view, the eye in a perspective.
    pub start: f64,
}

/// The rays of all pixels. Origins and directions are affine in the pixel coordinates (x, y), with pixel centres at half-integers:
/// `origin[0] + x·origin[1] + y·origin[2]`, and `direction` likewise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// Point on the ray, in voxels, on the plane through the volume's centre parallel to the screen, or the eye if that plane is behind
    /// it. This keeps coordinates small for distant eyes.
    pub origin: [DVec3; 3],
    /// Direction in voxels.
    pub direction: [DVec3; 3],
    /// See [`Ray::start`].
    pub start: f64,
    /// Side of a pixel in world units; per unit of depth in a perspective.
    pub pixel_size: f64,
    /// Unit vector from the volume to the eye along the central ray, in grid axes (world scale).
    pub to_eye: DVec3,
    /// Spacing of the grid in world units.
    pub spacing: DVec3,
}

impl Rays {
    /// The rays through points `[x, y]` pixels to the right and down. Each stands for a part of its pixel with a side of 1/`parts`:
    /// lattices are as dense, and pixels are filtered as little, as in a picture of `parts` times as many columns and rows.
    pub fn through_parts(self, [x, y]: [f64; 2], parts: u32) -> Self {
        let moved = |[base, right, down]: [DVec3; 3]| [base + x * right + y * down, right, down];
        let pixel_size = self.pixel_size / f64::from(parts);
        Self { origin: moved(self.origin), direction: moved(self.direction), pixel_size, ..self }
    }

    /// Rays of `camera` through the pixels of `viewport`, in voxel units of `grid`.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn new(camera: &Camera, viewport: Viewport, grid: &Grid) -> Result<Self, Error> {
        let basis = camera.basis()?;
        let (w, h) = (f64::from(viewport.width), f64::from(viewport.height));
        let to_voxels = grid.world_to_voxel_linear();
        let depth = (grid.centre() - camera.position).dot(basis.forward);
        let eye = grid.world_to_voxel(camera.position);
        // World vectors from the centre of the screen to its upper left corner, and one pixel to the right and down.
        let plane = |half_height: f64| {
            let pixel = 2.0 * half_height / h;
            let corner = basis.right * (-pixel * w / 2.0) + basis.up * half_height;
            ([corner, basis.right * pixel, basis.up * -pixel].map(|v| to_voxels * v), pixel)
        };
        let forward = to_voxels * basis.forward;
        let (origin, direction, start, pixel_size) = match camera.projection {
            Projection::Parallel { scale } => {
                let (p, pixel) = plane(scale);
                let origin = [eye + forward * depth + p[0], p[1], p[2]];
                (origin, [forward, DVec3::ZERO, DVec3::ZERO], f64::NEG_INFINITY, pixel)
            }
            Projection::Perspective { field_of_view } => {
                let (p, pixel) = plane((field_of_view.to_radians() / 2.0).tan());
                let direction = [forward + p[0], p[1], p[2]];
                let depth = depth.max(0.0);
                let origin = [eye + direction[0] * depth, direction[1] * depth, direction[2] * depth];
                (origin, direction, -depth, pixel)
            }
        };
        let to_eye = grid.world_to_grid_axes() * -basis.forward;
        Ok(Self { origin, direction, start, pixel_size, to_eye, spacing: grid.spacing() })
    }

    /// The rays through pixels that are `aspect` times as wide as high, about the same centre. Lattices are as dense as the shorter sides
    /// of pixels require.
    pub fn with_pixel_aspect(self, aspect: f64, viewport: Viewport) -> Self {
        let half_width = f64::from(viewport.width) / 2.0;
        let wider = |[base, right, down]: [DVec3; 3]| [base + right * half_width * (1.0 - aspect), right * aspect, down];
        let pixel_size = self.pixel_size * aspect.min(1.0);
        Self { origin: wider(self.origin), direction: wider(self.direction), pixel_size, ..self }
    }

    /// Whether all rays are parallel.
    pub fn is_parallel(&self) -> bool {
        self.start == f64::NEG_INFINITY
    }

    /// Ray through pixel coordinates (x, y); (½, ½) is the centre of the first pixel.
    pub fn at(&self, x: f64, y: f64) -> Ray {
        let along = |p: &[DVec3; 3]| p[0] + p[1] * x + p[2] * y;
        Ray { origin: along(&self.origin), direction: along(&self.direction), start: self.start }
    }

    /// Rays through the corners of the viewport. They bound all rays, which are affine in the pixel coordinates.
    pub fn corners(&self, viewport: Viewport) -> [Ray; 4] {
        let (w, h) = (f64::from(viewport.width), f64::from(viewport.height));
        [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)].map(|(x, y)| self.at(x, y))
    }

    /// Direction of the central ray in voxels.
    pub fn central_direction(&self) -> DVec3 {
        -self.to_eye / self.spacing
    }

    /// Voxels per pixel side along the in-layer axis of smaller spacing; in a perspective, at the volume's centre.
    pub fn voxels_per_pixel(&self, frame: AxisFrame) -> f64 {
        self.pixel_at_centre() / self.spacing[frame.u].min(self.spacing[frame.v])
    }

    /// Pixels per voxel step along a grid axis that is parallel to the screen; in a perspective, at the volume's centre.
    pub fn pixels_along(&self, axis: usize) -> f64 {
        self.spacing[axis] / self.pixel_at_centre()
    }

    /// Side of a pixel in world units at the volume's centre.
    fn pixel_at_centre(&self) -> f64 {
        if self.is_parallel() { self.pixel_size } else { self.pixel_size * -self.start }
    }

    /// Distance of parallel rays from pixel to pixel along x or y (0 or 1) of the screen, in [`Rays::pixel_size`]: more than 1 where each ray
    /// stands for a part of its pixel, or pixels are not square.
    pub(super) fn pixel_sides(&self, axis: usize) -> f64 {
        (self.origin[1 + axis] * self.spacing).length() / self.pixel_size
    }

    /// Whether a box, given by two corners in voxels, lies in front of the eye.
    pub fn all_ahead(&self, lowest: DVec3, highest: DVec3) -> bool {
        let Some(eye) = self.eye() else { return true };
        (0..8).all(|corner| {
            let upper = DVec3::from_array(std::array::from_fn(|i| f64::from(corner >> i & 1)));
            -((lowest + (highest - lowest) * upper - eye) * self.spacing).dot(self.to_eye) > 0.0
        })
    }

    /// Converts a direction (right, up, towards the viewer) to grid axes (world scale).
    pub fn from_camera_axes(&self, direction: DVec3) -> DVec3 {
        let pixels = if self.is_parallel() { &self.origin } else { &self.direction };
        let [right, down] = [pixels[1], pixels[2]].map(|step| (step * self.spacing).normalize());
        right * direction.x - down * direction.y + self.to_eye * direction.z
    }

    /// Eye of a perspective, in voxels.
    pub fn eye(&self) -> Option<DVec3> {
        (!self.is_parallel()).then(|| self.origin[0] + self.direction[0] * self.start)
    }

    /// Depth of `point` from `eye` in world units along the central ray. Both are (u, v, a) of `frame`, in voxels.
    pub(super) fn depth(&self, eye: DVec3, point: DVec3, frame: AxisFrame) -> f64 {
        -(frame.global(point - eye) * self.spacing).dot(self.to_eye)
    }
}

/// Matrix with the given rows.
pub(super) fn from_rows(rows: [DVec3; 3]) -> DMat3 {
    DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()
}
