//! Lattices whose samples are the pixels, where columns of pixels lean on the volume: perspectives, and rolled parallel views.
//!
//! In the plane of a layer, a column of pixels is a straight line. In a parallel view all these lines are parallel. In a perspective they
//! pass through one vanishing point, so each leans by its own angle, the same in all layers. Kernels resample each row of voxels where the
//! lines cross it, and then interpolate along the lines. That is interpolation along the axes, but for the curve of the kernel between
//! voxels.

use super::aligned::WORTH;
use super::crossings::{Crossings, Window};
use super::{AffineRays, Density, Lattice, MAX_VOXELS_PER_POINT, ScreenAxis, Source};
use crate::layers::Rays;
use crate::viewport::Viewport;
use glam::{DMat3, DVec3};

/// Largest |du/dv| of a column of pixels in a layer, in a parallel view. Compared with the lattices of [`super::aligned`], lit pictures of
/// lobster, engine and aneurism gain 0.3, 0.1 and 1.5 dB with a lean of 0.09, and lose 0.3 and 0.5 and gain 0.8 with 0.17.
const MAX_LEAN: f64 = 0.12;
/// The same in a perspective, whose other lattice is less faithful: gains of 0.3, -0.05 and 1.5 dB with 0.37, and of 2.4, 3.5 and 4.3 with at
/// most 0.11.
const MAX_LEAN_IN_PERSPECTIVE: f64 = 0.4;
/// Largest lean per voxel of v between samples. Interpolation along leaning columns moves surfaces by up to 0.1 voxels times the lean: a tenth
/// of a pixel, however large voxels are.
const MAX_LEAN_PER_PITCH: f64 = 0.8;
/// Largest number of rows by which the next column of a tile begins farther down.
const MAX_DRIFT: f64 = 1.0;
/// Largest change of the drift from row to row. With it, columns of a tile differ by no more rows than kernels/layered/pixel_tile.cl has room
/// for.
const MAX_DRIFT_PER_ROW: f64 = 1.0 / 256.0;
/// Columns and rows beyond the lattice that tiles may reach to.
const PADDING: [f64; 2] = [16.0, 48.0];
/// Largest change of the depth from the middle of the lattice to rays beyond its edges, as a factor.
const MAX_DEPTH: f64 = 4.0;
/// Rows by which samples of a row of a tile lie behind the first of them, at most.
const MOST_BEHIND: f64 = 1.45;
/// Voxel rows that kernels select from, at most.
const MOST_VOXELS_BEHIND: f64 = 2.0;

/// Rays of a lattice whose samples are pixels. With i and j counted from the middle of the lattice, ray (I, J) crosses a layer (u, v) voxels
/// beside the ray in the middle: (i steps\[0\] + j steps\[1\]) / (1 + i depth_steps\[0\] + j depth_steps\[1\]), times the spread of the rays
/// in this layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRays {
    /// Screen axis from one column to the next.
    pub across: ScreenAxis,
    /// Pixel of sample (0, 0), from the left and from the top.
    pub first_pixel: [u32; 2],
    /// Numerators, of u and v, from one column to the next, and from one row to the next.
    pub steps: [[f64; 2]; 2],
    /// Of the depth along the layer axis, relative to that of the ray in the middle; 0 in a parallel view.
    pub depth_steps: [f64; 2],
    /// Spread of the rays in the layer of the volume's centre, and its change per layer. In a perspective it is the distance from the eye in
    /// layers, negative if rays run towards lower layers; in a parallel view, 1 in all layers.
    pub spread: [f64; 2],
    /// Voxel rows, at most, by which samples of a row lie behind the first in a tile.
    pub most_behind: f64,
}

impl PixelRays {
    fn depth(&self, i: f64, j: f64) -> f64 {
        1.0 + i * self.depth_steps[0] + j * self.depth_steps[1]
    }

    /// Distance of ray (i, j) from the ray in the middle, along u and v, where the spread is 1.
    pub(super) fn offset(&self, i: f64, j: f64) -> [f64; 2] {
        [0, 1].map(|axis| (i * self.steps[0][axis] + j * self.steps[1][axis]) / self.depth(i, j))
    }

    /// Its change, along u and v, from one column and from one row to the next.
    fn derivatives(&self, i: f64, j: f64) -> [[f64; 2]; 2] {
        let (depth, offset) = (self.depth(i, j), self.offset(i, j));
        [0, 1].map(|n| [0, 1].map(|axis| (self.steps[n][axis] - offset[axis] * self.depth_steps[n]) / depth))
    }

    /// Change of u per voxel of v along column i.
    fn lean(&self, i: f64) -> f64 {
        let [_, row] = self.derivatives(i, 0.0);
        row[0] / row[1]
    }

    /// Numbers a, b, c, d: the next column of a tile begins (a + b j) / (c + d i) rows farther down, so that rows of samples follow rows of
    /// voxels.
    pub fn drift_terms(&self) -> [f64; 4] {
        let ([column, row], depth) = (self.steps.map(|step| step[1]), self.depth_steps);
        let turn = row * depth[0] - column * depth[1];
        [-column, turn, row, turn]
    }

    fn drift(&self, [i, j]: [f64; 2]) -> f64 {
        let [a, b, c, d] = self.drift_terms();
        (a + b * j) / (c + d * i)
    }

    /// Rows, at most, by which columns of a tile of this width begin before or after the tile, in a lattice of this size.
    pub fn lead(&self, size: [u32; 2], width: u32) -> u32 {
        let most = corners(size).map(|corner| self.drift(corner).abs()).into_iter().fold(0.0, f64::max);
        (most * f64::from(width) / 2.0).ceil() as u32 + 1
    }

    /// Matrix from (x, y, 1) on the screen to (I, J, 1).
    pub(super) fn screen_matrix(&self) -> DMat3 {
        let [x, y] = self.first_pixel.map(|first| f64::from(first) + 0.5);
        match self.across {
            ScreenAxis::X => DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-x, -y, 1.0)),
            ScreenAxis::Y => DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::new(-y, -x, 1.0)),
        }
    }

    /// Largest steps from column to column along u, and from row to row along v, in voxels. They are largest at corners of the volume,
    /// which are given as (i, j), with the spread.
    fn pitch(&self, corners: impl Iterator<Item = ([f64; 2], f64)>) -> [f64; 2] {
        corners.fold([0.0_f64; 2], |most, ([i, j], spread)| {
            let [column, row] = self.derivatives(i, j);
            let steps = [column[0] - row[0] / row[1] * column[1], row[1]];
            [0, 1].map(|n| most[n].max((steps[n] * spread).abs()))
        })
    }

    /// Whether kernels can sample these rays, in a lattice of this size.
    fn are_supported(&self, size: [u32; 2], pitch: [f64; 2]) -> bool {
        let corners = corners(size);
        let by_projection = if self.depth_steps == [0.0; 2] { MAX_LEAN } else { MAX_LEAN_IN_PERSPECTIVE };
        let max_lean = by_projection.min(MAX_LEAN_PER_PITCH * pitch[1]);
        let [_, _, c, d] = self.drift_terms();
        corners.iter().all(|&[i, j]| (1.0 / MAX_DEPTH..MAX_DEPTH).contains(&self.depth(i, j)))
            // Rows run the same way along all columns.
            && corners.iter().all(|&[i, _]| (c + d * i) * c > 0.0)
            && corners.iter().all(|&corner| self.lean(corner[0]).abs() <= max_lean && self.drift(corner).abs() <= MAX_DRIFT)
            && corners.iter().all(|&[i, _]| (self.drift([i, 1.0]) - self.drift([i, 0.0])).abs() <= MAX_DRIFT_PER_ROW)
            && pitch[0] <= MAX_VOXELS_PER_POINT
            && self.most_behind <= MOST_VOXELS_BEHIND
    }
}

/// The outermost (i, j) that tiles of a lattice of this size may reach to.
fn corners(size: [u32; 2]) -> [[f64; 2]; 4] {
    let [i, j] = [0, 1].map(|n| f64::from(size[n]) / 2.0 + PADDING[n]);
    [[-i, -j], [i, -j], [-i, j], [i, j]]
}

/// The lattice whose samples are the pixels, in place of `evenly`, if that is worth it: if kernels can sample it, and pixels are not many
/// more. `support`: corners of the field's support (u, v, a).
pub(super) fn on_pixels(
    evenly: &Lattice,
    rays: &Rays,
    viewport: Viewport,
    density: Density,
    support: &[DVec3; 8],
) -> Option<Lattice> {
    let crossings = Crossings::new(evenly, rays, support);
    let [base, x, y] = crossings.rays;
    let to_screen = DMat3::from_cols(x, y, base).inverse();
    let points = crossings.corners.map(|(corner, _)| to_screen * corner).map(|p| [p.x / p.z, p.y / p.z]);
    let window = Window::around(&points, viewport);
    let samples = f64::from(window.size[0]) * f64::from(window.size[1]);
    if samples == 0.0 || samples > evenly.samples() as f64 * WORTH || rays.voxels_per_pixel(evenly.frame) > 1.0 {
        return None;
    }
    let middle_pixel = window.middle();
    let middle = base + middle_pixel[0] * x + middle_pixel[1] * y;
    let at_middle = [middle.x / middle.z, middle.y / middle.z];
    let steps = [x, y].map(|d| [0, 1].map(|axis| (d[axis] - at_middle[axis] * d.z) / middle.z));
    let depth_steps = [x, y].map(|d| d.z / middle.z);
    // Columns of pixels are those along which u changes least.
    let across = if steps[0][0].abs() >= steps[1][0].abs() { ScreenAxis::X } else { ScreenAxis::Y };
    let ordered = |[x, y]: [f64; 2]| if across == ScreenAxis::X { [x, y] } else { [y, x] };
    let mut pixel_rays = PixelRays {
        across,
        first_pixel: window.first,
        steps: if across == ScreenAxis::X { steps } else { [steps[1], steps[0]] },
        depth_steps: ordered(depth_steps),
        spread: crossings.spread,
        most_behind: 0.0,
    };
    let size = if across == ScreenAxis::X { window.size } else { [window.size[1], window.size[0]] };
    let from_middle = |point: [f64; 2]| ordered([0, 1].map(|n| point[n] - middle_pixel[n]));
    let pitch = pixel_rays.pitch(points.iter().zip(crossings.corners).map(|(&point, (_, spread))| (from_middle(point), spread)));
    pixel_rays.most_behind = pitch[1] * MOST_BEHIND;
    if !(pixel_rays.are_supported(size, pitch) && pitch.iter().all(|pitch| density.follows_pixels(1.0 / pitch))) {
        return None;
    }
    let rays = |axis: usize| {
        let (crossing, shear) = match evenly.source {
            Source::Eye(eye) => (eye[axis] + crossings.spread[0] * at_middle[axis], at_middle[axis]),
            Source::Direction(_) => (at_middle[axis], evenly.rays[axis].shear[0]),
        };
        AffineRays { crossing: [crossing, 0.0], shear: [shear, 0.0] }
    };
    Some(Lattice {
        size,
        samples_per_voxel: pitch.map(|pitch| 1.0 / pitch),
        rays: [rays(0), rays(1)],
        aligned: [true; 2],
        crossed_along: None,
        stagger: Default::default(),
        pixel_rays: Some(Box::new(pixel_rays)),
        ..evenly.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::{Axis, Kernel, Sampling};
    use crate::volume::Grid;
    use approx::assert_abs_diff_eq;

    const ROUNDING: f64 = 1e-9;

    fn views() -> impl Iterator<Item = (Rays, Viewport, Lattice)> {
        let grid = Grid::new([140, 150, 160], DVec3::new(1.0, 1.1, 0.9)).unwrap();
        let viewport = Viewport::new(290, 270).unwrap();
        let perspective = Projection::Perspective { field_of_view: 30.0 };
        let parallel = Projection::Parallel { scale: 100.0 };
        let orbits = [
            (72.0, 20.0, 0.0, perspective),
            (30.0, -20.0, 5.0, perspective),
            (200.0, 20.0, 90.0, perspective),
            (140.0, 20.0, 0.0, perspective),
            (10.0, 60.0, 0.0, perspective),
            (72.0, 20.0, 5.0, parallel),
            (160.0, -20.0, -94.0, parallel),
        ];
        orbits.into_iter().map(move |(azimuth, elevation, roll, projection)| {
            let camera = Camera::orbit(grid.centre(), 420.0, Orbit { azimuth, elevation, roll }, projection);
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let axis = Axis::most_parallel(rays.central_direction());
            let lattice = Lattice::new(&rays, viewport, &grid, axis, Density::Relaxed, Sampling::Points(Kernel::Cubic)).unwrap();
            assert!(lattice.pixel_rays.is_some(), "{azimuth} {elevation} {roll}");
            (rays, viewport, lattice)
        })
    }

    /// (u, v) where the ray of a sample crosses a layer.
    fn crossing(lattice: &Lattice, [column, row]: [u32; 2], layer: f64) -> [f64; 2] {
        let ray = lattice.ray(column, row);
        let (origin, shear) = (lattice.frame.local(ray.origin), lattice.frame.shear(ray.direction));
        [0, 1].map(|n| origin[n] + (layer - origin.z) * shear[n])
    }

    #[test]
    fn samples_are_the_pixels() {
        for (rays, _, lattice) in views() {
            let from_screen = lattice.from_screen(&rays);
            for sample in [[0, 0], [17, 5], [lattice.size[0] - 1, 3], [80, lattice.size[1] - 1]] {
                let place = from_screen.inverse() * DVec3::new(f64::from(sample[0]), f64::from(sample[1]), 1.0);
                assert_abs_diff_eq!(place.x.fract(), 0.5, epsilon = ROUNDING);
                let pixel = rays.at(place.x, place.y);
                let (origin, shear) = (lattice.frame.local(pixel.origin), lattice.frame.shear(pixel.direction));
                for layer in [0.0, 60.0] {
                    let found = crossing(&lattice, sample, layer);
                    for n in 0..2 {
                        assert_abs_diff_eq!(found[n], origin[n] + (layer - origin.z) * shear[n], epsilon = 1e-7);
                    }
                }
            }
        }
    }

    /// All rays that hit the volume are in the lattice: those of pixels beside it miss.
    #[test]
    fn lattices_have_all_rays_of_the_volume() {
        for (rays, viewport, lattice) in views() {
            let from_screen = lattice.from_screen(&rays);
            let last = lattice.dims.map(|n| n as f64);
            for (x, y) in (0..viewport.width).step_by(3).flat_map(|x| (0..viewport.height).step_by(3).map(move |y| (x, y))) {
                let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let pixel = rays.at(x, y);
                let (origin, shear) = (lattice.frame.local(pixel.origin), lattice.frame.shear(pixel.direction));
                let hits = (0..lattice.dims[2]).any(|k| {
                    [0, 1].iter().all(|&n| {
                        let at = origin[n] + (k as f64 - origin.z) * shear[n];
                        (-1.0..=last[n]).contains(&at)
                    })
                });
                let place = from_screen * DVec3::new(x, y, 1.0);
                let inside = [0, 1].iter().all(|&n| (0.0..f64::from(lattice.size[n])).contains(&(place[n] + ROUNDING)));
                assert!(inside || !hits, "pixel {x} {y}");
            }
        }
    }

    #[test]
    fn columns_lean_by_one_angle_in_all_layers() {
        for (_, _, lattice) in views() {
            let pixel_rays = lattice.pixel_rays.as_deref().unwrap();
            for column in [0, 40, lattice.size[0] - 1] {
                let lean = pixel_rays.lean(lattice.offset_of(0, f64::from(column)));
                for layer in [0.0, 75.0] {
                    let [top, bottom] = [0, lattice.size[1] - 1].map(|row| crossing(&lattice, [column, row], layer));
                    assert_abs_diff_eq!(bottom[0] - top[0], lean * (bottom[1] - top[1]), epsilon = 1e-7);
                }
            }
        }
    }

    /// As kernels/layered/pixel_tile.cl divides a lattice into tiles of 16 columns.
    #[test]
    fn rows_of_a_tile_follow_rows_of_voxels() {
        const WIDTH: i64 = 16;
        const ROWS: i64 = 16;
        const RAGGED_ROWS: i64 = 2;
        for (_, _, lattice) in views() {
            let pixel_rays = lattice.pixel_rays.as_deref().unwrap();
            let lead = i64::from(pixel_rays.lead(lattice.size, WIDTH as u32));
            let [a, b, c, d] = pixel_rays.drift_terms();
            let [width, height] = lattice.size.map(i64::from);
            let first_row = |tile: [i64; 2], column: i64| {
                let row = tile[1] * ROWS - lead;
                let (i, j) = ((tile[0] * WIDTH) as f64 + 0.5 * (WIDTH - width) as f64, row as f64 - 0.5 * (height - 1) as f64);
                let drift = (((a + b * j) / (c + d * i)) * 32.0 + 0.5).floor() as i64;
                row + ((drift * (2 * column - (WIDTH - 1)) + 32) >> 6)
            };
            let mut most = 0.0_f64;
            for tile in (0..width / WIDTH).flat_map(|u| (0..(height + 2 * lead) / ROWS).map(move |v| [u, v])) {
                let ends = (0..WIDTH).map(|column| [first_row(tile, column), first_row([tile[0], tile[1] + 1], column)]);
                let ends: Vec<_> = ends.collect();
                assert!(ends.iter().all(|[first, end]| (1..=ROWS + RAGGED_ROWS).contains(&(end - first))), "{ends:?}");
                for r in 0..ROWS {
                    let along_v = (0..WIDTH).filter_map(|column| {
                        let row = ends[column as usize][0] + r;
                        let sample =
                            [(tile[0] * WIDTH + column) as u32, u32::try_from(row).ok().filter(|&row| i64::from(row) < height)?];
                        let at = crossing(&lattice, sample, 40.0);
                        let is_inside = [0, 1].iter().all(|&n| (-1.0..=lattice.dims[n] as f64).contains(&at[n]));
                        is_inside.then_some(at[1])
                    });
                    let (lo, hi) = along_v.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
                    most = most.max(hi - lo);
                }
            }
            assert!(most <= pixel_rays.most_behind, "{most} of {}", pixel_rays.most_behind);
            assert!(most > 0.5 * pixel_rays.most_behind, "a useful limit: {most} of {}", pixel_rays.most_behind);
        }
    }

    #[test]
    fn steep_columns_and_few_pixels_have_other_lattices() {
        let grid = Grid::new([140; 3], DVec3::ONE).unwrap();
        let at = |roll: f64, side: u32, projection: Projection| {
            let camera = Camera::orbit(grid.centre(), 420.0, Orbit { azimuth: 30.0, elevation: 20.0, roll }, projection);
            let viewport = Viewport::new(side, side).unwrap();
            let rays = Rays::new(&camera, viewport, &grid).unwrap();
            let axis = Axis::most_parallel(rays.central_direction());
            let lattice = Lattice::new(&rays, viewport, &grid, axis, Density::Relaxed, Sampling::Points(Kernel::Cubic));
            lattice.unwrap().pixel_rays.is_some()
        };
        let perspective = Projection::Perspective { field_of_view: 30.0 };
        let parallel = Projection::Parallel { scale: 110.0 };
        assert!(at(0.0, 280, perspective) && at(5.0, 280, parallel));
        assert!(!at(40.0, 280, perspective) && !at(20.0, 280, parallel));
        // Voxels of less than a pixel, and of four.
        assert!(!at(0.0, 140, perspective) && !at(0.0, 1000, perspective));
    }
}
