//! Estimators of gradients: closed forms, and the device against the f64 reference in all render paths that have them.

use crate::common::blends::{ISO, tolerance_of};
use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::device::LatticeSchedule;
use layersplat::settings::{Algorithm, Blend, Classification, Evaluation, Footprints, Layered, Shading};
use layersplat::volume::Voxels;
use layersplat::{Camera, Error, GradientEstimator, Kernel, Quality, Settings, Volume};

/// Rounding of an 8-bit gradient of a plane to the direction of its normal.
const ROUNDED_BYTES: f64 = 0.02;

fn points(kernel: Kernel, samples_per_layer: u32, gradient: GradientEstimator) -> Settings {
    let classification = Classification::Preintegrated { kernel, samples_per_layer };
    Settings { gradient: Some(gradient), early_termination: false, ..Layered { classification, ..Layered::default() }.into() }
}

fn splats(classification: Classification, gradient: GradientEstimator) -> Settings {
    Settings { gradient: Some(gradient), early_termination: false, ..Layered { classification, ..Layered::default() }.into() }
}

fn per_pixel(settings: Settings) -> Settings {
    Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(settings) }.into(), ..settings }
}

fn cast(kernel: Kernel, gradient: GradientEstimator) -> Settings {
    Settings { gradient: Some(gradient), early_termination: false, ..Algorithm::Raycast { kernel, step: 0.6 }.into() }
}

/// Step of ray casting, in smallest spacings, whose error is small beside that of segments of a quarter.
const FINE_STEP: f64 = 0.03;
/// In dB: half the error.
const CLEARLY_NEARER: f64 = 6.0;

/// Pairs of kernel and estimator in which gradients are estimated at the voxels.
const AT_VOXELS: [(Kernel, GradientEstimator); 6] = [
    (Kernel::Linear, GradientEstimator::Sobel),
    (Kernel::Cubic, GradientEstimator::Sobel),
    (Kernel::CatmullRom, GradientEstimator::Central),
    (Kernel::BSpline, GradientEstimator::Sobel),
    (Kernel::Linear, GradientEstimator::Gaussian(0.8)),
    (Kernel::BSpline, GradientEstimator::Gaussian(1.1)),
];

/// A volume with different smoothing along each axis, and two views. No layer is 1.5 smallest spacings thick, which would have more samples.
fn scene() -> (Volume<'static>, [Camera; 2]) {
    let volume = random_volume([14, 11, 12], DVec3::new(1.0, 0.9, 1.3), 21);
    let views = [parallel(&volume, viewport(25, 22), 25.0, -15.0), perspective(&volume, 200.0, 30.0, 35.0)];
    (volume, views)
}

/// The estimator that a comparison must tell from another one.
fn other(kernel: Kernel, gradient: GradientEstimator) -> GradientEstimator {
    match gradient {
        GradientEstimator::Central => GradientEstimator::Sobel,
        GradientEstimator::Gaussian(sigma) => GradientEstimator::Gaussian(0.7 * sigma),
        _ => GradientEstimator::for_kernel(kernel),
    }
}

fn assert_same(what: &str, volume: &Volume, camera: &Camera, settings: &Settings, tolerance: f64) {
    let (size, transfer) = (viewport(25, 22), smooth_transfer());
    Pair::of(volume, &transfer, camera, size, settings).assert_same(what, tolerance);
    let gradient = other(kernel_of(settings), settings.gradient.expect("given"));
    let wrong = Settings { gradient: Some(gradient), ..*settings };
    let differing = Pair::against(volume, &transfer, camera, size, settings, &wrong).differing(2.0 * tolerance);
    assert!(differing > 0.1, "{what}: {gradient:?} changes only {differing} of the rays");
}

#[test]
fn layers() {
    let (volume, views) = scene();
    for (camera, is_parallel) in views.into_iter().zip([true, false]) {
        for (kernel, gradient) in AT_VOXELS {
            // The second sample of a layer lies between two layers.
            for settings in [points(kernel, 1, gradient), points(kernel, 2, gradient), per_pixel(points(kernel, 1, gradient))] {
                let what = format!("{settings:?}, parallel {is_parallel}");
                assert_same(&what, &volume, &camera, &settings, tolerance_of(&settings, is_parallel));
            }
        }
    }
}

/// Tolerance of the footprint set, whose weights are bytes, relative to others (1.24 measured).
const OF_THE_SET: f64 = 1.5;

/// Lattices of both projections in both schedules, and pixels with exact footprints and with the set.
#[test]
fn splatted_layers() {
    let (volume, views) = scene();
    let (device, size) = (device(), viewport(25, 22));
    let samples = layersplat::device::Tuning { lattice_schedule: LatticeSchedule::Samples, ..*device.tuning() };
    let samples = device.with_tuning(samples).unwrap();
    for gradient in [GradientEstimator::Sobel, GradientEstimator::Gaussian(0.9)] {
        let lattice = splats(SPLATTED, gradient);
        let pixels = per_pixel(lattice);
        let set = Layered { footprints: Footprints::Set, ..layered(pixels) };
        let set = Settings { algorithm: set.into(), ..pixels };
        for (camera, is_parallel) in views.into_iter().zip([true, false]) {
            for (settings, factor) in [(lattice, 1.0), (pixels, 1.0), (set, OF_THE_SET)] {
                let what = format!("{settings:?}, parallel {is_parallel}");
                assert_same(&what, &volume, &camera, &settings, factor * tolerance_of(&settings, is_parallel));
            }
            let pair = Pair::on(&samples, &volume, &smooth_transfer(), &camera, size, &lattice);
            pair.assert_same(&format!("{lattice:?} by samples"), tolerance_of(&lattice, is_parallel));
        }
        for (azimuth, elevation) in [(85.0, 8.0), (10.0, 78.0)] {
            let camera = parallel(&volume, size, azimuth, elevation);
            for settings in [lattice, pixels] {
                let what = format!("{azimuth}, {elevation}: {settings:?}");
                assert_same(&what, &volume, &camera, &settings, tolerance_of(&settings, true));
            }
        }
    }
}

#[test]
fn layers_along_each_axis_in_both_schedules() {
    let (volume, _) = scene();
    let device = device();
    let samples = layersplat::device::Tuning { lattice_schedule: LatticeSchedule::Samples, ..*device.tuning() };
    let samples = device.with_tuning(samples).unwrap();
    let size = viewport(25, 22);
    for (azimuth, elevation) in [(85.0, 8.0), (10.0, 78.0), (190.0, -12.0)] {
        let camera = parallel(&volume, size, azimuth, elevation);
        for settings in [
            points(Kernel::Linear, 1, GradientEstimator::Sobel),
            points(Kernel::CatmullRom, 2, GradientEstimator::Sobel),
            points(Kernel::BSpline, 1, GradientEstimator::Sobel),
            points(Kernel::Cubic, 2, GradientEstimator::Gaussian(0.9)),
        ] {
            for device in [&device, &samples] {
                let pair = Pair::on(device, &volume, &smooth_transfer(), &camera, size, &settings);
                pair.assert_same(&format!("{azimuth}, {elevation}: {settings:?}"), tolerance_of(&settings, true));
            }
        }
    }
}

#[test]
fn rays() {
    let (volume, [parallel, _]) = scene();
    let inside = Camera { position: volume.grid().centre(), ..perspective(&volume, 200.0, 30.0, 60.0) };
    let inside = Camera { focal_point: volume.grid().centre() + DVec3::new(1.0, 0.4, 0.3), ..inside };
    for (kernel, gradient) in AT_VOXELS {
        let settings = cast(kernel, gradient);
        assert_same(&format!("{settings:?}"), &volume, &parallel, &settings, tolerance_of(&settings, true));
        // Segments of rays, where no lattice applies, against fine steps with the same estimator and with another.
        let draw = |settings: Settings| render(&volume, &smooth_transfer(), &inside, viewport(25, 22), &settings);
        let segments = draw(points(kernel, 1, gradient));
        let [same, different] = [gradient, other(kernel, gradient)].map(|gradient| {
            let algorithm = Algorithm::Raycast { kernel, step: FINE_STEP };
            compare(&segments, &draw(Settings { algorithm, ..cast(kernel, gradient) })).psnr.expect("differences")
        });
        assert!(same > different + CLEARLY_NEARER, "{kernel:?}, {gradient:?}: {same} and {different} dB");
    }
}

#[test]
fn surfaces() {
    let (volume, [camera, _]) = scene();
    let (sobel, gaussian) = (GradientEstimator::Sobel, GradientEstimator::Gaussian(0.8));
    let ways = |kernel, gradient| [points(kernel, 1, gradient), points(kernel, 2, gradient), cast(kernel, gradient)];
    for settings in [ways(Kernel::Linear, sobel), ways(Kernel::Linear, gaussian), ways(Kernel::BSpline, sobel)].concat() {
        let settings = Settings { blend: Blend::Iso(ISO), ..settings };
        let what = format!("{settings:?}");
        Pair::of(&volume, &smooth_transfer(), &camera, viewport(25, 22), &settings)
            .assert_same(&what, crate::common::blends::tolerance(&settings, true));
    }
}

/// A plane of bytes, seen by ray casting with a directional light: the mean light is that of its normal, whatever the estimator, and with
/// Sobel it varies less.
#[test]
fn planes_of_bytes_are_lit_by_their_normal() {
    let normal = DVec3::new(0.31, 0.22, 0.92).normalize();
    let dims = [40, 40, 40];
    let value = |p: DVec3| ((normal.dot(p - 19.5) + 0.5) * 255.0).round().clamp(0.0, 255.0) as u8;
    let place = |n: usize| DVec3::new((n % 40) as f64, (n / 40 % 40) as f64, (n / 1600) as f64);
    let volume = volume(dims, DVec3::ONE, Voxels::Uint8((0..64_000).map(|n| value(place(n))).collect()));
    let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, lights: one_light(DVec3::Z), ..Shading::default() };
    let size = viewport(60, 60);
    // From the side of low values, so that the surface is met first.
    let camera = scaled(parallel(&volume, size, 180.0, 0.0), 6.0);
    let light = |gradient| {
        let settings = Settings { shading: Some(shading), blend: Blend::Iso(127.5), ..points(Kernel::Linear, 1, gradient) };
        let white = step_transfer(127.5, 0.99);
        let frame = render(&volume, &white, &camera, size, &settings);
        let lit: Vec<f64> = frame.pixels().iter().map(|p| f64::from(p[0])).collect();
        let mean = lit.iter().sum::<f64>() / lit.len() as f64;
        let deviation = (lit.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / lit.len() as f64).sqrt();
        (mean, deviation)
    };
    let [central, sobel] = [GradientEstimator::Central, GradientEstimator::Sobel].map(light);
    let scale = step_color();
    assert!((sobel.0 / scale - normal.z).abs() < ROUNDED_BYTES, "{sobel:?}, {}", normal.z);
    assert!(sobel.1 < 0.5 * central.1, "{sobel:?}, {central:?}");
}

/// Red of the transfer function of a step.
fn step_color() -> f64 {
    step_transfer(127.5, 0.99).color(200.0)[0]
}

#[test]
fn estimators_that_do_not_fit_are_refused() {
    let refused = |settings: Settings| {
        let (volume, [camera, _]) = scene();
        let mut renderer = layersplat::Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
        match renderer.render(&camera, viewport(25, 22), &settings) {
            Err(Error::Settings { field: "gradient", problem }) => problem,
            other => panic!("{settings:?}: {other:?}"),
        }
    };
    let own = refused(points(Kernel::Linear, 1, GradientEstimator::Own));
    assert!(own.contains("central, sobel or gaussian:SIGMA"), "{own}");
    for sigma in [0.29, 2.01, f64::NAN, f64::INFINITY, -1.0] {
        let problem = refused(points(Kernel::Linear, 1, GradientEstimator::Gaussian(sigma)));
        assert!(problem.contains("0.3 to 2"), "{problem}");
    }
    assert!(refused(cast(Kernel::Gaussian, GradientEstimator::Gaussian(1.0))).contains("central"));
    assert!(refused(cast(Kernel::Gaussian, GradientEstimator::Sobel)).contains("central"));
    let splatted = Settings { gradient: Some(GradientEstimator::Own), ..Quality::Paper.settings() };
    assert!(refused(splatted).contains("central, sobel or gaussian:SIGMA"));
    let slices = Settings { gradient: Some(GradientEstimator::Sobel), ..Algorithm::Slicing { step: 1.0 }.into() };
    assert!(refused(slices).contains("central"));
}

/// By default, pre-integrated layers have Sobel gradients, splats central differences, and rays the gradients that fit their kernel.
#[test]
fn defaults() {
    let (volume, [camera, _]) = scene();
    let draw = |settings: &Settings| render(&volume, &smooth_transfer(), &camera, viewport(25, 22), settings);
    let layers = Kernel::OF_LAYERS.map(|kernel| points(kernel, 1, GradientEstimator::Sobel));
    let rays = Kernel::OF_LAYERS.map(|kernel| cast(kernel, GradientEstimator::for_kernel(kernel)));
    for given in layers.into_iter().chain(rays).chain([splats(SPLATTED, GradientEstimator::Central)]) {
        let default = Settings { gradient: None, ..given };
        assert_eq!(default.gradient_estimator(), given.gradient_estimator(), "{given:?}");
        assert!(draw(&given) == draw(&default), "{given:?}");
        let another = Settings { gradient: Some(GradientEstimator::Gaussian(1.0)), ..given };
        assert!(draw(&given) != draw(&another), "{given:?}");
    }
}
