//! Every width of vectors, and the tuning values of graphics processors, against the f64 reference, on whatever device there is.

mod common;

use common::blends::*;
use common::reference::{Pair, differing};
use common::*;
use glam::DVec3;
use layersplat::device::{DeviceKind, Tuning};
use layersplat::layers::{Density, Kernel};
use layersplat::settings::{Algorithm, Classification, Clipping, Evaluation, Layered};
use layersplat::{Camera, Device, Orbit, Projection, Renderer, Settings};

/// Floats are added in another order where rows and tiles begin elsewhere.
const REORDERED: f64 = 2e-5;
/// But for few rays, on which a value then rounds to another entry of the table.
const ANOTHER_ENTRY: f64 = 2e-4;
const ANOTHER_ENTRY_SHARE: f64 = 6e-3;

/// Of pixels that have samples of their own, from those that have a ray each: floats of places, and what these make of a steep ramp.
const OF_ONE_RAY: f64 = 2e-4;

/// The widths that kernels have, and how a graphics processor is used.
fn devices() -> Vec<(String, Device)> {
    let device = device();
    let own = *device.tuning();
    let with = |name: String, tuning| (name, device.with_tuning(tuning).unwrap());
    let widths = [16, 8, 4, 1].map(|width| with(format!("vectors of {width}"), Tuning { vector_width: width, ..own }));
    let gpu = Tuning::new(DeviceKind::Gpu, "", 1);
    assert!(
        gpu.vector_width != own.vector_width || gpu.tile_group != own.tile_group,
        "the device's own tuning shows nothing new"
    );
    widths.into_iter().chain([with("a graphics processor's tuning".into(), gpu)]).collect()
}

/// All that has blend modes, and the sheets.
fn everything() -> Vec<Algorithm> {
    let sheets = OTHERS.into_iter().filter(|a| matches!(a, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. }));
    let smooth = [Kernel::CatmullRom, Kernel::BSpline].map(|kernel| {
        // Without a lattice these have one width.
        let classification = Classification::Preintegrated { kernel, samples_per_layer: 2 };
        Layered { classification, evaluation: Evaluation::Lattice(Density::Fixed(2)), ..Layered::default() }.into()
    });
    let cast = Algorithm::Raycast { kernel: Kernel::BSpline, step: 0.6 };
    algorithms().into_iter().chain(sheets).chain(smooth).chain([cast]).collect()
}

#[test]
fn every_width_and_tuning() {
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(21, 19));
    let cameras = [parallel(&volume, size, 25.0, 15.0), perspective(&volume, 100.0, -20.0, 30.0)];
    let devices = devices();
    for (n, algorithm) in everything().into_iter().enumerate() {
        // Each in one projection, every other one cut: programs take long to build.
        let (camera, parallel) = (&cameras[n % 2], n % 2 == 0);
        let settings = composited(algorithm, if n % 4 < 2 { cuts() } else { Clipping::default() });
        let mut first: Option<Vec<_>> = None;
        for (name, device) in &devices {
            let what = format!("{name}: {algorithm:?}, {:?}", camera.projection);
            let pair = Pair::on(device, &volume, &transfer, camera, size, &settings);
            pair.assert_same(&what, tolerance_of(&settings, parallel));
            // Beside each other widths differ much less.
            let first = first.get_or_insert_with(|| pair.found.clone());
            for (most, allowed) in [(REORDERED, ANOTHER_ENTRY_SHARE), (ANOTHER_ENTRY, 0.0)] {
                let apart = differing(&pair.found, first, most);
                assert!(apart <= allowed, "{what}: {apart} of the rays differ from the first width's by more than {most}");
            }
        }
    }
}

/// Where each pixel has its own sample a tile's columns are staggered, and its rows become patches: whatever lies in a vector, and however
/// many rows there are, pictures are those of one ray for each pixel.
#[test]
fn staggered_columns_at_every_width() {
    let (volume, transfer, size) = (random_volume([33, 30, 28], DVec3::ONE, 3), smooth_transfer(), viewport(71, 58));
    let device = device();
    let rows = [5, 6, 30].map(|rows| {
        let tuning = Tuning { point_tile_rows: rows, ..*device.tuning() };
        (format!("{rows} rows"), device.with_tuning(tuning).unwrap())
    });
    let smooth = Classification::Preintegrated { kernel: Kernel::CatmullRom, samples_per_layer: 2 };
    for (azimuth, layered) in [
        (25.0, Layered::default()),
        (250.0, Layered { classification: smooth, evaluation: Evaluation::Lattice(Density::Fine), ..Layered::default() }),
    ] {
        let camera = parallel(&volume, size, azimuth, 15.0);
        let settings = Settings { early_termination: false, ..layered.into() };
        let direct = Layered { evaluation: Evaluation::Direct, ..layered };
        let expected = render(&volume, &transfer, &camera, size, &Settings { algorithm: direct.into(), ..settings });
        for (name, device) in devices().iter().chain(&rows) {
            let mut renderer = Renderer::new(device, &volume, &transfer).unwrap();
            let (found, _) = renderer.render(&camera, size, &settings).unwrap();
            assert_close(&format!("{name}, azimuth {azimuth}"), &found, &expected, OF_ONE_RAY);
        }
        let shifted = compare(&shifted_by_half_a_pixel(&expected), &expected).max_difference;
        assert!(shifted > 100.0 * OF_ONE_RAY, "half a pixel must be noticed: {shifted}");
    }
}

/// Of blocks of other sizes: sums of sixteen samples, in another order.
const OF_ANOTHER_BLOCK: f64 = 1e-5;

/// Where lines of the lattice stand upright, and where they do not, a pixel is what it is in any block of the warp.
#[test]
fn blocks_of_the_warp_change_nothing() {
    let (volume, transfer, size) = (random_volume([33, 30, 28], DVec3::ONE, 3), smooth_transfer(), viewport(71, 58));
    let device = device();
    let upright = parallel(&volume, size, 25.0, 15.0);
    let rolled = Orbit { azimuth: 25.0, elevation: 15.0, roll: 10.0 };
    let rolled = Camera::orbit(volume.grid().centre(), 100.0, rolled, Projection::Parallel { scale: 20.0 });
    let views = [
        (upright, Density::Fixed(1)),
        (upright, Density::Relaxed),
        (rolled, Density::Fixed(2)),
        (parallel(&volume, size, 25.0, 70.0), Density::Fixed(3)),
    ];
    for (n, (camera, density)) in views.into_iter().enumerate() {
        let settings = Settings::from(Layered { evaluation: Evaluation::Lattice(density), ..Layered::default() });
        let draw = |block| {
            let device = device.with_tuning(Tuning { block, ..*device.tuning() }).unwrap();
            let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
            renderer.render(&camera, size, &settings).unwrap().0
        };
        let expected = draw([32, 8]);
        for block in [[1, 1], [5, 3], [16, 2], [128, 8]] {
            assert_close(&format!("view {n}, {block:?}"), &draw(block), &expected, OF_ANOTHER_BLOCK);
        }
        let shifted = compare(&shifted_by_half_a_pixel(&expected), &expected).max_difference;
        assert!(shifted > 100.0 * OF_ANOTHER_BLOCK, "half a pixel must be noticed: {shifted}");
    }
}

/// Splats are counted, added up and listed by many: whoever shares a list, pictures are the same to the bit.
#[test]
fn lists_of_splats_change_no_bit() {
    let (volume, transfer, size) = (random_volume([19, 17, 14], DVec3::ONE, 5), smooth_transfer(), viewport(53, 37));
    let device = device();
    let one = Tuning { vector_width: 1, screen_tile_rows: 1, ..*device.tuning() };
    let tunings = [
        Tuning { list_tiles: 1, scan_group: 1, splat_chunks: 1, ..one },
        Tuning { list_tiles: 3, scan_group: 7, splat_chunks: 5, ..one },
        Tuning { list_tiles: 8, scan_group: 256, splat_chunks: 512, ..one },
        Tuning { list_tiles: 30, scan_group: 64, splat_chunks: 4096, ..one },
        Tuning { list_tiles: 2, scan_group: 3, splat_chunks: 64, screen_tile_rows: 4, ..one },
    ];
    let sheets = OTHERS.into_iter().filter(|a| matches!(a, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. }));
    let mut drawn = Vec::new();
    for (n, algorithm) in sheets.enumerate() {
        let camera = parallel(&volume, size, 25.0 + 65.0 * n as f64, 15.0);
        let draw = |tuning: &Tuning| {
            let device = device.with_tuning(*tuning).unwrap();
            let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
            renderer.render(&camera, size, &Settings { shading: None, ..algorithm.into() }).unwrap().0
        };
        let first = draw(&tunings[0]);
        assert!(first.pixels().iter().filter(|pixel| pixel[3] > 0.05).count() > 300, "{algorithm:?}: nothing to see");
        for tuning in &tunings[1..] {
            assert_eq!(first.pixels(), draw(tuning).pixels(), "{algorithm:?}: {tuning:?}");
        }
        drawn.push(first);
    }
    assert_ne!(drawn[0].pixels(), drawn[1].pixels(), "other pictures are noticed");
}
