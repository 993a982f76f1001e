//! Alignment of lattice samples with pixels.
//!
//! If a row or a column of pixels crosses all layers along one lattice axis, samples can coincide with pixels along the other. This holds
//! for views that are not rolled about a volume axis. If that other axis is u, staggered columns align both axes. Aligned samples need no
//! interpolation, so one sample per pixel is exact.
//!
//! In any other parallel view, unless columns of pixels lean little (`pixel_rays`), staggered columns have samples where rows (or columns) of
//! pixels cross them: pixels are interpolated along one axis only, between columns.

use super::density::MOST_CROSSED;
use super::{Density, MAX_VOXELS_PER_POINT, Sampling, ScreenAxis};
use crate::layers::{AxisFrame, Rays};
use crate::viewport::Viewport;

/// Largest drift of samples from their pixels across the viewport, in pixels.
const MOST_DRIFT: f64 = 0.01;
/// Break-even factor: this many aligned samples cost as much as one unaligned sample, because they need no interpolation.
pub(super) const WORTH: f64 = 1.1;

/// Distribution of samples along one lattice axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    pub samples_per_voxel: f64,
    /// Voxel coordinate of one of the samples that coincide with pixels; `None` if unaligned.
    pub on_pixel: Option<f64>,
}

/// Distribution of the samples of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spreads {
    /// Along u and v.
    pub along: [Spread; 2],
    /// See [`super::Lattice::crossed_along`].
    pub crossed_along: Option<ScreenAxis>,
}

/// Distribution of samples along u and v in a parallel view. `crossing` maps a screen position to its crossing of the centre layer.
pub(super) fn spreads(
    rays: &Rays,
    viewport: Viewport,
    frame: AxisFrame,
    density: Density,
    sampling: Sampling,
    crossing: impl Fn(f64, f64) -> [f64; 2],
) -> Spreads {
    let pixels = [frame.u, frame.v].map(|axis| rays.pixels_along(axis));
    let free = pixels.map(|pixels| density.samples(pixels).max(1.0));
    let alone = free.map(|samples_per_voxel| Spread { samples_per_voxel, on_pixel: None });
    // Minified pixels show the mean of many voxels, so the voxels determine the number of samples.
    let follows = matches!(sampling, Sampling::Points(_)) && rays.voxels_per_pixel(frame) <= 1.0;
    if !(follows && pixels.iter().all(|&pixels| density.follows_pixels(pixels))) {
        return Spreads { along: alone, crossed_along: None };
    }
    let [first, right, down] = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)].map(|(x, y)| crossing(x, y));
    let steps = [0, 1].map(|i| [right[i] - first[i], down[i] - first[i]]);
    let side = steps.map(|step| upright_side(step, viewport));
    let on_pixels = |i: usize, pitch: f64| Spread { samples_per_voxel: 1.0 / pitch, on_pixel: Some(first[i]) };
    if let Some(side) = side[0] {
        let pitch = [steps[0][side], steps[1][1 - side]].map(f64::abs);
        // Samples in aligned columns can be aligned, too, by staggering. That pays off unless it takes many more samples than requested.
        let worth = pitch[0] * free[0] * pitch[1] * free[1] * WORTH >= 1.0;
        if worth && pitch.iter().all(|&pitch| pitch <= MAX_VOXELS_PER_POINT) {
            return Spreads { along: [0, 1].map(|i| on_pixels(i, pitch[i])), crossed_along: None };
        }
    }
    let aligned = [0, 1].map(|i| {
        let pitch = steps[i][side[i]?].abs();
        (1.0 <= pitch * free[i] && pitch <= MAX_VOXELS_PER_POINT).then(|| on_pixels(i, pitch))
    });
    let beside_aligned = |i: usize, beside: f64| {
        let pixels = 1.0 / steps[i][0].abs().max(steps[i][1].abs());
        Spread { samples_per_voxel: (pixels * beside).clamp(1.0 / MAX_VOXELS_PER_POINT, free[i]), ..alone[i] }
    };
    if let (&[None, None], Some(crossed)) = (&aligned, density.crossed()) {
        // From a row (or column) of pixels to the next, along a column of the lattice.
        let along = usize::from(steps[0][1].abs() > steps[0][0].abs());
        let pitch = ((steps[0][0] * steps[1][1] - steps[0][1] * steps[1][0]) / steps[0][along]).abs();
        let columns = crossed * rays.pixel_sides(along) / steps[0][along].abs();
        let samples_per_voxel = columns.clamp(1.0 / MAX_VOXELS_PER_POINT, free[0] * MOST_CROSSED);
        let worth = samples_per_voxel <= free[0] * free[1] * pitch;
        if worth && pitch <= MAX_VOXELS_PER_POINT {
            return Spreads {
                along: [Spread { samples_per_voxel, ..alone[0] }, on_pixels(1, pitch)],
                crossed_along: Some([ScreenAxis::X, ScreenAxis::Y][along]),
            };
        }
    }
    let along = [0, 1].map(|i| match (aligned[i], aligned[1 - i], density.beside_aligned()) {
        (Some(on_pixel), _, Some(_)) => on_pixel,
        (None, Some(_), Some(beside)) => beside_aligned(i, beside),
        _ => alone[i],
    });
    Spreads { along, crossed_along: None }
}

/// The screen axis (0 or 1) along which alone a coordinate changes by `step` voxels per pixel, if there is one.
fn upright_side(step: [f64; 2], viewport: Viewport) -> Option<usize> {
    let sides = [viewport.width, viewport.height].map(f64::from);
    let along = usize::from(step[1].abs() > step[0].abs());
    (step[1 - along].abs() * sides[1 - along] <= MOST_DRIFT * step[along].abs()).then_some(along)
}

#[cfg(test)]
mod tests {
    use super::super::Lattice;
    use super::*;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::{Axis, Kernel};
    use crate::volume::Grid;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;

    const SIZE: (u32, u32) = (90, 70);

    /// A lattice of a view with `pixels` pixels per voxel.
    fn lattice(orbit: Orbit, pixels: f64, density: Density) -> (Lattice, Rays) {
        let grid = Grid::new([40, 50, 60], DVec3::new(1.0, 1.1, 0.9)).unwrap();
        let viewport = Viewport::new(SIZE.0, SIZE.1).unwrap();
        let scale = f64::from(SIZE.1) / 2.0 * 0.9 / pixels;
        let camera = Camera::orbit(grid.centre(), 100.0, orbit, Projection::Parallel { scale });
        let rays = Rays::new(&camera, viewport, &grid).unwrap();
        let axis = Axis::most_parallel(rays.central_direction());
        (Lattice::new(&rays, viewport, &grid, axis, density, Sampling::Points(Kernel::Cubic)).unwrap(), rays)
    }

    fn orbit(azimuth: f64, elevation: f64, roll: f64) -> Orbit {
        Orbit { azimuth, elevation, roll }
    }

    #[test]
    fn samples_lie_on_pixels_where_the_view_is_not_rolled() {
        for (orbit, aligned) in [
            (orbit(30.0, 20.0, 0.0), [true; 2]),
            (orbit(72.0, 20.0, 0.0), [true; 2]),
            (orbit(250.0, -30.0, 0.0), [true; 2]),
            (orbit(30.0, 0.0, 0.0), [true; 2]),
            (orbit(30.0, 20.0, 90.0), [true; 2]),
            (orbit(0.0, 60.0, 0.0), [true; 2]),
            (orbit(0.0, 20.0, 30.0), [false; 2]),
            (orbit(30.0, 20.0, 1.0), [true; 2]),
            (orbit(30.0, 20.0, 9.0), [false; 2]),
            (orbit(30.0, 60.0, 0.0), [false; 2]),
        ] {
            let (lattice, rays) = lattice(orbit, 1.2, Density::Relaxed);
            assert_eq!(lattice.aligned, aligned, "{orbit:?}");
            let to_lattice = lattice.from_screen(&rays);
            for (x, y) in [(0.5, 0.5), (31.5, 8.5), (89.5, 69.5), (0.5, 69.5)].into_iter().filter(|_| aligned == [true; 2]) {
                let place = to_lattice * DVec3::new(x, y, 1.0);
                assert_abs_diff_eq!(place.x, place.x.round(), epsilon = 1e-6);
                let column = place.x.round() as i64 as u32;
                let row = place.y - lattice.stagger.shift(column);
                assert_abs_diff_eq!(row, row.round(), epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn columns_have_samples_where_pixels_cross_them_in_rolled_views() {
        for (orbit, crossed) in [
            (orbit(0.0, 20.0, 30.0), Some(ScreenAxis::X)),
            (orbit(30.0, 20.0, 70.0), Some(ScreenAxis::Y)),
            (orbit(30.0, 60.0, 0.0), Some(ScreenAxis::X)),
            (orbit(40.0, 60.0, 20.0), Some(ScreenAxis::X)),
            (orbit(30.0, 20.0, 0.0), None),
        ] {
            let (lattice, rays) = lattice(orbit, 1.2, Density::Relaxed);
            assert_eq!(lattice.crossed_along, crossed, "{orbit:?}");
            let Some(along) = crossed else { continue };
            let to_lattice = lattice.from_screen(&rays);
            for (place, column) in [0.5, 31.5, 69.5].into_iter().flat_map(|place| [0, 7, 31].map(|column| (place, column))) {
                // The point of this row (or column) of pixels on this column of the lattice.
                let at = |other: f64| {
                    to_lattice
                        * if along == ScreenAxis::X { DVec3::new(other, place, 1.0) } else { DVec3::new(place, other, 1.0) }
                };
                let (start, next) = (at(0.0), at(1.0));
                let crossing = at((f64::from(column) - start.x) / (next.x - start.x));
                assert_abs_diff_eq!(crossing.x, f64::from(column), epsilon = 1e-6);
                let row = crossing.y - lattice.stagger.shift(column);
                assert_abs_diff_eq!(row, row.round(), epsilon = 1e-5);
            }
        }
    }

    #[test]
    fn samples_are_no_farther_apart_than_kernels_have_room_for() {
        let viewport = Viewport::new(SIZE.0, SIZE.1).unwrap();
        let densities = [Density::Relaxed, Density::Fine, Density::AtLeast(1), Density::Fixed(1)];
        let mut staggered = 0;
        for spacing in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.2), DVec3::new(0.2, 1.0, 1.0), DVec3::new(1.0, 0.3, 1.0)] {
            let grid = Grid::new([40, 50, 60], spacing).unwrap();
            for (azimuth, elevation) in [(0.0, 75.0), (44.0, 44.0), (0.0, 40.0), (75.0, 0.0), (60.0, 20.0), (90.0, 75.0)] {
                let camera =
                    Camera::orbit(grid.centre(), 100.0, orbit(azimuth, elevation, 0.0), Projection::Parallel { scale: 29.0 });
                let rays = Rays::new(&camera, viewport, &grid).unwrap();
                for (axis, density) in Axis::ALL.into_iter().flat_map(|a| densities.map(|d| (a, d))) {
                    let sampling = Sampling::Points(Kernel::Cubic);
                    let Some(lattice) = Lattice::new(&rays, viewport, &grid, axis, density, sampling) else { continue };
                    let apart = lattice.samples_per_voxel.map(|samples| 1.0 / samples);
                    let fit = apart.iter().all(|&voxels| voxels <= MAX_VOXELS_PER_POINT);
                    assert!(fit, "{spacing}, {azimuth}, {elevation}, {density:?}: {apart:?}");
                    staggered += i32::from(lattice.has_pixels_samples());
                }
            }
        }
        assert!(staggered >= 5, "{staggered}");
    }

    #[test]
    fn pixels_take_fewer_samples_where_they_are_aligned() {
        let samples = |roll| lattice(orbit(30.0, 20.0, roll), 1.2, Density::Relaxed).0.samples() as f64;
        assert!(samples(0.0) < 0.7 * samples(9.0), "{} {}", samples(0.0), samples(9.0));
    }

    #[test]
    fn samples_keep_to_voxels_where_these_are_much_larger_or_smaller_than_pixels() {
        for (pixels, density) in
            [(0.8, Density::Relaxed), (3.0, Density::Fine), (1.2, Density::Fixed(2)), (1.2, Density::AtLeast(2))]
        {
            assert_eq!(lattice(orbit(30.0, 20.0, 0.0), pixels, density).0.aligned, [false; 2], "{pixels} {density:?}");
        }
    }
}
