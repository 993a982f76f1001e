//! Cameras that fit the visible part of a volume, and the orientation in which it is seen.
//!
//! Visibility is determined per block of the reconstructed field. It depends on the volume and the transfer function only, not on how a
//! picture is rendered.

mod orientation;
mod sight;

pub use orientation::{Orientation, Side, UpReason};
pub use sight::{HalfSpace, Sight};

use crate::camera::{Basis, Camera, Orbit, Projection};
use crate::progress::Task;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use glam::DVec3;
use rayon::prelude::*;

/// Cells along each side of a block.
const BLOCK: i64 = 4;
/// Optical depth along the volume's diagonal that counts as invisible: half an 8-bit step.
const FAINT: f64 = 1.0 / 512.0;
/// Least distance of the eye from the centre of the view, as a fraction of the size of the fitted bounds.
const NEAREST: f64 = 0.01;
/// Margin around the fitted bounds, as a fraction of half the picture's height and width.
const MARGIN: f64 = 0.05;

/// Bounds of the visible part of a volume: world points whose convex hull contains it.
///
/// ```
/// use layersplat::framing::{Fixed, Framing};
/// use layersplat::{Orbit, Projection, OpenOptions, TransferFunction, Viewport, Volume};
///
/// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
/// let framing = Framing::visible(&volume, &TransferFunction::automatic(&volume), None);
/// let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// let camera = framing.parallel(orbit, Viewport::new(256, 256)?, Fixed::default());
/// // Closer than for the whole volume.
/// let Projection::Parallel { scale } = camera.projection else { panic!() };
/// assert!(scale < volume.grid().diagonal() / 2.0);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Framing {
    points: Vec<DVec3>,
}

/// Camera parameters that fitting must not change.
///
/// ```
/// use layersplat::framing::{Fixed, Framing};
/// use layersplat::{Orbit, Projection, OpenOptions, Viewport, Volume};
///
/// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
/// let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// let fixed = Fixed { scale: Some(10.0), ..Fixed::default() };
/// let camera = Framing::whole(&volume).parallel(orbit, Viewport::new(256, 256)?, fixed);
/// assert_eq!(camera.projection, Projection::Parallel { scale: 10.0 });
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed {
    /// World point at the centre of the picture.
    pub centre: Option<DVec3>,
    /// Half the picture's height in world units, for parallel views.
    pub scale: Option<f64>,
    /// Distance from the eye to the centre in world units, for perspective views.
    pub distance: Option<f64>,
}

impl Framing {
    /// Bounds of the voxels that `transfer` makes visible, widened by a kernel radius of 1; of the whole grid if nothing is visible.
    /// Opacities apply per `unit_distance` in world units, by default [`Grid::unit`].
    pub fn visible(volume: &Volume, transfer: &TransferFunction, unit_distance: Option<f64>) -> Self {
        let (volume, unit) = (volume.framed(), unit_distance.unwrap_or_else(|| volume.grid().unit()));
        let faint = -(-FAINT * unit / volume.grid().diagonal()).exp_m1();
        Self::showing(volume, |lo, hi| transfer.largest_opacity(lo, hi) >= faint)
    }

    /// Bounds of the iso-surface at `value`; of the whole grid if the field does not reach that value.
    pub fn iso(volume: &Volume, value: f64) -> Self {
        Self::showing(volume.framed(), |lo, hi| lo <= value && value <= hi)
    }

    /// Bounds of all voxels.
    pub fn whole(volume: &Volume) -> Self {
        let grid = volume.framed().grid();
        Self::from_voxels(grid, corners([0; 3], grid.dims().map(|n| n as i64 - 1)))
    }

    /// Bounds of a box along the axes of the world, such as that around surfaces.
    pub fn of_box(lowest: DVec3, highest: DVec3) -> Self {
        let corner = |n: usize| DVec3::from_array(std::array::from_fn(|i| if n >> i & 1 == 0 { lowest[i] } else { highest[i] }));
        Self { points: (0..8).map(corner).collect() }
    }

    /// Bounds of both, such as two steps of a sequence.
    pub fn joined(mut self, other: Self) -> Self {
        self.points.extend(other.points);
        self
    }

    /// Clips the bounds to a box in voxel coordinates. Where the two have nothing in common, the bounds stay, so that a camera exists.
    pub fn cropped(self, grid: &Grid, lowest: DVec3, highest: DVec3) -> Self {
        let voxels: Vec<DVec3> = self.points.iter().map(|&p| grid.world_to_voxel(p)).collect();
        let least = voxels.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let most = voxels.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        if least.cmpgt(highest).any() || most.cmplt(lowest).any() {
            return self;
        }
        Self::from_voxels(grid, voxels.into_iter().map(|p| p.max(lowest).min(highest)).collect())
    }

    /// Bounds of the blocks for whose range of values `shows` returns true.
    fn showing(volume: &Volume, shows: impl Fn(f64, f64) -> bool + Sync) -> Self {
        let dims = volume.grid().dims().map(|n| n as i64);
        let blocks = dims.map(|n| (n + 1 + BLOCK - 1) / BLOCK);
        let rows = (0..blocks[1] * blocks[2]).into_par_iter();
        let task = Task::new(format!("looking at {}", volume.name()), (blocks[1] * blocks[2]) as u64);
        let outline = |row| task.work(1, || row_outline(volume, &shows, dims, [row % blocks[1], row / blocks[1]]));
        let points: Vec<DVec3> = rows.flat_map_iter(outline).collect();
        let points = volume.gather_all(points.into_iter().flat_map(|p| p.to_array()).collect());
        let points: Vec<DVec3> = points.chunks_exact(3).map(DVec3::from_slice).collect();
        Self::from_voxels(volume.grid(), if points.is_empty() { corners([-1; 3], dims) } else { points })
    }

    /// Converts bounds in voxel coordinates.
    fn from_voxels(grid: &Grid, points: Vec<DVec3>) -> Self {
        let world = |p: DVec3| grid.origin() + grid.direction() * (p * grid.spacing());
        Self { points: points.into_iter().map(world).collect() }
    }

    /// Centre of the axis-aligned bounding box in world coordinates.
    pub fn centre(&self) -> DVec3 {
        let lo = self.points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let hi = self.points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (lo + hi) / 2.0
    }

    /// A parallel view from an orbit in which it fits, with a small margin. With an angle that is NaN or infinite the camera has no view:
    /// [`Camera::basis`] and all rendering return an error.
    pub fn parallel(&self, orbit: Orbit, viewport: Viewport, fixed: Fixed) -> Camera {
        let axes = self.axes(orbit);
        let (from, to) = axes.bounds(&self.points);
        let centre = fixed.centre.unwrap_or_else(|| axes.world((from + to) / 2.0));
        let middle = axes.local(centre);
        let half = (to - middle).max(middle - from);
        let scale = fixed.scale.unwrap_or_else(|| half.y.max(half.x / aspect(viewport)) / (1.0 - MARGIN));
        Camera::orbit(centre, half.z.max(scale) * 2.0, orbit, Projection::Parallel { scale })
    }

    /// A perspective from an orbit, with a vertical field of view in degrees, in which it fits. With an angle that is NaN or infinite the
    /// camera has no view: [`Camera::basis`] and all rendering return an error.
    pub fn perspective(&self, orbit: Orbit, viewport: Viewport, field_of_view: f64, fixed: Fixed) -> Camera {
        let axes = self.axes(orbit);
        let tan = (field_of_view.to_radians() / 2.0).tan() * (1.0 - MARGIN);
        let slopes = [tan * aspect(viewport), tan];
        // With z towards the eye, a point is visible if |x − c| ≤ (D − z)·slope. This gives two bounds on D·slope per axis.
        let bounds: [(f64, f64); 2] = std::array::from_fn(|i| {
            let side = |sign: f64| {
                let bound = |p: &DVec3| sign * axes.local(*p)[i] + axes.local(*p).z * slopes[i];
                self.points.iter().map(bound).fold(f64::NEG_INFINITY, f64::max)
            };
            (side(1.0), side(-1.0))
        });
        let (from, to) = axes.bounds(&self.points);
        let fitted = DVec3::new((bounds[0].0 - bounds[0].1) / 2.0, (bounds[1].0 - bounds[1].1) / 2.0, (from.z + to.z) / 2.0);
        let centre = fixed.centre.unwrap_or_else(|| axes.world(fitted));
        let middle = axes.local(centre);
        let needed = |i: usize| (bounds[i].0 - middle[i]).max(bounds[i].1 + middle[i]) / slopes[i];
        // A given centre in front of the object would put the eye inside it, so the distance has a lower limit.
        let least = NEAREST * (to - from).length();
        let distance = fixed.distance.unwrap_or_else(|| (needed(0).max(needed(1)) - middle.z).max(least));
        Camera::orbit(centre, distance, orbit, Projection::Perspective { field_of_view })
    }

    fn axes(&self, orbit: Orbit) -> Axes {
        let camera = Camera::orbit(DVec3::ZERO, 1.0, orbit, Projection::Parallel { scale: 1.0 });
        // Angles that are not finite lead to a camera that is not finite either: using it is an error, making it is none.
        let nowhere = Basis { right: DVec3::NAN, up: DVec3::NAN, forward: DVec3::NAN };
        let basis = camera.basis().unwrap_or(nowhere);
        Axes { right: basis.right, up: basis.up, to_eye: -basis.forward }
    }
}

/// Axes of a view.
struct Axes {
    right: DVec3,
    up: DVec3,
    to_eye: DVec3,
}

impl Axes {
    fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.to_eye))
    }

    fn world(&self, p: DVec3) -> DVec3 {
        self.right * p.x + self.up * p.y + self.to_eye * p.z
    }

    fn bounds(&self, points: &[DVec3]) -> (DVec3, DVec3) {
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        points.iter().map(|&p| self.local(p)).fold(empty, |(lo, hi), p| (lo.min(p), hi.max(p)))
    }
}

fn aspect(viewport: Viewport) -> f64 {
    f64::from(viewport.width) / f64::from(viewport.height)
}

/// Corners, in voxel coordinates, of the first and the last visible block in a row of blocks along x.
fn row_outline(volume: &Volume, shows: &impl Fn(f64, f64) -> bool, dims: [i64; 3], [by, bz]: [i64; 2]) -> Vec<DVec3> {
    let columns = volume.column_ranges(inside([by, bz], [dims[1], dims[2]], 0), inside([by, bz], [dims[1], dims[2]], BLOCK));
    let visible = |bx: i64| {
        let (lo, hi) = block_range(volume, dims, [bx, by, bz], &columns);
        // Blocks without voxels of this process are examined by other processes.
        lo <= hi && shows(lo, hi)
    };
    let blocks = (dims[0] + 1 + BLOCK - 1) / BLOCK;
    let Some(first) = (0..blocks).find(|&bx| visible(bx)) else { return Vec::new() };
    let last = (first..blocks).rfind(|&bx| visible(bx)).unwrap_or(first);
    let start = [first, by, bz].map(|b| b * BLOCK - 1);
    let end = [last, by, bz].map(|b| b * BLOCK - 1 + BLOCK);
    corners(start, std::array::from_fn(|i| end[i].min(dims[i])))
}

fn corners(from: [i64; 3], to: [i64; 3]) -> Vec<DVec3> {
    let corner = |n: usize| DVec3::from_array(std::array::from_fn(|i| if n >> i & 1 == 0 { from[i] } else { to[i] } as f64));
    (0..8).map(corner).collect()
}

/// Voxel indices at offset `beyond` from the first voxels of `blocks`, clamped to the grid. Block 0 starts at voxel −1.
fn inside<const N: usize>(blocks: [i64; N], dims: [i64; N], beyond: i64) -> [usize; N] {
    std::array::from_fn(|i| (blocks[i] * BLOCK - 1 + beyond).clamp(0, dims[i] - 1) as usize)
}

/// Range of the field in a block, given the ranges of the columns of its row. Block 0 starts at voxel −1, where the background applies.
fn block_range(volume: &Volume, dims: [i64; 3], block: [i64; 3], columns: &[(f64, f64)]) -> (f64, f64) {
    let from = block.map(|b| b * BLOCK - 1);
    let to = from.map(|v| v + BLOCK);
    let outside = (0..3).any(|i| from[i] < 0 || to[i] >= dims[i]);
    let background = volume.background();
    let range = if outside { (background, background) } else { (f64::INFINITY, f64::NEG_INFINITY) };
    let ([first], [last]) = (inside([block[0]], [dims[0]], 0), inside([block[0]], [dims[0]], BLOCK));
    columns[first..=last].iter().fold(range, |range, column| (range.0.min(column.0), range.1.max(column.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::layers::Rays;
    use crate::volume::Voxels;

    /// A box of value 255 from voxel 10 to 13, 20 to 29 and 5 to 24; spacing 1, 2, 1.
    fn scene() -> (Volume<'static>, TransferFunction) {
        let inside =
            |i: usize| (10..14).contains(&(i % 40)) && (20..30).contains(&(i / 40 % 40)) && (5..25).contains(&(i / 1600));
        let voxels = (0..64_000).map(|i| if inside(i) { 255 } else { 0 }).collect();
        let grid = Grid::new([40; 3], DVec3::new(1.0, 2.0, 1.0)).unwrap();
        let volume = Volume::new("box", grid, Voxels::Uint8(voxels)).unwrap();
        let transfer = TransferFunction::builtin("grey", &volume).unwrap();
        (volume, transfer)
    }

    /// Largest |x| and |y| of the projected corners of the box, widened by the kernel radius, on a screen from −1 to 1.
    fn reached(volume: &Volume, camera: &Camera, viewport: Viewport) -> (f64, f64) {
        let rays = Rays::new(camera, viewport, volume.grid()).unwrap();
        let basis = camera.basis().unwrap();
        corners([9, 19, 4], [14, 30, 25]).iter().fold((0.0, 0.0), |(x, y), p| {
            let world = *p * DVec3::new(1.0, 2.0, 1.0) - camera.position;
            let depth = if rays.is_parallel() { 1.0 } else { world.dot(basis.forward) };
            let half = rays.pixel_size * f64::from(viewport.height) / 2.0 * depth;
            let (right, up) = (world.dot(basis.right) / half / aspect(viewport), world.dot(basis.up) / half);
            (f64::max(x, right.abs()), f64::max(y, up.abs()))
        })
    }

    #[test]
    fn all_that_is_visible_fits_whatever_the_aspect() {
        let (volume, transfer) = scene();
        let framing = Framing::visible(&volume, &transfer, None);
        for (w, h) in [(400, 400), (200, 500), (500, 120)] {
            let viewport = Viewport::new(w, h).unwrap();
            for (azimuth, elevation, roll) in [(0.0, 0.0, 0.0), (30.0, 20.0, 15.0), (90.0, -60.0, 0.0), (200.0, 90.0, 70.0)] {
                let orbit = Orbit { azimuth, elevation, roll };
                let cameras = [
                    framing.parallel(orbit, viewport, Fixed::default()),
                    framing.perspective(orbit, viewport, 30.0, Fixed::default()),
                    framing.perspective(orbit, viewport, 100.0, Fixed::default()),
                ];
                for camera in cameras {
                    let (x, y) = reached(&volume, &camera, viewport);
                    assert!(x <= 1.0 && y <= 1.0, "{w}x{h} {orbit:?} {camera:?}: reaches {x}, {y}");
                    // Blocks exceed the visible voxels by up to three cells on either side.
                    assert!(x.max(y) > 0.6, "{w}x{h} {orbit:?} {camera:?}: fills {x}, {y} only");
                }
            }
        }
    }

    #[test]
    fn what_is_fixed_stays() {
        let (volume, transfer) = scene();
        let framing = Framing::visible(&volume, &transfer, None);
        let viewport = Viewport::new(100, 100).unwrap();
        let point = DVec3::new(30.0, 40.0, 10.0);
        let centre = Some(point);
        let fixed = Fixed { centre, scale: Some(7.0), distance: None };
        let camera = framing.parallel(Orbit::default(), viewport, fixed);
        assert_eq!((camera.focal_point, camera.projection), (point, Projection::Parallel { scale: 7.0 }));
        let around = framing.parallel(Orbit::default(), viewport, Fixed { centre, ..Fixed::default() });
        let (x, y) = reached(&volume, &around, viewport);
        assert!(x <= 1.0 && y <= 1.0 && x.max(y) > 0.8, "{x}, {y}");
        let near = framing.perspective(Orbit::default(), viewport, 40.0, Fixed { distance: Some(99.0), ..Fixed::default() });
        assert!((near.position.distance(near.focal_point) - 99.0).abs() < 1e-9);
    }

    #[test]
    fn a_middle_in_front_of_everything_is_still_looked_at() {
        let (volume, transfer) = scene();
        let framing = Framing::visible(&volume, &transfer, None);
        let centre = DVec3::new(20.0, 40.0, 400.0);
        let viewport = Viewport::new(100, 100).unwrap();
        let camera = framing.perspective(Orbit::default(), viewport, 30.0, Fixed { centre: Some(centre), ..Fixed::default() });
        assert!(camera.position.z > centre.z, "{camera:?}");
    }

    #[test]
    fn angles_that_are_not_finite_are_errors_of_the_camera() {
        let (volume, _) = scene();
        let framing = Framing::whole(&volume);
        let viewport = Viewport::new(100, 100).unwrap();
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for [azimuth, elevation, roll] in [[angle, 0.0, 0.0], [0.0, angle, 0.0], [0.0, 0.0, angle], [angle; 3]] {
                let orbit = Orbit { azimuth, elevation, roll };
                for fixed in [Fixed::default(), Fixed { centre: Some(DVec3::ZERO), scale: Some(1.0), distance: Some(1.0) }] {
                    for camera in [framing.parallel(orbit, viewport, fixed), framing.perspective(orbit, viewport, 30.0, fixed)] {
                        let error = Rays::new(&camera, viewport, volume.grid()).unwrap_err();
                        assert!(matches!(error, Error::Camera { .. }), "{orbit:?}, {fixed:?}: {error}");
                        assert!(error.to_string().contains("azimuth, elevation, roll"), "{orbit:?}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn haze_counts_by_what_is_seen_of_all_of_it() {
        let (volume, _) = scene();
        let opacities = vec![(0.0, 0.0), (100.0, 0.0), (255.0, 5e-5)];
        let haze = TransferFunction::new("haze", vec![(0.0, [1.0; 3])], opacities).unwrap();
        let size = |unit| {
            let framing = Framing::visible(&volume, &haze, unit);
            let camera = framing.parallel(Orbit::default(), Viewport::new(9, 9).unwrap(), Fixed::default());
            let Projection::Parallel { scale } = camera.projection else { panic!("{camera:?}") };
            scale
        };
        // The box has a height of 20 units. The haze around it is too thin to show the whole grid.
        assert!(size(None) < 20.0 && size(Some(1000.0)) > 30.0);
    }

    #[test]
    fn nothing_visible_shows_the_grid() {
        let (volume, _) = scene();
        let nothing = TransferFunction::new("n", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0)]).unwrap();
        let centre = Framing::visible(&volume, &nothing, None).centre();
        assert!((centre - volume.grid().centre()).length() < 1e-9);
        let single = Volume::new("one", Grid::new([1; 3], DVec3::ONE).unwrap(), Voxels::Uint8(vec![255])).unwrap();
        let camera = Framing::visible(&single, &TransferFunction::automatic(&single), None).parallel(
            Orbit::default(),
            Viewport::new(10, 10).unwrap(),
            Fixed::default(),
        );
        assert!(camera.basis().is_ok());
    }
}
