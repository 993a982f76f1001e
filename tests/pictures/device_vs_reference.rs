//! The device against the f64 reference: random volumes of odd dimensions, every axis and sign of the view, both projections, every voxel
//! type, shading on and off.

use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Axis, Correction, Density, Kernel, Rays};
use layersplat::reference::Layered as LayeredReference;
use layersplat::renderer::Plan;
use layersplat::settings::{Classification, Evaluation, LayerAxis, Layered};
use layersplat::transfer::Extinction;
use layersplat::volume::Voxels;
use layersplat::{Camera, Renderer, Settings, TransferFunction, Viewport, Volume};

/// Eight quadrature nodes approximate the footprint integral: up to 0.25 % of the value range per splat sum at |s| = 1, more at |s| = 2.
const QUADRATURE_TOLERANCE: f64 = 1.5e-2;

/// Larger lattices are compared at every `SAMPLE_STRIDE`-th sample.
const MOST_SAMPLES: u32 = 2000;
const SAMPLE_STRIDE: u32 = 13;

/// The last one exceeds the tile of the transposition, 16 × 64 voxels of a byte.
const SHAPES: [[usize; 3]; 7] = [[1, 1, 1], [1, 7, 4], [6, 1, 5], [5, 9, 1], [17, 33, 5], [11, 8, 13], [18, 67, 2]];
/// Each axis from both sides, exactly 45°, and views in between.
const VIEWS: [(f64, f64); 12] = [
    (0.0, 0.0),
    (180.0, 0.0),
    (90.0, 0.0),
    (-90.0, 0.0),
    (0.0, 90.0),
    (0.0, -90.0),
    (45.0, 0.0),
    (135.0, 0.0),
    (0.0, 45.0),
    (30.0, 20.0),
    (200.0, -35.0),
    (72.0, 64.0),
];

fn settings(classification: Classification, shading: bool) -> Settings {
    let settings = Settings {
        algorithm: Layered { classification, ..Layered::default() }.into(),
        early_termination: false,
        ..Settings::default()
    };
    if shading { settings } else { Settings { shading: None, ..settings } }
}

fn direct(classification: Classification, shading: bool) -> Settings {
    Settings {
        algorithm: Layered { evaluation: Evaluation::Direct, ..layered(settings(classification, shading)) }.into(),
        ..settings(classification, shading)
    }
}

/// Tolerance on the lattice of a perspective.
fn perspective_tolerance(classification: Classification) -> f64 {
    if classification == SPLATTED { QUADRATURE_TOLERANCE } else { DEVICE_TOLERANCE }
}

/// Every second view of a shape; consecutive shapes have all.
fn views_of(shape: usize) -> impl Iterator<Item = (usize, (f64, f64))> {
    VIEWS.into_iter().enumerate().skip(shape % 2).step_by(2)
}

/// Each classification, unshaded and shaded.
fn each() -> impl Iterator<Item = (Classification, bool)> {
    CLASSIFICATIONS.into_iter().flat_map(|c| [(c, false), (c, true)])
}

/// Two of these six, one shaded and one not; consecutive n cover all.
fn two_of_each(n: usize) -> impl Iterator<Item = (Classification, bool)> {
    each().skip(n % 3).step_by(3)
}

/// Compares the lattice samples, before the warp, with the reference on the same rays; returns the largest difference.
fn lattice_difference(
    volume: &Volume,
    transfer: &TransferFunction,
    camera: &Camera,
    size: Viewport,
    settings: &Settings,
) -> Option<f64> {
    let mut renderer = Renderer::new(&device(), volume, transfer).unwrap();
    let picture = renderer.lattice_picture(camera, size, settings).unwrap()?;
    let rays = Rays::new(camera, size, volume.grid()).unwrap();
    let axis = match layered(*settings).layer_axis {
        LayerAxis::Forced(axis) => axis,
        LayerAxis::Auto => Axis::most_parallel(rays.central_direction()),
    };
    let reference = LayeredReference::new(volume, transfer, settings);
    let mut largest: f64 = 0.0;
    let mut seen: f64 = 0.0;
    // A prime stride visits all phases and tiles, but not every sample. The outermost samples are all compared.
    let [columns, rows] = picture.size;
    let count = columns * rows;
    for sample in 0..count {
        let (column, row) = (sample % columns, sample / columns);
        let is_border = column == 0 || row == 0 || column == columns - 1 || row == rows - 1;
        if count > MOST_SAMPLES && sample % SAMPLE_STRIDE != 0 && !is_border {
            continue;
        }
        let expected = reference.composite(&picture.ray(column, row), Some(axis), rays.to_eye);
        for (e, f) in expected.iter().zip(picture.samples[sample as usize]) {
            largest = largest.max((e - f64::from(f)).abs());
        }
        seen = seen.max(expected[3]);
    }
    assert!(seen > 0.02, "nothing to see");
    Some(largest)
}

#[test]
fn lattice_of_parallel_views() {
    let spacing = DVec3::new(1.0, 0.7, 1.3);
    for (seed, dims) in SHAPES.into_iter().enumerate() {
        let volume = random_volume(dims, spacing, seed as u64);
        for (n, (azimuth, elevation)) in views_of(seed) {
            for (classification, shading) in two_of_each(seed + n) {
                let size = viewport(24, 20);
                let camera = parallel(&volume, size, azimuth, elevation);
                let settings = Settings {
                    algorithm: Layered {
                        evaluation: Evaluation::Lattice(Density::Fixed(2)),
                        ..layered(settings(classification, shading))
                    }
                    .into(),
                    ..settings(classification, shading)
                };
                let difference = lattice_difference(&volume, &smooth_transfer(), &camera, size, &settings).expect("a lattice");
                let what = format!("{dims:?} at {azimuth}, {elevation}, {classification:?}, shading {shading}");
                assert!(difference <= DEVICE_TOLERANCE, "{what}: differs by {difference}");
            }
        }
    }
}

#[test]
fn direct_in_parallel_views() {
    let spacing = DVec3::new(0.8, 1.0, 2.5);
    for (seed, dims) in SHAPES.into_iter().enumerate() {
        let volume = random_volume(dims, spacing, 50 + seed as u64);
        let size = viewport(21, 16);
        for (n, (azimuth, elevation)) in views_of(seed) {
            for settings in two_of_each(seed + n).map(|(classification, shading)| direct(classification, shading)) {
                let camera = parallel(&volume, size, azimuth, elevation);
                let axis = direct_axis(&volume, &camera, size, &settings);
                let expected = LayeredReference::new(&volume, &smooth_transfer(), &settings).render(&camera, size, axis).unwrap();
                let found = render(&volume, &smooth_transfer(), &camera, size, &settings);
                assert_close(&format!("{dims:?} at {azimuth}, {elevation}, {settings:?}"), &found, &expected, DEVICE_TOLERANCE);
            }
        }
    }
}

#[test]
fn direct_in_perspectives_wide_and_from_inside() {
    let volume = random_volume([17, 12, 14], DVec3::new(1.0, 1.2, 0.9), 7);
    let size = viewport(24, 24);
    for classification in CLASSIFICATIONS {
        wide_and_from_inside(&volume, size, &direct(classification, true));
    }
}

fn wide_and_from_inside(volume: &Volume, size: Viewport, direct: &Settings) {
    let mut own_axes = 0;
    for field_of_view in [30.0, 60.0, 90.0] {
        for (azimuth, elevation) in [(0.0, 0.0), (45.0, 0.0), (45.0, 30.0), (160.0, -20.0), (0.0, 90.0)] {
            let camera = perspective(volume, azimuth, elevation, field_of_view);
            let axis = direct_axis(volume, &camera, size, direct);
            own_axes += usize::from(axis.is_none());
            // Rays at exactly 45° may choose different axes in f32 and f64.
            let pair = Pair::of(volume, &smooth_transfer(), &camera, size, direct);
            let what = format!("{field_of_view}° at {azimuth}, {elevation}");
            pair.assert_same(&what, DEVICE_TOLERANCE);
            assert!(axis.is_none() || pair.largest() <= DEVICE_TOLERANCE, "{what}: differs by {}", pair.largest());
        }
    }
    assert!(own_axes >= 4, "the wide views must have rays with separate axes: {own_axes}");
    let inside = Camera { position: volume.grid().centre() + DVec3::new(0.3, 0.2, 2.2), ..perspective(volume, 0.0, 0.0, 60.0) };
    assert_eq!(direct_axis(volume, &inside, size, direct), None);
    Pair::of(volume, &smooth_transfer(), &inside, size, direct).assert_same("from inside", DEVICE_TOLERANCE);
}

#[test]
fn lattice_of_perspectives() {
    let volume = random_volume([17, 12, 14], DVec3::new(1.0, 1.2, 0.9), 8);
    let size = viewport(32, 24);
    let mut lattices = 0;
    for (n, (azimuth, elevation)) in VIEWS.into_iter().enumerate() {
        // Each classification in every view, shaded in every other one.
        for (classification, shading) in each().skip(n % 2).step_by(2) {
            let camera = perspective(&volume, azimuth, elevation, 30.0);
            if let Some(difference) =
                lattice_difference(&volume, &smooth_transfer(), &camera, size, &settings(classification, shading))
            {
                lattices += 1;
                assert!(
                    difference <= perspective_tolerance(classification),
                    "{azimuth}, {elevation}, {classification:?}, shading {shading}: differs by {difference}"
                );
            }
        }
    }
    assert!(lattices >= 27, "only {lattices} views of 36 had a lattice");
    // 60° along an axis has a lattice; 90° at 45° has none and uses ray casting.
    let wide = perspective(&volume, 0.0, 0.0, 60.0);
    let rays = Rays::new(&perspective(&volume, 45.0, 0.0, 90.0), size, volume.grid()).unwrap();
    for settings in CLASSIFICATIONS.map(|c| settings(c, true)) {
        let difference = lattice_difference(&volume, &smooth_transfer(), &wide, size, &settings).expect("a lattice");
        assert!(difference <= perspective_tolerance(layered(settings).classification), "60°: differs by {difference}");
        let plan = Plan::new(&rays, size, volume.grid(), &settings).unwrap();
        assert!(matches!(plan, Plan::CastSegments(..) | Plan::Raycast(..)), "{plan}");
    }
}

#[test]
fn every_correction_and_extinction() {
    let volume = random_volume([9, 8, 7], DVec3::ONE, 9);
    let size = viewport(20, 20);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let corrections =
        [Correction::None, Correction::Constant, Correction::SubLayers(3), Correction::SubLayers(4), Correction::SubLayers(16)];
    let points = [1, 2, 3].map(|samples_per_layer| Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer });
    for classification in corrections.map(Classification::Post).into_iter().chain(points) {
        // In the last case alpha times length exceeds 1, where linear extinction is clamped.
        for (extinction, unit) in [(Extinction::Exponential, 0.8), (Extinction::Linear, 0.8), (Extinction::Linear, 0.2)] {
            let settings = Settings { extinction, unit_distance: Some(unit), ..settings(classification, true) };
            let difference = lattice_difference(&volume, &smooth_transfer(), &camera, size, &settings).expect("a lattice");
            assert!(difference <= DEVICE_TOLERANCE, "{classification:?}, {extinction:?}: differs by {difference}");
            let settings =
                Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(settings) }.into(), ..settings };
            let expected =
                LayeredReference::new(&volume, &smooth_transfer(), &settings).render(&camera, size, Some(Axis::Z)).unwrap();
            let found = render(&volume, &smooth_transfer(), &camera, size, &settings);
            assert_close(&format!("direct, {classification:?}, {extinction:?}"), &found, &expected, DEVICE_TOLERANCE);
        }
    }
}

#[test]
fn every_voxel_type_with_its_background() {
    let dims = [9, 10, 11];
    let bytes = random_bytes(dims, 10);
    let map = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { bytes.iter().map(|&b| f(f64::from(b))).collect() };
    let signed = map(&|b| b - 128.0);
    let hounsfield = map(&|b| (b * 15.7 - 1024.0).round());
    let cases = [
        (Voxels::Int8(signed.iter().map(|&v| v as i8).collect()), (-128.0, 127.0)),
        (Voxels::Uint16(map(&|b| b * 257.0).iter().map(|&v| v as u16).collect()), (0.0, 65535.0)),
        (Voxels::Int16(hounsfield.iter().map(|&v| v as i16).collect()), (-1024.0, 2979.5)),
        (Voxels::Float32(map(&|b| b * 1e-6 - 5e-5).iter().map(|&v| v as f32).collect()), (-5e-5, 2.05e-4)),
    ];
    let size = viewport(20, 20);
    for (voxels, (lo, hi)) in cases {
        let volume = volume(dims, DVec3::ONE, voxels);
        // Opacities of a coarse level apply per spacing of the finest.
        let grid = volume.grid().clone().with_unit(0.6);
        let volume = volume.with_grid(grid).unwrap();
        let kind = volume.voxel_type();
        let transfer = smooth_transfer().stretched(lo, hi).unwrap();
        for (azimuth, elevation) in [(10.0, 5.0), (80.0, -10.0)] {
            let camera = parallel(&volume, size, azimuth, elevation);
            for settings in CLASSIFICATIONS.map(|c| settings(c, true)) {
                let difference = lattice_difference(&volume, &transfer, &camera, size, &settings).expect("a lattice");
                assert!(difference <= DEVICE_TOLERANCE, "{kind}: differs by {difference}");
            }
        }
    }
}

#[test]
fn a_visible_background_ends_with_the_support() {
    let volume = random_volume([9, 8, 7], DVec3::ONE, 11);
    let transfer = TransferFunction::new("fog", vec![(0.0, [1.0, 0.5, 0.2])], vec![(0.0, 0.1), (255.0, 0.4)]).unwrap();
    let size = viewport(20, 20);
    for settings in CLASSIFICATIONS.map(|c| settings(c, true)) {
        for (azimuth, elevation) in [(0.0, 0.0), (30.0, 20.0), (80.0, 0.0)] {
            let camera = parallel(&volume, size, azimuth, elevation);
            let difference = lattice_difference(&volume, &transfer, &camera, size, &settings).expect("a lattice");
            // A sample on different sides of the support's edge in f32 and f64 would differ by its whole opacity.
            assert!(difference <= DEVICE_TOLERANCE, "{azimuth}, {elevation}: differs by {difference}");
            assert_eq!(render(&volume, &transfer, &camera, size, &settings).pixel(0, 0), [0.0; 4]);
        }
        let camera = perspective(&volume, 20.0, 10.0, 30.0);
        let difference = lattice_difference(&volume, &transfer, &camera, size, &settings).expect("a lattice");
        assert!(difference <= perspective_tolerance(layered(settings).classification), "perspective: differs by {difference}");
    }
}

#[test]
fn injected_errors_are_noticed() {
    let volume = random_volume([17, 15, 13], DVec3::ONE, 12);
    let size = viewport(24, 24);
    let camera = parallel(&volume, size, 30.0, 20.0);
    for classification in CLASSIFICATIONS {
        let right = direct(classification, true);
        let found = render(&volume, &smooth_transfer(), &camera, size, &right);
        let reference = |settings: &Settings, axis| {
            LayeredReference::new(&volume, &smooth_transfer(), settings).render(&camera, size, Some(axis)).unwrap()
        };
        let good = reference(&right, Axis::Z);
        assert_close("unharmed", &found, &good, DEVICE_TOLERANCE);
        let noticed = |wrong: &layersplat::Frame| compare(&found, wrong).max_difference > 2.0 * DEVICE_TOLERANCE;
        assert!(noticed(&shifted_by_half_a_pixel(&good)), "half a pixel");
        assert!(noticed(&reference(&right, Axis::X)), "another layer axis");
        for other in CLASSIFICATIONS.into_iter().chain([Classification::Post(Correction::None)]).filter(|c| *c != classification)
        {
            assert!(noticed(&reference(&direct(other, true), Axis::Z)), "{other:?} for {classification:?}");
        }
        assert!(noticed(&reference(&Settings { extinction: Extinction::Linear, ..right }, Axis::Z)), "linear extinction");
        assert!(noticed(&reference(&direct(classification, false), Axis::Z)), "no shading");
    }
}

/// Least PSNR between the kernels' subdivision of a segment of several hues, up to 32 parts, and the reference's 512.
const LEAST_IN_PARTS: f64 = 50.0;

/// Opaque segments of two hues are subdivided with attenuation between the parts. Without subdivision they would differ strongly.
#[test]
fn deep_segments_of_several_hues() {
    let (volume, hues) = block_of_hues();
    let size = viewport(20, 20);
    for (n, (classification, shading)) in each().filter(|(c, _)| *c != SPLATTED).enumerate() {
        // Nearly along an axis: elsewhere rays cut edges between samples that neither sample sees.
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (6.0, 3.0), (183.0, -5.0)].into_iter().skip(n % 2).step_by(2) {
            let settings = direct(classification, shading);
            let camera = parallel(&volume, size, azimuth, elevation);
            let axis = direct_axis(&volume, &camera, size, &settings);
            let found = render(&volume, &hues, &camera, size, &settings);
            let mut reference = LayeredReference::new(&volume, &hues, &settings);
            let whole = reference.render(&camera, size, axis).unwrap();
            reference.in_parts = true;
            let in_parts = reference.render(&camera, size, axis).unwrap();
            let [near, far] = [&in_parts, &whole].map(|r| compare(&found, r).psnr.unwrap());
            let what = format!("{classification:?}, shading {shading} at {azimuth}, {elevation}");
            assert!(near > LEAST_IN_PARTS, "{what}: {near} dB");
            assert!(far < near - 6.0, "{what}: the mean over a segment must be detected: {far} dB, subdivided {near}");
        }
    }
}
