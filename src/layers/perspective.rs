//! The lattice of a perspective: an eye ray keeps its (I, J) in all layers.

use super::axis::{Axis, AxisFrame};
use super::kernel_function::kernel_function;
use super::lattice::{ANCHOR_LIMIT, Density, MAX_SAMPLES_PER_VOXEL};
use super::rays::{Ray, Rays, Viewport, from_rows};
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// Largest |s| of a ray that a lattice takes. A field of view of 30° needs 1.65 when the volume just fits.
pub const MAX_LATTICE_SHEAR: f64 = 2.0;
/// The eye must be at least this far, in layers, before the first layer.
const MIN_EYE_DISTANCE: f64 = 1.0;
/// Voxels between neighbouring samples in the farthest layer: kernels/lattice_perspective.cl keeps 7 per sample.
const MAX_VOXELS_PER_SAMPLE: f64 = 7.0;
/// The same for kernels/point_lattice.cl, which looks at two vectors of voxels for one of samples.
const MAX_VOXELS_PER_POINT: f64 = 1.75;
/// Longest side of a lattice, in viewport sides: beyond it the near end of the volume is so close that the far end
/// would be sampled many times too densely, and pixels are fewer than samples.
const MAX_SIDES: u32 = 4;

/// A node z in \[−1, 1\] of the quadrature over the kernel's depth, with its weight: the weights sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussNode {
    /// Position, in layers.
    pub z: f64,
    /// Weight times f(z), scaled so that all sum to 1.
    pub weight: f64,
}

/// Four Gauss nodes on each half of \[−1, 1\], weighted with f(z): F(x, y) ≈ Σ w f(x + s_u z) f(y + s_v z), whose
/// lattice sum is exactly 1 because the weights sum to 1.
pub fn quadrature_nodes() -> [GaussNode; 8] {
    const HALF: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let mut nodes = [GaussNode { z: 0.0, weight: 0.0 }; 8];
    for (i, node) in nodes.iter_mut().enumerate() {
        let (x, w) = HALF[i % 4];
        node.z = (x + if i < 4 { -1.0 } else { 1.0 }) / 2.0;
        node.weight = w * kernel_function(node.z);
    }
    let sum: f64 = nodes.iter().map(|n| n.weight).sum();
    nodes.map(|n| GaussNode { weight: n.weight / sum, ..n })
}

/// A lattice of eye rays: column I holds the rays of shear s_u(I) = first_u + (I + ½)·step_u, rows J likewise in v.
#[derive(Clone, Debug, PartialEq)]
pub struct PerspectiveLattice {
    /// Layer axis and in-layer axes.
    pub frame: AxisFrame,
    /// Voxels along u, v, a.
    pub dims: [usize; 3],
    /// Samples along u and v.
    pub size: [u32; 2],
    /// Samples per voxel in the layer nearest to the eye.
    pub samples_per_voxel: [f64; 2],
    /// +1 when rays run towards higher layers, else −1.
    pub layer_step: i32,
    first: [f64; 2],
    step: [f64; 2],
    eye: DVec3,
    centre_layer: f64,
}

impl PerspectiveLattice {
    /// Whether a lattice of this layer axis can reach all rays: none leans more than [`MAX_LATTICE_SHEAR`], and the eye is
    /// before the volume's layers.
    pub fn reaches(rays: &Rays, grid: &Grid, axis: Axis) -> bool {
        Self::unsampled(rays, grid, axis).is_some()
    }

    /// The lattice for a perspective, or `None` where none reaches or the volume comes too close. `density` holds for the
    /// layer nearest to the eye.
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density) -> Option<Self> {
        let lattice = Self::sampled(rays, viewport, grid, axis, density, f64::INFINITY)?;
        let far = lattice.layer_distances().1;
        lattice.step.iter().all(|step| far * step <= MAX_VOXELS_PER_SAMPLE).then_some(lattice)
    }

    /// The same for point-sampled layers: finer where neighbouring rays would be more than 1.75 voxels apart in the farthest layer: with the
    /// two voxels more on either side that gradients need, a row of samples then spans no more than two vectors.
    pub fn of_points(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density) -> Option<Self> {
        Self::sampled(rays, viewport, grid, axis, density, MAX_VOXELS_PER_POINT)
    }

    fn sampled(
        rays: &Rays,
        viewport: Viewport,
        grid: &Grid,
        axis: Axis,
        density: Density,
        voxels_per_sample: f64,
    ) -> Option<Self> {
        let mut lattice = Self::unsampled(rays, grid, axis)?;
        let screen = lattice.screen_shears(rays, viewport);
        let corners = lattice.support_corners();
        for i in 0..2 {
            let (mut lo, mut hi) = lattice.shear_bounds(i);
            let (near, far) = lattice.layer_distances();
            let spacing = grid.spacing()[[lattice.frame.u, lattice.frame.v][i]];
            // Pixels that a voxel of the nearest layer would cover, by the shear per pixel at a corner of the volume.
            let pixels = |c: &DVec3| {
                let depth = rays.depth(lattice.eye, *c, lattice.frame);
                spacing * (c.z - lattice.eye.z).abs() / (depth * rays.pixel_size * near)
            };
            let pixels = corners.iter().map(pixels).fold(0.0, f64::max);
            // Where pixels cover several voxels their mean is shown: no voxel may be missed.
            let least = if pixels < 1.0 { ANCHOR_LIMIT } else { 0.0 };
            let samples_per_voxel = density.samples(pixels).max(far / near / voxels_per_sample).max(least);
            let step = 1.0 / (samples_per_voxel * near);
            if let Some(screen) = screen {
                let (seen_lo, seen_hi) = bounds(&screen.map(|s| s[i]));
                (lo, hi) = (lo.max(seen_lo - 3.0 * step), hi.min(seen_hi + 3.0 * step));
            }
            let samples = ((hi - lo) / step).ceil().max(0.0);
            // Where pixels cover several voxels it is these that number the samples.
            let sides = if pixels < 1.0 { Viewport::MAX_SIDE } else { [viewport.width, viewport.height][i].max(64) * MAX_SIDES };
            let most = f64::from(sides);
            if samples > most || samples_per_voxel > f64::from(MAX_SAMPLES_PER_VOXEL) {
                return None;
            }
            lattice.size[i] = samples as u32;
            lattice.samples_per_voxel[i] = samples_per_voxel;
            lattice.step[i] = step;
            lattice.first[i] = (lo + hi - samples * step) / 2.0;
        }
        Some(lattice)
    }

    /// The lattice without its samples, if it reaches.
    fn unsampled(rays: &Rays, grid: &Grid, axis: Axis) -> Option<Self> {
        let frame = axis.frame();
        let dims = [frame.u, frame.v, frame.a].map(|i| grid.dims()[i]);
        let eye = frame.local(rays.eye()?);
        let centre_layer = (dims[2] as f64 - 1.0) / 2.0;
        let lattice = Self {
            frame,
            dims,
            size: [0; 2],
            samples_per_voxel: [0.0; 2],
            layer_step: if eye.z < centre_layer { 1 } else { -1 },
            first: [0.0; 2],
            step: [0.0; 2],
            eye,
            centre_layer,
        };
        let (near, _) = lattice.layer_distances();
        let ahead = lattice.support_corners().iter().all(|c| rays.depth(eye, *c, frame) > 0.0);
        let upright = (0..2).all(|i| {
            let (lo, hi) = lattice.shear_bounds(i);
            lo.abs().max(hi.abs()) <= MAX_LATTICE_SHEAR
        });
        (near >= MIN_EYE_DISTANCE && ahead && upright).then_some(lattice)
    }

    /// Distances, in layers, from the eye to the nearest and the farthest layer of the support; the nearest is not
    /// positive for an eye beside or inside.
    fn layer_distances(&self) -> (f64, f64) {
        let to = |k: f64| (k - self.eye.z) * f64::from(self.layer_step);
        let (a, b) = (to(-1.0), to(self.dims[2] as f64));
        (a.min(b), a.max(b))
    }

    /// Shears of the rays to the corners of the support.
    fn shear_bounds(&self, i: usize) -> (f64, f64) {
        bounds(&self.support_corners().map(|c| (c[i] - self.eye[i]) / (c.z - self.eye.z)))
    }

    /// The corners of the field's support, (u, v, a).
    fn support_corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|c| {
            DVec3::from_array(std::array::from_fn(|i| if c >> i & 1 == 0 { -1.0 } else { self.dims[i] as f64 }))
        })
    }

    /// Shears of the rays through the viewport's corners, unless one of them runs away from the layers.
    fn screen_shears(&self, rays: &Rays, viewport: Viewport) -> Option<[[f64; 2]; 4]> {
        let directions = rays.corners(viewport).map(|ray| ray.direction);
        let ahead = directions.iter().all(|d| d[self.frame.a] * f64::from(self.layer_step) > 0.0);
        ahead.then(|| directions.map(|d| self.frame.shear(d)))
    }

    /// For each column (`i` = 0) or row (1), and `padding` more: the voxel coordinate at which its rays cross the volume's middle layer, and
    /// their shear.
    pub fn crossings(&self, i: usize, padding: u32) -> Vec<[f32; 2]> {
        (0..self.size[i] + padding)
            .map(|index| {
                let shear = self.shear(i, f64::from(index));
                [(self.eye[i] + (self.centre_layer - self.eye.z) * shear) as f32, shear as f32]
            })
            .collect()
    }

    /// The layer, in general half-integer, at which [`Self::crossings`] are given.
    pub fn centre_layer(&self) -> f64 {
        self.centre_layer
    }

    fn shear(&self, i: usize, index: f64) -> f64 {
        self.first[i] + (index + 0.5) * self.step[i]
    }

    /// The ray of sample (I, J), in voxels (x, y, z).
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        let shear = DVec3::new(self.shear(0, f64::from(column)), self.shear(1, f64::from(row)), 1.0);
        let to_centre = self.centre_layer - self.eye.z;
        let sign = f64::from(self.layer_step);
        Ray {
            origin: self.frame.global(self.eye + shear * to_centre),
            direction: self.frame.global(shear * sign),
            start: -to_centre.abs(),
        }
    }

    /// Takes (x, y, 1) of the screen to (I, J, 1)·w of the lattice, sample centres at whole numbers; w has the sign of
    /// `layer_step` for rays that reach the layers.
    pub fn from_screen(&self, rays: &Rays) -> DMat3 {
        let [d, dx, dy] = rays.direction.map(|d| self.frame.local(d));
        let row = |i: usize| {
            let numerator = |d: DVec3| (d[i] - self.first[i] * d.z) / self.step[i] - 0.5 * d.z;
            DVec3::new(numerator(dx), numerator(dy), numerator(d))
        };
        from_rows([row(0), row(1), DVec3::new(dx.z, dy.z, d.z)])
    }
}

fn bounds(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &v| (lo.min(v), hi.max(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::footprint;
    use approx::assert_abs_diff_eq;

    /// math.md states 0.25 % of the value range for eight nodes and |s| ≤ 1; single footprints are within this.
    const QUADRATURE_ERROR: f64 = 0.0025;

    #[test]
    fn nodes_sum_to_one_and_approach_the_footprint() {
        let nodes = quadrature_nodes();
        assert_abs_diff_eq!(nodes.iter().map(|n| n.weight).sum::<f64>(), 1.0, epsilon = 1e-15);
        let mut largest: f64 = 0.0;
        for (s_u, s_v) in [(0.0, 0.0), (0.4, -0.9), (1.0, 1.0), (1.0, 0.3)] {
            for (x, y) in [(0.0, 0.0), (0.5, 0.25), (0.9, 0.1), (0.33, 1.2)] {
                let sum: f64 =
                    nodes.iter().map(|n| n.weight * kernel_function(x + s_u * n.z) * kernel_function(y + s_v * n.z)).sum();
                largest = largest.max((sum - footprint(x, y, s_u, s_v)).abs());
            }
        }
        assert!(largest < QUADRATURE_ERROR, "{largest}");
    }

    #[test]
    fn the_ray_of_a_pixel_is_the_ray_of_its_lattice_position() {
        let grid = Grid::new([20, 30, 25], DVec3::ONE).unwrap();
        let viewport = Viewport::new(80, 60).unwrap();
        for azimuth in [0.0, 40.0, 95.0, 190.0] {
            let orbit = Orbit { azimuth, elevation: 10.0, roll: 3.0 };
            let camera = Camera::orbit(grid.centre(), 100.0, orbit, Projection::Perspective { field_of_view: 25.0 });
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let axis = Axis::most_parallel(rays.central_direction());
            let lattice = PerspectiveLattice::new(&rays, viewport, &grid, axis, Density::AtLeast(1)).unwrap();
            let p = lattice.from_screen(&rays) * DVec3::new(30.5, 20.5, 1.0);
            assert!(p.z * f64::from(lattice.layer_step) > 0.0);
            let shear = lattice.frame.shear(rays.at(30.5, 20.5).direction);
            assert_abs_diff_eq!(lattice.shear(0, p.x / p.z), shear[0], epsilon = 1e-9);
            assert_abs_diff_eq!(lattice.shear(1, p.y / p.z), shear[1], epsilon = 1e-9);
        }
    }

    #[test]
    fn an_eye_inside_or_a_wide_angle_has_no_lattice() {
        let grid = Grid::new([32; 3], DVec3::ONE).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let lattice = |azimuth: f64, distance: f64, field_of_view: f64| {
            let orbit = Orbit { azimuth, elevation: 0.0, roll: 0.0 };
            let camera = Camera::orbit(grid.centre(), distance, orbit, Projection::Perspective { field_of_view });
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let axis = Axis::most_parallel(rays.central_direction());
            PerspectiveLattice::new(&rays, viewport, &grid, axis, Density::AtLeast(1))
        };
        assert!(lattice(0.0, 104.0, 30.0).is_some());
        assert!(lattice(45.0, 104.0, 30.0).is_some());
        assert!(lattice(0.0, 3.0, 30.0).is_none());
        assert!(lattice(45.0, 38.0, 90.0).is_none());
    }
}
