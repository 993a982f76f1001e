//! Gradient opacity in all algorithms that composite: closed forms, the f64 reference, the converged integral.

use crate::common::blends::{composited, compositing, crop, cuts, tolerance_of};
use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::reference::Integral;
use layersplat::settings::{Algorithm, Blend, Clipping, GradientOpacity};
use layersplat::transfer::Extinction;
use layersplat::volume::Voxels;
use layersplat::{Camera, Error, GradientEstimator, Settings, TransferFunction, Volume};

/// Transmittances of up to 20 samples in f32, each raised to a power (elementary.cl: 1.2e-6 of the logarithm).
const FLOATS: f64 = 3e-5;
/// Ray casting in steps of 1/10 voxel compared with the integral in steps of 1/16.
const STEP_TOLERANCE: f64 = 6e-3;

fn edges(points: &[(f64, f64)]) -> Option<GradientOpacity> {
    Some(GradientOpacity::new(points).unwrap())
}

/// For a random volume of bytes: from 0 to 1 over most gradient magnitudes, then slightly down.
fn ramp() -> Option<GradientOpacity> {
    edges(&[(5.0, 0.0), (30.0, 0.4), (70.0, 1.0), (120.0, 0.8)])
}

fn thinned(settings: Settings) -> Settings {
    Settings { gradient_opacity: ramp(), ..settings }
}

fn unlit(settings: Settings) -> Settings {
    Settings { shading: None, ..settings }
}

fn is_sheets(settings: &Settings) -> bool {
    matches!(settings.algorithm, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. })
}

/// Each algorithm, lit and unlit.
fn each() -> impl Iterator<Item = Settings> {
    compositing().into_iter().map(|a| composited(a, Clipping::default())).flat_map(|s| [s, unlit(s)])
}

fn scene() -> (Volume<'static>, [Camera; 2]) {
    let volume = random_volume([14, 11, 12], DVec3::new(1.0, 0.7, 1.3), 21);
    let views = [parallel(&volume, viewport(25, 22), 25.0, -15.0), perspective(&volume, 200.0, 30.0, 35.0)];
    (volume, views)
}

/// A linear field has a constant gradient, so the remaining extinction is known.
#[test]
fn of_an_even_slope() {
    const RISE: f64 = 30.0;
    let (dims, spacing, alpha) = ([12, 12, 16], DVec3::new(1.0, 0.8, 1.5), 0.06);
    let rising = (0..dims[0] * dims[1] * dims[2]).map(|i| (i / (dims[0] * dims[1])) as f32 * RISE as f32 - 50.0).collect();
    let volume = volume(dims, spacing, Voxels::Float32(rising));
    let fog = TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(0.0, alpha)]).unwrap();
    // Excludes the outer layers, where the field is not linear.
    let inside = crop([0.0, 0.0, 4.0], [11.0, 11.0, 12.0]);
    let camera = scaled(parallel(&volume, viewport(9, 9), 0.0, 0.0), 2.0);
    let length = 8.0 * spacing.z;
    // Values per world unit.
    let slope = RISE / spacing.z;
    for (points, left) in [
        (vec![(0.0, 0.0), (2.0 * slope, 1.0)], 0.5),
        (vec![(0.9 * slope, 1.0), (1.3 * slope, 0.2)], 0.8),
        (vec![(0.0, 0.0), (0.2 * slope, 0.9), (0.8 * slope, 0.1), (1.2 * slope, 0.5)], 0.3),
        (vec![(1.1 * slope, 0.0), (1.2 * slope, 1.0)], 0.0),
        (vec![(7.0, 0.25)], 0.25),
    ] {
        for algorithm in compositing() {
            let settings =
                Settings { gradient_opacity: edges(&points), unit_distance: Some(1.0), ..composited(algorithm, inside) };
            // Gaussian reconstructions of a linear field ripple.
            if is_sheets(&settings) || matches!(algorithm, Algorithm::Raycast { kernel: Kernel::Gaussian, .. }) {
                continue;
            }
            let expected = (1.0f64 - alpha).powf(left * length);
            for settings in [settings, unlit(settings)] {
                let found = 1.0 - f64::from(render(&volume, &fog, &camera, viewport(9, 9), &settings).pixel(4, 4)[3]);
                assert!((found - expected).abs() < FLOATS, "{points:?} in {algorithm:?}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn device_and_reference() {
    let (volume, views) = scene();
    let size = viewport(25, 22);
    for (camera, is_parallel) in views.into_iter().zip([true, false]) {
        for settings in each().map(thinned) {
            let what = format!("{:?}, shading {:?}, parallel {is_parallel}", settings.algorithm, settings.shading.is_some());
            let tolerance = tolerance_of(&settings, is_parallel);
            Pair::of(&volume, &smooth_transfer(), &camera, size, &settings).assert_same(&what, tolerance);
            let wrong = Settings { gradient_opacity: None, ..settings };
            let wrong = Pair::against(&volume, &smooth_transfer(), &camera, size, &settings, &wrong);
            assert!(wrong.differing(2.0 * tolerance) > 0.3, "{what}: full opacity must be detected");
        }
    }
}

#[test]
fn cut_and_of_linear_extinction() {
    let (volume, [camera, _]) = scene();
    let size = viewport(25, 22);
    for settings in each().map(thinned) {
        for settings in [
            Settings { clipping: cuts(), ..settings },
            Settings { extinction: Extinction::Linear, unit_distance: Some(1.2), ..settings },
        ] {
            let what = format!("{:?}, {:?}", settings.algorithm, settings.extinction);
            Pair::of(&volume, &smooth_transfer(), &camera, size, &settings).assert_same(&what, tolerance_of(&settings, true));
        }
    }
}

/// A factor of 1 changes no bit; a factor of 0 leaves nothing.
#[test]
fn all_and_nothing() {
    let (volume, views) = scene();
    for camera in views {
        for settings in each().filter(|s| s.shading.is_some()) {
            let draw = |gradient_opacity| {
                let settings = Settings { gradient_opacity, ..settings };
                render(&volume, &smooth_transfer(), &camera, viewport(25, 22), &settings)
            };
            assert_eq!(draw(edges(&[(3.0, 1.0)])), draw(None), "{:?}", settings.algorithm);
            assert_eq!(largest_opacity(&draw(edges(&[(0.0, 0.0)]))), 0.0, "{:?}", settings.algorithm);
        }
    }
}

/// Gradient magnitudes are in world units: scaling the world does not change the picture.
#[test]
fn in_another_unit() {
    let (volume, [camera, _]) = scene();
    let bytes = random_bytes(volume.grid().dims(), 21);
    let metres = crate::common::volume(volume.grid().dims(), volume.grid().spacing() * 0.001, Voxels::Uint8(bytes));
    let metres = metres.with_background(0.0).unwrap();
    let settings = thinned(Settings::default());
    let size = viewport(25, 22);
    let found = render(&volume, &smooth_transfer(), &camera, size, &settings);
    let camera = parallel(&metres, size, 25.0, -15.0);
    let steeper = Settings { gradient_opacity: edges(&[(5e3, 0.0), (3e4, 0.4), (7e4, 1.0), (1.2e5, 0.8)]), ..settings };
    assert_close("metres", &render(&metres, &smooth_transfer(), &camera, size, &steeper), &found, FLOATS);
    assert!(compare(&render(&metres, &smooth_transfer(), &camera, size, &settings), &found).max_difference > 0.05);
}

/// Per pixel, smaller steps converge to the integral; the lattice of every kernel is close to it.
#[test]
fn converges() {
    let (volume, views) = scene();
    let size = viewport(25, 22);
    let cast = Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.1 };
    for camera in views {
        for settings in [cast.into(), unlit(cast.into())].map(thinned) {
            let transfer = smooth_transfer();
            let mut integral = Integral::new(&volume, &transfer, None);
            (integral.shading, integral.gradient_opacity) = (settings.shading, settings.gradient_opacity);
            let expected = integral.render(&camera, size).unwrap();
            let found = render(&volume, &smooth_transfer(), &camera, size, &settings);
            assert_close("fine steps", &found, &expected, STEP_TOLERANCE);
            let central = Settings { gradient: Some(GradientEstimator::Central), ..Settings::default() };
            let near = compare(&render(&volume, &smooth_transfer(), &camera, size, &thinned(central)), &expected);
            println!("default: {near:?}");
        }
    }
}

#[test]
fn culling_changes_nothing() {
    let (volume, views) = scene();
    for camera in views {
        for settings in each().map(thinned) {
            let draw =
                |culling| render(&volume, &smooth_transfer(), &camera, viewport(25, 22), &Settings { culling, ..settings });
            assert_eq!(draw(true), draw(false), "{:?}", settings.algorithm);
        }
    }
}

#[test]
fn refusals() {
    for points in [&[][..], &[(0.0, 1.5)], &[(-1.0, 0.5)], &[(1.0, 0.5), (1.0, 0.7)], &[(f64::NAN, 0.5)], &[(1.0, 0.5); 9]] {
        let refused = GradientOpacity::new(points);
        assert!(matches!(refused, Err(Error::OutOfRange { name: "gradient_opacity", .. })), "{points:?}: {refused:?}");
    }
    let (volume, [camera, _]) = scene();
    let settings = Settings { blend: Blend::Maximum, ..thinned(Settings::default()) };
    let mut renderer = layersplat::Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let refused = renderer.render(&camera, viewport(9, 9), &settings).unwrap_err();
    assert!(matches!(refused, Error::Settings { field: "gradient_opacity", .. }), "{refused}");
}
