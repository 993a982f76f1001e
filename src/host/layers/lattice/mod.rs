//! Ray lattices: grids of rays with the same column and row in every layer.

mod aligned;
mod crossings;
mod density;
mod lines;
mod parallel;
mod perspective;
mod phases;
mod pixel_rays;
mod stagger;

pub use density::Density;
pub use lines::Lines;
pub use perspective::MAX_LATTICE_SHEAR;
pub use phases::{LayerOffset, MAX_SAMPLES_PER_VOXEL, Phases};
pub use pixel_rays::PixelRays;
pub use stagger::Stagger;

use super::axis::{Axis, AxisFrame};
use super::kernel::Kernel;
use super::rays::{Ray, Rays, from_rows};
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::{DMat3, DVec3};

/// Samples per voxel at or above which every voxel is sampled, regardless of the position of the samples.
const ANCHOR_LIMIT: f64 = 1.5;

/// Largest distance between adjacent points in a layer, in voxels. kernels/layered/point_lattice.cl reads two vectors of voxels per vector
/// of samples; that is the span of a row of samples plus two voxels on either side for gradients.
const MAX_VOXELS_PER_POINT: f64 = 1.75;

/// Sampling of the layers of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Splatting of voxels; in phases in a parallel view.
    Splats,
    /// Point sampling of a kernel's field.
    Points(Kernel),
}

impl Sampling {
    /// Extent of the field beyond the outermost voxels.
    fn radius(self) -> f64 {
        match self {
            Sampling::Splats => 1.0,
            Sampling::Points(kernel) => f64::from(kernel.radius()),
        }
    }
}

/// Corners of the support of a field, (u, v, a), for volumes of these dimensions.
fn support_corners(dims: [usize; 3], sampling: Sampling) -> [DVec3; 8] {
    let radius = sampling.radius();
    std::array::from_fn(|c| {
        DVec3::from_array(std::array::from_fn(|i| if c >> i & 1 == 0 { -radius } else { dims[i] as f64 - 1.0 + radius }))
    })
}

/// Rays of the columns (or rows) of a lattice along u (or v). Crossing and shear of ray I are affine in I − middle, where `middle` is half
/// the last index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineRays {
    /// Voxel coordinate at which ray `middle` crosses the centre layer, and step to the next ray.
    pub crossing: [f64; 2],
    /// Shear of ray `middle`, and step to the next ray.
    pub shear: [f64; 2],
}

/// Origin of the rays of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// A common direction in voxels (x, y, z).
    Direction(DVec3),
    /// An eye point (u, v, a).
    Eye(DVec3),
}

/// An axis of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScreenAxis {
    /// Along rows of pixels.
    X,
    /// Along columns of pixels.
    Y,
}

/// A lattice of rays. Ray (I, J) crosses layer k at u = c_u(I) + (k − k_c) s_u(I), v = c_v(J) + (k − k_c) s_v(J). k_c is the layer of
/// the volume's centre, possibly a half-integer.
///
/// In a parallel view all rays have the same shear, and columns may be shifted by fractions of a row (`stagger`, this project's own). In a
/// perspective all rays meet at the eye.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Layer axis and in-layer axes.
    pub frame: AxisFrame,
    /// Number of voxels along u, v, a.
    pub dims: [usize; 3],
    /// Number of samples along u and v.
    pub size: [u32; 2],
    /// Samples per voxel along u and v; in a perspective, in the layer nearest to the eye, or with `pixel_rays` where there are fewest.
    pub samples_per_voxel: [f64; 2],
    /// +1 if rays run towards higher layers, else −1.
    pub layer_step: i32,
    /// Layer of the volume's centre, k_c.
    pub centre_layer: f64,
    /// Rays of the columns and of the rows.
    pub rays: [AffineRays; 2],
    /// Phases of splatted layers in a parallel view.
    pub phases: Option<Phases>,
    /// Whether samples coincide with pixels along u and v, so that the warp need not interpolate.
    pub aligned: [bool; 2],
    /// Screen axis along which pixels lie between columns, if these have a sample wherever a row (x) or a column (y) of pixels crosses
    /// them. The warp interpolates along that axis alone.
    pub crossed_along: Option<ScreenAxis>,
    /// Shift of the columns in fractions of a row, if these have samples on pixels, or on rows or columns of pixels.
    pub stagger: Stagger,
    /// Rays of samples that are pixels, where columns of pixels lean. `rays` has only the ray in the middle then, with steps of 0.
    pub pixel_rays: Option<Box<PixelRays>>,
    source: Source,
}

impl Lattice {
    /// The lattice of a layer axis for a view, cropped to the viewport. `None` if no lattice covers all rays, or the volume is too close. In
    /// a perspective, `density` applies to the layer nearest to the eye.
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, density: Density, sampling: Sampling) -> Option<Self> {
        if rays.is_parallel() {
            parallel::lattice(rays, viewport, grid, axis, density, sampling)
        } else {
            perspective::lattice(rays, viewport, grid, axis, density, sampling)
        }
    }

    /// Whether a lattice of this layer axis covers all rays of a perspective: no shear is too large, and the eye is in front of all layers.
    pub fn reaches_perspective(rays: &Rays, grid: &Grid, axis: Axis, sampling: Sampling) -> bool {
        perspective::reaches(rays, grid, axis, sampling)
    }

    /// Whether all rays are parallel.
    pub fn is_parallel(&self) -> bool {
        matches!(self.source, Source::Direction(_))
    }

    /// Whether every pixel coincides with a sample, so that the warp need not interpolate.
    pub fn has_pixels_samples(&self) -> bool {
        self.aligned == [true; 2]
    }

    /// Whether columns are staggered.
    fn is_staggered(&self) -> bool {
        self.has_pixels_samples() || self.crossed_along.is_some()
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Shear of the central rays.
    pub fn shear(&self) -> [f64; 2] {
        self.rays.map(|r| r.shear[0])
    }

    /// Distance of column or row `index` from the middle one.
    fn offset_of(&self, i: usize, index: f64) -> f64 {
        index - (f64::from(self.size[i]) - 1.0) / 2.0
    }

    /// Crossing of column (`i` = 0) or row (1) `index` with the centre layer in voxels, and its shear. Not of lattices with `pixel_rays`.
    pub fn crossing(&self, i: usize, index: f64) -> [f64; 2] {
        let AffineRays { crossing, shear } = self.rays[i];
        [crossing, shear].map(|[middle, step]| middle + self.offset_of(i, index) * step)
    }

    /// Ray of sample (I, J), in voxels (x, y, z).
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        let [u, v] = match &self.pixel_rays {
            Some(pixel_rays) => {
                let offset = pixel_rays.offset(self.offset_of(0, f64::from(column)), self.offset_of(1, f64::from(row)));
                [0, 1].map(|i| {
                    let AffineRays { crossing, shear } = self.rays[i];
                    [0, 1].map(|n| [crossing[0], shear[0]][n] + pixel_rays.spread[n] * offset[i])
                })
            }
            None => [self.crossing(0, f64::from(column)), self.crossing(1, f64::from(row) + self.stagger.shift(column))],
        };
        let origin = self.frame.global(DVec3::new(u[0], v[0], self.centre_layer));
        match self.source {
            Source::Direction(direction) => Ray { origin, direction, start: f64::NEG_INFINITY },
            Source::Eye(eye) => {
                let direction = self.frame.global(DVec3::new(u[1], v[1], 1.0) * f64::from(self.layer_step));
                Ray { origin, direction, start: -(self.centre_layer - eye.z).abs() }
            }
        }
    }

    /// Matrix from (x, y, 1) on the screen to (I, J, 1)·w on the lattice, without the stagger; samples have integer coordinates. w is 1 in a
    /// parallel view. In a perspective it has the sign of [`Self::forward`] for rays that reach the layers.
    pub fn from_screen(&self, rays: &Rays) -> DMat3 {
        if let Some(pixel_rays) = &self.pixel_rays {
            return pixel_rays.screen_matrix();
        }
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

    /// Sign of w for points in front of the eye.
    pub fn forward(&self) -> f64 {
        if self.is_parallel() || self.pixel_rays.is_some() { 1.0 } else { f64::from(self.layer_step) }
    }

    /// Crossing of a ray of a parallel view with the centre layer.
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
        let mut compared = 0;
        for projection in [Projection::Parallel { scale: 12.0 }, Projection::Perspective { field_of_view: 25.0 }] {
            for azimuth in [0.0, 30.0, 72.0, 95.0, 200.0] {
                let orbit = Orbit { azimuth, elevation: 20.0, roll: 7.0 };
                let camera = Camera::orbit(grid.centre(), 140.0, orbit, projection);
                let rays = Rays::new(&camera, viewport, &grid).unwrap();
                let axis = Axis::most_parallel(rays.central_direction());
                for sampling in [Sampling::Splats, Sampling::Points(Kernel::Cubic), Sampling::Points(Kernel::CatmullRom)] {
                    let lattice = Lattice::new(&rays, viewport, &grid, axis, Density::Relaxed, sampling).unwrap();
                    if lattice.pixel_rays.is_some() {
                        continue; // their own test: pixel_rays.rs
                    }
                    let place = lattice.from_screen(&rays) * DVec3::new(30.5, 20.5, 1.0);
                    assert!(place.z * lattice.forward() > 0.0);
                    let pixel = rays.at(30.5, 20.5);
                    let (origin, shear) = (lattice.frame.local(pixel.origin), lattice.frame.shear(pixel.direction));
                    for i in 0..2 {
                        let [crossing, lattice_shear] = lattice.crossing(i, place[i] / place.z);
                        assert_abs_diff_eq!(lattice_shear, shear[i], epsilon = 1e-9);
                        let expected = origin[i] + (lattice.centre_layer - origin.z) * shear[i];
                        assert_abs_diff_eq!(crossing, expected, epsilon = 1e-8);
                    }
                    let ray = lattice.ray(3, 2);
                    assert_abs_diff_eq!(lattice.frame.local(ray.origin).x, lattice.crossing(0, 3.0)[0], epsilon = 1e-9);
                    compared += 1;
                }
            }
        }
        assert!(compared > 20, "{compared}");
    }
}
