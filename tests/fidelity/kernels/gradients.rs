//! Fidelity of gradient estimators to Marschner and Lobb's signal: what smoothing costs where nothing needs to be smoothed.

use super::fidelity::{LIT, MARGIN};
use super::scene::{marschner_lobb, marschner_lobb_signal};
use crate::common::*;
use layersplat::GradientEstimator::{self, Central, Gaussian, Own, Sobel};
use layersplat::{Kernel, Quality, Settings};

/// PSNR over RGB, in dB, of the estimators that fit a kernel most closely, of Sobel and of Gaussians of 0.7 and 1 voxels.
type Measured = [f64; 4];
/// Number of samples per axis; `standard`, `standard` with the linear kernel, and `high`.
const SIGNAL: [(usize, [Measured; 3]); 3] = [
    (41, [[21.0, 18.7, 18.8, 17.8], [20.9, 18.9, 18.9, 17.7], [28.2, 18.5, 18.6, 17.9]]),
    (64, [[27.8, 26.6, 25.9, 21.3], [27.7, 26.7, 26.1, 21.5], [36.7, 27.9, 26.8, 21.0]]),
    (96, [[32.3, 32.4, 32.1, 29.2], [32.6, 32.4, 32.1, 29.3], [43.0, 36.0, 35.1, 29.9]]),
];
const KERNELS: [(Quality, Kernel, GradientEstimator); 3] = [
    (Quality::Standard, Kernel::Cubic, Central),
    (Quality::Standard, Kernel::Linear, Central),
    (Quality::High, Kernel::BSpline, Own),
];

#[test]
fn smoothed_gradients_of_marschner_and_lobbs_signal() {
    let [.., (most, _)] = SIGNAL;
    let fine = marschner_lobb(most);
    let [_, shading] = LIT;
    let integral = fine.integral(shading).with_known(|p| marschner_lobb_signal(most, p));
    let truth = integral.render(&fine.camera, fine.size).unwrap();
    let mut missed = Vec::new();
    for (n, measured) in SIGNAL {
        let scene = marschner_lobb(n);
        for ((quality, kernel, own), measured) in KERNELS.into_iter().zip(measured) {
            let found = [own, Sobel, Gaussian(0.7), Gaussian(1.0)].map(|gradient| {
                let settings = Settings { shading, gradient: Some(gradient), ..with_kernel(quality, kernel).into() };
                compare(&scene.render_with(&settings), &truth).psnr.expect("not identical")
            });
            eprintln!("| {n}, {quality:?}, {} | {found:.1?} |", kernel.name());
            let [own, .., blurred] = found;
            if blurred > own - MARGIN || found.iter().zip(measured).any(|(found, measured)| *found < measured - MARGIN) {
                missed.push(format!("{n}, {quality:?}, {kernel:?}: {found:.1?} dB for {measured:?}"));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
