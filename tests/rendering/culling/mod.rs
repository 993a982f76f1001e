//! Culling: it never changes a bit of a picture, and saves work.

mod fringe;
mod middle;

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Kernel};
use layersplat::settings::{Algorithm, Blend, Classification, Evaluation, LayerAxis, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, Frame, Renderer, Settings, TransferFunction, Volume};

/// A splat whose neighbourhood of three voxels is invisible may still contribute a thousandth to a visible sample.
const SPLATS_LEFT_OUT: f64 = 1e-3;

/// A mostly empty volume of 0 and 255; only interpolated values between two invisible voxels are visible.
fn between() -> (Volume<'static>, TransferFunction) {
    let dims = [70, 41, 53];
    let mut random = Random(5);
    let mut bytes = vec![0u8; dims.iter().product()];
    for _ in 0..60 {
        let at = random.next() as usize % bytes.len();
        bytes[at] = 255;
    }
    let opacities = vec![(0.0, 0.0), (60.0, 0.0), (120.0, 0.8), (200.0, 0.0), (255.0, 0.0)];
    let transfer = TransferFunction::new("between", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
    (volume(dims, DVec3::ONE, Voxels::Uint8(bytes)), transfer)
}

/// A thick ball of 255 in 0; a narrow band of values between is visible, the voxels inside and outside are not.
fn shell() -> (Volume<'static>, TransferFunction) {
    let n = 40;
    let inside = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - DVec3::splat(n as f64 / 2.0);
        p.length() < 14.3
    };
    let bytes = (0..n * n * n).map(|i| if inside(i) { 255 } else { 0 }).collect();
    let opacities = vec![(0.0, 0.0), (110.0, 0.0), (128.0, 0.7), (146.0, 0.0), (255.0, 0.0)];
    let transfer = TransferFunction::new("shell", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
    (volume([n; 3], DVec3::ONE, Voxels::Uint8(bytes)), transfer)
}

/// A view with and without culling.
fn culled_and_whole(renderer: &mut Renderer, camera: &Camera, settings: &Settings) -> [Frame; 2] {
    [true, false].map(|culling| renderer.render(camera, viewport(64, 64), &Settings { culling, ..*settings }).unwrap().0)
}

#[test]
fn culling_never_changes_a_bit() {
    let fog =
        TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(0.0, 0.02), (10.0, 0.0), (250.0, 0.0), (255.0, 0.5)]).unwrap();
    let random = random_volume([45, 30, 37], DVec3::new(1.0, 1.5, 0.8), 6);
    let size = viewport(64, 64);
    for (v, (volume, transfer)) in [between(), shell(), (between().0, fog), (random, smooth_transfer())].into_iter().enumerate() {
        let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
        for (n, (azimuth, elevation)) in
            [(0.0, 0.0), (45.0, 0.0), (30.0, 20.0), (100.0, -40.0), (10.0, 80.0)].into_iter().enumerate()
        {
            let views = [
                parallel(&volume, size, azimuth, elevation),
                perspective(&volume, azimuth, elevation, 30.0),
                perspective(&volume, azimuth, elevation, 90.0),
                perspective(&volume, azimuth, elevation, 150.0),
            ];
            // Each in every other view.
            for camera in views.into_iter().skip((v + n) % 2).step_by(2) {
                for settings in evaluations() {
                    let [culled, whole] = culled_and_whole(&mut renderer, &camera, &settings);
                    let name = settings.algorithm.name();
                    // Omitted splats of sheets have a small weight; everything else is exact.
                    let limit = if name == "view-sheets" { SPLATS_LEFT_OUT } else { 0.0 };
                    let difference = compare(&culled, &whole).max_difference;
                    assert!(difference <= limit, "{azimuth}, {elevation}, {name}: {difference}");
                    // Classification before splatting cannot show values between voxels, and single samples may skip them.
                    let sees_all = name != "axis-sheets" && !(name == "layered" && layered(settings).classification == SPLATTED);
                    let seen = largest_opacity(&culled) > 0.01 || !sees_all;
                    assert!(seen, "{azimuth}, {elevation}, {name}, {:?}: the picture is empty", camera.projection);
                }
            }
        }
    }
}

/// A constant volume far from zero with one larger voxel, and steps of opacity just above the constant.
#[test]
fn culling_survives_rounding_and_the_footprint_set() {
    use layersplat::settings::Footprints;
    let size = viewport(64, 64);
    let dims = [24; 3];
    let mut seen: f32 = 0.0;
    for (flat, peak) in [(100u16, 255u16), (60_000, 65_535)] {
        let mut values = vec![flat; 24 * 24 * 24];
        values[12 * 24 * 24 + 11 * 24 + 13] = peak;
        let volume = volume(dims, DVec3::ONE, Voxels::Uint16(values));
        for edge in [0.01, 0.1, 0.3, 0.5] {
            let edge = f64::from(flat) + edge;
            let opacities = vec![(0.0, 0.0), (edge, 0.0), (edge + 2.0, 0.5), (65_535.0, 0.5)];
            let transfer = TransferFunction::new("edge", vec![(0.0, [1.0; 3])], opacities).unwrap();
            let unshaded = Settings { shading: None, early_termination: false, ..Settings::default() };
            let direct = Settings {
                algorithm: Layered { classification: SPLATTED, evaluation: Evaluation::Direct, ..layered(unshaded) }.into(),
                ..unshaded
            };
            let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
            let set = Settings { algorithm: Layered { footprints: Footprints::Set, ..layered(direct) }.into(), ..direct };
            for settings in [
                direct,
                set,
                unshaded,
                Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(unshaded) }.into(), ..unshaded },
            ] {
                let camera = parallel(&volume, size, 45.0, 35.0);
                let [culled, whole] = culled_and_whole(&mut renderer, &camera, &settings);
                assert!(culled == whole, "{flat}, {edge}, {:?}: {:?}", layered(settings).footprints, compare(&culled, &whole));
                seen = seen.max(largest_opacity(&whole));
            }
        }
    }
    assert!(seen > 0.1);
}

/// Compares rendering with and without culling bit for bit; returns the number of visible pixels.
#[track_caller]
fn assert_culled_right(what: &str, volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: Settings) -> usize {
    let mut renderer = Renderer::new(&device(), volume, transfer).unwrap();
    let [culled, whole] = culled_and_whole(&mut renderer, camera, &settings);
    assert!(culled == whole, "{what}, {settings:?}: {:?}", compare(&culled, &whole));
    whole.pixels().iter().filter(|p| p[3] > 0.01).count()
}

/// Forced axes: rays move up to three voxels per layer and cross blocks sideways.
#[test]
fn culling_sees_where_leaning_rays_reach() {
    let faint =
        TransferFunction::new("faint", vec![(0.0, [1.0, 0.8, 0.6])], vec![(0.0, 0.0), (0.5, 1e-3), (255.0, 0.5)]).unwrap();
    for (volume, transfer) in [between(), shell(), (between().0, faint)] {
        for (azimuth, elevation) in [(50.0, 0.0), (63.0, 10.0), (-70.0, 5.0), (15.0, 68.0), (120.0, -50.0)] {
            for classification in CLASSIFICATIONS {
                for evaluation in [Layered::default().evaluation, Evaluation::Direct] {
                    let layered =
                        Layered { layer_axis: LayerAxis::Forced(Axis::Z), classification, evaluation, ..Layered::default() };
                    let camera = parallel(&volume, viewport(64, 64), azimuth, elevation);
                    let seen = assert_culled_right("leaning", &volume, &transfer, &camera, layered.into());
                    assert!(seen > 0 || classification == SPLATTED, "{azimuth}, {elevation}: the picture is empty");
                }
            }
        }
    }
}

/// A Gaussian has a radius of two voxels, and its sums deviate by up to 4.4 %.
#[test]
fn culling_knows_the_gaussians_reach_and_error() {
    let n = 24;
    let opacities = |points: &[(f64, f64)]| TransferFunction::new("band", vec![(0.0, [1.0, 0.8, 0.6])], points.to_vec()).unwrap();
    // One voxel exceeds all others, because tables end at the largest value.
    let with_peak = |mut values: Vec<u8>| {
        values[n * n + n + 1] = 255;
        volume([n; 3], DVec3::ONE, Voxels::Uint8(values))
    };
    let block = || {
        let is_inside = |i: usize| [i % n, i / n % n, i / n / n].iter().all(|c| (5..19).contains(c));
        with_peak((0..n * n * n).map(|i| if is_inside(i) { 100 } else { 0 }).collect())
    };
    let hole = || {
        let mut values = vec![100; n * n * n];
        values[n * n * 12 + n * 12 + 12] = 0;
        with_peak(values).with_background(100.0).unwrap()
    };
    let above = || opacities(&[(0.0, 0.0), (100.5, 0.0), (102.0, 0.3), (104.0, 0.0), (255.0, 0.0)]);
    let below = || opacities(&[(0.0, 0.0), (98.0, 0.0), (98.5, 0.3), (99.5, 0.0), (255.0, 0.0)]);
    // Visible only near the largest sums, and near the smallest.
    let far_above = || opacities(&[(0.0, 0.0), (103.2, 0.0), (103.6, 0.5), (105.0, 0.0), (255.0, 0.0)]);
    let far_below = || opacities(&[(0.0, 0.0), (95.0, 0.0), (96.4, 0.5), (96.8, 0.0), (255.0, 0.0)]);
    let faint = || opacities(&[(0.0, 0.0), (1e-3, 1e-3), (0.1, 0.2), (255.0, 0.5)]);
    let algorithm = Algorithm::Raycast { kernel: Kernel::Gaussian, step: 0.5 };
    let cases = [
        ("above", block(), above()),
        ("below", block(), below()),
        ("far above", block(), far_above()),
        ("far below", block(), far_below()),
        ("faint", block(), faint()),
        ("faint threads", between().0, faint()),
        ("above, beside another background", hole(), above()),
        ("below, beside another background", hole(), below()),
    ];
    for (what, volume, transfer) in cases {
        for camera in [parallel(&volume, viewport(64, 64), 30.0, 20.0), perspective(&volume, -100.0, 40.0, 40.0)] {
            for shading in [Settings::default().shading, None] {
                let settings = Settings { shading, early_termination: false, ..algorithm.into() };
                let seen = assert_culled_right(what, &volume, &transfer, &camera, settings);
                assert!(seen > 100, "{what}: {seen} visible pixels");
            }
        }
    }
}

/// Algorithms with a kernel: one and two samples per layer on a lattice, per pixel, and ray casting.
fn ways_of(kernel: Kernel) -> [Algorithm; 4] {
    let points = |evaluation, samples_per_layer| {
        let classification = Classification::Preintegrated { kernel, samples_per_layer };
        Algorithm::Layered(Layered { classification, evaluation, ..Layered::default() })
    };
    let lattice = Layered::default().evaluation;
    [points(lattice, 1), points(lattice, 2), points(Evaluation::Direct, 1), Algorithm::Raycast { kernel, step: 0.5 }]
}

/// Transfer functions, for bytes up to 100, that show overshoot only: all voxels are transparent.
fn beyond() -> [TransferFunction; 2] {
    let show =
        |opacities: &[(f64, f64)]| TransferFunction::new("beyond", vec![(0.0, [1.0, 0.8, 0.6])], opacities.to_vec()).unwrap();
    [show(&[(0.0, 0.0), (100.01, 0.0), (102.0, 0.5)]), show(&[(-2.0, 0.5), (-0.01, 0.0), (100.0, 0.0)])]
}

/// A block of 100 in 0, with a hole.
fn block_with_a_hole() -> Volume<'static> {
    let dims = [44, 40, 42];
    let within = |i: usize, [from, to]: [usize; 2]| {
        [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]].iter().all(|c| (from..to).contains(c))
    };
    let value = |i| if within(i, [6, 17]) && !within(i, [11, 12]) { 100 } else { 0 };
    volume(dims, DVec3::new(1.0, 0.9, 1.2), Voxels::Uint8((0..dims.iter().product()).map(value).collect()))
}

/// A view per layer axis.
fn views_of_axes(volume: &Volume) -> [Camera; 3] {
    let size = viewport(64, 64);
    [parallel(volume, size, 30.0, 20.0), perspective(volume, 80.0, 12.0, 30.0), parallel(volume, size, 20.0, 70.0)]
}

/// Overshoot beyond all voxels: culling by the range of the voxels would remove it.
#[test]
fn culling_sees_what_overshoots() {
    let volume = block_with_a_hole();
    for transfer in beyond() {
        assert!((0..=100).all(|v| transfer.opacity(f64::from(v)) == 0.0), "voxels must be transparent");
        for algorithm in [Kernel::CatmullRom, Kernel::BSpline].into_iter().flat_map(ways_of) {
            for (n, camera) in views_of_axes(&volume).into_iter().enumerate() {
                for shading in [Settings::default().shading, None] {
                    let settings = Settings { shading, early_termination: false, ..algorithm.into() };
                    let seen = assert_culled_right("beyond", &volume, &transfer, &camera, settings);
                    assert!(seen > 30, "view {n}, {settings:?}: {seen} visible pixels");
                }
            }
        }
    }
}

/// Blend modes that reduce values, for each kernel, with visible values everywhere or only in a corner.
#[test]
fn culling_knows_what_kernels_reach() {
    let faint =
        || TransferFunction::new("faint", vec![(0.0, [1.0, 0.8, 0.6])], vec![(0.0, 0.0), (0.5, 1e-3), (255.0, 0.5)]).unwrap();
    let cases = [(between(), faint()), ((block_with_a_hole(), smooth_transfer()), smooth_transfer())];
    for ((volume, transfer), faint) in cases {
        let views = views_of_axes(&volume);
        for (n, kernel) in [Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline].into_iter().enumerate() {
            let [once, twice, direct, cast] = ways_of(kernel);
            let composited =
                [(once, Blend::Composite), (twice, Blend::Composite), (direct, Blend::Composite), (cast, Blend::Composite)];
            // Combine each blend mode with one of the algorithms per kernel of radius two, because programs take long to build.
            let gathered = match kernel {
                Kernel::CatmullRom => vec![(once, Blend::Iso(60.0)), (direct, Blend::Maximum)],
                Kernel::BSpline => {
                    vec![(twice, Blend::Iso(60.0)), (once, Blend::Maximum), (cast, Blend::Average), (direct, Blend::Minimum)]
                }
                _ => vec![],
            };
            for (m, (algorithm, blend)) in composited.into_iter().chain(gathered).enumerate() {
                for transfer in [&transfer, &faint] {
                    let settings = Settings { blend, early_termination: false, ..algorithm.into() };
                    let seen = assert_culled_right("reach", &volume, transfer, &views[(n + m) % 3], settings);
                    assert!(seen > 30 || blend == Blend::Minimum, "{settings:?}: {seen} visible pixels");
                }
            }
        }
    }
}

/// Least speed-up for a small visible block; measured 11 to 40.
const LEAST_GAIN: f64 = 4.0;
/// The shortest of this many frames counts, because other processes delay some.
const TRIES: usize = 3;

#[test]
fn culling_saves_work() {
    let n = 128;
    let is_inside = |i: usize| [i % n, i / n % n, i / n / n].iter().all(|c| (60..68).contains(c));
    let values = (0..n * n * n).map(|i| if is_inside(i) { 200 } else { 0 }).collect();
    let volume = volume([n; 3], DVec3::ONE, Voxels::Uint8(values));
    let size = viewport(96, 96);
    let camera = parallel(&volume, size, 30.0, 20.0);
    // Sheets splat visible voxels only, with and without culling.
    for settings in evaluations().into_iter().filter(|s| !s.algorithm.name().ends_with("sheets")) {
        let mut renderer = Renderer::new(&device(), &volume, &step_transfer(100.0, 0.3)).unwrap();
        renderer.measure(true);
        let mut milliseconds = |culling: bool| {
            let settings = Settings { culling, ..settings };
            let frame = || {
                let measured = renderer.render(&camera, size, &settings).unwrap().1.measured.expect("asked for");
                assert!(measured.active_samples > 0, "{settings:?}: the picture is empty");
                measured.stages.iter().map(|(_, ms)| ms).sum::<f64>()
            };
            // The first frame includes preparation.
            std::iter::repeat_with(frame).take(TRIES + 1).skip(1).fold(f64::INFINITY, f64::min)
        };
        let (culled, whole) = (milliseconds(true), milliseconds(false));
        eprintln!("{:?}: {culled:.2} of {whole:.2} ms", settings.algorithm);
        assert!(whole > LEAST_GAIN * culled, "{:?}: {culled} of {whole} ms", settings.algorithm);
    }
}
