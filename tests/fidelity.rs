//! The shipped pictures, warp included, against the converged integral: the table in docs/fidelity.md.

mod common;

use common::*;
use layersplat::layers::Correction;
use layersplat::reference::Integral;
use layersplat::renderer::Classification;
use layersplat::{Frame, Quality, Settings};

/// Least PSNR over RGB, in dB, of `standard` and `high`.
const LEAST: [(&str, f64, f64); 5] =
    [("fuel", 53.0, 61.0), ("neghip", 49.0, 51.5), ("lobster", 50.0, 56.0), ("engine", 47.0, 53.5), ("aneurism", 38.5, 42.0)];

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
        let picture = |quality: Quality| {
            let settings = Settings { shading: None, ..quality.settings() };
            render(&volume, &transfer, &camera, size, &settings)
        };
        for (quality, least) in
            [(Quality::Draft, 0.0), (Quality::Standard, standard), (Quality::High, high), (Quality::Paper, 0.0)]
        {
            let frame = picture(quality);
            let (rgb, rgba) = psnr(&frame, &truth);
            eprintln!("fidelity {name} {quality:?}: {rgb:.1} dB RGB, {rgba:.1} dB RGBA");
            assert!(rgb >= least, "{name} {quality:?}: {rgb} dB, less than {least}");
            assert!(rgba >= least - 1.0, "{name} {quality:?}: alpha is off: {rgba} dB");
        }
        let shifted = psnr(&shifted_by_half_a_pixel(&picture(Quality::Standard)), &truth).0;
        assert!(shifted < standard, "{name}: half a pixel must be noticed, {shifted} dB");
        let high_without = |wrong: Settings| {
            let settings = Settings { shading: None, ..wrong };
            psnr(&render(&volume, &transfer, &camera, size, &settings), &truth).0
        };
        let without_kappa =
            high_without(Settings { classification: Classification::Post(Correction::None), ..Quality::High.settings() });
        assert!(without_kappa < psnr(&picture(Quality::High), &truth).0, "{name}: a missing kappa must cost, {without_kappa} dB");
        let wrong_unit = high_without(Settings { unit_distance: Some(1.1), ..Quality::High.settings() });
        assert!(wrong_unit < high, "{name}: a wrong unit distance must be noticed, {wrong_unit} dB");
    }
}
