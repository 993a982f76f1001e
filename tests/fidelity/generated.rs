//! Fidelity of lit presets where the data sets of the other tests say little: generated volumes with noise, thin shells and terraces, and real
//! volumes with steep opacities or at 45°, between two layer axes (docs/dev/fidelity.md). Pictures are framed as the command does by default.

use crate::common::*;
use layersplat::framing::{Fixed, Framing, Orientation};
use layersplat::layers::Kernel;
use layersplat::settings::{Algorithm, Classification, Evaluation, Layered};
use layersplat::{Camera, Frame, GradientEstimator, Orbit, Quality, Settings, TransferFunction, Viewport, Volume};

const PRESETS: [Quality; 2] = [Quality::Standard, Quality::High];
/// Azimuth and elevation: between two layer axes, and oblique from below.
const VIEWS: [[f64; 2]; 2] = [[45.0, 20.0], [203.0, -28.0]];

/// A name, and per view and preset: PSNR over RGB in dB to the integral of the preset's kernel and gradients, and the roughness of the picture
/// relative to that with central differences.
type Measured = (&'static str, [[(f64, f64); 2]; 2]);
const GENERATED: [Measured; 3] = [
    ("noise", [[(47.2, 0.48), (53.0, 0.51)], [(47.9, 0.53), (55.5, 0.55)]]),
    ("walnut", [[(38.9, 0.50), (47.9, 0.81)], [(40.7, 0.75), (47.4, 0.88)]]),
    ("mr", [[(44.5, 0.55), (50.5, 0.64)], [(44.5, 0.61), (49.5, 0.66)]]),
];
/// Tolerance of PSNR in dB: differences between devices and vector widths are much smaller, a lost refinement step is larger.
const MARGIN: f64 = 1.0;
/// Tolerance of relative roughness, which follows the noise of few pixels; less than what Sobel gains anywhere.
const MARGIN_ROUGHNESS: f64 = 0.05;
/// Least fall in dB when an error is injected: more than the tolerance, so that the table notices the error. Central differences fall by 4.6 dB
/// and more, turned views by 2.0 and more.
const NOTICED: f64 = 1.5;

/// Degrees by which a view is turned as an injected error. `standard` is farther from its integral and needs more.
fn turn(quality: Quality) -> f64 {
    if quality == Quality::High { 0.5 } else { 1.0 }
}

fn psnr(a: &Frame, b: &Frame) -> f64 {
    compare(a, b).psnr.expect("not identical")
}

/// What a picture shows, and its size.
struct Scene {
    volume: Volume<'static>,
    transfer: TransferFunction,
    framing: Framing,
    size: Viewport,
}

impl Scene {
    fn new((volume, transfer): (Volume<'static>, TransferFunction), side: u32) -> Self {
        let framing = Framing::visible(&volume, &transfer, None);
        Self { volume, transfer, framing, size: viewport(side, side) }
    }

    fn camera(&self, orbit: Orbit) -> Camera {
        self.framing.parallel(orbit, self.size, Fixed::default())
    }

    fn picture(&self, camera: &Camera, gradient: GradientEstimator, algorithm: impl Into<Algorithm>) -> Frame {
        let settings = Settings { gradient: Some(gradient), ..algorithm.into().into() };
        render(&self.volume, &self.transfer, camera, self.size, &settings)
    }
}

fn orbit([azimuth, elevation]: [f64; 2]) -> Orbit {
    Orbit { azimuth, elevation, roll: 0.0 }
}

#[test]
fn presets_reach_what_was_measured_on_generated_volumes() {
    for ((name, volume, transfer), (measured_name, measured)) in generated::all().into_iter().zip(GENERATED) {
        assert_eq!(name, measured_name);
        let scene = Scene::new((volume, transfer), 256);
        for (view, measured) in VIEWS.into_iter().zip(measured) {
            for (quality, (measured, relative)) in PRESETS.into_iter().zip(measured) {
                let what = format!("{name} {view:?} {quality:?}");
                assert_preset(&what, &scene, orbit(view), quality, measured, relative);
            }
        }
    }
}

fn assert_preset(what: &str, scene: &Scene, orbit: Orbit, quality: Quality, measured: f64, relative: f64) {
    let (settings, camera) = (quality.settings(), scene.camera(orbit));
    let shipped = render(&scene.volume, &scene.transfer, &camera, scene.size, &settings);
    let truth = scene.picture(&camera, GradientEstimator::Sobel, converged(kernel_of(&settings)));
    let central = scene.picture(&camera, GradientEstimator::Central, quality.layered());
    let turned = scene.camera(Orbit { azimuth: orbit.azimuth + turn(quality), ..orbit });
    let turned = render(&scene.volume, &scene.transfer, &turned, scene.size, &settings);
    let [db, other, turned] = [&shipped, &central, &turned].map(|frame| psnr(frame, &truth));
    let [sobel, rough] = [&shipped, &central].map(|frame| frame.roughness().expect("a body in the picture"));
    let found = sobel / rough;
    eprintln!(
        "generated {what}: {db:.1} dB (central {other:.1}, turned {turned:.1}), roughness {sobel:.1}, {found:.2} of {rough:.1} with central"
    );
    assert!((db - measured).abs() < MARGIN, "{what}: {db} dB, not {measured}");
    assert!(other < db - NOTICED, "{what}: other gradients must be noticed, {other} dB for {db}");
    assert!(turned < db - NOTICED, "{what}: a turned view must be noticed, {turned} dB for {db}");
    assert!(found < relative + MARGIN_ROUGHNESS, "{what}: roughness {sobel} is {found} of {rough} with central, not {relative}");
}

/// Kernel and gradients of the held-out pictures.
const CUBIC: (Kernel, GradientEstimator) = (Kernel::Cubic, GradientEstimator::Central);
/// Measured PSNR over RGB in dB of the first three of [`ways_of_high`] to ray casting in steps of 1/16, and to the fourth.
type HeldOut = [[f64; 3]; 2];
const STEP: HeldOut = [[40.1, 36.4, 40.1], [48.3, 37.8, 48.3]];
const SKULL: HeldOut = [[53.5, 47.0, 56.0], [54.3, 47.2, 57.4]];
const SKULL_Z: HeldOut = [[51.2, 43.0, 54.8], [51.6, 43.0, 55.8]];

/// `high`, the same without adaptation to steep opacities, per pixel with eight samples per layer, and ray casting in a quarter of the
/// reference's steps.
fn ways_of_high() -> [Algorithm; 4] {
    let (kernel, _) = CUBIC;
    let high = with_kernel(Quality::High, kernel);
    let samples = |samples_per_layer| Classification::Preintegrated { kernel, samples_per_layer };
    [
        high.into(),
        Layered { adapts_to_opacity: false, ..high }.into(),
        Layered { classification: samples(8), evaluation: Evaluation::Direct, ..high }.into(),
        Algorithm::Raycast { kernel, step: 1.0 / 64.0 },
    ]
}

fn assert_held_out(name: &str, scene: &Scene, orbit: Orbit, measured: HeldOut) {
    let (kernel, gradient) = CUBIC;
    let camera = scene.camera(orbit);
    let truth = scene.picture(&camera, gradient, converged(kernel));
    let [high, plain, pixels, fine] = ways_of_high().map(|algorithm| scene.picture(&camera, gradient, algorithm));
    let found = [&truth, &fine].map(|truth| [&high, &plain, &pixels].map(|frame| psnr(frame, truth)));
    let turned = scene.camera(Orbit { azimuth: orbit.azimuth + turn(Quality::High), ..orbit });
    let turned = psnr(&scene.picture(&turned, gradient, with_kernel(Quality::High, kernel)), &truth);
    eprintln!(
        "held out {name}: high, without adaptation, per pixel with eight samples per layer: {:.1?} dB to steps of 1/16, {:.1?} to 1/64, which are \
         {:.1} apart; turned {turned:.1}",
        found[0],
        found[1],
        psnr(&fine, &truth)
    );
    let reached = found.iter().flatten().zip(measured.iter().flatten());
    assert!(
        reached.into_iter().all(|(found, measured)| (found - measured).abs() < MARGIN),
        "{name}: {found:?}, not {measured:?}"
    );
    assert!(turned < found[0][0] - NOTICED, "{name}: a turned view must be noticed, {turned} dB for {}", found[0][0]);
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn high_reaches_what_was_measured_on_held_out_pictures() {
    let (neghip, transfer) = data_set("neghip");
    let step = transfer.with_opacities(vec![(99.0, 0.0), (100.0, 1.0)]).unwrap();
    assert_held_out("step", &Scene::new((neghip, step), 512), orbit([42.0, 30.0]), STEP);
    let skull = Scene::new(skull(), 512);
    let view = orbit([45.0, 20.0]);
    assert_held_out("skull, y up", &skull, view, SKULL);
    let chosen = Orientation::of(skull.volume.grid()).frame();
    assert_held_out("skull, z up", &skull, chosen.orbit(view), SKULL_Z);
}
