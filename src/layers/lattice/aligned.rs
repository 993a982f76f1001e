//! Samples on pixels: where a row or a column of the screen crosses all layers along an axis of the lattice, as it does wherever the view is
//! not rolled about an axis of the volume, samples can lie on pixels along the other. There is nothing to interpolate along that one then,
//! and one sample per pixel is exact.

use super::{Density, Sampling};
use crate::layers::{AxisFrame, Rays};
use crate::viewport::Viewport;

/// Pixels by which samples may leave theirs from one end of the viewport to the other.
const MOST_DRIFT: f64 = 0.01;

/// How samples lie along one axis of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    pub samples_per_voxel: f64,
    /// A voxel coordinate at which a sample lies.
    pub on_pixel: Option<f64>,
}

/// How samples lie along u and v of a parallel view. `crossing` tells where a place of the screen crosses the layer of the centre.
pub(super) fn spreads(
    rays: &Rays,
    viewport: Viewport,
    frame: AxisFrame,
    density: Density,
    sampling: Sampling,
    crossing: impl Fn(f64, f64) -> [f64; 2],
) -> [Spread; 2] {
    let free = [frame.u, frame.v].map(|axis| density.samples(rays.pixels_along(axis)).max(1.0));
    let alone = free.map(|samples_per_voxel| Spread { samples_per_voxel, on_pixel: None });
    let beside = density.beside_aligned();
    // Where a pixel shows the mean of many voxels, it is these that number the samples.
    let (Some(beside), Sampling::Points(_), false) = (beside, sampling, rays.voxels_per_pixel(frame) > 1.0) else { return alone };
    let [first, right, down] = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)].map(|(x, y)| crossing(x, y));
    let steps = [0, 1].map(|i| [right[i] - first[i], down[i] - first[i]]);
    let pitch = steps.map(|step| pixel_pitch(step, viewport));
    let aligned = [0, 1].map(|i| pitch[i].filter(|pitch| 1.0 <= pitch * free[i]));
    [0, 1].map(|i| match (aligned[i], aligned[1 - i]) {
        (Some(pitch), _) => Spread { samples_per_voxel: 1.0 / pitch, on_pixel: Some(first[i]) },
        (None, Some(_)) => {
            let pixels = 1.0 / steps[i][0].abs().max(steps[i][1].abs());
            Spread { samples_per_voxel: (pixels * beside).min(free[i]), ..alone[i] }
        }
        (None, None) => alone[i],
    })
}

/// Voxels between pixels along the side of the screen along which an axis runs, if there is one.
fn pixel_pitch(step: [f64; 2], viewport: Viewport) -> Option<f64> {
    let sides = [viewport.width, viewport.height].map(f64::from);
    let along = usize::from(step[1].abs() > step[0].abs());
    let pitch = step[along].abs();
    (step[1 - along].abs() * sides[1 - along] <= MOST_DRIFT * pitch).then_some(pitch)
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

    /// A lattice of a view in which a voxel is so many pixels large.
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
            (orbit(30.0, 20.0, 0.0), [true, false]),
            (orbit(72.0, 20.0, 0.0), [false, true]),
            (orbit(250.0, -30.0, 0.0), [false, true]),
            (orbit(30.0, 0.0, 0.0), [true, true]),
            (orbit(30.0, 20.0, 90.0), [true, false]),
            (orbit(30.0, 20.0, 1.0), [false, false]),
            (orbit(30.0, 60.0, 0.0), [false, false]),
        ] {
            let (lattice, rays) = lattice(orbit, 1.2, Density::Relaxed);
            assert_eq!(lattice.aligned, aligned, "{orbit:?}");
            let to_lattice = lattice.from_screen(&rays);
            for (i, _) in aligned.iter().enumerate().filter(|(_, aligned)| **aligned) {
                for (x, y) in [(0.5, 0.5), (31.5, 8.5), (89.5, 69.5), (0.5, 69.5)] {
                    let place = (to_lattice * DVec3::new(x, y, 1.0))[i];
                    assert_abs_diff_eq!(place, place.round(), epsilon = 1e-6);
                }
            }
        }
    }

    #[test]
    fn pixels_take_fewer_samples_where_they_are_aligned() {
        let samples = |roll| lattice(orbit(30.0, 20.0, roll), 1.2, Density::Relaxed).0.samples() as f64;
        assert!(samples(0.0) < 0.7 * samples(3.0), "{} {}", samples(0.0), samples(3.0));
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
