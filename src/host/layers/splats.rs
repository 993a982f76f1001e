//! Splats of the sheet methods: screen position, depth and size.
//!
//! The kernel is isotropic in voxel units. Sheets are perpendicular to the central ray in voxel units; for cubic voxels, that is
//! perpendicular to the view. If anisotropic voxels would make other rays run along such sheets or cross them backwards, sheets are parallel
//! to the screen instead. A splat is the kernel seen along the central ray; in a perspective it is scaled by depth.

use super::gaussian::{GAUSSIAN_RADIUS, gaussian_integral};
use super::rays::Rays;
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec2, DVec3};

/// Splats closer to the eye's plane than this, in voxels, are omitted: they would cover the whole screen.
const NEAREST_SPLAT: f64 = 1.0;

/// Least cosine between rays and the sheet normal, in voxel units.
const STEEP: f64 = 0.5;

/// Projection of voxels to the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatProjection {
    /// Linear part of the projection of a point in voxels to (x·w, y·w, w), with pixel coordinates x and y. w is 1 in a parallel view.
    pub to_screen: DMat3,
    /// Translation of that projection.
    pub offset: DVec3,
    /// Gradient of depth. Depths are in voxels along the central ray.
    pub along: DVec3,
    /// Point of depth 0: the volume's centre, in voxels.
    pub centre: DVec3,
    /// Coefficients that map pixel offsets (dx, dy) to voxel offsets across the view, for w = 1: (f₀·dx + f₁·dy, f₂·dy).
    pub footprint: [f64; 3],
    /// Least depth of splats; −∞ in a parallel view.
    pub nearest: f64,
    /// Least w of splats; 0 in a parallel view.
    pub least_w: f64,
}

impl SplatProjection {
    /// Projection of a view of a volume.
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid) -> Self {
        let centre = DVec3::from_array(grid.dims().map(|n| (n as f64 - 1.0) / 2.0));
        let central = rays.central_direction().normalize();
        let (o, d) = (&rays.origin, &rays.direction);
        let (to_screen, offset, across, along, eye_depth) = match rays.eye() {
            None => {
                let inverse = DMat3::from_cols(o[1], o[2], d[0]).inverse();
                let at = inverse * -o[0];
                let affine = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]) * inverse;
                (affine, DVec3::new(at.x, at.y, 1.0), [o[1], o[2]], central, f64::NEG_INFINITY)
            }
            Some(eye) => {
                let inverse = DMat3::from_cols(d[1], d[2], d[0]).inverse();
                let along = normal_of_sheets(rays, viewport, central);
                (inverse, inverse * -eye, [d[1], d[2]], along, along.dot(eye - centre))
            }
        };
        let [gx, gy] = across.map(|g| g - central * central.dot(g));
        let ex = gx.normalize();
        let skew = ex.dot(gy);
        let footprint = [gx.length(), skew, (gy - ex * skew).length()];
        let least_w = if rays.is_parallel() { 0.0 } else { NEAREST_SPLAT * rays.spacing.min_element() };
        Self { to_screen, offset, along, centre, footprint, nearest: eye_depth + NEAREST_SPLAT, least_w }
    }

    /// Pixel coordinates and w of a point in voxels.
    pub fn project(&self, p: DVec3) -> (DVec2, f64) {
        let h = self.to_screen * p + self.offset;
        (h.truncate() / h.z, h.z)
    }

    /// Depth of a point: distance from the volume's centre along the central ray, in voxels.
    pub fn depth(&self, p: DVec3) -> f64 {
        self.along.dot(p - self.centre)
    }

    /// Squared distance across the view, in voxels, for a pixel offset from a splat of scale `w`.
    pub fn squared_distance(&self, offset: DVec2, w: f64) -> f64 {
        let [f0, f1, f2] = self.footprint.map(|f| f * w);
        DVec2::new(f0 * offset.x + f1 * offset.y, f2 * offset.y).length_squared()
    }

    /// Half the width and height of a splat in pixels, for w = 1.
    pub fn half_size(&self) -> DVec2 {
        let [f0, f1, f2] = self.footprint;
        DVec2::new(DVec2::new(1.0 / f0, f1 / (f0 * f2)).length(), 1.0 / f2) * GAUSSIAN_RADIUS
    }

    /// Least depth of sheets, so that every splat of a sheet is drawn.
    pub fn nearest_sheet(&self) -> f64 {
        self.nearest + GAUSSIAN_RADIUS
    }
}

/// Gradient of depth in a perspective: along the central ray, or perpendicular to the screen if a corner ray would meet the sheets too
/// obliquely.
fn normal_of_sheets(rays: &Rays, viewport: Viewport, central: DVec3) -> DVec3 {
    if rays.corners(viewport).iter().all(|ray| central.dot(ray.direction.normalize()) >= STEEP) {
        return central;
    }
    let facing = -rays.to_eye * rays.spacing;
    facing / facing.dot(central)
}

/// Slabs into which sheets cut a splat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatSlabs {
    /// Distance between sheets in voxels.
    pub distance: f64,
}

impl SplatSlabs {
    /// Largest number of sheets that a splat covers.
    pub fn count(self) -> usize {
        (2.0 * GAUSSIAN_RADIUS / self.distance).ceil() as usize + 1
    }

    /// First sheet that a splat at `depth` covers, and its distance from the first possible position, 0 … 1. Sheet s lies at s·distance.
    pub fn first(self, depth: f64) -> (i64, f64) {
        let from = (depth - GAUSSIAN_RADIUS) / self.distance - 0.5;
        (from.ceil() as i64, from.ceil() - from)
    }

    /// Mean of the kernel over the slab of the `n`-th covered sheet; `fraction` is that of [`SplatSlabs::first`].
    pub fn weight(self, n: usize, fraction: f64) -> f64 {
        let lo = (fraction + n as f64 - 1.0) * self.distance - GAUSSIAN_RADIUS;
        (gaussian_integral(lo + self.distance) - gaussian_integral(lo)) / self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::viewport::Viewport;
    use approx::assert_abs_diff_eq;

    #[test]
    fn voxels_land_where_their_rays_are() {
        let grid = Grid::new([9, 7, 5], DVec3::new(1.0, 5.0, 0.7)).unwrap();
        let size = Viewport::new(40, 30).unwrap();
        let orbit = Orbit { azimuth: 33.0, elevation: -20.0, roll: 15.0 };
        let cameras = [
            Camera::fit_parallel(grid.centre(), grid.diagonal(), size, orbit),
            Camera::fit_perspective(grid.centre(), grid.diagonal(), 40.0, size, orbit),
            Camera::fit_perspective(grid.centre(), grid.diagonal(), 150.0, size, orbit),
        ];
        for camera in cameras {
            let rays = Rays::new(&camera, size, &grid).unwrap();
            let projection = SplatProjection::new(&rays, size, &grid);
            let p = DVec3::new(1.0, 5.0, 3.0);
            let (pixel, w) = projection.project(p);
            let ray = rays.at(pixel.x, pixel.y);
            let off = p - ray.origin;
            assert_abs_diff_eq!(off.cross(ray.direction.normalize()).length(), 0.0, epsilon = 1e-9);
            assert!(w > 0.0);
            // Every ray crosses the sheets in order.
            assert!(rays.corners(size).iter().all(|ray| projection.along.dot(ray.direction) > 0.0));
            // The ray of an adjacent pixel crosses the splat's plane at the distance that the footprint gives.
            if rays.is_parallel() {
                let other = rays.at(pixel.x + 0.3, pixel.y - 0.8);
                let t = projection.along.dot(p - other.origin) / projection.along.dot(other.direction);
                let across = (other.origin + other.direction * t - p).length_squared();
                assert_abs_diff_eq!(projection.squared_distance(DVec2::new(0.3, -0.8), w), across, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn slabs_hold_the_whole_kernel() {
        for distance in [0.125, 0.3, 0.5, 1.0, 1.7, 4.0] {
            let slabs = SplatSlabs { distance };
            for depth in [-3.2, 0.0, 0.4, 7.9] {
                let (first, fraction) = slabs.first(depth);
                let total: f64 = (0..slabs.count()).map(|n| slabs.weight(n, fraction) * distance).sum();
                assert_abs_diff_eq!(total, 1.0, epsilon = 1e-12);
                // Sheets up to a voxel thick preserve the splat's position.
                let at = |n: usize| (first + n as i64) as f64 * distance;
                let mean: f64 = (0..slabs.count()).map(|n| at(n) * slabs.weight(n, fraction) * distance).sum();
                assert!(distance > 1.0 || (mean - depth).abs() < 0.01 * distance, "{distance} {depth}: {mean}");
            }
        }
        assert_eq!((SplatSlabs { distance: 1.0 }.count(), SplatSlabs { distance: 0.5 }.count()), (5, 9));
    }
}
