//! The sheared lattice of a parallel view: m_u × m_v samples per voxel, aligned with the grid, moving with the ray.

use super::axis::{Axis, AxisFrame};
use super::rays::{Ray, Rays, Viewport, from_rows};
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// Most samples per voxel and axis. Closer views are rendered per pixel.
pub const MAX_SAMPLES_PER_VOXEL: u32 = 16;
/// Samples kept around the viewport: the warp's filter reaches two, and one more keeps rounding away.
const MARGIN: f64 = 3.0;
/// Pixels between samples in [`Density::Relaxed`].
const RELAXED_PIXELS: f64 = 1.6;
/// Samples per voxel this close above a whole number round down to it.
const CEIL_SLACK: f64 = 1e-6;

/// Samples per voxel of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// Nowhere coarser than the screen, at least this many.
    AtLeast(u32),
    /// As the screen, but where a voxel covers more than two pixels up to 1.6 pixels apart: the kernel has no finer detail
    /// to show there, and the warp interpolates.
    Relaxed,
    /// This many, 1 … 16.
    Fixed(u32),
}

impl Density {
    /// Samples per voxel where a voxel covers `pixels` pixels; in general not whole.
    pub(super) fn samples(self, pixels: f64) -> f64 {
        match self {
            Density::AtLeast(m) => pixels.max(f64::from(m)),
            Density::Relaxed => pixels.min((pixels / RELAXED_PIXELS).max(2.0)),
            Density::Fixed(m) => f64::from(m),
        }
    }
}

/// Where the samples of one phase sit in one layer: sample column i lies at `base + i + fraction` voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerOffset {
    /// Voxel below the sample of column 0.
    pub base: i32,
    /// Distance from that voxel, 0 … 1.
    pub fraction: f32,
}

/// A sheared lattice. Column I holds the ray that crosses the plane of the volume's centre (a = centre_a) at
/// u = centre_u + first_u + (I + ½)/m_u, and moves by the shear from layer to layer; rows J likewise in v.
///
/// I = i·m + p has the **phase** p: in one layer all samples of a phase have the same offset from the voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Layer axis and in-layer axes.
    pub frame: AxisFrame,
    /// Voxels along u, v, a.
    pub dims: [usize; 3],
    /// Shear per layer, |s| ≤ 1 unless the axis was forced.
    pub shear: [f64; 2],
    /// Whole samples per voxel along u and v.
    pub samples_per_voxel: [u32; 2],
    /// Extent along u and v in voxels; each holds m samples.
    pub columns: [u32; 2],
    /// +1 when rays run towards higher layers, else −1.
    pub layer_step: i32,
    first: [f64; 2],
    centre: DVec3,
    direction: DVec3,
}

impl Lattice {
    /// The lattice for a parallel view, cropped to what the viewport shows, or `None` where none reaches: |s| > 1 (a
    /// forced axis), or closer than [`MAX_SAMPLES_PER_VOXEL`].
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density) -> Option<Self> {
        let frame = axis.frame();
        let direction = rays.central_direction();
        let shear = frame.shear(direction);
        if !shear.iter().all(|s| s.abs() <= 1.0 + 1e-6) {
            return None;
        }
        let samples_per_voxel = [frame.u, frame.v]
            .map(|i| (density.samples(grid.spacing()[i] / rays.pixel_size) - CEIL_SLACK).ceil().max(1.0) as u32);
        if samples_per_voxel.iter().any(|&m| m > MAX_SAMPLES_PER_VOXEL) {
            return None;
        }
        let dims = [frame.u, frame.v, frame.a].map(|i| grid.dims()[i]);
        let centre = frame.local(grid.centre_in_voxels());
        let mut lattice = Self {
            frame,
            dims,
            shear,
            samples_per_voxel,
            columns: [0; 2],
            layer_step: if direction[frame.a] > 0.0 { 1 } else { -1 },
            first: [0.0; 2],
            centre,
            direction,
        };
        lattice.crop(rays, viewport);
        Some(lattice)
    }

    /// Sets the extent: whole voxels, anchored symmetrically to the centre, where the volume's shadow along the rays
    /// and the viewport overlap.
    fn crop(&mut self, rays: &Rays, viewport: Viewport) {
        let (w, h) = (f64::from(viewport.width), f64::from(viewport.height));
        let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)].map(|(x, y)| self.crossing(rays.at(x, y)));
        for i in 0..2 {
            let s = self.shear[i].abs();
            let reach = (self.dims[i] as f64 + 1.0) / 2.0 + 2.0 * s + s * (self.dims[2] as f64 + 1.0) / 2.0;
            let half = reach.ceil();
            let margin = MARGIN / f64::from(self.samples_per_voxel[i]);
            let seen = corners.map(|c| c[i]);
            let lo = seen.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - margin;
            let hi = seen.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + margin;
            let first = (lo + half).floor().clamp(0.0, 2.0 * half);
            let last = (hi + half).ceil().clamp(first, 2.0 * half);
            self.first[i] = first - half;
            self.columns[i] = (last - first) as u32;
        }
    }

    /// Where a ray crosses the centre's plane, (u, v) from the centre, in voxels.
    fn crossing(&self, ray: Ray) -> [f64; 2] {
        let origin = self.frame.local(ray.origin) - self.centre;
        [origin.x - origin.z * self.shear[0], origin.y - origin.z * self.shear[1]]
    }

    /// Samples along u.
    pub fn width(&self) -> u32 {
        self.columns[0] * self.samples_per_voxel[0]
    }

    /// Samples along v.
    pub fn height(&self) -> u32 {
        self.columns[1] * self.samples_per_voxel[1]
    }

    /// Offsets along u (`i` = 0) or v (1) of each layer −1 … n and each phase, layer by layer.
    pub fn offsets(&self, i: usize) -> Vec<LayerOffset> {
        let m = self.samples_per_voxel[i];
        (-1..=self.dims[2] as i64)
            .flat_map(|k| (0..m).map(move |p| (k, p)))
            .map(|(k, p)| {
                let position = self.position(i, f64::from(p)) + (k as f64 - self.centre.z) * self.shear[i];
                let base = position.floor();
                LayerOffset { base: base as i32, fraction: (position - base) as f32 }
            })
            .collect()
    }

    /// Voxel coordinate along u or v, on the centre's plane, of column or row `index`.
    fn position(&self, i: usize, index: f64) -> f64 {
        self.centre[i] + self.first[i] + (index + 0.5) / f64::from(self.samples_per_voxel[i])
    }

    /// The ray of sample (I, J), in voxels (x, y, z).
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        let (u, v) = (self.position(0, f64::from(column)), self.position(1, f64::from(row)));
        let origin = self.frame.global(DVec3::new(u, v, self.centre.z));
        Ray { origin, direction: self.direction, start: f64::NEG_INFINITY }
    }

    /// Takes (x, y, 1) of the screen to (I, J, 1) of the lattice, sample centres at whole numbers.
    pub fn from_screen(&self, rays: &Rays) -> DMat3 {
        let at = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| self.crossing(rays.at(x, y)));
        let row = |i: usize| {
            let m = f64::from(self.samples_per_voxel[i]);
            let [p, px, py] = at.map(|c| (c[i] - self.first[i]) * m - 0.5);
            DVec3::new(px - p, py - p, p)
        };
        from_rows([row(0), row(1), DVec3::Z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use approx::assert_abs_diff_eq;

    fn lattice(dims: [usize; 3], spacing: DVec3, orbit: Orbit, scale: f64) -> (Lattice, Rays) {
        let grid = Grid::new(dims, spacing).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let camera = Camera::orbit(grid.centre(), 10.0, orbit, Projection::Parallel { scale });
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        let axis = Axis::most_parallel(rays.central_direction());
        (Lattice::new(&rays, viewport, &grid, axis, Density::AtLeast(1)).unwrap(), rays)
    }

    #[test]
    fn the_ray_of_a_pixel_is_the_ray_of_its_lattice_position() {
        for azimuth in [0.0, 30.0, 72.0, 200.0] {
            let orbit = Orbit { azimuth, elevation: 20.0, roll: 7.0 };
            let (lattice, rays) = lattice([17, 33, 5], DVec3::new(1.0, 0.5, 3.0), orbit, 12.0);
            let sample = lattice.from_screen(&rays) * DVec3::new(20.5, 31.5, 1.0);
            let pixel = rays.at(20.5, 31.5);
            let first = lattice.ray(0, 0);
            let next = lattice.ray(1, 1);
            let f = lattice.frame;
            let origin = f.local(first.origin) + (f.local(next.origin) - f.local(first.origin)) * sample.truncate().extend(0.0);
            let t = (origin.z - f.local(pixel.origin).z) / f.local(pixel.direction).z;
            let crossing = f.local(pixel.origin) + f.local(pixel.direction) * t;
            assert_abs_diff_eq!(crossing.x, origin.x, epsilon = 1e-9);
            assert_abs_diff_eq!(crossing.y, origin.y, epsilon = 1e-9);
        }
    }

    #[test]
    fn offsets_follow_the_shear_and_are_never_coarser_than_the_screen() {
        let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
        let (lattice, rays) = lattice([16, 16, 16], DVec3::ONE, orbit, 16.0);
        assert_eq!(lattice.samples_per_voxel, [2, 2]);
        assert!(1.0 / 2.0 <= rays.pixel_size);
        let offsets = lattice.offsets(0);
        let at = |k: usize, p: usize| f64::from(offsets[k * 2 + p].base) + f64::from(offsets[k * 2 + p].fraction);
        for k in 0..17 {
            assert_abs_diff_eq!(at(k + 1, 0) - at(k, 0), lattice.shear[0], epsilon = 1e-6);
            assert_abs_diff_eq!(at(k, 1) - at(k, 0), 0.5, epsilon = 1e-6);
        }
    }

    #[test]
    fn samples_per_voxel_follow_the_screen() {
        for (pixels, relaxed) in [(0.3, 0.3), (1.34, 1.34), (2.0, 2.0), (3.0, 2.0), (4.8, 3.0), (16.0, 10.0)] {
            assert_abs_diff_eq!(Density::Relaxed.samples(pixels), relaxed, epsilon = 1e-12);
            assert_eq!(Density::AtLeast(3).samples(pixels), pixels.max(3.0));
            assert_eq!(Density::Fixed(7).samples(pixels), 7.0);
        }
    }

    #[test]
    fn zooming_in_crops_and_then_leaves_the_lattice() {
        let (near, _) = lattice([64; 3], DVec3::ONE, Orbit::default(), 4.0);
        assert!(near.columns[0] < 12, "{:?}", near.columns);
        let grid = Grid::new([64; 3], DVec3::ONE).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let camera = Camera::orbit(grid.centre(), 1.0, Orbit::default(), Projection::Parallel { scale: 0.5 });
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        assert!(Lattice::new(&rays, viewport, &grid, Axis::Z, Density::AtLeast(1)).is_none());
    }
}
