//! The sheared lattice of a parallel view: m_u × m_v samples per voxel, moving with the ray.

use super::axis::{Axis, AxisFrame};
use super::rays::{Ray, Rays, Viewport, from_rows};
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// Most samples per voxel and axis of a lattice in phases. Closer views are rendered per pixel.
pub const MAX_SAMPLES_PER_VOXEL: u32 = 16;
/// Largest |s| of a lattice: phases have stencils for 1; others go on where two axes share a picture (`Axis::shares`).
const MAX_SHEAR_IN_PHASES: f64 = 1.0 + 1e-6;
const MAX_SHEAR: f64 = 1.06;
/// Samples kept around the viewport: the warp's filter reaches two, and one more keeps rounding away.
const MARGIN: f64 = 3.0;
/// How dense samples are where voxels are smaller than pixels, about as large, and much larger.
struct Rule {
    /// Samples per pixel, as long as these are no more than `per_voxel`. Hard edges need more than one.
    per_pixel: f64,
    /// Samples per voxel that are enough for what the kernel can show, until they are `pixels` apart.
    per_voxel: f64,
    /// Most pixels between samples.
    pixels: f64,
}

/// Aneurism, 1.16 pixels per voxel: 33.1 dB with 1 sample per voxel, 34.4 with 1 per pixel, 38.5 with 1.6. Neghip,
/// 4.7 pixels: 51.7 dB with samples 2 pixels apart, 52.1 with 1.6.
const RELAXED: Rule = Rule { per_pixel: 1.6, per_voxel: 1.86, pixels: 2.0 };
const FINE: Rule = Rule { per_pixel: 2.1, per_voxel: 2.35, pixels: 1.7 };
/// Samples per voxel from which on no voxel is missed, wherever samples lie.
pub(super) const ANCHOR_LIMIT: f64 = 1.5;
/// Samples per voxel this close above a whole number round down to it.
const CEIL_SLACK: f64 = 1e-6;

/// Samples per voxel of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// Nowhere coarser than the screen, at least this many.
    AtLeast(u32),
    /// Finer than the screen where voxels are small, coarser where they are large: up to 1.6 samples per pixel, up to 1.86
    /// per voxel, at most 2 pixels apart. The kernel has no finer detail to show, and the warp interpolates.
    Relaxed,
    /// The same with up to 2.1 samples per pixel, 2.35 per voxel, at most 1.7 pixels apart.
    Fine,
    /// This many, 1 … 16.
    Fixed(u32),
}

impl Rule {
    fn samples(&self, pixels: f64) -> f64 {
        (pixels * self.per_pixel).min((pixels / self.pixels).max(self.per_voxel))
    }
}

impl Density {
    /// Samples per voxel where a voxel covers `pixels` pixels; in general not whole.
    pub(super) fn samples(self, pixels: f64) -> f64 {
        match self {
            Density::AtLeast(m) => pixels.max(f64::from(m)),
            Density::Relaxed => RELAXED.samples(pixels),
            Density::Fine => FINE.samples(pixels),
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
/// u = centre_u + first_u + (I + ½)/m_u (I/m_u where voxels are odd in number and m is near 1), and moves by the shear from layer to layer; rows J likewise in v.
///
/// Where m is whole, I = i·m + p has the **phase** p: in one layer all samples of a phase have the same offset from the
/// voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Layer axis and in-layer axes.
    pub frame: AxisFrame,
    /// Voxels along u, v, a.
    pub dims: [usize; 3],
    /// Shear per layer.
    pub shear: [f64; 2],
    /// Samples per voxel along u and v.
    pub samples_per_voxel: [f64; 2],
    /// Samples along u and v.
    pub size: [u32; 2],
    /// +1 when rays run towards higher layers, else −1.
    pub layer_step: i32,
    first: [f64; 2],
    centre: DVec3,
    direction: DVec3,
}

impl Lattice {
    /// The lattice for a parallel view, cropped to what the viewport shows, or `None` where none reaches: |s| > 1.06 (a
    /// forced axis).
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density) -> Option<Self> {
        let mut lattice = Self::unsampled(rays, grid, axis, density, MAX_SHEAR)?;
        lattice.crop(rays, viewport, [1.0; 2]);
        Some(lattice)
    }

    /// The same with phases: whole samples per voxel, and whole voxels. `None` where |s| > 1, and where these are more than
    /// [`MAX_SAMPLES_PER_VOXEL`].
    pub fn in_phases(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density) -> Option<Self> {
        let mut lattice = Self::unsampled(rays, grid, axis, density, MAX_SHEAR_IN_PHASES)?;
        let m = lattice.samples_per_voxel.map(|m| (m - CEIL_SLACK).ceil());
        if m.iter().any(|&m| m > f64::from(MAX_SAMPLES_PER_VOXEL)) {
            return None;
        }
        lattice.samples_per_voxel = m;
        lattice.crop(rays, viewport, m);
        Some(lattice)
    }

    fn unsampled(rays: &Rays, grid: &Grid, axis: Axis, density: Density, max_shear: f64) -> Option<Self> {
        let frame = axis.frame();
        let direction = rays.central_direction();
        let shear = frame.shear(direction);
        if !shear.iter().all(|s| s.abs() <= max_shear) {
            return None;
        }
        let samples_per_voxel = [frame.u, frame.v].map(|i| density.samples(grid.spacing()[i] / rays.pixel_size).max(1.0));
        Some(Self {
            frame,
            dims: [frame.u, frame.v, frame.a].map(|i| grid.dims()[i]),
            shear,
            samples_per_voxel,
            size: [0; 2],
            layer_step: if direction[frame.a] > 0.0 { 1 } else { -1 },
            first: [0.0; 2],
            centre: frame.local(grid.centre_in_voxels()),
            direction,
        })
    }

    /// Sets the extent: whole cells of so many samples, anchored symmetrically to the centre, where the volume's shadow
    /// along the rays and the viewport overlap.
    fn crop(&mut self, rays: &Rays, viewport: Viewport, samples_per_cell: [f64; 2]) {
        let corners = rays.corners(viewport).map(|ray| self.crossing(ray));
        for (i, per_cell) in samples_per_cell.into_iter().enumerate() {
            let s = self.shear[i].abs();
            let m = self.samples_per_voxel[i];
            let cell = per_cell / m;
            let reach = (self.dims[i] as f64 + 1.0) / 2.0 + 2.0 * s + s * (self.dims[2] as f64 + 1.0) / 2.0;
            let half = (reach / cell).ceil();
            let seen = corners.map(|c| c[i]);
            let lo = seen.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - MARGIN / m;
            let hi = seen.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + MARGIN / m;
            let first = (lo / cell + half).floor().clamp(0.0, 2.0 * half);
            let last = (hi / cell + half).ceil().clamp(first, 2.0 * half);
            self.first[i] = (first - half) * cell;
            self.size[i] = ((last - first) * per_cell) as u32;
        }
    }

    /// Where a ray crosses the centre's plane, (u, v) from the centre, in voxels.
    fn crossing(&self, ray: Ray) -> [f64; 2] {
        let origin = self.frame.local(ray.origin) - self.centre;
        [origin.x - origin.z * self.shear[0], origin.y - origin.z * self.shear[1]]
    }

    /// Samples per voxel of a lattice in phases.
    pub fn phases(&self) -> [u32; 2] {
        self.samples_per_voxel.map(|m| m as u32)
    }

    /// Columns and rows of each phase.
    pub fn columns(&self) -> [u32; 2] {
        [0, 1].map(|i| self.size[i] / self.phases()[i])
    }

    /// For each column (`i` = 0) or row (1), and `padding` more: the voxel coordinate at which its rays cross the volume's
    /// middle layer, and their shear.
    pub fn crossings(&self, i: usize, padding: u32) -> Vec<[f32; 2]> {
        (0..self.size[i] + padding).map(|index| [self.position(i, f64::from(index)) as f32, self.shear[i] as f32]).collect()
    }

    /// The layer, in general half-integer, at which [`Self::crossings`] are given.
    pub fn centre_layer(&self) -> f64 {
        self.centre.z
    }

    /// Offsets along u (`i` = 0) or v (1) of each layer −1 … n and each phase, layer by layer.
    pub fn offsets(&self, i: usize) -> Vec<LayerOffset> {
        let m = self.phases()[i];
        (-1..=self.dims[2] as i64)
            .flat_map(|k| (0..m).map(move |p| (k, p)))
            .map(|(k, p)| {
                let position = self.position(i, f64::from(p)) + (k as f64 - self.centre.z) * self.shear[i];
                let base = position.floor();
                LayerOffset { base: base as i32, fraction: (position - base) as f32 }
            })
            .collect()
    }

    /// Where samples lie in their cells: symmetric to the centre, and so that about one per voxel lies on voxels, not between
    /// them, whether their number is even or odd.
    fn anchor(&self, i: usize) -> f64 {
        let between = self.dims[i] % 2 == 1 && self.samples_per_voxel[i] < ANCHOR_LIMIT;
        if between { 0.0 } else { 0.5 }
    }

    /// Voxel coordinate along u or v, on the centre's plane, of column or row `index`.
    fn position(&self, i: usize, index: f64) -> f64 {
        self.centre[i] + self.first[i] + (index + self.anchor(i)) / self.samples_per_voxel[i]
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
            let m = self.samples_per_voxel[i];
            let [p, px, py] = at.map(|c| (c[i] - self.first[i]) * m - self.anchor(i));
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
        (Lattice::in_phases(&rays, viewport, &grid, axis, Density::AtLeast(1)).unwrap(), rays)
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
        assert_eq!(lattice.phases(), [2, 2]);
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
        for (pixels, relaxed) in [(0.3, 0.48), (1.0, 1.6), (1.34, 1.86), (3.0, 1.86), (4.8, 2.4), (16.0, 8.0)] {
            assert_abs_diff_eq!(Density::Relaxed.samples(pixels), relaxed, epsilon = 1e-12);
            assert_eq!(Density::AtLeast(3).samples(pixels), pixels.max(3.0));
            assert_eq!(Density::Fixed(7).samples(pixels), 7.0);
        }
    }

    #[test]
    fn zooming_in_crops_and_then_leaves_the_lattice() {
        let (near, _) = lattice([64; 3], DVec3::ONE, Orbit::default(), 4.0);
        assert!(near.columns()[0] < 12, "{:?}", near.columns());
        let grid = Grid::new([64; 3], DVec3::ONE).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let camera = Camera::orbit(grid.centre(), 1.0, Orbit::default(), Projection::Parallel { scale: 0.5 });
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        assert!(Lattice::in_phases(&rays, viewport, &grid, Axis::Z, Density::AtLeast(1)).is_none());
    }
}
