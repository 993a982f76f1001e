//! Voxels on sheared axes, compared with the converged integral of the function that they sample.

use glam::{DAffine3, DMat3, DVec3};
use layersplat::reference::Integral;
use layersplat::renderer::{Channel, UploadedVolume};
use layersplat::volume::Grid;
use layersplat::{
    Camera, Device, DeviceChoice, Error, Frame, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::f64::consts::PI;

const VIEWPORT: Viewport = Viewport { width: 88, height: 80 };
const DIMS: [usize; 3] = [40, 36, 32];
/// PSNR in dB over RGBA, at quality `high`: 66 and more were measured.
const LEAST: f64 = 60.0;
/// With an error, at most this: up to 38 dB were measured.
const WRONG: f64 = 45.0;

/// A smooth function of a place in voxels, from 0 to 1, that is 0 beyond the outermost ones; and its gradient per voxel.
fn function(place: DVec3) -> (f64, DVec3) {
    let sides = DVec3::from_array(DIMS.map(|n| n as f64 - 1.0));
    let share = place / sides;
    if share.min_element() <= 0.0 || share.max_element() >= 1.0 {
        return (0.0, DVec3::ZERO);
    }
    // One bump along x, two of different heights along y, and one along z.
    let bump = |t: f64| ((PI * t).sin().powi(2), PI * (2.0 * PI * t).sin());
    let two = |t: f64| {
        let (high, slope) = ((2.0 * PI * t).sin().powi(2), 2.0 * PI * (4.0 * PI * t).sin());
        (high * (0.6 + 0.4 * t), slope * (0.6 + 0.4 * t) + 0.4 * high)
    };
    let [(x, dx), (y, dy), (z, dz)] = [bump(share.x), two(share.y), bump(share.z)];
    (x * y * z, DVec3::new(dx * y * z, x * dy * z, x * y * dz) / sides)
}

/// Sheared along two axes, turned, mirrored, and with three spacings.
fn placement() -> DAffine3 {
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::new(-0.2, 0.35, 1.0));
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let axes = turn * shear * DMat3::from_diagonal(DVec3::new(-0.8, 1.0, 1.1));
    DAffine3::from_mat3_translation(axes, DVec3::new(12.0, -40.0, 5.0))
}

/// The voxels of a grid whose voxel p holds the function at `place · p`.
fn sampled(grid: Grid, place: DAffine3) -> Volume<'static> {
    let [x, y, _] = grid.dims();
    let at = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64);
    let voxels: Vec<f32> = (0..grid.voxel_count()).map(|n| function(place.transform_point3(at(n))).0 as f32).collect();
    Volume::new("bumps", grid, voxels).unwrap()
}

fn transfer() -> TransferFunction {
    let colors = vec![(0.0, [0.1, 0.2, 0.9]), (0.5, [0.9, 0.8, 0.2]), (1.0, [1.0, 0.3, 0.1])];
    TransferFunction::new("ramp", colors, vec![(0.0, 0.0), (0.15, 0.0), (0.5, 0.15), (1.0, 0.3)]).unwrap()
}

fn device() -> Device {
    Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
}

/// The voxels at the origin, without shear.
fn uploaded(device: &Device) -> UploadedVolume {
    UploadedVolume::new(device, &sampled(Grid::new(DIMS, DVec3::new(0.8, 1.0, 1.1)).unwrap(), DAffine3::IDENTITY)).unwrap()
}

/// PSNR in dB over RGBA.
fn psnr(one: &Frame, other: &Frame) -> f64 {
    let pairs = one.pixels().as_flattened().iter().zip(other.pixels().as_flattened());
    let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (squares / (4 * one.pixels().len()) as f64).log10()
}

/// The integral of the function at its place in the world. Opacities are per smallest distance of adjacent voxels, times `unit`.
fn truth(camera: &Camera, settings: &Settings, unit: f64) -> Frame {
    let grid = Grid::covering(DIMS, placement()).unwrap();
    let to_voxels = placement().inverse() * grid.index_to_world();
    let volume = sampled(grid, to_voxels);
    let axes = placement().matrix3;
    let smallest = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length).into_iter().fold(f64::INFINITY, f64::min);
    let transfer = transfer();
    let known = move |place: DVec3| {
        let (value, gradient) = function(to_voxels.transform_point3(place));
        (value, to_voxels.matrix3.transpose() * gradient)
    };
    let mut integral = Integral::new(&volume, &transfer, Some(unit * smallest)).with_known(known);
    integral.shading = settings.shading;
    integral.render(camera, VIEWPORT).unwrap()
}

#[test]
fn pictures_are_of_the_function_that_sheared_voxels_sample() {
    let device = device();
    let volume = uploaded(&device);
    let placed = volume.with_placement(placement()).unwrap();
    // Another shear of the second axis by a fifth, for an error.
    let mut wrong = placement();
    wrong.matrix3.y_axis -= 0.1 * wrong.matrix3.x_axis / 0.8;
    let wrong = volume.with_placement(wrong).unwrap();
    let grid = placed.description().grid();
    let high = Quality::High.settings();
    for (name, settings) in [("lit", high), ("unlit", Settings { shading: None, ..high })] {
        for (azimuth, elevation) in [(25.0, 20.0), (80.0, -35.0)] {
            let orbit = Orbit { azimuth, elevation, roll: 0.0 };
            let camera = Camera::fit_parallel(grid.centre(), 0.7 * grid.diagonal(), VIEWPORT, orbit);
            let draw = |volume: &UploadedVolume| {
                let mut renderer = Renderer::from_channels(&[Channel::new(volume, &transfer())]).unwrap();
                renderer.render(&camera, VIEWPORT, &settings).unwrap().0
            };
            let (picture, truth, other_unit) = (draw(&placed), truth(&camera, &settings, 1.0), truth(&camera, &settings, 1.3));
            let fidelity = psnr(&picture, &truth);
            let [sheared_otherwise, other_unit] = [psnr(&draw(&wrong), &truth), psnr(&picture, &other_unit)];
            println!(
                "{name}, azimuth {azimuth}: {fidelity:.1} dB; {sheared_otherwise:.1} with another shear, {other_unit:.1} per other length"
            );
            assert!(fidelity >= LEAST, "{name}, azimuth {azimuth}: {fidelity}");
            assert!(
                sheared_otherwise < WRONG && other_unit < WRONG,
                "errors would be noticed: {sheared_otherwise}, {other_unit}"
            );
            assert!(
                picture.pixels().iter().filter(|pixel| pixel[3] > 0.2).count() > 500,
                "the field fills a part of the picture"
            );
        }
    }
}

/// A transform without shear moves the voxels, and their values stay.
#[test]
fn unsheared_voxels_keep_their_values() {
    /// Of floats, at places that are off by 1e-6 of a voxel.
    const SAME: f64 = 90.0;
    let device = device();
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let affine = DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(DVec3::new(-0.8, 1.0, 1.1)), DVec3::splat(9.0));
    let placed = uploaded(&device).with_placement(affine).unwrap();
    let grid = placed.description().grid().clone();
    let own = sampled(grid.clone(), affine.inverse() * grid.index_to_world());
    let own = UploadedVolume::new(&device, &own).unwrap();
    let camera =
        Camera::fit_parallel(grid.centre(), grid.diagonal(), VIEWPORT, Orbit { azimuth: 25.0, elevation: 20.0, roll: 0.0 });
    let [one, other] = [&placed, &own].map(|volume| {
        let mut renderer = Renderer::from_uploaded(volume, &transfer()).unwrap();
        renderer.render(&camera, VIEWPORT, &Settings::default()).unwrap().0
    });
    assert!(psnr(&one, &other) > SAME, "{}", psnr(&one, &other));
}

#[test]
fn what_has_no_place_is_refused() {
    let device = device();
    let flat = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y));
    assert!(matches!(uploaded(&device).with_placement(flat), Err(Error::Grid { .. })));
    let volume = sampled(Grid::new(DIMS, DVec3::ONE).unwrap(), DAffine3::IDENTITY);
    let part = volume.part([0; 3], [40, 36, 4]).unwrap();
    assert!(matches!(UploadedVolume::part(&device, &part).unwrap().with_placement(placement()), Err(Error::Volume { .. })));
}
