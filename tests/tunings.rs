//! Every width of vectors, and the tuning values of graphics processors, against the f64 reference, on whatever device there is.

mod common;

use common::blends::*;
use common::reference::{Pair, RIM_SHARE};
use common::*;
use layersplat::Device;
use layersplat::device::{DeviceKind, Tuning};
use layersplat::layers::{Density, Kernel};
use layersplat::settings::{Algorithm, Classification, Clipping, Evaluation, Layered};

/// Floats are added in another order where rows and tiles begin elsewhere.
const REORDERED: f64 = 2e-5;

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
            let first = first.get_or_insert_with(|| pair.found.clone()).clone();
            let apart = Pair { found: pair.found, expected: first }.differing(REORDERED);
            assert!(apart <= RIM_SHARE, "{what}: {apart} of the rays are not those of the first width");
        }
    }
}
