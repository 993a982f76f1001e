//! The shipped pictures, warp included, against the converged integral: the table in docs/fidelity.md.

mod common;

use common::*;
use layersplat::layers::{Correction, Interpolation};
use layersplat::reference::Integral;
use layersplat::settings::{Algorithm, Classification, Evaluation, Layered};
use layersplat::{Frame, Quality, Settings, TransferFunction};

/// Least PSNR over RGB, in dB, of `standard` and `high`.
const LEAST: [(&str, f64, f64); 5] =
    [("fuel", 53.0, 69.5), ("neghip", 49.0, 58.5), ("lobster", 50.0, 62.5), ("engine", 47.0, 59.5), ("aneurism", 38.5, 42.5)];

/// Ray casting in the same small steps, on the device: in floats, and with the nearest of 4096 table entries.
const LEAST_CONVERGED: f64 = 80.0;

/// What pre-integration must gain on a thin shell, in dB: one sample over kappa, two over four sub-layers.
const LEAST_SHELL_GAIN: f64 = 4.0;

fn psnr(a: &Frame, b: &Frame) -> (f64, f64) {
    let comparison = compare(a, b);
    (comparison.psnr.expect("not identical"), comparison.psnr_rgba.expect("not identical"))
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn standard_and_high_reach_their_psnr() {
    let size = viewport(512, 512);
    for (name, standard, high) in LEAST {
        let (volume, transfer) = data_set(name);
        let camera = parallel(&volume, size, 72.0, 20.0);
        let truth = Integral::new(&volume, &transfer, None).render(&camera, size).unwrap();
        let found = |settings: Settings, what: &str| {
            let unshaded = Settings { shading: None, ..settings };
            let (rgb, rgba) = psnr(&render(&volume, &transfer, &camera, size, &unshaded), &truth);
            eprintln!("fidelity {name} {what}: {rgb:.1} dB RGB, {rgba:.1} dB RGBA");
            (rgb, rgba)
        };
        for (quality, least) in [(Quality::Draft, 0.0), (Quality::Standard, standard), (Quality::High, high)] {
            let (rgb, rgba) = found(quality.settings(), &format!("{quality:?}"));
            assert!(rgb >= least, "{name} {quality:?}: {rgb} dB, less than {least}");
            assert!(rgba >= least - 1.0, "{name} {quality:?}: alpha is off: {rgba} dB");
            let splatted = Settings {
                algorithm: Layered { classification: quality.splatted(), ..layered(quality.settings()) }.into(),
                ..quality.settings()
            };
            let (post, _) = found(splatted, &format!("{quality:?} post"));
            if quality != Quality::Standard {
                assert!(rgb > post, "{name} {quality:?}: pre-integration must gain, {rgb} dB for {post}");
            }
        }
        found(Quality::Paper.settings(), "Paper");
        for quality in [Quality::Standard, Quality::High] {
            found(
                Settings {
                    algorithm: Layered { evaluation: Evaluation::Direct, ..layered(quality.settings()) }.into(),
                    ..quality.settings()
                },
                &format!("{quality:?} per pixel"),
            );
        }
        let converged = Algorithm::Raycast { interpolation: Interpolation::Tricubic, step: 0.0625 };
        let (on_the_device, _) = found(Settings { algorithm: converged, ..Settings::default() }, "ray casting");
        assert!(on_the_device > LEAST_CONVERGED, "{name}: {on_the_device} dB between the truths of device and host");
        let picture = |settings: Settings| render(&volume, &transfer, &camera, size, &Settings { shading: None, ..settings });
        let shifted = psnr(&shifted_by_half_a_pixel(&picture(Quality::Standard.settings())), &truth).0;
        assert!(shifted < standard, "{name}: half a pixel must be noticed, {shifted} dB");
        let high = Settings {
            algorithm: Layered { classification: Quality::High.splatted(), ..layered(Quality::High.settings()) }.into(),
            ..Quality::High.settings()
        };
        let with_kappa = psnr(&picture(high), &truth).0;
        let without = Settings {
            algorithm: Layered { classification: Classification::Post(Correction::None), ..layered(high) }.into(),
            ..high
        };
        let without_kappa = psnr(&picture(without), &truth).0;
        assert!(without_kappa < with_kappa, "{name}: a missing kappa must cost, {without_kappa} dB");
        for settings in [high, Quality::High.settings()] {
            let wrong = psnr(&picture(Settings { unit_distance: Some(1.1), ..settings }), &truth).0;
            let right = psnr(&picture(settings), &truth).0;
            assert!(wrong < right - 1.0, "{name}: a wrong unit distance must be noticed, {wrong} dB for {right}");
        }
    }
}

/// What the paper compares with, at its defaults, each against the integral of its own kernel: `high` is nearer to ours.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn high_is_nearer_to_its_integral_than_sheets_and_slices_to_theirs() {
    let size = viewport(512, 512);
    for (name, ..) in LEAST {
        let (volume, transfer) = data_set(name);
        let camera = parallel(&volume, size, 72.0, 20.0);
        let unshaded = Settings { shading: None, ..Settings::default() };
        let with = |algorithm| render(&volume, &transfer, &camera, size, &Settings { algorithm, ..unshaded });
        let truth = |interpolation| with(Algorithm::Raycast { interpolation, step: 0.0625 });
        let cubic = truth(Interpolation::Tricubic);
        let high = Settings { shading: None, ..Quality::High.settings() };
        let ours = psnr(&render(&volume, &transfer, &camera, size, &high), &cubic).0;
        let others = [
            (Algorithm::ViewSheets { sheet_distance: 1.0 }, Interpolation::Gaussian),
            (Algorithm::Slicing { step: 1.0 }, Interpolation::Trilinear),
            (Algorithm::AxisSheets { layer_axis: layersplat::settings::LayerAxis::Auto }, Interpolation::Gaussian),
        ];
        for (algorithm, kernel) in others {
            let theirs = psnr(&with(algorithm), &truth(kernel)).0;
            eprintln!("fidelity {name}: high {ours:.1} dB, {} {theirs:.1} dB, each to its own integral", algorithm.name());
            assert!(ours > theirs, "{name}: {ours} dB, {} {theirs}", algorithm.name());
        }
    }
}

/// A thin shell of opacity: values between two samples jump over it, and classification after interpolation misses it.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn pre_integration_finds_thin_shells() {
    let size = viewport(256, 256);
    let (volume, _) = data_set("engine");
    let opacities = vec![(0.0, 0.0), (120.0, 0.0), (130.0, 0.9), (140.0, 0.0), (255.0, 0.0)];
    let shell = TransferFunction::new("shell", vec![(0.0, [0.3, 0.5, 1.0]), (255.0, [1.0, 0.6, 0.2])], opacities).unwrap();
    let camera = parallel(&volume, size, 72.0, 20.0);
    let truth = Integral::new(&volume, &shell, None).render(&camera, size).unwrap();
    let found =
        |settings: Settings| psnr(&render(&volume, &shell, &camera, size, &Settings { shading: None, ..settings }), &truth).0;
    // Per pixel: the shell's edges are finer than any lattice's samples.
    let high = Settings {
        algorithm: Layered { evaluation: Evaluation::Direct, ..layered(Quality::High.settings()) }.into(),
        ..Quality::High.settings()
    };
    let classified = [Classification::Post(Correction::Constant), Quality::High.splatted(), POINTS, layered(high).classification];
    let [kappa, sub_layers, once, twice] = classified
        .map(|classification| found(Settings { algorithm: Layered { classification, ..layered(high) }.into(), ..high }));
    eprintln!(
        "fidelity thin shell in engine: {kappa:.1} dB with kappa, {sub_layers:.1} with four sub-layers, pre-integrated {once:.1} \
         with one sample per layer, {twice:.1} with two"
    );
    assert!(once > kappa + LEAST_SHELL_GAIN && twice > sub_layers + LEAST_SHELL_GAIN, "{once}, {twice} dB");
}
