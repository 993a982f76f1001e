//! Footprints on the device: of one voxel, exact and from the set, and properties of the set.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Correction, Density, FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, Rays, footprint, set_direction};
use layersplat::settings::{Classification, Evaluation, Footprints, LayerAxis, Layered};
use layersplat::volume::Voxels;
use layersplat::{Renderer, Settings};

#[test]
fn one_voxel_shows_its_footprint() {
    let volume = volume([1, 1, 1], DVec3::ONE, Voxels::Uint8(vec![255])).with_background(0.0).unwrap();
    let transfer = linear_extinction(4e-3);
    let size = viewport(32, 32);
    for (azimuth, elevation) in [(0.0, 0.0), (30.0, 20.0), (80.0, -5.0)] {
        for evaluation in [Evaluation::Lattice(Density::Fixed(8)), Evaluation::Direct] {
            let settings = Settings {
                algorithm: Layered { classification: Classification::Post(Correction::None), evaluation, ..layered(unshaded()) }
                    .into(),
                ..unshaded()
            };
            let camera = scaled(parallel(&volume, size, azimuth, elevation), 2.0);
            let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
            let rays = Rays::new(&camera, size, volume.grid()).unwrap();
            let frame = Axis::most_parallel(rays.central_direction()).frame();
            let [su, sv] = frame.shear(rays.central_direction());
            let dt = DVec3::new(su, sv, 1.0).length();
            let samples: Vec<_> = match renderer.lattice_picture(&camera, size, &settings).unwrap() {
                Some(p) => {
                    (0..p.samples.len()).map(|i| (p.ray(i as u32 % p.size[0], i as u32 / p.size[0]), p.samples[i])).collect()
                }
                None => {
                    let picture = renderer.render(&camera, size, &settings).unwrap().0;
                    (0..1024)
                        .map(|i| (rays.at(f64::from(i % 32) + 0.5, f64::from(i / 32) + 0.5), picture.pixel(i % 32, i / 32)))
                        .collect()
                }
            };
            let mut largest: f64 = 0.0;
            for (ray, [_, _, _, alpha]) in samples {
                let o = frame.local(ray.origin);
                let expected = footprint(o.x - o.z * su, o.y - o.z * sv, su, sv);
                largest = largest.max(expected);
                let found = -(1.0 - f64::from(alpha)).ln() / (4e-3 * 255.0 * dt);
                // Half a table entry is 1/8192 of the range.
                assert!((found - expected).abs() < 5e-4, "{azimuth}: {found} for {expected}");
            }
            assert!(largest > 0.5);
        }
    }
}

/// Image index of a shear: the nearest column of the row nearest in angle.
fn nearest(shear: [f64; 2]) -> usize {
    let off = |index: usize, i: usize| (set_direction(index)[i].atan() - shear[i].atan()).abs();
    let order = |a: &usize, b: &usize| [1, 0].map(|i| off(*a, i)).partial_cmp(&[1, 0].map(|i| off(*b, i))).expect("angles");
    (0..FOOTPRINT_SET_LEN).min_by(order).expect("images")
}

/// Image `index` at (x, y): byte values of F at the texel centres, linearly interpolated, 0 outside.
fn image_of_set(index: usize, x: f64, y: f64) -> f64 {
    let (side, [su, sv]) = (FOOTPRINT_SET_SIZE as f64, set_direction(index));
    let centre = |texel: f64, s: f64| ((texel + 0.5) / side * 2.0 - 1.0) * (1.0 + s.abs());
    let texel = |column: f64, row: f64| {
        let inside = (0.0..side).contains(&column) && (0.0..side).contains(&row);
        if inside { (footprint(centre(column, su), centre(row, sv), su, sv) * 255.0).round_ties_even() / 255.0 } else { 0.0 }
    };
    let [column, row] = [(x, su), (y, sv)].map(|(p, s)| (p / (1.0 + s.abs()) + 1.0) / 2.0 * side - 0.5);
    let (i, j) = (column.floor(), row.floor());
    let line = |row: f64| texel(i, row) + (column - i) * (texel(i + 1.0, row) - texel(i, row));
    line(j) + (row - j) * (line(j + 1.0) - line(j))
}

/// A texel at the boundary between two byte values may be either.
const SET_TOLERANCE: f64 = 1.1 / 255.0;
/// Few texels are, and half a table entry is 1/8192 of the range: root mean square over the pixels.
const SET_RMS: f64 = 2e-4;

#[test]
fn one_voxel_shows_the_nearest_image_of_the_set() {
    let volume = volume([1, 1, 1], DVec3::ONE, Voxels::Uint8(vec![255])).with_background(0.0).unwrap();
    let size = viewport(32, 32);
    for (azimuth, elevation) in
        [(0.7, -1.1), (-40.3, 3.9), (31.7, 21.3), (17.3, -38.1), (-7.9, 33.7), (150.3, 12.7), (93.1, 28.3)]
    {
        let camera = scaled(parallel(&volume, size, azimuth, elevation), 2.0);
        let layered = Layered {
            classification: Classification::Post(Correction::None),
            evaluation: Evaluation::Direct,
            footprints: Footprints::Set,
            ..layered(unshaded())
        };
        let picture =
            render(&volume, &linear_extinction(4e-3), &camera, size, &Settings { algorithm: layered.into(), ..unshaded() });
        let rays = Rays::new(&camera, size, volume.grid()).unwrap();
        let frame = Axis::most_parallel(rays.central_direction()).frame();
        let [su, sv] = frame.shear(rays.central_direction());
        let (dt, image) = (DVec3::new(su, sv, 1.0).length(), nearest([su, sv]));
        let (mut squares, mut largest) = (0.0, 0.0f64);
        for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
            let o = frame.local(rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5).origin);
            let (u, v) = (o.x - o.z * su, o.y - o.z * sv);
            // Weights are divided by their sum over 4 × 4 voxels, so that constant fields reconstruct exactly.
            let around = |p: f64| (-1..=2).map(move |n| p.floor() + f64::from(n));
            let weight = |i: f64, j: f64| image_of_set(image, u - i, v - j);
            let sum: f64 = around(v).flat_map(|j| around(u).map(move |i| (i, j))).map(|(i, j)| weight(i, j)).sum();
            let covered = around(u).any(|i| i == 0.0) && around(v).any(|j| j == 0.0);
            let expected = if covered { weight(0.0, 0.0) / sum } else { 0.0 };
            let found = -(1.0 - f64::from(picture.pixel(x, y)[3])).ln() / (4e-3 * 255.0 * dt);
            assert!((found - expected).abs() < SET_TOLERANCE, "{azimuth}, {elevation} at {x}, {y}: {found} for {expected}");
            squares += (found - expected).powi(2);
            largest = largest.max(expected);
        }
        let rms = (squares / 1024.0f64).sqrt();
        assert!(rms < SET_RMS && largest > 0.4, "{azimuth}, {elevation}: {rms}, largest {largest}");
    }
}

/// Rounding: the weights of the 8-bit images are divided by their sum.
const SET_SUM_TOLERANCE: f64 = 1e-4;

#[test]
fn the_set_keeps_what_is_flat() {
    // Deep inside a homogeneous cube with extinction linear in the value, ln T is proportional to the lattice sum.
    let volume = cube([40, 40, 6], DVec3::ONE);
    let transfer = linear_extinction(2e-4);
    let size = viewport(16, 16);
    let mut largest: f64 = 0.0;
    for (azimuth, elevation) in [(0.0, 0.0), (3.0, 3.0), (10.0, 25.0), (30.0, 20.0), (44.0, 1.0), (40.0, 30.0), (-20.0, -33.0)] {
        let camera = scaled(parallel(&volume, size, azimuth, elevation), 2.0);
        let exact = Settings {
            algorithm: Layered {
                evaluation: Evaluation::Direct,
                classification: Classification::Post(Correction::None),
                layer_axis: LayerAxis::Forced(Axis::Z),
                ..layered(unshaded())
            }
            .into(),
            ..unshaded()
        };
        let set = Settings { algorithm: Layered { footprints: Footprints::Set, ..layered(exact) }.into(), ..exact };
        let [a, b] = [exact, set].map(|s| render(&volume, &transfer, &camera, size, &s));
        for (p, q) in a.pixels().iter().zip(b.pixels()) {
            largest = largest.max(((1.0 - f64::from(q[3])).ln() / (1.0 - f64::from(p[3])).ln() - 1.0).abs());
        }
    }
    assert!(largest < SET_SUM_TOLERANCE, "{largest}");
}

#[test]
fn the_set_is_nearest_and_close() {
    let size = viewport(40, 40);
    let volume = random_volume([20, 20, 20], DVec3::ONE, 5);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let direct = Settings {
        algorithm: Layered { classification: SPLATTED, evaluation: Evaluation::Direct, ..Layered::default() }.into(),
        ..Settings::default()
    };
    let [exact, set] = [Footprints::Exact, Footprints::Set].map(|footprints| {
        render(
            &volume,
            &smooth_transfer(),
            &camera,
            size,
            &Settings { algorithm: Layered { footprints, ..layered(direct) }.into(), ..direct },
        )
    });
    let psnr = compare(&exact, &set).psnr.expect("the set differs");
    assert!((35.0..80.0).contains(&psnr), "{psnr}");
}
