//! How the sheet methods see voxels: where their splats lie on the screen and in depth, and how large they are there.
//!
//! The kernel is round in voxel units, and so is space here: sheets are at right angles to the central ray in voxel units,
//! which for cubic voxels is at right angles to the view. Where flat voxels would let other rays run along such sheets, or
//! meet them backwards, sheets are parallel to the screen instead. A splat is its kernel as seen along the central ray, in a
//! perspective scaled by its depth.

use super::gaussian::{GAUSSIAN_RADIUS, gaussian_integral};
use super::rays::Rays;
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec2, DVec3};

/// Splats nearer to the eye's plane than this, in voxels, are left out: they would cover any screen.
const NEAREST_SPLAT: f64 = 1.0;

/// Least cosine between rays and the normal of sheets, in voxel units.
const STEEP: f64 = 0.5;

/// The projection of voxels onto the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatProjection {
    /// With `offset`: a point p in voxels to (x·w, y·w, w), pixel coordinates times w; w = 1 in a parallel view.
    pub to_screen: DMat3,
    /// See `to_screen`.
    pub offset: DVec3,
    /// Depth per voxel along x, y and z: depths are in voxels along the central ray.
    pub along: DVec3,
    /// The point whose depth is 0: the volume's centre, in voxels.
    pub centre: DVec3,
    /// Pixel offsets (dx, dy) to offsets across the view, in voxels for w = 1: (f₀·dx + f₁·dy, f₂·dy).
    pub footprint: [f64; 3],
    /// Splats of less depth are left out; −∞ in a parallel view.
    pub nearest: f64,
    /// And splats of less w; 0 in a parallel view.
    pub least_w: f64,
}

impl SplatProjection {
    /// The projection of a view onto a volume.
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

    /// Pixel coordinates of a point in voxels, and w.
    pub fn project(&self, p: DVec3) -> (DVec2, f64) {
        let h = self.to_screen * p + self.offset;
        (h.truncate() / h.z, h.z)
    }

    /// Depth of a point, in voxels along the central ray from the volume's centre.
    pub fn depth(&self, p: DVec3) -> f64 {
        self.along.dot(p - self.centre)
    }

    /// Squared distance across the view, in voxels, between a pixel and a splat at a pixel offset, of scale `w`.
    pub fn squared_distance(&self, offset: DVec2, w: f64) -> f64 {
        let [f0, f1, f2] = self.footprint.map(|f| f * w);
        DVec2::new(f0 * offset.x + f1 * offset.y, f2 * offset.y).length_squared()
    }

    /// Half the width and height of a splat in pixels, for w = 1.
    pub fn half_size(&self) -> DVec2 {
        let [f0, f1, f2] = self.footprint;
        DVec2::new(DVec2::new(1.0 / f0, f1 / (f0 * f2)).length(), 1.0 / f2) * GAUSSIAN_RADIUS
    }

    /// Depth of the nearest sheet that is drawn: all splats that reach it are.
    pub fn nearest_sheet(&self) -> f64 {
        self.nearest + GAUSSIAN_RADIUS
    }
}

/// Depth per voxel in a perspective: along the central ray, or where any ray, a corner's, meets such sheets too flatly, in planes
/// parallel to the screen.
fn normal_of_sheets(rays: &Rays, viewport: Viewport, central: DVec3) -> DVec3 {
    if rays.corners(viewport).iter().all(|ray| central.dot(ray.direction.normalize()) >= STEEP) {
        return central;
    }
    let facing = -rays.to_eye * rays.spacing;
    facing / facing.dot(central)
}

/// The slabs into which sheets `distance` voxels apart cut a splat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatSlabs {
    /// Distance of sheets, in voxels.
    pub distance: f64,
}

impl SplatSlabs {
    /// Most sheets that a splat reaches.
    pub fn count(self) -> usize {
        (2.0 * GAUSSIAN_RADIUS / self.distance).ceil() as usize + 1
    }

    /// The first sheet that a splat at a depth reaches, and how far beyond the first possible place it lies, 0 … 1.
    /// Sheet s lies at s·distance.
    pub fn first(self, depth: f64) -> (i64, f64) {
        let from = (depth - GAUSSIAN_RADIUS) / self.distance - 0.5;
        (from.ceil() as i64, from.ceil() - from)
    }

    /// Mean of the kernel over the slab of the n-th sheet reached, for a fraction from [`SplatSlabs::first`].
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
            // Every ray meets the sheets in order.
            assert!(rays.corners(size).iter().all(|ray| projection.along.dot(ray.direction) > 0.0));
            // A neighbouring pixel's ray crosses the splat's plane as far away as the footprint says.
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
                // Sheets no thicker than a voxel keep the splat's place.
                let at = |n: usize| (first + n as i64) as f64 * distance;
                let mean: f64 = (0..slabs.count()).map(|n| at(n) * slabs.weight(n, fraction) * distance).sum();
                assert!(distance > 1.0 || (mean - depth).abs() < 0.01 * distance, "{distance} {depth}: {mean}");
            }
        }
        assert_eq!((SplatSlabs { distance: 1.0 }.count(), SplatSlabs { distance: 0.5 }.count()), (5, 9));
    }
}
