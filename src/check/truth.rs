//! Reference pictures of the check in `f64` on the host: `reference` evaluates each ray, or the rays of a lattice, which are then warped.

use super::Family;
use super::pictures::{Picture, SIZE, transfer, volume};
use crate::device::Device;
use crate::image::Frame;
use crate::layers::{Axis, Kernel, Lattice, Lines, Rays};
use crate::reference::{Integral, Layered, Marched, Sheets};
use crate::renderer::{PaperPlan, Plan, Renderer};
use glam::{DVec3, DVec4};

/// Computes the reference picture; of the studio, draws it.
pub(super) fn drawn(family: Family, Picture { settings, camera, surfaces }: &Picture) -> Frame {
    let (volume, transfer) = (&volume(), &transfer());
    let integral = || {
        let own = Integral::new(volume, transfer, None).with_gradient(Kernel::Cubic, settings.gradient_estimator());
        let mut integral = own.with_surfaces(surfaces);
        integral.shading = settings.shading;
        integral
    };
    if family == Family::Surfaces {
        return integral().render(camera, SIZE).unwrap();
    }
    if family == Family::Studio {
        let mut renderer = Renderer::new(&Device::shared(), volume, transfer).unwrap();
        return renderer.render(camera, SIZE, settings).unwrap().0;
    }
    let rays = Rays::new(camera, SIZE, volume.grid()).unwrap();
    let layered = Layered::new(volume, transfer, settings);
    match Plan::new(&rays, SIZE, volume.grid(), settings).unwrap() {
        Plan::Lattice(lattice, _) => {
            let axis = lattice.frame.layer_axis();
            let filter = rays.voxels_per_pixel(lattice.frame).ceil() as usize;
            let sample = |i, j| DVec4::from_array(layered.composite(&lattice.ray(i, j), Some(axis), rays.to_eye));
            let samples = (0..lattice.size[1]).flat_map(|j| (0..lattice.size[0]).map(move |i| (i, j)));
            let samples: Vec<DVec4> = samples.map(|(i, j)| sample(i, j)).collect();
            return warped(&lattice, &samples, &rays, filter);
        }
        Plan::Direct(..) => layered.render(camera, SIZE, Some(Axis::most_parallel(rays.central_direction()))),
        Plan::CastSegments(..) => integral().render(camera, SIZE),
        Plan::Paper(PaperPlan::AxisSheets(_) | PaperPlan::ViewSheets(_)) => {
            Sheets::new(volume, transfer, settings).render(camera, SIZE)
        }
        Plan::Raycast(..) | Plan::CastValues(..) | Plan::Paper(PaperPlan::Slicing(_)) => {
            Marched::new(volume, transfer, settings).render(camera, SIZE)
        }
        plan @ Plan::Shared(..) => panic!("{family}: {plan}"),
    }
    .unwrap()
}

/// Warps a lattice to the screen: the mean of `filter` × `filter` positions per pixel.
fn warped(lattice: &Lattice, samples: &[DVec4], rays: &Rays, filter: usize) -> Frame {
    let from_screen = lattice.from_screen(rays);
    let places = |n: u32| (0..filter).map(move |i| f64::from(n) + (i as f64 + 0.5) / filter as f64);
    let pixel = |x: u32, y: u32| {
        let mut sum = DVec4::ZERO;
        for (x, y) in places(y).flat_map(|y| places(x).map(move |x| (x, y))) {
            let place = from_screen * DVec3::new(x, y, 1.0);
            let [column, row] = [place.x / place.z, place.y / place.z];
            sum += if lattice.has_pixels_samples() {
                let column = column.round();
                sample(lattice, samples, column as i64, (row - lattice.stagger.shift(column.max(0.0) as u32)).round() as i64)
            } else {
                let lines = if filter == 1 { Lines::new(lattice, rays, SIZE).map(|lines| lines.axis) } else { None };
                let step = |axis: usize| {
                    let change = from_screen.col(axis);
                    [0, 1].map(|i| change[i] - place[i] / place.z * change.z)
                };
                match (lattice.crossed_along, lines) {
                    (Some(axis), _) => {
                        let [across, along] = step(axis as usize);
                        between_columns(lattice, samples, column, row, along / across)
                    }
                    (None, Some(axis)) => between_lines(lattice, samples, [column, row], step(0), axis),
                    (None, None) => interpolated(lattice, samples, column, row),
                }
            };
        }
        (sum / (filter * filter) as f64).to_array().map(|c| c as f32)
    };
    let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
    Frame::new(SIZE, pixels.map(|(x, y)| pixel(x, y)).collect())
}

/// A lattice sample; transparent outside the lattice.
fn sample(lattice: &Lattice, samples: &[DVec4], i: i64, j: i64) -> DVec4 {
    let [width, height] = lattice.size.map(i64::from);
    let inside = (0..width).contains(&i) && (0..height).contains(&j);
    if inside { samples[(j * width + i) as usize] } else { DVec4::ZERO }
}

/// Interpolates the samples of columns that a row of pixels crosses; `slope`: of that row, in rows of the lattice per column.
fn between_columns(lattice: &Lattice, samples: &[DVec4], column: f64, row: f64, slope: f64) -> DVec4 {
    let below = column.floor() as i64;
    let [before, low, high, behind] = [-1, 0, 1, 2].map(|n| {
        let (i, across) = (below + n, (below + n) as f64 - column);
        let j = (row + across * slope - lattice.stagger.shift(i.max(0) as u32)).round() as i64;
        (Kernel::CatmullRom.weight(across), sample(lattice, samples, i, j))
    });
    filtered([before, low, high, behind])
}

/// Weighted sum of four colours, clamped to the range of the middle two and to its opacity.
fn filtered(colors: [(f64, DVec4); 4]) -> DVec4 {
    let sum: DVec4 = colors.into_iter().map(|(weight, color)| weight * color).sum();
    let [_, (_, low), (_, high), _] = colors;
    let within = sum.clamp(low.min(high), low.max(high));
    within.min(DVec4::splat(within.w))
}

/// Interpolates lines of constant u (`axis` 0) or v (1) where a row of pixels crosses them, then between these. `step`: lattice position from
/// a pixel to the next of the row.
fn between_lines(lattice: &Lattice, samples: &[DVec4], place: [f64; 2], step: [f64; 2], axis: usize) -> DVec4 {
    let slope = step[1 - axis] / step[axis];
    let below = place[axis].floor();
    let line = |line: f64| {
        let at = place[1 - axis] + (line - place[axis]) * slope;
        let colors = [-1.0, 0.0, 1.0, 2.0].map(|n| {
            let j = at.floor() + n;
            let [i, j] = if axis == 0 { [line, j] } else { [j, line] };
            (Kernel::CatmullRom.weight(at - at.floor() - n), sample(lattice, samples, i as i64, j as i64))
        });
        filtered(colors)
    };
    filtered([-1.0, 0.0, 1.0, 2.0].map(|n| (Kernel::CatmullRom.weight(place[axis] - below - n), line(below + n))))
}

/// Interpolates lattice samples by Catmull–Rom, clamped to the range of the four nearest samples; colours are clamped to the opacity.
fn interpolated(lattice: &Lattice, samples: &[DVec4], column: f64, row: f64) -> DVec4 {
    let sample = |i: i64, j: i64| sample(lattice, samples, i, j);
    let (i, j) = (column.floor() as i64, row.floor() as i64);
    let mut sum = DVec4::ZERO;
    for (di, dj) in (-1..3).flat_map(|dj| (-1..3).map(move |di| (di, dj))) {
        let weight = |x: f64| Kernel::CatmullRom.weight(x);
        sum += weight(column - (i + di) as f64) * weight(row - (j + dj) as f64) * sample(i + di, j + dj);
    }
    let around = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| sample(i + di, j + dj));
    let (lowest, highest) = around.into_iter().fold((around[0], around[0]), |(lo, hi), s| (lo.min(s), hi.max(s)));
    let within = sum.clamp(lowest, highest);
    within.min(DVec4::splat(within.w))
}
