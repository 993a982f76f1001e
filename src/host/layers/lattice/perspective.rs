//! Lattice of a perspective view: shears of the rays are evenly spaced.

use super::phases::MAX_SAMPLES_PER_VOXEL;
use super::pixel_rays::on_pixels;
use super::{ANCHOR_LIMIT, AffineRays, Density, Lattice, MAX_VOXELS_PER_POINT, Sampling, Source, Stagger, support_corners};
use crate::layers::{Axis, AxisFrame, Rays};
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::DVec3;

/// Largest |s| of a ray. A field of view of 30° needs 1.65 if the volume just fits.
pub const MAX_LATTICE_SHEAR: f64 = 2.0;
/// Least distance of the eye from the first layer, in layers.
const MIN_EYE_DISTANCE: f64 = 1.0;
/// Most voxels between adjacent samples in the farthest layer, limited by kernels/layered/splat_perspective.cl.
const MAX_VOXELS_PER_SAMPLE: f64 = 7.0;
/// Longest side of a lattice, in viewport sides (see [`is_worth`]): beyond it the near end of the volume is so close that the far end
/// would be sampled many times too densely, and pixels are fewer than samples.
const MAX_SIDES: u32 = 4;
/// Least viewport side assumed for this limit.
const MIN_SIDE: u32 = 64;
/// Margin around the viewport in samples.
const MARGIN: f64 = 3.0;

/// See [`Lattice::reaches_perspective`].
pub(super) fn reaches(rays: &Rays, grid: &Grid, axis: Axis, sampling: Sampling) -> bool {
    EyeRays::new(rays, grid, axis, sampling).is_some()
}

/// See [`Lattice::new`]. Points are denser if adjacent rays would be too far apart in the farthest layer.
pub(super) fn lattice(
    rays: &Rays,
    viewport: Viewport,
    grid: &Grid,
    axis: Axis,
    density: Density,
    sampling: Sampling,
) -> Option<Lattice> {
    let eye_rays = EyeRays::new(rays, grid, axis, sampling)?;
    let EyeRays { frame, dims, eye, centre_layer, layer_step, .. } = eye_rays;
    let (near, far) = eye_rays.layer_distances();
    let screen = eye_rays.screen_shears(rays, viewport);
    let mut lattice = Lattice {
        frame,
        dims,
        size: [0; 2],
        samples_per_voxel: [0.0; 2],
        layer_step,
        centre_layer,
        rays: [AffineRays { crossing: [0.0; 2], shear: [0.0; 2] }; 2],
        phases: None,
        aligned: [false; 2],
        crossed_along: None,
        stagger: Stagger::default(),
        pixel_rays: None,
        source: Source::Eye(eye),
    };
    let mut follows_voxels = [false; 2];
    for i in 0..2 {
        let (mut lo, mut hi) = eye_rays.shear_bounds(i);
        let pixels = eye_rays.pixels_per_voxel(rays, grid.spacing()[[frame.u, frame.v][i]]);
        // Minified pixels show the mean of several voxels, so no voxel may be skipped.
        let least = if pixels < 1.0 { ANCHOR_LIMIT } else { 0.0 };
        let for_points = if sampling != Sampling::Splats { far / near / MAX_VOXELS_PER_POINT } else { 0.0 };
        let samples_per_voxel = density.samples(pixels).max(for_points).max(least);
        let step = 1.0 / (samples_per_voxel * near);
        if let Some(screen) = screen {
            let (seen_lo, seen_hi) = bounds(&screen.map(|s| s[i]));
            (lo, hi) = (lo.max(seen_lo - MARGIN * step), hi.min(seen_hi + MARGIN * step));
        }
        let samples = ((hi - lo) / step).ceil().max(0.0);
        let too_far_apart = sampling == Sampling::Splats && far * step > MAX_VOXELS_PER_SAMPLE;
        if samples_per_voxel > f64::from(MAX_SAMPLES_PER_VOXEL) || too_far_apart {
            return None;
        }
        follows_voxels[i] = pixels < 1.0;
        lattice.size[i] = samples as u32;
        lattice.samples_per_voxel[i] = samples_per_voxel;
        let (middle, to_centre) = ((lo + hi) / 2.0, centre_layer - eye.z);
        lattice.rays[i] = AffineRays { crossing: [eye[i] + to_centre * middle, to_centre * step], shear: [middle, step] };
    }
    if sampling != Sampling::Splats {
        let on_pixels = on_pixels(&lattice, rays, viewport, density, &support_corners(dims, sampling));
        if on_pixels.is_some() {
            return on_pixels;
        }
    }
    is_worth(lattice.size, follows_voxels, viewport).then_some(lattice)
}

/// Whether a lattice of this size has few enough samples for a viewport. Its longer side is held to the viewport's longer side and its
/// shorter to the shorter: either axis of a layer can lie along either side of the screen, and a volume is drawn like its copy with
/// permuted axes. Where pixels cover several voxels, a side `follows_voxels`, and the viewport does not limit it.
fn is_worth(size: [u32; 2], follows_voxels: [bool; 2], viewport: Viewport) -> bool {
    let ascending = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let most = ascending([viewport.width, viewport.height].map(|side| side.max(MIN_SIDE) * MAX_SIDES));
    let limited = ascending([0, 1].map(|i| if follows_voxels[i] { 0 } else { size[i] }));
    let storable = (0..2).all(|i| !follows_voxels[i] || size[i] <= Viewport::MAX_SIDE);
    storable && limited[0] <= most[0] && limited[1] <= most[1]
}

/// An eye in front of the layers of a volume.
struct EyeRays {
    frame: AxisFrame,
    /// Number of voxels along u, v, a.
    dims: [usize; 3],
    /// Position of the eye, (u, v, a).
    eye: DVec3,
    centre_layer: f64,
    layer_step: i32,
    sampling: Sampling,
}

impl EyeRays {
    /// `None` if a lattice does not cover all rays.
    fn new(rays: &Rays, grid: &Grid, axis: Axis, sampling: Sampling) -> Option<Self> {
        let frame = axis.frame();
        let dims = [frame.u, frame.v, frame.a].map(|i| grid.dims()[i]);
        let eye = frame.local(rays.eye()?);
        let centre_layer = (dims[2] as f64 - 1.0) / 2.0;
        let layer_step = if eye.z < centre_layer { 1 } else { -1 };
        let eye_rays = Self { frame, dims, eye, centre_layer, layer_step, sampling };
        let (near, _) = eye_rays.layer_distances();
        let ahead = support_corners(dims, sampling).iter().all(|c| rays.depth(eye, *c, frame) > 0.0);
        let upright = (0..2).all(|i| {
            let (lo, hi) = eye_rays.shear_bounds(i);
            lo.abs().max(hi.abs()) <= MAX_LATTICE_SHEAR
        });
        (near >= MIN_EYE_DISTANCE && ahead && upright).then_some(eye_rays)
    }

    /// Pixels per voxel in the nearest layer, from the largest shear per pixel at a corner of the volume.
    fn pixels_per_voxel(&self, rays: &Rays, spacing: f64) -> f64 {
        let (near, _) = self.layer_distances();
        let pixels = |c: &DVec3| {
            let depth = rays.depth(self.eye, *c, self.frame);
            spacing * (c.z - self.eye.z).abs() / (depth * rays.pixel_size * near)
        };
        support_corners(self.dims, self.sampling).iter().map(pixels).fold(0.0, f64::max)
    }

    /// Distances, in layers, from the eye to the nearest and the farthest layer of the support. The nearest is not positive if the eye is
    /// beside or inside the layers.
    fn layer_distances(&self) -> (f64, f64) {
        let to = |k: f64| (k - self.eye.z) * f64::from(self.layer_step);
        let (a, b) = (to(-self.sampling.radius()), to(self.dims[2] as f64 - 1.0 + self.sampling.radius()));
        (a.min(b), a.max(b))
    }

    /// Range of the shears of the rays to the corners of the support.
    fn shear_bounds(&self, i: usize) -> (f64, f64) {
        bounds(&support_corners(self.dims, self.sampling).map(|c| (c[i] - self.eye[i]) / (c.z - self.eye.z)))
    }

    /// Shears of the rays through the viewport's corners; `None` if one of them points away from the layers.
    fn screen_shears(&self, rays: &Rays, viewport: Viewport) -> Option<[[f64; 2]; 4]> {
        let directions = rays.corners(viewport).map(|ray| ray.direction);
        let ahead = directions.iter().all(|d| d[self.frame.a] * f64::from(self.layer_step) > 0.0);
        ahead.then(|| directions.map(|d| self.frame.shear(d)))
    }
}

fn bounds(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &v| (lo.min(v), hi.max(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::Kernel;

    #[test]
    fn an_eye_inside_or_a_wide_angle_has_no_lattice() {
        let grid = Grid::new([32; 3], DVec3::ONE).unwrap();
        let viewport = Viewport::new(64, 64).unwrap();
        let at = |azimuth: f64, distance: f64, field_of_view: f64| {
            let orbit = Orbit { azimuth, elevation: 0.0, roll: 0.0 };
            let camera = Camera::orbit(grid.centre(), distance, orbit, Projection::Perspective { field_of_view });
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let axis = Axis::most_parallel(rays.central_direction());
            lattice(&rays, viewport, &grid, axis, Density::AtLeast(1), Sampling::Splats)
        };
        assert!(at(0.0, 104.0, 30.0).is_some());
        assert!(at(45.0, 104.0, 30.0).is_some());
        assert!(at(0.0, 3.0, 30.0).is_none());
        assert!(at(45.0, 38.0, 90.0).is_none());
    }

    /// In a viewport much wider than high: the axes of the layers change places, the screen stays.
    #[test]
    fn permuted_axes_have_the_same_lattice() {
        let viewport = Viewport::new(200, 40).unwrap();
        let of = |dims: [usize; 3], position: DVec3, view_up: DVec3, axis: Axis| {
            let grid = Grid::new(dims, DVec3::ONE).unwrap();
            let (focal_point, projection) = (grid.centre(), Projection::Perspective { field_of_view: 30.0 });
            let camera = Camera { position: focal_point + position, focal_point, view_up, projection };
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let lattice = lattice(&rays, viewport, &grid, axis, Density::Fixed(16), Sampling::Points(Kernel::Cubic));
            lattice.map(|lattice| lattice.size)
        };
        let [u, v] = of([30, 8, 14], DVec3::new(3.0, 60.0, 5.0), DVec3::Z, Axis::Y).expect("a lattice");
        assert!(u > v && u > viewport.height * MAX_SIDES, "long enough to tell the sides apart: {u} x {v}");
        assert_eq!(of([14, 30, 8], DVec3::new(5.0, 3.0, 60.0), DVec3::X, Axis::Z), Some([v, u]));
    }

    #[test]
    fn sides_are_held_to_the_viewport_in_order_of_length() {
        let viewport = Viewport::new(200, 100).unwrap();
        let [long, short] = [200 * MAX_SIDES, 100 * MAX_SIDES];
        let limited = [false; 2];
        assert!(is_worth([long, short], limited, viewport) && is_worth([short, long], limited, viewport));
        assert!(!is_worth([long + 1, short], limited, viewport) && !is_worth([short, long + 1], limited, viewport));
        assert!(!is_worth([short + 1, short + 1], limited, viewport));
        // A side that follows the voxels leaves the viewport's longer one to the other.
        let most = Viewport::MAX_SIDE;
        assert!(is_worth([most, long], [true, false], viewport) && is_worth([long, most], [false, true], viewport));
        assert!(!is_worth([most + 1, 1], [true, false], viewport) && !is_worth([most, long + 1], [true, false], viewport));
    }
}
