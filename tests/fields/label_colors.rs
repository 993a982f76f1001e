//! Scans in the colours of labels: the integral in `f64`, closed forms, and what stays as it is.

use crate::common::*;
use glam::{DMat3, DVec3};
use layersplat::device::{LatticeSchedule, Tuning};
use layersplat::layers::Kernel;
use layersplat::reference::{Integral, Marched};
use layersplat::renderer::LabelColors;
use layersplat::settings::{Algorithm, Blend, Evaluation, Layered};
use layersplat::volume::{Grid, Voxels};
use layersplat::{
    Camera, Device, Error, Frame, GradientEstimator, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport, Volume,
};

const SIZE: Viewport = Viewport { width: 72, height: 64 };
/// Colours of labels are bytes, and so are their weights; positions are floats.
const BYTES: f64 = 1.0 / 255.0 + 2e-3;
/// In dB, by which a picture in colours of labels may be farther from its integral than the scan's own: edges of labels are sampled once per
/// segment.
const SLACK: f64 = 2.0;

/// Colours and weights: no label, a red one, a green one of weight 0.6, and a hidden one.
const ENTRIES: [[f64; 4]; 4] = [[0.0; 4], [0.9, 0.1, 0.2, 1.0], [0.1, 0.8, 0.3, 0.6], [0.2, 0.3, 1.0, 0.0]];

/// A soft, rippled ball.
fn scan() -> Volume<'static> {
    let grid = Grid::new([26, 22, 24], DVec3::new(1.0, 1.2, 0.9)).unwrap();
    let value = |n: usize| {
        let voxel = DVec3::new((n % 26) as f64, (n / 26 % 22) as f64, (n / 26 / 22) as f64);
        let p = (voxel - grid.centre_in_voxels()) / grid.centre_in_voxels();
        (235.0 * (-1.8 * p.length_squared()).exp() + 12.0 * (7.0 * p.x).sin()).clamp(0.0, 255.0) as u8
    };
    Volume::new("scan", grid.clone(), (0..grid.voxel_count()).map(value).collect::<Vec<_>>()).unwrap()
}

/// Labels on a coarser grid, rotated, over a part of the scan.
fn labels() -> Volume<'static> {
    let turn = DMat3::from_rotation_z(0.35) * DMat3::from_rotation_x(0.2);
    let grid = Grid::oriented([9, 8, 10], DVec3::new(2.3, 2.0, 1.8), DVec3::new(3.0, 1.0, 2.0), turn).unwrap();
    let id = |n: usize| [0u8, 1, 2, 3, 1, 2][(n % 9) / 3 + 3 * (n / 72 / 5)];
    Volume::new("labels", grid.clone(), (0..grid.voxel_count()).map(id).collect::<Vec<_>>()).unwrap()
}

fn cameras() -> [Camera; 3] {
    let scan = scan();
    [parallel(&scan, SIZE, 25.0, 20.0), parallel(&scan, SIZE, 80.0, -30.0), perspective(&scan, 200.0, 60.0, 35.0)]
}

fn drawn(device: &Device, labels: Option<&LabelColors>, camera: &Camera, settings: &Settings) -> Frame {
    let mut renderer = Renderer::new(device, &scan(), &smooth_transfer()).unwrap();
    renderer.set_label_colors(labels).unwrap();
    renderer.render(camera, SIZE, settings).unwrap().0
}

fn psnr(one: &Frame, other: &Frame) -> f64 {
    compare(one, other).psnr_rgba.unwrap_or(f64::INFINITY)
}

fn alphas(frame: &Frame) -> Vec<u32> {
    frame.pixels().iter().map(|pixel| pixel[3].to_bits()).collect()
}

fn all_settings() -> Vec<(&'static str, Settings)> {
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..Settings::default() };
    let unlit = Settings { shading: None, ..Settings::default() };
    let clipped = Settings { early_termination: false, ..Quality::High.settings() };
    vec![("standard", Settings::default()), ("unlit", unlit), ("high", clipped), ("rays", cast)]
}

#[test]
fn colors_of_labels_have_the_integral_of_their_definition() {
    let (scan, labels, transfer) = (scan(), labels(), smooth_transfer());
    let colors = LabelColors::new(&device(), &[(&labels, &ENTRIES)]).unwrap();
    for (name, settings) in all_settings() {
        let kernel = kernel_of(&settings);
        let integral = |camera: &Camera, entries: Option<&[[f64; 4]]>| {
            let mut integral = Integral::new(&scan, &transfer, None).with_gradient(kernel, GradientEstimator::for_kernel(kernel));
            integral.shading = settings.shading;
            let integral = match entries {
                Some(entries) => integral.with_label_colors(&labels, entries),
                None => integral,
            };
            integral.render(camera, SIZE).unwrap()
        };
        for camera in &cameras() {
            let plain = psnr(&drawn(&device(), None, camera, &settings), &integral(camera, None));
            let picture = drawn(&device(), Some(&colors), camera, &settings);
            let found = psnr(&picture, &integral(camera, Some(&ENTRIES)));
            println!("{name}: {found:.1} dB, the scan alone {plain:.1} dB");
            assert!(found >= plain.min(50.0) - SLACK && found > 36.0, "{name}: {found}, the scan alone {plain}");
            // Exchanged colours are noticed.
            let exchanged = [ENTRIES[0], ENTRIES[2], ENTRIES[1], ENTRIES[3]];
            assert!(psnr(&picture, &integral(camera, Some(&exchanged))) < 30.0);
            // Culling changes nothing.
            assert!(drawn(&device(), Some(&colors), camera, &Settings { culling: false, ..settings }) == picture);
        }
    }
}

#[test]
fn cast_rays_are_those_of_the_reference() {
    let (scan, labels, transfer) = (scan(), labels(), smooth_transfer());
    let colors = LabelColors::new(&device(), &[(&labels, &ENTRIES)]).unwrap();
    let algorithm = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.7 };
    for blend in [Blend::Composite, Blend::Iso(120.0)] {
        let settings = Settings { algorithm, blend, early_termination: false, ..Settings::default() };
        for camera in &cameras() {
            let expected = Marched::new(&scan, &transfer, &settings).with_label_colors(&labels, &ENTRIES);
            let expected = expected.render(camera, SIZE).unwrap();
            let found = drawn(&device(), Some(&colors), camera, &settings);
            // Rays that touch an iso-surface round to either side.
            let apart = pixels_apart(&found, &expected, DEVICE_TOLERANCE + BYTES);
            assert!(apart <= SIZE.pixels() / 500, "{blend:?}: {apart} pixels differ");
            assert!(largest_opacity(&found) > 0.5);
        }
    }
}

/// The opacity keeps its bits, also with hidden labels, which keep all of the picture.
#[test]
fn the_scan_keeps_its_opacity_and_hidden_labels_its_colors() {
    let labels = labels();
    let shown = LabelColors::new(&device(), &[(&labels, &ENTRIES)]).unwrap();
    let hidden = LabelColors::new(&device(), &[(&labels, &[[0.3, 0.9, 0.5, 0.0]; 4])]).unwrap();
    let samples = own_device();
    let samples = samples.with_tuning(Tuning { lattice_schedule: LatticeSchedule::Samples, ..*samples.tuning() }).unwrap();
    let on_samples = LabelColors::new(&samples, &[(&labels, &ENTRIES)]).unwrap();
    for (name, settings) in all_settings() {
        for camera in &cameras() {
            let plain = drawn(&device(), None, camera, &settings);
            let tinted = drawn(&device(), Some(&shown), camera, &settings);
            assert!(alphas(&tinted) == alphas(&plain) && tinted != plain, "{name}");
            assert!(drawn(&device(), Some(&hidden), camera, &settings) == plain, "{name}: hidden labels");
            // A work-item per sample draws the same.
            let (plain, other) =
                (drawn(&samples, None, camera, &settings), drawn(&samples, Some(&on_samples), camera, &settings));
            assert!(alphas(&other) == alphas(&plain), "{name}");
            assert_close(name, &other, &tinted, DEVICE_TOLERANCE);
        }
    }
}

/// Fog of one colour: its colour times the weight's complement, plus the label's times the weight, times the opacity.
#[test]
fn fog_has_the_mixed_color() {
    let fog = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![100; 1728])).with_background(100.0).unwrap();
    let own = [0.2, 0.9, 0.4];
    let transfer = TransferFunction::new("fog", vec![(0.0, own)], vec![(0.0, 0.1), (255.0, 0.1)]).unwrap();
    let everywhere = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![1; 1728]));
    let mut renderer = Renderer::new(&device(), &fog, &transfer).unwrap();
    for weight in [0.0, 0.25, 1.0] {
        let label = [0.8, 0.1, 1.0];
        let colors = LabelColors::new(&device(), &[(&everywhere, &[[0.0; 4], [0.8, 0.1, 1.0, weight]])]).unwrap();
        renderer.set_label_colors(Some(&colors)).unwrap();
        let settings = Settings { shading: None, ..Settings::default() };
        let frame = renderer.render(&parallel(&fog, SIZE, 30.0, 20.0), SIZE, &settings).unwrap().0;
        let mut seen = 0;
        for pixel in frame.pixels().iter().map(|pixel| pixel.map(f64::from)).filter(|pixel| pixel[3] > 0.3) {
            for c in 0..3 {
                let expected = ((1.0 - weight) * own[c] + weight * label[c]) * pixel[3];
                assert!((pixel[c] - expected).abs() <= BYTES, "weight {weight}: {pixel:?}, expected {expected}");
            }
            seen += 1;
        }
        assert!(seen > 500, "{seen}");
    }
}

/// The colour of a label of weight 0 does not reach its neighbours, and layers that overlap add.
#[test]
fn weights_keep_colors_apart_and_layers_add() {
    let block = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![200; 1728]));
    let black = TransferFunction::new("black", vec![(0.0, [0.0; 3])], vec![(0.0, 0.0), (200.0, 0.4)]).unwrap();
    let halves = volume([12; 3], DVec3::ONE, Voxels::Uint8((0..1728).map(|n| u8::from(n % 12 < 6)).collect()));
    let all = volume([12; 3], DVec3::ONE, Voxels::Uint8(vec![1; 1728]));
    let mut renderer = Renderer::new(&device(), &block, &black).unwrap();
    // Rays, for the lattice's filter keeps red, green, blue and alpha between those of its samples, each by itself.
    let settings =
        Settings { shading: None, algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..Settings::default() };
    let camera = parallel(&block, SIZE, 20.0, 15.0);
    let mut draw = |layers: &[(&Volume, &[[f64; 4]])]| {
        renderer.set_label_colors(Some(&LabelColors::new(&device(), layers).unwrap())).unwrap();
        renderer.render(&camera, SIZE, &settings).unwrap().0
    };
    // Red beside a green that is hidden.
    let apart = draw(&[(&halves, &[[0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0]])]);
    assert!(apart.pixels().iter().all(|pixel| pixel[1] == 0.0) && apart.pixels().iter().any(|pixel| pixel[0] > 0.5));
    // Red of weight 1 in a half, and blue of weight 1 everywhere: half of each where both are.
    let both = draw(&[(&halves, &[[0.0; 4], [1.0, 0.0, 0.0, 1.0]]), (&all, &[[0.0; 4], [0.0, 0.0, 1.0, 1.0]])]);
    let (mixed, blue) = (both.pixels().iter()).fold((0, 0), |(mixed, blue), &[r, g, b, a]| {
        assert!(g == 0.0 && f64::from((r + b - a).abs()) <= BYTES, "{r} and {b} of {a}");
        (mixed + usize::from(a > 0.5 && (r - b).abs() < 0.01), blue + usize::from(a > 0.5 && r < 0.01))
    });
    assert!(mixed > 100 && blue > 100, "{mixed} pixels of both, {blue} blue ones");
}

/// An eye inside the volume has no lattice: rays are cast.
#[test]
fn views_from_inside_have_colors() {
    let (scan, labels, transfer) = (scan(), labels(), smooth_transfer());
    let inside = Orbit { azimuth: 30.0, elevation: 10.0, roll: 0.0 };
    let camera = Camera::fit_perspective(scan.grid().centre(), 6.0, 100.0, SIZE, inside);
    let colors = LabelColors::new(&device(), &[(&labels, &ENTRIES)]).unwrap();
    let settings = Settings { shading: None, ..Settings::default() };
    let found = drawn(&device(), Some(&colors), &camera, &settings);
    let kernel = kernel_of(&settings);
    let integral = Integral::new(&scan, &transfer, None).with_kernel(kernel).with_label_colors(&labels, &ENTRIES);
    assert!(psnr(&found, &integral.render(&camera, SIZE).unwrap()) > 40.0);
    assert!(alphas(&found) == alphas(&drawn(&device(), None, &camera, &settings)));
    // Converged rays, too.
    let cast = Settings { algorithm: CONVERGED, ..settings };
    assert!(drawn(&device(), Some(&colors), &camera, &cast) != drawn(&device(), None, &camera, &cast));
}

#[test]
fn labels_without_a_placement_have_that_of_a_scan_of_their_size() {
    let scan = scan();
    let ids: Vec<u8> = (0..scan.grid().voxel_count()).map(|n| u8::from(n % 26 < 13)).collect();
    let unplaced = Volume::new("ids", Grid::new(scan.grid().dims(), DVec3::ONE).unwrap(), ids.clone()).unwrap();
    let placed = Volume::new("ids", scan.grid().clone(), ids).unwrap();
    let [camera, ..] = cameras();
    let [one, other] = [&unplaced, &placed].map(|labels| {
        let colors = LabelColors::new(&device(), &[(labels, &ENTRIES[..2])]).unwrap();
        drawn(&device(), Some(&colors), &camera, &Settings::default())
    });
    assert!(one == other);
}

#[test]
fn mistakes_are_named() {
    let (scan, labels) = (scan(), labels());
    let new =
        |labels: &Volume, entries: &[[f64; 4]]| LabelColors::new(&device(), &[(labels, entries)]).err().map(|e| e.to_string());
    let message = new(&labels, &ENTRIES[..3]).unwrap();
    assert!(message.contains("labels: label 3 has no colour: the table has 3 entries"), "{message}");
    let mut bad = ENTRIES;
    bad[2][1] = f64::NAN;
    let message = new(&labels, &bad).unwrap();
    assert!(message.contains("label 2") && message.contains("expected 0 to 1"), "{message}");
    let floats = volume([4; 3], DVec3::ONE, Voxels::Float32(vec![1.0; 64]));
    let message = new(&floats, &ENTRIES).unwrap();
    assert!(message.contains("labels are uint8 or uint16"), "{message}");
    let message = LabelColors::new(&device(), &[]).err().unwrap().to_string();
    assert!(message.contains("give at least one"), "{message}");
    let other = volume([4; 3], DVec3::ONE, Voxels::Uint8(vec![1; 64]));
    let message = LabelColors::new(&device(), &[(&labels, &ENTRIES), (&other, &ENTRIES)]).err().unwrap().to_string();
    assert!(message.contains("not that of the first layer"), "{message}");

    let mut renderer = Renderer::new(&device(), &scan, &smooth_transfer()).unwrap();
    let mut refused = |labels: &Volume| {
        let colors = LabelColors::new(&device(), &[(labels, &ENTRIES)]).unwrap();
        let error = renderer.set_label_colors(Some(&colors)).unwrap_err();
        assert!(matches!(error, Error::Volume { .. }), "{error:?}");
        error.to_string()
    };
    let far = Grid::oriented([4; 3], DVec3::ONE, DVec3::new(500.0, 0.0, 0.0), DMat3::IDENTITY).unwrap();
    let message = refused(&Volume::new("far.nrrd", far, vec![1u8; 64]).unwrap());
    assert!(message.contains("far.nrrd: its labels lie outside scan") && message.contains("placement"), "{message}");

    // What has no colours of labels.
    let colors = LabelColors::new(&device(), &[(&labels, &ENTRIES)]).unwrap();
    renderer.set_label_colors(Some(&colors)).unwrap();
    let post = Layered { classification: SPLATTED, ..layered(Settings::default()) };
    let direct = Layered { evaluation: Evaluation::Direct, ..layered(Settings::default()) };
    let [camera, ..] = cameras();
    for (settings, field) in [
        (Settings { blend: Blend::Maximum, ..Settings::default() }, "blend"),
        (Settings { algorithm: post.into(), ..Settings::default() }, "label_colors"),
        (Settings { algorithm: direct.into(), ..Settings::default() }, "label_colors"),
        (Settings { algorithm: Algorithm::Slicing { step: 1.0 }, ..Settings::default() }, "label_colors"),
        (Settings { algorithm: Algorithm::ViewSheets { sheet_distance: 1.0 }, ..Settings::default() }, "label_colors"),
    ] {
        let error = renderer.render(&camera, SIZE, &settings).err().unwrap();
        assert!(matches!(&error, Error::Settings { field: found, .. } if *found == field), "{error}");
    }
    // Without labels again.
    renderer.set_label_colors(None).unwrap();
    assert!(
        renderer.render(&camera, SIZE, &Settings::default()).unwrap().0 == drawn(&device(), None, &camera, &Settings::default())
    );
}
