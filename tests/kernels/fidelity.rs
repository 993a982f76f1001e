//! How near each kernel comes to what the voxels are samples of: Marschner and Lobb's signal, which is known everywhere, and data sets
//! whose halves are shown beside the whole.

use crate::common::*;
use crate::scene::{Scene, marschner_lobb, marschner_lobb_signal, whole_and_halved};
use layersplat::glam::DVec3;
use layersplat::layers::{Kernel, Rays};
use layersplat::settings::{Algorithm, Classification, Layered, Shading};
use layersplat::{Frame, Quality};

/// PSNR over RGB, in dB, of each of [`Kernel::OF_LAYERS`] in each of [`ways`].
type Measured = [[f64; 4]; 4];

/// Of a scene, unlit and lit.
struct Reached {
    unlit: Measured,
    lit: Measured,
}

/// The sizes of Marschner and Lobb's signal; the last one's steps are those of the truth.
const SIGNAL: [(usize, Reached); 3] = [
    (41, Reached { unlit: [[0.0; 4]; 4], lit: [[0.0; 4]; 4] }),
    (64, Reached { unlit: [[0.0; 4]; 4], lit: [[0.0; 4]; 4] }),
    (96, Reached { unlit: [[0.0; 4]; 4], lit: [[0.0; 4]; 4] }),
];
const HALVED: [(&str, Reached); 2] = [
    ("engine", Reached { unlit: [[0.0; 4]; 4], lit: [[0.0; 4]; 4] }),
    ("colin27_hires", Reached { unlit: [[0.0; 4]; 4], lit: [[0.0; 4]; 4] }),
];
/// How much less a picture may have, as in fidelity.rs.
const MARGIN: f64 = 1.0;

/// What the B-spline gains over the paper's cubic, both lit in `high`, at least: on the signal, and on data sets, whose halves have lost
/// what no kernel finds again.
const LEAST_GAIN: f64 = 3.0;
const LEAST_GAIN_OF_HALVES: f64 = 2.0;

/// The whole data set under its B-spline, on the device, and the host's integral of it: floats, and steps twice as long.
const LEAST_TRUTH: f64 = 50.0;
/// Every n-th pixel of it is looked at: a prime.
const EVERY: usize = 211;
const LIT: [Option<Shading>; 2] = [None, Some(Shading { ambient: 0.2, diffuse: 0.7, specular: 0.3, power: 20.0, light: None })];

fn psnr(a: &Frame, b: &Frame) -> f64 {
    compare(a, b).psnr.expect("not identical")
}

/// The qualities and ray casting, with a kernel.
fn ways(kernel: Kernel) -> [Algorithm; 4] {
    let layered = |quality: Quality| {
        let samples_per_layer = quality.layered().classification.samples_per_layer();
        let classification = Classification::Preintegrated { kernel, samples_per_layer };
        Layered { classification, ..quality.layered() }.into()
    };
    let [draft, standard, high] = [Quality::Draft, Quality::Standard, Quality::High].map(layered);
    [draft, standard, high, Algorithm::Raycast { kernel, step: 0.5 }]
}

/// Holds every kernel in every way against what was measured, and the B-spline's gain against a least one.
fn assert_reached(scene: &Scene, truths: &[Frame; 2], reached: &Reached, least_gain: f64) {
    let mut missed = Vec::new();
    for ((shading, truth), measured) in LIT.into_iter().zip(truths).zip([&reached.unlit, &reached.lit]) {
        let what = format!("{}, {}", scene.name, if shading.is_some() { "lit" } else { "unlit" });
        let found = Kernel::OF_LAYERS.map(|kernel| ways(kernel).map(|way| psnr(&scene.render(way, shading), truth)));
        for ((kernel, found), measured) in Kernel::OF_LAYERS.into_iter().zip(&found).zip(measured) {
            let row: Vec<String> = found.iter().map(|db| format!("{db:.1}")).collect();
            eprintln!("| {what} | {} | {} |", kernel.name(), row.join(" | "));
            if found.iter().zip(measured).any(|(found, measured)| *found < measured - MARGIN) {
                missed.push(format!("{what}, {kernel:?}: {found:.1?} dB for {measured:?}"));
            }
        }
        let high = |kernel| found[Kernel::OF_LAYERS.iter().position(|k| *k == kernel).unwrap()][2];
        let gain = high(Kernel::BSpline) - high(Kernel::Cubic);
        if shading.is_some() && gain < least_gain {
            missed.push(format!("{what}: the B-spline gains {gain:.1} dB"));
        }
        // Half a pixel away none of them is as near.
        let best = scene.render(ways(Kernel::BSpline)[2], shading);
        let [right, shifted] = [&best, &shifted_by_half_a_pixel(&best)].map(|frame| psnr(frame, truth));
        if shifted > right - MARGIN {
            missed.push(format!("{what}: half a pixel must be noticed, {shifted:.1} dB for {right:.1}"));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn kernels_come_near_marschner_and_lobbs_signal() {
    let [.., (most, _)] = SIGNAL;
    let fine = marschner_lobb(most);
    let truths = LIT.map(|shading| {
        let integral = fine.integral(shading).with_known(|p| marschner_lobb_signal(most, p));
        integral.render(&fine.camera, fine.size).unwrap()
    });
    for (n, reached) in &SIGNAL {
        assert_reached(&marschner_lobb(*n), &truths, reached, LEAST_GAIN);
    }
}

/// The signal is what the volume samples, and its gradient what it differs by.
#[test]
fn the_signal_is_that_of_the_volume() {
    /// Of bytes.
    const ROUNDED: f64 = 0.5 + 1e-6;
    let n = 41;
    let scene = marschner_lobb(n);
    for index in (0..n * n * n).step_by(97) {
        let p = DVec3::new((index % n) as f64, (index / n % n) as f64, (index / (n * n)) as f64);
        let (value, _) = marschner_lobb_signal(n, p);
        assert!((value - scene.volume.value(index)).abs() <= ROUNDED, "{value} at {p}");
        let place = p + DVec3::new(0.3, 0.1, 0.45);
        let (_, gradient) = marschner_lobb_signal(n, place);
        let at = |d: DVec3| marschner_lobb_signal(n, place + d).0;
        let h = 1e-4;
        let differences = DVec3::from_array(DVec3::AXES.map(|d| (at(h * d) - at(-h * d)) / (2.0 * h)));
        assert!((gradient - differences).length() < 1e-4, "{gradient} for {differences} at {place}");
    }
    let far = |n| marschner_lobb_signal(n, DVec3::new(7.3, 20.0, 31.0)).0;
    assert!((far(n) - far(n + 1)).abs() > 1.0, "another size is another signal");
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn halves_come_near_the_whole() {
    for (name, reached) in &HALVED {
        let [whole, halved] = whole_and_halved(name);
        let fine = Algorithm::Raycast { kernel: Kernel::BSpline, step: 0.125 };
        let truths = LIT.map(|shading| whole.render(fine, shading));
        // The larger one takes the host too long.
        if *name == "engine" {
            for (shading, truth) in LIT.into_iter().zip(&truths) {
                let db = psnr_on_the_host(&whole, shading, truth);
                assert!(db > LEAST_TRUTH, "{name}: {db} dB between the truths of device and host");
            }
        }
        assert_reached(&halved, &truths, reached, LEAST_GAIN_OF_HALVES);
    }
}

/// PSNR of the host's integral under the B-spline on every n-th pixel of a picture.
fn psnr_on_the_host(scene: &Scene, shading: Option<Shading>, picture: &Frame) -> f64 {
    let rays = Rays::new(&scene.camera, scene.size, scene.volume.grid()).unwrap();
    let integral = scene.integral(shading).with_kernel(Kernel::BSpline);
    let (mut squares, mut count) = (0.0, 0.0);
    for i in (0..picture.pixels().len()).step_by(EVERY) {
        let (x, y) = (i as u32 % picture.width(), i as u32 / picture.width());
        let expected = integral.composite(&rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5), rays.to_eye);
        squares += (0..3).map(|c| (expected[c] - f64::from(picture.pixel(x, y)[c])).powi(2)).sum::<f64>();
        count += 3.0;
    }
    -10.0 * (squares / count).log10()
}
