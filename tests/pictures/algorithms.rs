//! The paper's comparison algorithms: Beer–Lambert, the f64 reference, and the integral of their own kernel.

use crate::common::reference::{Pair, RIM_SHARE, differing};
use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::reference::Integral;
use layersplat::settings::{Algorithm, LayerAxis};
use layersplat::transfer::Extinction;
use layersplat::volume::Voxels;
use layersplat::{Camera, Orbit, Settings, TransferFunction, Viewport, Volume};

/// Tens of samples add up the errors of the nearest of 4096 table entries; slab weights are interpolated between 257. An 8-bit step is
/// 4e-3.
const DEVICE_TOLERANCE: f64 = 2e-3;
/// Slicing looks up the nearest of 256 front and back values: half an entry each, over a range of 200 values.
const SLICING_TOLERANCE: f64 = 6e-3;

fn tolerance(algorithm: Algorithm) -> f64 {
    if matches!(algorithm, Algorithm::Slicing { .. }) { SLICING_TOLERANCE } else { DEVICE_TOLERANCE }
}

#[track_caller]
fn assert_is_reference(volume: &Volume, transfer: &TransferFunction, camera: &Camera, size: Viewport, settings: &Settings) {
    let what = format!("{:?} {:?} {:?}", volume.grid().dims(), settings.algorithm, camera);
    let pair = Pair::of(volume, transfer, camera, size, settings);
    assert!(pair.expected.iter().any(|pixel| pixel[3] > 0.02), "{what}: nothing to see");
    let tolerance = tolerance(settings.algorithm);
    pair.assert_allowed(&what, tolerance);
    let between = |n: usize| std::array::from_fn(|c| (pair.found[n.saturating_sub(1)][c] + pair.found[n][c]) / 2.0);
    let shifted: Vec<[f64; 4]> = (0..pair.found.len()).map(between).collect();
    assert!(differing(&shifted, &pair.expected, tolerance) > RIM_SHARE, "{what}: half a pixel must be noticed");
}

const SHAPES: [[usize; 3]; 5] = [[1, 1, 1], [1, 7, 4], [6, 1, 5], [17, 21, 5], [11, 8, 13]];
const VIEWS: [(f64, f64); 8] =
    [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (45.0, 0.0), (0.0, 45.0), (30.0, 20.0), (200.0, -35.0), (72.0, 64.0)];

fn unlimited(algorithm: Algorithm) -> Settings {
    Settings { algorithm, early_termination: false, ..Settings::default() }
}

#[test]
fn parallel_views() {
    for (seed, dims) in SHAPES.into_iter().enumerate() {
        let volume = random_volume(dims, DVec3::new(1.0, 0.7, 1.3), seed as u64);
        for (n, (azimuth, elevation)) in VIEWS.into_iter().enumerate() {
            let size = viewport(37, 26);
            let orbit = Orbit { azimuth, elevation, roll: 10.0 * n as f64 };
            let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), size, orbit);
            for algorithm in OTHERS {
                let settings = unlimited(algorithm);
                let settings = if n % 2 == 0 { settings } else { Settings { shading: None, ..settings } };
                assert_is_reference(&volume, &smooth_transfer(), &camera, size, &settings);
            }
        }
    }
}

#[test]
fn perspectives() {
    let volume = random_volume([12, 15, 9], DVec3::new(1.0, 1.4, 0.8), 3);
    let size = viewport(40, 33);
    for (azimuth, elevation, field_of_view) in [(0.0, 0.0, 20.0), (35.0, 25.0, 40.0), (-110.0, -60.0, 70.0)] {
        let camera = perspective(&volume, azimuth, elevation, field_of_view);
        for algorithm in OTHERS {
            assert_is_reference(&volume, &smooth_transfer(), &camera, size, &unlimited(algorithm));
        }
    }
}

/// Wide perspectives of flat voxels, which oblique rays cross at all angles.
#[test]
fn wide_perspectives_of_flat_voxels() {
    let volume = random_volume([12, 11, 6], DVec3::new(1.0, 1.0, 4.0), 3);
    let size = viewport(40, 33);
    for (azimuth, field_of_view) in [(45.0, 60.0), (20.0, 100.0), (80.0, 140.0)] {
        let camera = perspective(&volume, azimuth, 20.0, field_of_view);
        for algorithm in OTHERS {
            assert_is_reference(&volume, &smooth_transfer(), &camera, size, &unlimited(algorithm));
        }
    }
}

/// A block of 255 in 0. The voxels around it have the value 0, but a gradient.
#[test]
fn rims_of_a_block() {
    let n = 16;
    let inside = |i: usize| [i % n, i / n % n, i / n / n].iter().all(|c| (5..11).contains(c));
    let bytes = (0..n * n * n).map(|i| if inside(i) { 255 } else { 0 }).collect();
    let volume = volume([n; 3], DVec3::ONE, Voxels::Uint8(bytes));
    let size = viewport(40, 40);
    for algorithm in OTHERS {
        let camera = parallel(&volume, size, 30.0, 20.0);
        assert_is_reference(&volume, &smooth_transfer(), &camera, size, &unlimited(algorithm));
    }
}

#[test]
fn from_inside() {
    let volume = random_volume([20, 20, 20], DVec3::ONE, 4);
    let size = viewport(32, 32);
    let camera = perspective(&volume, 30.0, 20.0, 60.0);
    let eye = camera.focal_point + (camera.position - camera.focal_point).normalize() * 4.3;
    for algorithm in OTHERS {
        assert_is_reference(&volume, &smooth_transfer(), &Camera { position: eye, ..camera }, size, &unlimited(algorithm));
    }
}

#[test]
fn voxel_types_edges_and_switches() {
    let dims = [11, 9, 10];
    let size = viewport(30, 30);
    let bytes = random_bytes(dims, 5);
    let volumes = [
        volume(dims, DVec3::ONE, Voxels::Int16(bytes.iter().map(|&b| 40 * i16::from(b) - 3000).collect())),
        volume(dims, DVec3::ONE, Voxels::Float32(bytes.iter().map(|&b| f32::from(b) * 0.01 + 1e3).collect())),
        volume(dims, DVec3::ONE, Voxels::Int8(bytes.iter().map(|&b| (i16::from(b) - 128) as i8).collect())),
    ];
    for volume in volumes {
        let (lo, hi) = volume.range();
        let transfer = smooth_transfer().stretched(lo, hi).unwrap();
        let camera = parallel(&volume, size, 25.0, 35.0);
        for algorithm in OTHERS {
            let linear = Settings { extinction: Extinction::Linear, unit_distance: Some(1.5), ..unlimited(algorithm) };
            assert_is_reference(&volume, &transfer, &camera, size, &linear);
        }
    }
    // The background is visible up to the edge of the support.
    let fog = TransferFunction::new("fog", vec![(0.0, [1.0, 0.5, 0.2])], vec![(0.0, 0.05), (255.0, 0.3)]).unwrap();
    let volume = random_volume(dims, DVec3::ONE, 6);
    let camera = parallel(&volume, size, 25.0, 35.0);
    for algorithm in OTHERS.into_iter().filter(|a| !matches!(a, Algorithm::AxisSheets { .. })) {
        let pair = Pair::of(&volume, &fog, &camera, size, &unlimited(algorithm));
        pair.assert_allowed(&format!("{algorithm:?} in fog"), tolerance(algorithm));
    }
}

#[test]
fn forced_layer_axes() {
    let volume = random_volume([12, 10, 11], DVec3::ONE, 8);
    let size = viewport(30, 30);
    let camera = parallel(&volume, size, 45.0, 0.0);
    let pictures = [layersplat::layers::Axis::X, layersplat::layers::Axis::Z].map(|axis| {
        let settings = unlimited(Algorithm::AxisSheets { layer_axis: LayerAxis::Forced(axis) });
        assert_is_reference(&volume, &smooth_transfer(), &camera, size, &settings);
        render(&volume, &smooth_transfer(), &camera, size, &settings)
    });
    assert_ne!(pictures[0], pictures[1]);
}

/// A homogeneous cube: exact along rays, and up to the ripple of a Gaussian's lattice sum with sheets.
#[test]
fn beer_lambert() {
    /// The ripple is ±4.4 % in three dimensions; the requirement is 5 %.
    const RIPPLE: f64 = 0.05;
    /// Rounding over 40 samples; half a step where a side face is crossed.
    const FLOATS: f64 = 1e-4;
    let (dims, alpha) = ([16, 16, 16], 0.05);
    let tau = -(1.0f64 - alpha).ln();
    for spacing in [DVec3::ONE, DVec3::new(1.0, 1.0, 1.7)] {
        let volume = volume(dims, spacing, Voxels::Uint8(vec![200; 16 * 16 * 16])).with_background(0.0).unwrap();
        // Extinction proportional to the value makes depths line integrals of the field, and that of the cube is its length.
        let ramp = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], ramp(tau)).unwrap();
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (8.0, 5.0)] {
            let camera = scaled(parallel(&volume, viewport(9, 9), azimuth, elevation), 1.5);
            let rays = layersplat::layers::Rays::new(&camera, viewport(9, 9), volume.grid()).unwrap();
            let direction = rays.central_direction();
            let length = 16.0 * (direction * spacing / direction.abs().max_element()).length();
            for algorithm in OTHERS {
                let settings = Settings { shading: None, ..unlimited(algorithm) };
                let frame = render(&volume, &ramp, &camera, viewport(9, 9), &settings);
                let limit = match algorithm {
                    Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. } => RIPPLE,
                    Algorithm::Raycast { kernel: Kernel::Gaussian, .. } => RIPPLE,
                    _ => 0.02,
                };
                for p in frame.pixels() {
                    let depth = -(1.0 - f64::from(p[3])).ln() / (tau * length);
                    assert!((depth - 1.0).abs() < limit + FLOATS, "{algorithm:?} {azimuth} {elevation}: {depth}");
                }
                let doubled = Settings { unit_distance: Some(0.5), ..settings };
                let p = render(&volume, &ramp, &camera, viewport(9, 9), &doubled).pixel(4, 4);
                let depth = -(1.0 - f64::from(p[3])).ln() / (tau * length);
                assert!((depth - 2.0).abs() < 2.0 * limit + FLOATS, "a wrong distance must be noticed: {depth}");
            }
        }
    }
}

/// Control points whose extinction is proportional to the value and `tau` at 200.
fn ramp(tau: f64) -> Vec<(f64, f64)> {
    (0..=255).map(|v| (f64::from(v), -(-tau * f64::from(v) / 200.0).exp_m1())).collect()
}

/// Each algorithm converges to the integral of its own kernel with smaller steps, and not to that of another kernel.
#[test]
fn convergence_to_the_own_integral() {
    /// Gain per halved step, in dB.
    const GAIN: f64 = 3.0;
    let volume = Volume::open("builtin:hydrogen@24", &layersplat::OpenOptions::default()).unwrap();
    let transfer = smooth_transfer();
    let size = viewport(64, 64);
    let camera = parallel(&volume, size, 35.0, 20.0);
    let truth = |kernel| Integral::new(&volume, &transfer, None).with_kernel(kernel).render(&camera, size).unwrap();
    let kernels = [Kernel::Linear, Kernel::Cubic, Kernel::Gaussian];
    let truths = kernels.map(truth);
    let mut cases: Vec<(usize, Vec<Algorithm>, f64)> = vec![
        (2, [1.0, 0.5, 0.25].map(|sheet_distance| Algorithm::ViewSheets { sheet_distance }).to_vec(), 60.0),
        (0, [1.0, 0.5, 0.25].map(|step| Algorithm::Slicing { step }).to_vec(), 50.0),
    ];
    for (n, kernel) in kernels.into_iter().enumerate() {
        cases.push((n, [1.0, 0.5, 0.0625].map(|step| Algorithm::Raycast { kernel, step }).to_vec(), 60.0));
    }
    for (kernel, steps, least) in cases {
        let psnr = |algorithm: &Algorithm, kernel: usize| {
            let settings = Settings { shading: None, ..unlimited(*algorithm) };
            compare(&render(&volume, &transfer, &camera, size, &settings), &truths[kernel]).psnr_rgba.unwrap()
        };
        let found: Vec<f64> = steps.iter().map(|a| psnr(a, kernel)).collect();
        assert!(found.windows(2).all(|w| w[1] > w[0] + GAIN), "{steps:?}: {found:?} dB");
        assert!(found[2] > least, "{steps:?}: {found:?} dB");
        let foreign = psnr(&steps[2], (kernel + 1) % 3);
        assert!(foreign < found[2] - 6.0, "{steps:?}: another kernel's integral must be distinguished, {foreign} dB");
    }
}
