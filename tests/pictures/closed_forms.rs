//! Closed forms on the device: Beer–Lambert, exact line integrals, ray termination.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Correction, Density, Rays};
use layersplat::reference::Integral;
use layersplat::settings::{Classification, Evaluation, Layered};
use layersplat::transfer::Extinction;
use layersplat::volume::Voxels;
use layersplat::{Camera, Renderer, Settings, TransferFunction, Viewport, Volume};

/// Opacities are stored and multiplied in f32, over up to 40 layers.
const FLOAT_TOLERANCE: f64 = 2e-5;
/// Error bound of the midpoint rule at 1/16 voxel, and of the piecewise-linear approximation of 1 − e^{−cρ}.
const INTEGRAL_TOLERANCE: f64 = 5e-4;
/// Quadrature of the perspective lattice: 0.25 % of the values, in an exponent of about 1.
const QUADRATURE_TOLERANCE: f64 = 3e-3;

/// Transmittance at the centre of the picture.
fn middle(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) -> f64 {
    let frame = render(volume, transfer, camera, viewport(33, 33), settings);
    1.0 - f64::from(frame.pixel(16, 16)[3])
}

#[test]
fn beer_lambert_through_both_faces_of_the_layer_axis() {
    let mut cases = 0;
    for dims in [[12, 12, 12], [20, 16, 9]] {
        for spacing in [DVec3::ONE, DVec3::new(1.0, 2.0, 0.5), DVec3::new(0.3, 0.3, 0.9)] {
            let volume = cube(dims, spacing);
            for unit in [1.0, 0.4, 3.0] {
                for (azimuth, elevation) in
                    [(0.0, 0.0), (180.0, 0.0), (90.0, 0.0), (-90.0, 0.0), (0.0, 90.0), (12.0, 7.0), (100.0, -8.0), (5.0, 80.0)]
                {
                    let corrections = [Correction::None, Correction::Constant, Correction::SubLayers(5)];
                    for classification in corrections.map(Classification::Post).into_iter().chain(CLASSIFICATIONS) {
                        let camera = scaled(parallel(&volume, viewport(33, 33), azimuth, elevation), 1.0);
                        let rays = Rays::new(&camera, viewport(33, 33), volume.grid()).unwrap();
                        let axis = Axis::most_parallel(rays.central_direction());
                        let frame = axis.frame();
                        let [su, sv] = frame.shear(rays.central_direction());
                        let n = frame.local(DVec3::from_array(dims.map(|n| n as f64)));
                        // The central ray must stay |s| inside the side faces over all n layers.
                        if su.abs() * (n.z + 2.0) / 2.0 + su.abs() + 0.5 > n.x / 2.0
                            || sv.abs() * (n.z + 2.0) / 2.0 + sv.abs() + 0.5 > n.y / 2.0
                        {
                            continue;
                        }
                        cases += 1;
                        let step = (DVec3::new(su, sv, 1.0) * frame.local(spacing)).length() / unit;
                        let tau = -(1.0f64 - 0.05).ln();
                        let expected = (-tau * n.z * step).exp();
                        for evaluation in [Evaluation::Lattice(Density::Fixed(2)), Evaluation::Direct] {
                            let settings = Settings {
                                algorithm: Layered { classification, evaluation, ..layered(unshaded()) }.into(),
                                unit_distance: Some(unit),
                                ..unshaded()
                            };
                            let found = middle(&volume, &step_transfer(100.0, 0.05), &camera, &settings);
                            assert!(
                                (found - expected).abs() < FLOAT_TOLERANCE,
                                "{dims:?} {spacing} {azimuth} {classification:?}: {found} for {expected}"
                            );
                        }
                    }
                }
            }
        }
    }
    assert!(cases > 200, "{cases} cases");
}

/// Weights sum to 1 within 1e-6, so values are accurate to 2e-4. Over ten layers, that changes the opacity by a thousandth.
const WEIGHTS_TOLERANCE: f64 = 1e-3;

/// A constant field keeps its value to six digits, regardless of the layers it is combined from: a function that rises from 199.9 to 200.1
/// reveals the fourth digit of κ.
#[test]
fn layers_are_mixed_by_weights_that_sum_up_to_one() {
    let n = 12;
    let mut values = vec![200; n * n * n];
    // Tables end at the largest value and start at the smallest: place both in corners, far from the central rays.
    values[0] = 255;
    values[n * n * n - 1] = 0;
    let volume = volume([n; 3], DVec3::ONE, Voxels::Uint8(values)).with_background(0.0).unwrap();
    let steep = vec![(199.9, 0.0), (200.1, 0.1), (255.0, 0.1)];
    let steep = TransferFunction::new("steep", vec![(0.0, [1.0; 3])], steep).unwrap();
    for (azimuth, elevation) in [(0.0, 0.0), (-90.0, 0.0), (0.0, 90.0)] {
        let camera = scaled(parallel(&volume, viewport(33, 33), azimuth, elevation), 1.0);
        // Number of slabs without influence of the background, in layers.
        for (correction, layers) in [(Correction::Constant, 10.0), (Correction::SubLayers(2), 11.0)] {
            for evaluation in [Evaluation::Lattice(Density::Fixed(2)), Evaluation::Direct] {
                let classification = Classification::Post(correction);
                let layered = Layered { classification, evaluation, ..layered(unshaded()) };
                let found = middle(&volume, &steep, &camera, &Settings { algorithm: layered.into(), ..unshaded() });
                let expected = (1.0f64 - 0.05).powf(layers);
                let what = format!("{azimuth}, {elevation}, {layered:?}");
                assert!((found - expected).abs() < WEIGHTS_TOLERANCE, "{what}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn beer_lambert_in_perspective() {
    let volume = cube([24, 24, 12], DVec3::new(1.0, 1.0, 1.5));
    let camera = perspective(&volume, 0.0, 0.0, 20.0);
    let evaluations = [Evaluation::Lattice(Density::AtLeast(2)), Evaluation::Direct];
    for (classification, evaluation) in CLASSIFICATIONS.into_iter().flat_map(|c| evaluations.map(|e| (c, e))) {
        let settings = Settings { algorithm: Layered { classification, evaluation, ..layered(unshaded()) }.into(), ..unshaded() };
        let frame = render(&volume, &step_transfer(100.0, 0.05), &camera, viewport(65, 65), &settings);
        for (x, y) in [(32, 32), (36, 32), (32, 27), (37, 36)] {
            let rays = Rays::new(&camera, viewport(65, 65), volume.grid()).unwrap();
            let direction = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5).direction;
            let [su, sv] = Axis::Z.frame().shear(direction);
            let expected = (-(-(1.0f64 - 0.05).ln()) * 12.0 * DVec3::new(su, sv, 1.5).length()).exp();
            let found = 1.0 - f64::from(frame.pixel(x, y)[3]);
            // The warp interpolates between rays of slightly different lengths.
            assert!((found - expected).abs() < 5.0 * FLOAT_TOLERANCE, "{evaluation:?} at {x}, {y}: {found} for {expected}");
        }
    }
}

/// Weights of Gaussian splats do not sum to exactly 1.
const GAUSSIAN_SUM_TOLERANCE: f64 = 0.05;

/// α·Δt of 1.2 to 2.4 per sample is clamped to 1.
#[test]
fn linear_extinction_takes_no_more_light_than_there_is() {
    let volume = cube([12; 3], DVec3::ONE);
    for settings in evaluations() {
        let settings = Settings { extinction: Extinction::Linear, unit_distance: Some(0.25), shading: None, ..settings };
        for (azimuth, elevation) in [(0.0, 0.0), (30.0, 20.0)] {
            let camera = parallel(&volume, viewport(33, 33), azimuth, elevation);
            let frame = render(&volume, &step_transfer(100.0, 0.6), &camera, viewport(33, 33), &settings);
            let what = format!("{:?} at {azimuth}, {elevation}", settings.algorithm);
            let tolerance = if settings.algorithm.name() == "axis-sheets" { GAUSSIAN_SUM_TOLERANCE } else { FLOAT_TOLERANCE };
            for channel in frame.pixel(16, 16) {
                assert!((f64::from(channel) - 1.0).abs() <= tolerance, "{what}: {channel} instead of 1 in the centre");
            }
            let most = f64::from(largest_opacity(&frame));
            assert!(most <= 1.0 + tolerance, "{what}: {most}");
        }
    }
}

/// Fraction of light absorbed per layer.
const THIN: f64 = 0.03;

/// Rays end at the first sample that leaves less than 1/4096, a documented limit, and not before.
#[test]
fn early_termination_is_at_one_4096th() {
    let limit = 1.0 / 4096.0;
    let volume = cube([8, 8, 300], DVec3::ONE);
    let camera = scaled(parallel(&volume, viewport(33, 33), 0.0, 0.0), 1.0);
    for settings in evaluations() {
        let [left, all] = [true, false].map(|early_termination| {
            let settings = Settings { early_termination, shading: None, ..settings };
            middle(&volume, &step_transfer(100.0, THIN), &camera, &settings)
        });
        let what = format!("{:?}", settings.algorithm);
        assert!(all < 0.6 * limit, "{what}: {all} is left without early termination");
        assert!(left <= limit && left > (1.0 - 2.0 * THIN) * limit, "{what}: {left} is left, of {limit}");
    }
}

#[test]
fn an_eye_inside_sees_what_is_before_it() {
    // Homogeneous fog, seen from inside. The optical depth of a ray is its length in the support, to within a layer at the side faces,
    // and changes continuously with the eye position.
    let volume = cube([32, 32, 32], DVec3::ONE);
    let size = viewport(24, 24);
    let transfer = TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(0.0, 0.03)]).unwrap();
    let tau = -(1.0f64 - 0.03).ln();
    for distance in [0.3, 0.45, 0.6, 0.9, 5.0] {
        for classification in CLASSIFICATIONS {
            let camera = perspective(&volume, 20.0, 10.0, 90.0);
            let eye = camera.focal_point + (camera.position - camera.focal_point).normalize() * distance;
            let camera = Camera { position: eye, ..camera };
            let frame = render(
                &volume,
                &transfer,
                &camera,
                size,
                &Settings { algorithm: Layered { classification, ..layered(unshaded()) }.into(), ..unshaded() },
            );
            let truth = Integral::new(&volume, &transfer, None).render(&camera, size).unwrap();
            for (found, expected) in frame.pixels().iter().zip(truth.pixels()) {
                let [found, expected] = [found, expected].map(|p| -(1.0 - f64::from(p[3])).ln() / tau);
                assert!((found - expected).abs() < 0.9, "{distance}, {classification:?}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn a_step_at_the_first_point_hides_what_is_below() {
    let mut values = vec![50; 16 * 16 * 16];
    values[8 * 256 + 8 * 16 + 8] = 150;
    let volume = volume([16; 3], DVec3::ONE, Voxels::Uint8(values));
    let opacities = vec![(100.0, 0.0), (100.0, 1.0), (200.0, 1.0)];
    let transfer = TransferFunction::new("step", vec![(100.0, [1.0; 3])], opacities).unwrap();
    let camera = parallel(&volume, viewport(64, 64), 10.0, 5.0);
    for classification in CLASSIFICATIONS {
        let settings = Settings { algorithm: Layered { classification, ..Layered::default() }.into(), ..Settings::default() };
        let frame = render(&volume, &transfer, &camera, viewport(64, 64), &settings);
        let opaque = frame.pixels().iter().filter(|p| p[3] > 0.5).count();
        assert!((1..60).contains(&opaque), "{classification:?}: {opaque} opaque pixels for one voxel");
    }
}

#[test]
fn rays_through_side_faces_are_right_to_one_layer() {
    let volume = cube([10, 10, 16], DVec3::ONE);
    let size = viewport(48, 48);
    let camera = parallel(&volume, size, 35.0, 15.0);
    let settings = Settings {
        algorithm: Layered { classification: SPLATTED, evaluation: Evaluation::Direct, ..layered(unshaded()) }.into(),
        ..unshaded()
    };
    let frame = render(&volume, &step_transfer(100.0, 0.05), &camera, size, &settings);
    let rays = Rays::new(&camera, size, volume.grid()).unwrap();
    let tau = -(1.0f64 - 0.05).ln();
    let mut seen = 0;
    for y in 0..48 {
        for x in 0..48 {
            let ray = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
            // Chord of the half-value box, [−½, n−½].
            let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
            for (i, n) in [10.0, 10.0, 16.0].into_iter().enumerate() {
                let (a, b) = ((-0.5 - ray.origin[i]) / ray.direction[i], (n - 0.5 - ray.origin[i]) / ray.direction[i]);
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            }
            let chord = (leave - enter).max(0.0) * ray.direction.length();
            let step = ray.direction.length() / ray.direction.z.abs();
            let found = -(1.0 - f64::from(frame.pixel(x, y)[3])).ln() / tau;
            // One layer, and another at edges and corners, which round two faces at once.
            assert!((found - chord).abs() <= 2.0 * step, "{x}, {y}: {found} for {chord}");
            seen += usize::from(chord > 5.0);
        }
    }
    assert!(seen > 200);
}

/// Largest difference in opacity between the lattice or pixels and the exact line integral, over all rays.
fn line_integral_difference(volume: &Volume, camera: &Camera, size: Viewport, settings: &Settings) -> f64 {
    let transfer = linear_extinction(4e-4);
    let integral = Integral::new(volume, &transfer, settings.unit_distance);
    let mut renderer = Renderer::new(&device(), volume, &transfer).unwrap();
    let mut largest: f64 = 0.0;
    if let Some(picture) = renderer.lattice_picture(camera, size, settings).unwrap() {
        for (i, sample) in picture.samples.iter().enumerate() {
            let ray = picture.ray(i as u32 % picture.size[0], i as u32 / picture.size[0]);
            largest = largest.max((f64::from(sample[3]) - integral.composite(&ray, DVec3::Z)[3]).abs());
        }
    } else {
        let (frame, _) = renderer.render(camera, size, settings).unwrap();
        largest = compare(&frame, &integral.render(camera, size).unwrap()).max_difference;
    }
    largest
}

#[test]
fn every_ray_is_the_line_integral_where_extinction_is_linear_in_the_value() {
    let size = viewport(24, 24);
    for volume in [random_volume([9, 13, 11], DVec3::new(1.0, 0.6, 1.4), 3), cube([8, 8, 8], DVec3::ONE)] {
        for (azimuth, elevation) in [(0.0, 0.0), (45.0, 0.0), (30.0, 20.0), (100.0, -40.0), (0.0, 80.0)] {
            for correction in [Correction::None, Correction::Constant, Correction::SubLayers(2), Correction::SubLayers(4)] {
                for evaluation in [Evaluation::Lattice(Density::Fixed(1)), Evaluation::Direct] {
                    let settings = Settings {
                        algorithm: Layered {
                            classification: Classification::Post(correction),
                            evaluation,
                            ..layered(unshaded())
                        }
                        .into(),
                        ..unshaded()
                    };
                    let camera = parallel(&volume, size, azimuth, elevation);
                    let difference = line_integral_difference(&volume, &camera, size, &settings);
                    assert!(
                        difference < INTEGRAL_TOLERANCE,
                        "{azimuth}, {elevation}, {correction:?}, {evaluation:?}: {difference}"
                    );
                }
            }
        }
        let camera = perspective(&volume, 20.0, 10.0, 30.0);
        let lattice = Settings { algorithm: Layered { classification: SPLATTED, ..layered(unshaded()) }.into(), ..unshaded() };
        let direct = Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(lattice) }.into(), ..lattice };
        assert!(line_integral_difference(&volume, &camera, size, &direct) < INTEGRAL_TOLERANCE);
        assert!(line_integral_difference(&volume, &camera, size, &lattice) < QUADRATURE_TOLERANCE);
        // Between point-sampled layers, values are interpolated linearly. Along the layer axis, their mean is that of the field.
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (0.0, -90.0)] {
            for evaluation in [Evaluation::Lattice(Density::Fixed(2)), Evaluation::Direct] {
                let settings = Settings {
                    algorithm: Layered { classification: POINTS, evaluation, ..layered(unshaded()) }.into(),
                    ..unshaded()
                };
                let difference = line_integral_difference(&volume, &parallel(&volume, size, azimuth, elevation), size, &settings);
                assert!(difference < INTEGRAL_TOLERANCE, "points, {azimuth}, {elevation}, {evaluation:?}: {difference}");
            }
        }
    }
    let volume = cube([8, 8, 8], DVec3::ONE);
    let wrong = Settings { unit_distance: Some(1.05), ..unshaded() };
    let transfer = linear_extinction(4e-4);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let found = render(
        &volume,
        &transfer,
        &camera,
        size,
        &Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(wrong) }.into(), ..wrong },
    );
    let expected = Integral::new(&volume, &transfer, None).render(&camera, size).unwrap();
    assert!(compare(&found, &expected).max_difference > 2.0 * INTEGRAL_TOLERANCE, "a wrong unit distance must be noticed");
}

#[test]
fn a_function_is_the_same_wherever_its_points_end() {
    // A narrow opacity peak, with and without outer control points: a segment across it must not count as all peak.
    let volume = random_volume([24, 20, 22], DVec3::ONE, 6);
    let size = viewport(64, 64);
    let camera = parallel(&volume, size, 20.0, 30.0);
    let band = |points: &[(f64, f64)]| TransferFunction::new("band", vec![(0.0, [1.0, 0.7, 0.4])], points.to_vec()).unwrap();
    let short = band(&[(100.0, 0.02), (105.0, 0.9), (110.0, 0.04)]);
    let long = band(&[(-10.0, 0.02), (100.0, 0.02), (105.0, 0.9), (110.0, 0.04), (300.0, 0.04)]);
    let moved = band(&[(110.0, 0.02), (115.0, 0.9), (120.0, 0.04)]);
    for classification in CLASSIFICATIONS {
        for evaluation in [Evaluation::Lattice(Density::Fixed(2)), Evaluation::Direct] {
            let settings =
                Settings { algorithm: Layered { classification, evaluation, ..layered(unshaded()) }.into(), ..unshaded() };
            let [a, b] = [&short, &long].map(|t| render(&volume, t, &camera, size, &settings));
            let psnr = compare(&a, &b).psnr_rgba.unwrap_or(f64::INFINITY);
            assert!(psnr > 45.0, "{classification:?}, {evaluation:?}: {psnr} dB");
            assert!(largest_opacity(&a) > 0.1, "the picture is empty");
            let other = render(&volume, &moved, &camera, size, &settings);
            assert!(compare(&a, &other).psnr_rgba.is_some_and(|p| p < 40.0), "a moved band must be noticed");
        }
    }
}
