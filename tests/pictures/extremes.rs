//! Extreme values of f32: pictures must remain correct.

use crate::common::{OTHERS, device, random_bytes, smooth_transfer, volume};
use glam::DVec3;
use layersplat::settings::{Classification, ClipPlane, Clipping, Evaluation, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, Correction, Frame, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport};

/// All algorithms.
fn ways() -> Vec<Settings> {
    let layered = [
        Layered::default(),
        Layered { classification: Classification::Post(Correction::SubLayers(2)), ..Layered::default() },
        Layered { evaluation: Evaluation::Direct, ..Layered::default() },
    ];
    layered.map(Settings::from).into_iter().chain(OTHERS.map(Settings::from)).collect()
}

/// A picture of a world scaled by `unit`, including eye, unit distance and clip plane.
fn picture(unit: f64, projection: Projection, settings: &Settings) -> Frame {
    let bytes = random_bytes([14, 11, 12], 5);
    let volume = volume([14, 11, 12], DVec3::new(1.0, 2.0, 1.5) * unit, Voxels::Uint8(bytes));
    let transfer = smooth_transfer();
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let grid = volume.grid();
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 5.0 };
    let camera = Camera::orbit(grid.centre(), 50.0 * unit, orbit, projection);
    let plane = ClipPlane { point: grid.centre(), normal: DVec3::new(1.0, 0.5, 0.2) };
    let settings = Settings { unit_distance: Some(1.3 * unit), clipping: Clipping::default().with_planes([plane]), ..*settings };
    renderer.render(&camera, Viewport::new(33, 29).unwrap(), &settings).unwrap().0
}

/// Scaling the world by a power of two changes no bit, however small or large.
#[test]
fn the_unit_of_the_world_is_of_no_matter() {
    for settings in ways() {
        for (exponent, perspective) in [(-90, false), (90, true), (-70, true), (80, false)] {
            let unit = 2f64.powi(exponent);
            let projection = |unit: f64| match perspective {
                false => Projection::Parallel { scale: 14.0 * unit },
                true => Projection::Perspective { field_of_view: 35.0 },
            };
            let (own, other) = (picture(1.0, projection(1.0), &settings), picture(unit, projection(unit), &settings));
            assert!(own.pixels().iter().any(|p| p[3] > 0.1), "the picture must not be empty: {settings:?}");
            assert!(own == other, "2^{exponent}: {settings:?}");
        }
    }
}

/// Largest difference between the centre of a picture of one voxel and one of an extremely small region: their values differ by up to the
/// length of a pixel of the first.
const ACROSS_A_PIXEL: f32 = 0.02;

#[test]
fn pictures_of_next_to_nothing_have_its_colour() {
    let bytes = random_bytes([14, 11, 12], 5);
    let volume = volume([14, 11, 12], DVec3::ONE, Voxels::Uint8(bytes));
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let viewport = Viewport::new(25, 25).unwrap();
    let centre = volume.grid().centre() + DVec3::new(0.3, 0.2, 0.1);
    for settings in ways() {
        let mut at = |scale: f64| {
            let camera = Camera::orbit(centre, 50.0, Orbit::default(), Projection::Parallel { scale });
            renderer.render(&camera, viewport, &settings).unwrap().0.pixels()[12 * 25 + 12]
        };
        let near = at(0.1);
        assert!(near[3] > 0.1);
        for scale in [1e-9, 1e-15, 1e-16, 1e-20, 1e-29] {
            let far = at(scale);
            let difference = near.iter().zip(far).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(difference < ACROSS_A_PIXEL, "{scale}: {far:?} for {near:?}, {settings:?}");
        }
        for scale in [1e-40, 1e-300, 1e40] {
            let camera = Camera::orbit(centre, 50.0, Orbit::default(), Projection::Parallel { scale });
            let refused = renderer.render(&camera, viewport, &settings).unwrap_err().to_string();
            assert!(refused.contains("scale"), "{refused}");
        }
    }
}

/// A ramp too steep for f32 becomes a step.
#[test]
fn ranges_too_narrow_for_floats_are_steps() {
    let bytes: Vec<u8> = random_bytes([14, 11, 12], 5).into_iter().map(|b| if b > 128 { b } else { 0 }).collect();
    let volume = volume([14, 11, 12], DVec3::ONE, Voxels::Uint8(bytes));
    let transfer = |end: f64| {
        let colors = vec![(0.0, [0.2, 0.4, 0.8]), (end, [1.0, 0.8, 0.4])];
        TransferFunction::new("ramp", colors, vec![(0.0, 0.0), (end, 0.7)]).unwrap()
    };
    let viewport = Viewport::new(25, 25).unwrap();
    let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, Orbit::default());
    for settings in ways() {
        let of = |end: f64| {
            let mut renderer = Renderer::new(&device(), &volume, &transfer(end)).unwrap();
            renderer.render(&camera, viewport, &settings).unwrap().0
        };
        let (step, steeper) = (of(1e-30), of(1e-37));
        assert!(step.pixels().iter().any(|p| p[3] > 0.5), "{settings:?}");
        let difference = step.pixels().iter().flatten().zip(steeper.pixels().iter().flatten());
        let difference = difference.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(difference < ACROSS_A_PIXEL, "differs by {difference}: {settings:?}");
    }
}
