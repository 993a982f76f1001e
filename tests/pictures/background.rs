//! Background outside the grid and at invalid voxels.

use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::settings::{Algorithm, Evaluation, Layered};
use layersplat::volume::Voxels;
use layersplat::{Settings, TransferFunction, Volume};

/// Slicing looks up the nearest of 256 front and back values.
const SLICING_TOLERANCE: f64 = 8e-3;
/// Fraction of the pixels that another background must change.
const LEAST_CHANGED: f64 = 0.02;

/// All algorithms without early termination; layered ones per pixel, like the reference.
fn every_way() -> Vec<Settings> {
    let layered = CLASSIFICATIONS.map(|classification| Settings {
        algorithm: Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() }.into(),
        ..Settings::default()
    });
    let others = OTHERS.map(|algorithm| Settings { algorithm, ..Settings::default() });
    layered.into_iter().chain(others).map(|settings| Settings { early_termination: false, ..settings }).collect()
}

/// Whether the algorithm reconstructs with Gaussians. Their sums are off by a fraction of the distance from the background, so they use the
/// smallest value instead if it is invisible.
fn is_gaussian(algorithm: Algorithm) -> bool {
    matches!(algorithm, Algorithm::ViewSheets { .. } | Algorithm::Raycast { kernel: Kernel::Gaussian, .. })
}

/// All algorithms, and the layered ones also on their lattices.
fn every_way_and_lattices() -> Vec<Settings> {
    let lattices = CLASSIFICATIONS.map(|classification| Settings {
        algorithm: Layered { classification, ..Layered::default() }.into(),
        ..Settings::default()
    });
    lattices.into_iter().chain(every_way()).collect()
}

/// Values from 100 to 255; only values around 50 are visible.
fn positive() -> (Volume<'static>, TransferFunction) {
    let values = random_bytes([12, 11, 10], 1).iter().map(|b| b.saturating_add(100)).collect();
    let opacities = vec![(0.0, 0.0), (40.0, 0.0), (50.0, 0.5), (60.0, 0.0)];
    (
        volume([12, 11, 10], DVec3::ONE, Voxels::Uint8(values)),
        TransferFunction::new("50", vec![(0.0, [1.0; 3])], opacities).unwrap(),
    )
}

#[test]
fn positive_data_have_no_skin() {
    let (volume, transfer) = positive();
    let size = viewport(30, 30);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let around_zero = volume.clone().with_background(0.0).unwrap();
    for settings in every_way_and_lattices() {
        let opacity = |volume: &Volume| largest_opacity(&render(volume, &transfer, &camera, size, &settings));
        assert_eq!(opacity(&volume), 0.0, "{settings:?}");
        // Voxels classified one by one have no intermediate values towards the background.
        if !matches!(settings.algorithm, Algorithm::AxisSheets { .. }) && !is_gaussian(settings.algorithm) {
            assert!(opacity(&around_zero) > 0.2, "{settings:?}: values of at least 100 in a background of 0 must have a skin");
        }
    }
}

#[test]
fn any_background_is_drawn_as_the_reference_does() {
    let dims = [8, 7, 9];
    let bytes = random_bytes(dims, 2);
    let volumes = [
        volume(dims, DVec3::ONE, Voxels::Uint8(bytes.clone())),
        volume(dims, DVec3::ONE, Voxels::Int16(bytes.iter().map(|&b| i16::from(b)).collect())),
        volume(dims, DVec3::ONE, Voxels::Float32(bytes.iter().map(|&b| f32::from(b)).collect())),
    ];
    let colors = vec![(-400.0, [0.1, 0.2, 0.9]), (90.0, [0.2, 0.9, 0.3]), (500.0, [1.0, 0.6, 0.1])];
    // The backgrounds below are transparent, but values between them and the voxels are visible.
    let opacities =
        vec![(-400.0, 0.0), (-250.0, 0.0), (-50.0, 0.2), (30.0, 0.0), (90.0, 0.0), (255.0, 0.3), (320.0, 0.2), (390.0, 0.0)];
    let transfer = TransferFunction::new("bands", colors, opacities).unwrap();
    let size = viewport(19, 17);
    for volume in volumes {
        let camera = parallel(&volume, size, 30.0, 20.0);
        // Below and above the range of a byte, and between two of its values.
        for background in [-300.0, 60.5, 400.0] {
            let volume = volume.clone().with_background(background).unwrap();
            let away = volume.clone().with_background(background + 25.0).unwrap();
            for settings in every_way() {
                let what = format!("{} in {background}, {settings:?}", volume.voxel_type());
                let found = render(&volume, &transfer, &camera, size, &settings);
                let unculled = render(&volume, &transfer, &camera, size, &Settings { culling: false, ..settings });
                // Omitting distant splats is the only culling that is not bit-exact.
                let inexact = matches!(settings.algorithm, Algorithm::ViewSheets { .. });
                assert_close(&what, &found, &unculled, if inexact { DEVICE_TOLERANCE } else { 0.0 });
                let tolerance =
                    if matches!(settings.algorithm, Algorithm::Slicing { .. }) { SLICING_TOLERANCE } else { DEVICE_TOLERANCE };
                Pair::of(&volume, &transfer, &camera, size, &settings).assert_allowed(&what, tolerance);
                if !matches!(settings.algorithm, Algorithm::AxisSheets { .. }) && !is_gaussian(settings.algorithm) {
                    let wrong = render(&away, &transfer, &camera, size, &settings);
                    let wrong = pixels_apart(&found, &wrong, tolerance) as f64 / found.pixels().len() as f64;
                    assert!(wrong > LEAST_CHANGED, "{what}: a background 25 away must be noticed: {wrong}");
                }
            }
        }
    }
}

#[test]
fn voxels_without_a_value_count_as_background() {
    let dims = [11, 10, 9];
    let bytes = random_bytes(dims, 3);
    let lost = |i: usize| i % 7 == 3;
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38];
    let values = |fill: &dyn Fn(usize) -> f32| {
        let value = |(i, &b): (usize, &u8)| if lost(i) { fill(i) } else { 280.0 + f32::from(b) * 0.1 };
        Voxels::Float32(bytes.iter().enumerate().map(value).collect())
    };
    let smallest = 280.0 + f32::from((0..bytes.len()).filter(|&i| !lost(i)).map(|i| bytes[i]).min().unwrap()) * 0.1;
    let size = viewport(30, 30);
    for background in [None, Some(290.0)] {
        let surrounded = |voxels| {
            let volume = volume(dims, DVec3::ONE, voxels);
            match background {
                Some(value) => volume.with_background(value.into()).unwrap(),
                None => volume,
            }
        };
        let with_holes = surrounded(values(&|i| odd[i % 4]));
        let filled = surrounded(values(&|_| background.unwrap_or(smallest)));
        assert_eq!(with_holes.range(), filled.range());
        assert_eq!(with_holes.invalid(), (0..bytes.len()).filter(|&i| lost(i)).count());
        let transfer = TransferFunction::automatic(&with_holes);
        let camera = parallel(&with_holes, size, 30.0, 20.0);
        for settings in every_way_and_lattices() {
            let [a, b] = [&with_holes, &filled].map(|volume| render(volume, &transfer, &camera, size, &settings));
            assert_close(&format!("{background:?}, {settings:?}"), &a, &b, 0.0);
        }
    }
}

/// Only values between the voxels and a background outside their type's range are visible: at the border, on all sides.
#[test]
fn what_shows_beyond_the_voxels_type_is_not_culled() {
    let dims = [20, 19, 18];
    let size = viewport(30, 30);
    for (first, background) in [(0, -300.0), (235, 500.0)] {
        let values = random_bytes(dims, 4).iter().map(|b| first + b / 13).collect();
        let volume = volume(dims, DVec3::ONE, Voxels::Uint8(values)).with_background(background).unwrap();
        let middle = (f64::from(first) + background) / 2.0;
        let opacities = vec![(middle - 50.0, 0.0), (middle, 0.3), (middle + 50.0, 0.0)];
        let transfer = TransferFunction::new("between", vec![(0.0, [1.0; 3])], opacities).unwrap();
        let camera = parallel(&volume, size, 30.0, 20.0);
        let ways = every_way_and_lattices().into_iter().filter(|s| {
            s.algorithm != Algorithm::AxisSheets { layer_axis: layersplat::settings::LayerAxis::Auto }
                && !is_gaussian(s.algorithm)
        });
        for settings in ways {
            let [culled, whole] =
                [true, false].map(|culling| render(&volume, &transfer, &camera, size, &Settings { culling, ..settings }));
            assert_close(&format!("{background}, {settings:?}"), &culled, &whole, 0.0);
        }
    }
}
