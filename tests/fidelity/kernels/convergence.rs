//! Convergence of each kernel to its own integral, lit at every step.

use super::scene::closest;
use crate::common::*;
use layersplat::layers::Kernel;
use layersplat::reference::Integral;
use layersplat::settings::{Classification, Evaluation, Layered, Shading};
use layersplat::{Frame, Settings, Volume};

/// PSNR with eight samples per layer, 1 dB below the measured one.
const LEAST_APPROACHED: [(Kernel, f64); 4] =
    [(Kernel::Cubic, 83.5), (Kernel::Linear, 83.3), (Kernel::CatmullRom, 86.6), (Kernel::BSpline, 84.5)];
/// From this PSNR on, in dB, more samples may be worse: the rest are bends of the field between samples, and the steps of the integral.
const NEAR: f64 = 80.0;
/// Least difference to another kernel's integral in dB.
const TOLD_APART: f64 = 6.0;

fn psnr(a: &Frame, b: &Frame) -> f64 {
    compare(a, b).psnr.unwrap_or(f64::INFINITY)
}

/// Per pixel, more samples approach the integral.
#[test]
fn more_samples_per_layer_approach_the_kernels_own_integral() {
    let volume = Volume::open("builtin:hydrogen@40", &layersplat::OpenOptions::default()).unwrap();
    let (size, transfer) = (viewport(64, 64), smooth_transfer());
    for (camera, what) in
        [(parallel(&volume, size, 40.0, 25.0), "parallel"), (perspective(&volume, 40.0, 25.0, 40.0), "perspective")]
    {
        let truths = LEAST_APPROACHED.map(|(kernel, _)| {
            let mut integral = Integral::new(&volume, &transfer, None).with_kernel(kernel);
            integral.shading = Some(Shading::default());
            integral.render(&camera, size).unwrap()
        });
        for (n, (kernel, least)) in LEAST_APPROACHED.into_iter().enumerate() {
            let found = |samples_per_layer| {
                let classification = Classification::Preintegrated { kernel, samples_per_layer };
                let layered = Layered { evaluation: Evaluation::Direct, classification, ..Layered::default() };
                let settings = Settings { early_termination: false, ..closest(layered.into(), Some(Shading::default())) };
                render(&volume, &transfer, &camera, size, &settings)
            };
            let mut last: f64 = 0.0;
            for samples_per_layer in 1..=Classification::MAX_POINTS {
                let db = psnr(&found(samples_per_layer), &truths[n]);
                eprintln!("convergence, {what}, {kernel:?}, {samples_per_layer} samples per layer: {db:.1} dB");
                assert!(db > last.min(NEAR), "{what}, {kernel:?}, {samples_per_layer} samples: {db} dB after {last}");
                last = db;
            }
            assert!(last > least, "{what}, {kernel:?}: {last} dB with 8 samples per layer");
            let foreign = psnr(&found(Classification::MAX_POINTS), &truths[(n + 1) % truths.len()]);
            assert!(
                foreign < last - TOLD_APART,
                "{what}, {kernel:?}: another kernel's integral is {foreign} dB away, its own {last}"
            );
        }
    }
}
