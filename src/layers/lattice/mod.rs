//! Lattices of rays: a ray keeps its column and row in all layers.

mod aligned;
mod density;
mod parallel;
mod perspective;
mod phases;
mod stagger;

pub use density::Density;
pub use perspective::MAX_LATTICE_SHEAR;
pub use phases::{LayerOffset, MAX_SAMPLES_PER_VOXEL, Phases};
pub use stagger::Stagger;

use super::axis::{Axis, AxisFrame};
use super::kernel::Kernel;
use super::rays::{Ray, Rays, from_rows};
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// Samples per voxel from which on no voxel is missed, wherever samples lie.
const ANCHOR_LIMIT: f64 = 1.5;

/// Most voxels between neighbouring points in a layer: kernels/layered/point_lattice.cl looks at two vectors of voxels for one of samples.
/// With the two voxels more on either side that gradients need, a row of samples spans no more.
const MAX_VOXELS_PER_POINT: f64 = 1.75;

/// How the layers of a lattice are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// By splatting their voxels: in a parallel view in phases.
    Splats,
    /// At points, of a kernel's field.
    Points(Kernel),
}

impl Sampling {
    /// How far the field reaches beyond the outer voxels.
    fn radius(self) -> f64 {
        match self {
            Sampling::Splats => 1.0,
            Sampling::Points(kernel) => f64::from(kernel.radius()),
        }
    }
}

/// The rays of the columns (or rows) of a lattice along u (or v): both numbers of ray I are affine in I − middle, where `middle` is half
/// of the last I.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineRays {
    /// Voxel coordinate at which ray `middle` crosses the layer of the volume's centre, and the distance to that of the next.
    pub crossing: [f64; 2],
    /// Shear of ray `middle`, and the difference to that of the next.
    pub shear: [f64; 2],
}

/// Where the rays of a lattice come from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// One direction in voxels (x, y, z).
    Direction(DVec3),
    /// An eye, (u, v, a).
    Eye(DVec3),
}

/// A lattice of rays: ray (I, J) crosses layer k at u = c_u(I) + (k − k_c) s_u(I), v = c_v(J) + (k − k_c) s_v(J), where k_c, in
/// general half-integer, is the layer of the volume's centre.
///
/// In a parallel view all shears are one, samples are a share of a voxel apart, and those of columns may lie behind the rows' (`stagger`);
/// in a perspective all rays meet in the eye.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Layer axis and in-layer axes.
    pub frame: AxisFrame,
    /// Voxels along u, v, a.
    pub dims: [usize; 3],
    /// Samples along u and v.
    pub size: [u32; 2],
    /// Samples per voxel along u and v; in a perspective, in the layer nearest to the eye.
    pub samples_per_voxel: [f64; 2],
    /// +1 when rays run towards higher layers, else −1.
    pub layer_step: i32,
    /// k_c.
    pub centre_layer: f64,
    /// The rays of the columns and of the rows.
    pub rays: [AffineRays; 2],
    /// Of the splatted layers of a parallel view.
    pub phases: Option<Phases>,
    /// Whether samples lie on pixels along u and v, so that nothing is interpolated.
    pub aligned: [bool; 2],
    /// By how much of a row the samples of columns lie behind, where they lie on pixels along both axes.
    pub stagger: Stagger,
    source: Source,
}

impl Lattice {
    /// The lattice of a layer axis for a view, cropped to what the viewport shows, or `None` where none reaches all rays or the volume
    /// comes too close. In a perspective `density` holds for the layer nearest to the eye.
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density, sampling: Sampling) -> Option<Self> {
        if rays.is_parallel() {
            parallel::lattice(rays, viewport, grid, axis, density, sampling)
        } else {
            perspective::lattice(rays, viewport, grid, axis, density, sampling)
        }
    }

    /// Whether a lattice of this layer axis can reach all rays of a perspective: none has too large a shear, and the eye is before the
    /// volume's layers.
    pub fn reaches_perspective(rays: &Rays, grid: &Grid, axis: Axis, sampling: Sampling) -> bool {
        perspective::reaches(rays, grid, axis, sampling)
    }

    /// Whether all rays are parallel.
    pub fn is_parallel(&self) -> bool {
        matches!(self.source, Source::Direction(_))
    }

    /// Whether each pixel has a sample of its own, so that nothing is interpolated.
    pub fn has_pixels_samples(&self) -> bool {
        self.aligned == [true; 2]
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Shear of the rays in the middle.
    pub fn shear(&self) -> [f64; 2] {
        self.rays.map(|r| r.shear[0])
    }

    /// Distance of column or row `index` from the middle one.
    fn offset_of(&self, i: usize, index: f64) -> f64 {
        index - (f64::from(self.size[i]) - 1.0) / 2.0
    }

    /// Voxel coordinate at which the rays of column (`i` = 0) or row (1) `index` cross the layer of the centre, and their shear.
    pub fn crossing(&self, i: usize, index: f64) -> [f64; 2] {
        let AffineRays { crossing, shear } = self.rays[i];
        [crossing, shear].map(|[middle, step]| middle + self.offset_of(i, index) * step)
    }

    /// The ray of sample (I, J), in voxels (x, y, z).
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        let u = self.crossing(0, f64::from(column));
        let v = self.crossing(1, f64::from(row) + self.stagger.of(column));
        let origin = self.frame.global(DVec3::new(u[0], v[0], self.centre_layer));
        match self.source {
            Source::Direction(direction) => Ray { origin, direction, start: f64::NEG_INFINITY },
            Source::Eye(eye) => {
                let direction = self.frame.global(DVec3::new(u[1], v[1], 1.0) * f64::from(self.layer_step));
                Ray { origin, direction, start: -(self.centre_layer - eye.z).abs() }
            }
        }
    }

    /// Takes (x, y, 1) of the screen to (I, J, 1)·w of the lattice, sample centres at whole numbers, but for their `stagger`; w is 1 in a
    /// parallel view, and has the sign of [`Self::forward`] for rays that reach the layers.
    pub fn from_screen(&self, rays: &Rays) -> DMat3 {
        match self.source {
            Source::Direction(_) => {
                let at = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| self.crossing_of(rays.at(x, y)));
                let row = |i: usize| {
                    let [middle, step] = self.rays[i].crossing;
                    let [p, px, py] = at.map(|c| (c[i] - middle) / step - self.offset_of(i, 0.0));
                    DVec3::new(px - p, py - p, p)
                };
                from_rows([row(0), row(1), DVec3::Z])
            }
            Source::Eye(_) => {
                let [d, dx, dy] = rays.direction.map(|d| self.frame.local(d));
                let row = |i: usize| {
                    let [middle, step] = self.rays[i].shear;
                    let numerator = |d: DVec3| (d[i] - middle * d.z) / step - self.offset_of(i, 0.0) * d.z;
                    DVec3::new(numerator(dx), numerator(dy), numerator(d))
                };
                from_rows([row(0), row(1), DVec3::new(dx.z, dy.z, d.z)])
            }
        }
    }

    /// Sign of w in front of the eye.
    pub fn forward(&self) -> f64 {
        if self.is_parallel() { 1.0 } else { f64::from(self.layer_step) }
    }

    /// Where a ray of a parallel view crosses the layer of the centre.
    fn crossing_of(&self, ray: Ray) -> [f64; 2] {
        let origin = self.frame.local(ray.origin);
        [0, 1].map(|i| origin[i] + (self.centre_layer - origin.z) * self.rays[i].shear[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_ray_of_a_pixel_is_the_ray_of_its_lattice_position() {
        let grid = Grid::new([17, 33, 25], DVec3::new(1.0, 0.5, 1.5)).unwrap();
        let viewport = Viewport::new(80, 60).unwrap();
        for projection in [Projection::Parallel { scale: 12.0 }, Projection::Perspective { field_of_view: 25.0 }] {
            for azimuth in [0.0, 30.0, 72.0, 95.0, 200.0] {
                let orbit = Orbit { azimuth, elevation: 20.0, roll: 7.0 };
                let camera = Camera::orbit(grid.centre(), 140.0, orbit, projection);
                let rays = Rays::new(&camera, viewport, &grid).unwrap();
                let axis = Axis::most_parallel(rays.central_direction());
                for sampling in [Sampling::Splats, Sampling::Points(Kernel::Cubic), Sampling::Points(Kernel::CatmullRom)] {
                    let lattice = Lattice::new(&rays, viewport, &grid, axis, Density::Relaxed, sampling).unwrap();
                    let place = lattice.from_screen(&rays) * DVec3::new(30.5, 20.5, 1.0);
                    assert!(place.z * lattice.forward() > 0.0);
                    let pixel = rays.at(30.5, 20.5);
                    let (origin, shear) = (lattice.frame.local(pixel.origin), lattice.frame.shear(pixel.direction));
                    for i in 0..2 {
                        let [crossing, of_lattice] = lattice.crossing(i, place[i] / place.z);
                        assert_abs_diff_eq!(of_lattice, shear[i], epsilon = 1e-9);
                        let expected = origin[i] + (lattice.centre_layer - origin.z) * shear[i];
                        assert_abs_diff_eq!(crossing, expected, epsilon = 1e-8);
                    }
                    let ray = lattice.ray(3, 2);
                    assert_abs_diff_eq!(lattice.frame.local(ray.origin).x, lattice.crossing(0, 3.0)[0], epsilon = 1e-9);
                }
            }
        }
    }
}
