//! The device against the f64 reference, for all kernels except the paper's cubic, which other tests cover.

use crate::common::blends::*;
use crate::common::reference::{Pair, RIM_SHARE};
use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Density, Kernel};
use layersplat::settings::{Algorithm, Blend, Classification, Clipping, Evaluation, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, GradientEstimator, Orbit, Projection, Quality, Settings, TransferFunction, Volume};

const KERNELS: [Kernel; 3] = [Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline];
/// Kernels of radius two.
const SMOOTH: [Kernel; 2] = [Kernel::CatmullRom, Kernel::BSpline];
/// Where the background shows, it is lit by what the smooth kernels leave of the surface there: gradients so weak that the light fades in with
/// them, a thousand times as steeply. Measured on PoCL: 3.1e-3.
const FOG_TOLERANCE: f64 = 5e-3;
const LATTICE: Evaluation = Evaluation::Lattice(Density::Fixed(2));

fn points(kernel: Kernel, evaluation: Evaluation, samples_per_layer: u32) -> Algorithm {
    let classification = Classification::Preintegrated { kernel, samples_per_layer };
    Layered { classification, evaluation, ..Layered::default() }.into()
}

fn cast(kernel: Kernel) -> Algorithm {
    Algorithm::Raycast { kernel, step: 0.6 }
}

/// On a lattice and per pixel, with one and two samples per layer, and ray casting.
fn each_way(kernel: Kernel) -> [Algorithm; 5] {
    let direct = Evaluation::Direct;
    [points(kernel, LATTICE, 1), points(kernel, LATTICE, 2), points(kernel, direct, 1), points(kernel, direct, 2), cast(kernel)]
}

fn composited_whole(algorithm: Algorithm) -> Settings {
    composited(algorithm, Clipping::default())
}

/// Asserts that device and reference agree; the visible part may be small.
#[track_caller]
fn assert_alike(what: &str, volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) {
    let pair = Pair::of(volume, transfer, camera, viewport(24, 20), settings);
    let seen = pair.expected.iter().map(|p| p[3]).fold(0.0, f64::max);
    assert!(seen > 0.02, "{what}, {settings:?}: the picture is empty");
    let is_fog = transfer.opacity(volume.background()) > 0.0;
    let tolerance = if is_fog { FOG_TOLERANCE } else { tolerance(settings, true) };
    pair.assert_allowed(&format!("{what}, {settings:?}"), tolerance);
}

#[test]
fn composited_lit_and_unlit_in_both_projections() {
    let volume = random_volume([17, 12, 14], DVec3::new(1.0, 0.8, 1.25), 31);
    let size = viewport(24, 20);
    for kernel in KERNELS {
        for (n, algorithm) in each_way(kernel).into_iter().enumerate() {
            let lit = composited_whole(algorithm);
            let mut both = [lit, Settings { shading: None, ..lit }];
            both.rotate_left(n % 2);
            let cameras = [parallel(&volume, size, 30.0, 20.0), perspective(&volume, 30.0, 20.0, 30.0)];
            for (camera, settings) in cameras.iter().zip(both) {
                let pair = Pair::of(&volume, &smooth_transfer(), camera, size, &settings);
                pair.assert_same(&format!("{settings:?}"), DEVICE_TOLERANCE);
            }
        }
    }
}

/// For each kernel: one sample per layer on a lattice, two per pixel, and ray casting.
fn three_ways<const N: usize>(kernels: [Kernel; N]) -> impl Iterator<Item = Algorithm> {
    kernels.into_iter().flat_map(|k| [points(k, LATTICE, 1), points(k, Evaluation::Direct, 2), cast(k)])
}

/// Rays along the other two axes; a visible background throughout the support; clipping.
#[test]
fn every_layer_axis_visible_backgrounds_and_clipping() {
    let volume = bump();
    let fog = TransferFunction::new("fog", vec![(0.0, [1.0, 0.5, 0.2])], vec![(-40.0, 0.1), (255.0, 0.4)]).unwrap();
    let size = viewport(24, 20);
    for algorithm in three_ways(SMOOTH) {
        for (azimuth, elevation) in [(80.0, 10.0), (20.0, 75.0), (190.0, -10.0)] {
            let camera = parallel(&volume, size, azimuth, elevation);
            let what = format!("{azimuth}, {elevation}");
            assert_alike(&what, &volume, &smooth_transfer(), &camera, &composited_whole(algorithm));
            assert_alike(&what, &volume, &smooth_transfer(), &camera, &composited(algorithm, cuts()));
            assert_alike(&what, &volume, &fog, &camera, &composited_whole(algorithm));
        }
    }
}

/// Only values above or below all voxels are visible, in separate colours: control points outside the range of the data must be looked up.
#[test]
fn control_points_beyond_the_data() {
    let block = |n: usize| if [n % 13, n / 13 % 12, n / 156].iter().all(|c| (3..8).contains(c)) { 200 } else { 20 };
    let volume = volume([13, 12, 11], DVec3::new(1.0, 0.8, 1.25), Voxels::Uint8((0..13 * 12 * 11).map(block).collect()));
    let volume = volume.with_background(20.0).unwrap();
    let camera = parallel(&volume, viewport(24, 20), 30.0, 20.0);
    let show = |colors: [[f64; 3]; 2], opacities: [(f64, f64); 3]| {
        let [low, high] = colors;
        let colors = vec![(-10.0, low), (19.0, [0.0; 3]), (201.0, [0.0; 3]), (230.0, high)];
        TransferFunction::new("beyond", colors, opacities.to_vec()).unwrap()
    };
    let hues = [[0.9, 0.3, 0.2], [0.2, 0.5, 0.9]];
    let above = show(hues, [(200.0, 0.0), (201.0, 0.0), (230.0, 0.7)]);
    let below = show(hues, [(-10.0, 0.7), (19.0, 0.0), (20.0, 0.0)]);
    for transfer in [&above, &below] {
        for algorithm in three_ways(SMOOTH) {
            assert_alike("beyond", &volume, transfer, &camera, &composited_whole(algorithm));
        }
        // Kernels that do not overshoot show none of these values.
        let linear = render(&volume, transfer, &camera, viewport(24, 20), &composited_whole(points(Kernel::Linear, LATTICE, 1)));
        assert_eq!(largest_opacity(&linear), 0.0);
    }
}

/// Constant fields reconstruct exactly: all kernels, and coefficients, give the same result. An iso-surface at the constant has no speckles.
#[test]
fn constant_volumes() {
    let volume = volume([9, 8, 10], DVec3::ONE, Voxels::Float32(vec![0.1; 720])).with_background(0.1).unwrap();
    let transfer = TransferFunction::new("flat", vec![(0.0, [0.2, 0.5, 0.9])], vec![(0.0, 0.0), (0.2, 0.4)]).unwrap();
    let size = viewport(24, 20);
    let camera = parallel(&volume, size, 30.0, 20.0);
    for kernel in Kernel::OF_LAYERS {
        let pictures = [points(kernel, LATTICE, 1), points(kernel, Evaluation::Direct, 2)].map(|algorithm| {
            let beside = |iso: f64| render(&volume, &transfer, &camera, size, &settings(algorithm, Blend::Iso(iso)));
            assert!([0.1 - 1e-4, 0.1 + 1e-4].iter().all(|&iso| largest_opacity(&beside(iso)) == 0.0), "{kernel:?}: speckles");
            render(&volume, &transfer, &camera, size, &composited_whole(algorithm))
        });
        for picture in pictures {
            // Inside the rim, every ray has the same value: colours are of one hue, unlit.
            for pixel in picture.pixels() {
                let expected = [0.2, 0.5, 0.9].map(|c| c * pixel[3]);
                assert!((0..3).all(|c| (pixel[c] - expected[c]).abs() < 1e-5), "{kernel:?}: {pixel:?}");
            }
            assert!(largest_opacity(&picture) > 0.5, "{kernel:?}: the picture is empty");
        }
    }
}

/// Algorithms and blend modes combined with the smooth kernels, so that each pair occurs once: every combination takes seconds to compile.
fn gathering() -> Vec<(Algorithm, Blend)> {
    let (catmull_rom, bspline, direct) = (Kernel::CatmullRom, Kernel::BSpline, Evaluation::Direct);
    vec![
        (points(catmull_rom, LATTICE, 1), Blend::Minimum),
        (points(catmull_rom, direct, 2), Blend::Maximum),
        (cast(catmull_rom), Blend::Maximum),
        (points(bspline, LATTICE, 1), Blend::Maximum),
        (points(bspline, direct, 2), Blend::Minimum),
        (cast(bspline), Blend::Average),
    ]
}

/// The same for iso-surfaces, one of them refined.
fn surfaces() -> Vec<(Algorithm, Blend)> {
    let ways = [points(Kernel::BSpline, LATTICE, 1), points(Kernel::CatmullRom, Evaluation::Direct, 2), cast(Kernel::BSpline)];
    ways.map(|way| (way, Blend::Iso(ISO))).to_vec()
}

#[test]
fn every_blend() {
    let volume = bump();
    let size = viewport(24, 20);
    let views = [parallel(&volume, size, 30.0, 20.0), perspective(&volume, 30.0, 20.0, 30.0)];
    for (algorithm, blend) in gathering().into_iter().chain(surfaces()) {
        let whole = settings(algorithm, blend);
        for (n, camera) in views.iter().enumerate() {
            let pair = Pair::of(&volume, &smooth_transfer(), camera, size, &whole);
            pair.assert_same(&format!("{whole:?}"), tolerance(&whole, n == 0));
        }
        if blend.gathers_values() {
            assert_alike("cut", &volume, &smooth_transfer(), &views[0], &clipped(algorithm, blend, cuts()));
        }
    }
}

/// Axes of one, two and three voxels: multiple mirroring.
#[test]
fn tiny_volumes() {
    for (seed, dims) in [[1, 1, 1], [1, 7, 4], [6, 1, 5], [3, 2, 1], [2, 3, 3]].into_iter().enumerate() {
        let volume = random_volume(dims, DVec3::new(1.0, 0.7, 1.3), 60 + seed as u64);
        let camera = parallel(&volume, viewport(24, 20), 25.0, 15.0);
        let all = gathering().into_iter().map(|(algorithm, blend)| settings(algorithm, blend));
        let all = all.chain(three_ways(SMOOTH).map(composited_whole));
        for settings in all {
            assert_alike(&format!("{dims:?}"), &volume, &smooth_transfer(), &camera, &settings);
        }
    }
}

/// 16-bit integers and floats, some of them invalid: the background replaces these before filtering.
#[test]
fn voxels_of_two_bytes_and_of_floats() {
    let dims = [9, 10, 11];
    let bytes = random_bytes(dims, 10);
    let hounsfield = bytes.iter().map(|&b| (f64::from(b) * 15.7 - 1024.0).round() as i16);
    let reals = bytes.iter().enumerate().map(|(n, &b)| if n % 37 == 5 { f32::NAN } else { f32::from(b) * 1e-6 - 5e-5 });
    let cases = [(Voxels::Int16(hounsfield.collect()), (-1024.0, 2979.5)), (Voxels::Float32(reals.collect()), (-5e-5, 2.05e-4))];
    for (voxels, (lo, hi)) in cases {
        let volume = volume(dims, DVec3::ONE, voxels);
        let transfer = smooth_transfer().stretched(lo, hi).unwrap();
        let camera = parallel(&volume, viewport(24, 20), 10.0, 5.0);
        for algorithm in SMOOTH.map(|kernel| points(kernel, LATTICE, 1)).into_iter().chain([cast(Kernel::BSpline)]) {
            assert_alike(&volume.voxel_type().to_string(), &volume, &transfer, &camera, &composited_whole(algorithm));
        }
    }
}

/// Kernels are distinguishable: compared with any other kernel, all these comparisons fail.
#[test]
fn kernels_are_told_apart() {
    let volume = random_volume([17, 12, 14], DVec3::new(1.0, 0.8, 1.25), 31);
    let size = viewport(24, 20);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let differing = |kernel, other, way: fn(Kernel) -> Algorithm| {
        let [settings, expected] = [kernel, other].map(|kernel| composited_whole(way(kernel)));
        Pair::against(&volume, &smooth_transfer(), &camera, size, &settings, &expected).differing(DEVICE_TOLERANCE)
    };
    let kernels = Kernel::OF_LAYERS;
    for (way, others) in [(|kernel| points(kernel, LATTICE, 1)) as fn(_) -> _, |kernel| points(kernel, Evaluation::Direct, 2)]
        .into_iter()
        .zip([1..2, 2..3])
    {
        for (n, kernel) in kernels.into_iter().enumerate() {
            assert!(differing(kernel, kernel, way) <= RIM_SHARE, "{kernel:?}");
            // Each pair of the four occurs once.
            for other in others.clone().map(|next| kernels[(n + next) % kernels.len()]) {
                let share = differing(kernel, other, way);
                assert!(share > 5.0 * RIM_SHARE, "{kernel:?} passes for {other:?}: {share} of the rays differ");
            }
        }
    }
}

/// Eyes inside the volume, whose rays have different layer axes; exactly 45°, where two axes are blended; one pixel, and few rows.
/// Transparent, opaque, and in between. PSNR to each kernel's integral, about 3 dB below the measured one.
#[test]
fn odd_places() {
    let volume = random_volume([25, 24, 26], DVec3::ONE, 41);
    let inside = {
        let orbit = Orbit { azimuth: 25.0, elevation: 10.0, roll: 0.0 };
        Camera::orbit(volume.grid().centre(), 4.0, orbit, Projection::Perspective { field_of_view: 80.0 })
    };
    // Pixels of 0.7 voxels: larger ones show means.
    let diagonal = |width, height| {
        let size = viewport(width, height);
        (scaled(parallel(&volume, size, 45.0, 0.0), 0.35 * f64::from(height)), size)
    };
    let [(camera, size), (of_one, one), (of_few, few)] = [diagonal(40, 32), diagonal(1, 1), diagonal(97, 3)];
    let views = [
        ("inside", inside, viewport(40, 32), 50.0),
        ("45°", camera, size, 33.0),
        ("a pixel", of_one, one, 27.0),
        ("few rows", of_few, few, 34.0),
    ];
    for kernel in SMOOTH {
        for (what, camera, size, least) in views {
            let gradient = Some(GradientEstimator::for_kernel(kernel));
            let high = Settings { early_termination: false, gradient, ..with_kernel(Quality::High, kernel).into() };
            let picture = |settings: &Settings| render(&volume, &smooth_transfer(), &camera, size, settings);
            let of_integral = |kernel| picture(&Settings { algorithm: converged(kernel), gradient: None, ..high });
            let found = picture(&high);
            let [own, foreign] =
                [kernel, Kernel::Linear].map(|kernel| compare(&found, &of_integral(kernel)).psnr.unwrap_or(f64::INFINITY));
            eprintln!("{what}, {kernel:?}: {own:.1} dB to its own integral, {foreign:.1} to the linear one");
            assert!(own > least && foreign < own, "{what}, {kernel:?}: {own} dB, {foreign} to another kernel's");
        }
        let opacity = |alpha| TransferFunction::new("even", vec![(0.0, [0.5; 3])], vec![(0.0, alpha)]).unwrap();
        let opaque = |alpha| {
            let settings = with_kernel(Quality::High, kernel).into();
            let frame = render(&volume, &opacity(alpha), &inside, viewport(24, 20), &settings);
            frame.pixels().iter().map(|p| p[3]).collect::<Vec<_>>()
        };
        assert!(opaque(0.0).iter().all(|&a| a == 0.0) && opaque(1.0).iter().all(|&a| a > 0.999), "{kernel:?}");
    }
}
