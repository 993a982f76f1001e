//! Fidelity of the presets, warp included, lit and unlit, to the converged integral: the tables in docs/dev/fidelity.md. `high` is compared with
//! the integral of the paper's cubic using that kernel, and with the integral of its own kernel. Lit presets as shipped are compared with the
//! integral of their own kernel and gradients.

use crate::common::*;
use layersplat::layers::{Correction, Kernel, Rays};
use layersplat::reference::Integral;
use layersplat::settings::{Algorithm, Classification, Evaluation, LayerAxis, Layered, Shading};
use layersplat::{Camera, Frame, GradientEstimator, OpenOptions, Quality, Settings, TransferFunction, Viewport, Volume};
use std::collections::HashMap;

/// Measured PSNR over RGB in dB, one number per entry of [`ways`].
type Measured<'a> = &'a [f64];

const UNLIT: [(&str, [f64; 9]); 5] = [
    ("fuel", [54.7, 63.7, 70.5, 54.5, 63.1, 65.0, 62.3, 65.3, 78.2]),
    ("neghip", [44.6, 51.7, 59.5, 43.9, 50.0, 52.1, 48.5, 52.6, 66.2]),
    ("lobster", [48.9, 58.4, 71.9, 48.5, 55.7, 57.9, 55.4, 58.4, 72.0]),
    ("engine", [47.5, 55.9, 66.2, 46.6, 52.6, 54.1, 51.5, 56.0, 66.4]),
    ("aneurism", [33.1, 41.5, 51.0, 32.9, 38.9, 42.2, 39.8, 41.5, 51.0]),
];
const LIT: [(&str, [f64; 14]); 5] = [
    ("fuel", [54.6, 59.2, 66.6, 54.5, 59.6, 59.7, 59.4, 59.5, 68.0, 63.2, 70.0, 56.4, 55.0, 49.8]),
    ("neghip", [46.6, 51.5, 57.2, 45.1, 48.8, 49.5, 47.7, 51.7, 59.2, 51.5, 59.1, 44.8, 42.8, 38.6]),
    ("lobster", [46.5, 52.8, 58.5, 45.8, 50.1, 50.9, 50.0, 52.8, 58.6, 52.5, 57.8, 46.9, 46.1, 42.2]),
    ("engine", [42.0, 49.9, 56.8, 41.0, 46.1, 47.2, 46.1, 49.9, 56.8, 49.9, 56.9, 44.3, 44.0, 38.7]),
    ("aneurism", [36.0, 44.2, 49.7, 35.4, 40.5, 42.4, 40.8, 44.2, 49.7, 41.8, 49.4, 36.3, 34.6, 27.7]),
];
const LIT_SKULL: [f64; 14] = [36.0, 44.5, 53.7, 33.0, 33.7, 33.8, 32.5, 35.9, 44.2, 44.3, 48.9, 39.8, 36.7, 30.4];
/// Kernels of `high` that are compared with their own integral.
const OWN: [Kernel; 2] = [Kernel::BSpline, Kernel::CatmullRom];
const OWN_UNLIT: [[f64; 2]; 5] = [[67.7, 67.1], [55.3, 55.1], [64.4, 64.9], [64.4, 64.8], [46.9, 47.1]];
const OWN_LIT: [[f64; 2]; 5] = [[67.1, 66.3], [52.5, 50.8], [62.2, 61.5], [58.3, 55.3], [53.6, 53.4]];
const OWN_LIT_SKULL: [f64; 2] = [52.3, 51.4];
/// Presets as shipped, lit, to the integral of their own kernel and gradients.
const SHIPPED: [Quality; 3] = [Quality::Draft, Quality::Standard, Quality::High];
const SHIPPED_LIT: [[f64; 3]; 5] =
    [[54.3, 57.9, 65.7], [47.7, 52.6, 58.5], [47.5, 51.8, 58.2], [42.5, 49.0, 57.1], [36.3, 43.7, 50.3]];
const SHIPPED_LIT_SKULL: [f64; 3] = [37.3, 45.2, 56.1];
/// PSNR of the engine's plate (43.8 if gradients at segment centres are corrected along rays only).
const PLATE: f64 = 50.0;
/// Tolerance of PSNR: differences between devices and vector widths are much smaller, a lost refinement step is larger.
const MARGIN: f64 = 1.0;
/// Tolerance of PSNR over RGBA relative to that measured over RGB.
const MARGIN_ALPHA: f64 = 3.0;

/// The integrals of device and host, unlit and lit, differ by rounding and by the nearest of 4096 table entries.
const LEAST_TRUTH: [f64; 2] = [80.0, 70.0];
/// Lit, with kernels that overshoot: their tables cover a wider range, with wider entries. A single ray that grazes an opaque surface gives
/// 62 dB in a picture of 128².
const LEAST_LIT_TRUTH_OF_OWN: f64 = 60.0;
/// Every n-th pixel is compared with the host's integral; a prime, so that all columns are covered.
const EVERY: usize = 101;

/// Least gain of pre-integration on a thin shell in dB: one sample over kappa, two over four sub-layers.
const LEAST_SHELL_GAIN: f64 = 4.0;

fn psnr(a: &Frame, b: &Frame) -> f64 {
    compare(a, b).psnr.expect("not identical")
}

/// Variants whose fidelity to the integral of the paper's cubic is documented, in the order of the tables.
fn ways() -> Vec<(String, Settings)> {
    let with = |quality: Quality, layered: Layered, what: &str| {
        (format!("{quality:?}{what}"), Settings { gradient: Some(GradientEstimator::Central), ..layered.into() })
    };
    let shipped = [Quality::Draft, Quality::Standard, Quality::High];
    let post = shipped.map(|q| with(q, Layered { classification: q.splatted(), ..q.layered() }, " post"));
    let cubic = |quality| with_kernel(quality, Kernel::Cubic);
    let per_pixel = [Quality::Standard, Quality::High]
        .map(|q| with(q, Layered { evaluation: Evaluation::Direct, ..cubic(q) }, " cubic per pixel"));
    let others = [
        Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 },
        Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 },
        Algorithm::Slicing { step: 1.0 },
        Algorithm::ViewSheets { sheet_distance: 1.0 },
        Algorithm::AxisSheets { layer_axis: LayerAxis::Auto },
    ];
    let shipped = shipped.map(|q| with(q, cubic(q), " cubic"));
    let paper = [with(Quality::Paper, Quality::Paper.layered(), "")];
    let others = others.map(|algorithm| (format!("{algorithm:?}"), algorithm.into()));
    shipped.into_iter().chain(post).chain(paper).chain(per_pixel).chain(others).collect()
}

/// PSNR of the host's integral on every n-th pixel of a picture.
fn psnr_on_the_host(
    volume: &Volume,
    transfer: &TransferFunction,
    view: View,
    (kernel, gradient): OwnField,
    picture: &Frame,
) -> f64 {
    let rays = Rays::new(&view.camera, view.size, volume.grid()).unwrap();
    let mut integral = Integral::new(volume, transfer, None).with_gradient(kernel, gradient);
    integral.shading = view.shading;
    let (mut squares, mut count) = (0.0, 0.0);
    for i in (0..picture.pixels().len()).step_by(EVERY) {
        let (x, y) = (i as u32 % picture.width(), i as u32 / picture.width());
        let expected = integral.composite(&rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5), rays.to_eye);
        squares += (0..3).map(|c| (expected[c] - f64::from(picture.pixel(x, y)[c])).powi(2)).sum::<f64>();
        count += 3.0;
    }
    -10.0 * (squares / count).log10()
}

/// A kernel and the estimation of gradients.
type OwnField = (Kernel, GradientEstimator);

/// A kernel with the gradients that fit it most closely.
fn most_closely(kernel: Kernel) -> OwnField {
    (kernel, GradientEstimator::for_kernel(kernel))
}

#[derive(Clone, Copy)]
struct View {
    camera: Camera,
    size: Viewport,
    shading: Option<Shading>,
}

impl View {
    fn picture(self, volume: &Volume, transfer: &TransferFunction, settings: Settings) -> Frame {
        render(volume, transfer, &self.camera, self.size, &Settings { shading: self.shading, ..settings })
    }

    /// Integral of a field on the device, verified against the host.
    fn truth(self, name: &str, volume: &Volume, transfer: &TransferFunction, (kernel, gradient): OwnField) -> Frame {
        let truth = self.picture(volume, transfer, Settings { gradient: Some(gradient), ..converged(kernel).into() });
        let least = match self.shading {
            None => LEAST_TRUTH[0],
            Some(_) if OWN.contains(&kernel) => LEAST_LIT_TRUTH_OF_OWN,
            Some(_) => LEAST_TRUTH[1],
        };
        let on_the_host = psnr_on_the_host(volume, transfer, self, (kernel, gradient), &truth);
        assert!(on_the_host > least, "{name} {}, {kernel:?}: {on_the_host} dB between the truths of device and host", self.lit());
        truth
    }

    fn lit(self) -> &'static str {
        if self.shading.is_some() { "lit" } else { "unlit" }
    }
}

/// Compares each variant with its measured fidelity, and `high` with other kernels with theirs; returns the integral.
fn assert_reached(
    name: &str,
    volume: &Volume,
    transfer: &TransferFunction,
    view: View,
    measured: Measured,
    own: [f64; 2],
) -> Frame {
    let (picture, lit) = (|settings| view.picture(volume, transfer, settings), view.lit());
    let truth = view.truth(name, volume, transfer, most_closely(Kernel::Cubic));
    let mut missed = Vec::new();
    let mut hold = |way: &str, frame: &Frame, truth: &Frame, measured: f64| {
        let (db, with_alpha) = (psnr(frame, truth), compare(frame, truth).psnr_rgba.expect("not identical"));
        eprintln!("fidelity {name} {lit} {way}: {db:.1} dB RGB, {with_alpha:.1} dB RGBA");
        if db < measured - MARGIN || with_alpha < measured - MARGIN_ALPHA {
            missed.push(format!("{name} {lit} {way}: {db:.1} dB, {with_alpha:.1} with alpha, for {measured}"));
        }
    };
    for ((way, settings), &measured) in ways().iter().zip(measured) {
        hold(way, &picture(*settings), &truth, measured);
    }
    for (kernel, measured) in OWN.into_iter().zip(own) {
        let (_, gradient) = most_closely(kernel);
        let frame = picture(Settings { gradient: Some(gradient), ..with_kernel(Quality::High, kernel).into() });
        let own = view.truth(name, volume, transfer, (kernel, gradient));
        hold(&format!("High {} to its own", kernel.name()), &frame, &own, measured);
        let (right, foreign) = (psnr(&frame, &own), psnr(&frame, &truth));
        assert!(foreign < right, "{name} {lit} {kernel:?}: {foreign} dB to Eq. 2's integral, {right} to its own");
    }
    assert!(missed.is_empty(), "{missed:#?}");
    let standard = picture(ways()[1].1);
    let [right, shifted] = [&standard, &shifted_by_half_a_pixel(&standard)].map(|frame| psnr(frame, &truth));
    assert!(shifted < right - MARGIN, "{name} {lit}: half a pixel must be noticed, {shifted} dB for {right}");
    truth
}

/// Compares each lit preset with its measured fidelity.
fn assert_shipped(name: &str, volume: &Volume, transfer: &TransferFunction, view: View, measured: [f64; 3]) {
    // The integrals of a kernel, with the preset's gradients and with those that fit the kernel most closely. `assert_reached` compares the
    // latter with the host.
    let mut integrals = HashMap::new();
    let found = SHIPPED.map(|quality| {
        let settings = quality.settings();
        let kernel = kernel_of(&settings);
        let [truth, other] = integrals.entry(kernel).or_insert_with(|| {
            let truth = view.truth(name, volume, transfer, (kernel, settings.gradient_estimator()));
            [truth, view.picture(volume, transfer, converged(kernel).into())]
        });
        let frame = view.picture(volume, transfer, settings);
        let [db, foreign] = [truth, other].map(|truth| psnr(&frame, truth));
        // The draft's own error is larger.
        assert!(
            quality == Quality::Draft || foreign < db - MARGIN,
            "{name} {quality:?}: other gradients must be noticed, {foreign} dB for {db}"
        );
        db
    });
    eprintln!("fidelity {name} lit, as shipped: {found:.1?} dB");
    assert!(found.iter().zip(measured).all(|(found, measured)| *found > measured - MARGIN), "{name}: {found:?} for {measured:?}");
}

/// The tables apply to the shipped presets.
#[test]
fn qualities_are_shipped_with_the_kernels_that_they_are_measured_with() {
    for (quality, kernel) in [(Quality::Draft, Kernel::Cubic), (Quality::Standard, Kernel::Cubic), (Quality::High, OWN[0])] {
        assert_eq!(with_kernel(quality, kernel), quality.layered());
    }
}

/// Name, measurements of [`ways`] per view, and measurements of [`OWN`].
type BuiltIn = (&'static str, [[f64; 14]; 4], [[f64; 2]; 4]);
/// The built-in volumes, unlit and lit, parallel and perspective.
const BUILT_IN: [BuiltIn; 2] = [
    (
        "hydrogen@48",
        [
            [62.6, 72.4, 83.4, 62.0, 69.1, 70.7, 68.7, 72.4, 83.4, 69.6, 86.2, 63.6, 60.5, 52.3],
            [60.7, 67.1, 77.2, 60.7, 67.6, 67.4, 68.9, 67.1, 77.2, 69.5, 77.2, 64.9, 62.4, 53.4],
            [59.6, 68.2, 73.4, 59.3, 67.6, 69.9, 68.6, 71.8, 83.0, 69.7, 87.0, 63.8, 60.7, 52.6],
            [58.1, 65.3, 72.1, 58.0, 65.9, 68.6, 68.1, 67.3, 77.3, 70.1, 78.4, 65.3, 62.7, 54.0],
        ],
        [[80.3, 80.3], [88.5, 81.8], [74.6, 74.9], [71.0, 71.3]],
    ),
    (
        "marschner-lobb@40x48x44",
        [
            [41.1, 45.9, 61.8, 40.6, 44.2, 46.3, 44.0, 45.8, 61.8, 42.4, 59.4, 36.5, 34.7, 30.6],
            [37.2, 38.8, 46.0, 35.5, 36.4, 36.7, 36.2, 38.8, 46.0, 41.9, 45.9, 32.0, 33.2, 33.4],
            [38.3, 42.1, 51.7, 38.0, 42.2, 45.2, 43.1, 44.3, 59.2, 42.3, 58.7, 36.2, 34.8, 30.1],
            [37.2, 38.0, 44.8, 34.9, 35.6, 36.3, 35.8, 38.4, 45.5, 41.9, 46.3, 32.1, 33.5, 33.1],
        ],
        [[50.8, 48.8], [44.4, 44.2], [49.0, 46.6], [42.3, 41.7]],
    ),
];

#[test]
fn every_way_reaches_what_was_measured_on_built_in_volumes() {
    let size = viewport(128, 128);
    for (name, measured, own) in BUILT_IN {
        let volume = Volume::open(format!("builtin:{name}"), &OpenOptions::default()).unwrap();
        let cameras = [parallel(&volume, size, 72.0, 20.0), perspective(&volume, 72.0, 20.0, 30.0)];
        let views = cameras.into_iter().flat_map(|camera| [(camera, None), (camera, Some(Shading::default()))]);
        for (((camera, shading), measured), own) in views.zip(measured).zip(own) {
            assert_reached(name, &volume, &smooth_transfer(), View { camera, size, shading }, &measured, own);
        }
    }
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn every_way_reaches_what_was_measured_lit() {
    let (size, shading) = (viewport(512, 512), Some(Shading::default()));
    for (((name, measured), own), shipped) in LIT.into_iter().zip(OWN_LIT).zip(SHIPPED_LIT) {
        let (volume, transfer) = data_set(name);
        let camera = parallel(&volume, size, 72.0, 20.0);
        assert_reached(name, &volume, &transfer, View { camera, size, shading }, &measured, own);
        assert_shipped(name, &volume, &transfer, View { camera, size, shading }, shipped);
    }
    let (volume, transfer) = skull();
    let camera = scaled(parallel(&volume, size, 30.0, 20.0), 70.0);
    assert_reached("skull", &volume, &transfer, View { camera, size, shading }, &LIT_SKULL, OWN_LIT_SKULL);
    assert_shipped("skull", &volume, &transfer, View { camera, size, shading }, SHIPPED_LIT_SKULL);
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn every_way_reaches_what_was_measured_unlit() {
    let size = viewport(512, 512);
    for ((name, measured), own) in UNLIT.into_iter().zip(OWN_UNLIT) {
        let (volume, transfer) = data_set(name);
        let camera = parallel(&volume, size, 72.0, 20.0);
        let truth = assert_reached(name, &volume, &transfer, View { camera, size, shading: None }, &measured, own);
        let found = |settings| psnr(&render(&volume, &transfer, &camera, size, &Settings { shading: None, ..settings }), &truth);
        let high = with_kernel(Quality::High, Kernel::Cubic);
        let with = |correction| Layered { classification: Classification::Post(correction), ..high }.into();
        let [with_kappa, without_kappa] = [Correction::SubLayers(4), Correction::None].map(|c| found(with(c)));
        assert!(without_kappa < with_kappa, "{name}: a missing kappa must cost, {without_kappa} dB");
        for settings in [with(Correction::SubLayers(4)), high.into()] {
            let wrong = found(Settings { unit_distance: Some(1.1), ..settings });
            let right = found(settings);
            assert!(wrong < right - MARGIN, "{name}: a wrong unit distance must be noticed, {wrong} dB for {right}");
        }
    }
}

/// The paper's comparison algorithms at their defaults, each against the integral of its own kernel. `high` with the paper's cubic is closer
/// to its integral. As shipped it is about as close, because its field has more curvature between two samples.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn high_is_nearer_to_its_integral_than_sheets_and_slices_to_theirs() {
    let size = viewport(512, 512);
    for (name, _) in UNLIT {
        let (volume, transfer) = data_set(name);
        let camera = parallel(&volume, size, 72.0, 20.0);
        let unshaded = Settings { shading: None, ..Settings::default() };
        let with = |algorithm| render(&volume, &transfer, &camera, size, &Settings { algorithm, ..unshaded });
        let truth = |kernel| with(converged(kernel));
        let high = [with_kernel(Quality::High, Kernel::Cubic), Quality::High.layered()].map(Settings::from);
        let [ours, shipped] = high.map(|high| psnr(&with(high.algorithm), &truth(kernel_of(&high))));
        let others = [
            (Algorithm::ViewSheets { sheet_distance: 1.0 }, Kernel::Gaussian),
            (Algorithm::Slicing { step: 1.0 }, Kernel::Linear),
            (Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }, Kernel::Gaussian),
        ];
        for (algorithm, kernel) in others {
            let theirs = psnr(&with(algorithm), &truth(kernel));
            let sheets = algorithm.name();
            eprintln!(
                "fidelity {name}: high {shipped:.1} dB, with cubic {ours:.1} dB, {sheets} {theirs:.1} dB, each to its own integral"
            );
            assert!(ours > theirs && shipped > theirs - MARGIN, "{name}: {ours} and {shipped} dB, {sheets} {theirs}");
        }
    }
}

/// The engine's plate, three voxels thick, with its face visible. Gradients reverse inside it and become weak in between.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn plates_are_lit_by_their_faces() {
    let size = viewport(512, 512);
    let (volume, transfer) = data_set("engine");
    let camera = parallel(&volume, size, 30.0, 20.0);
    let truth = render(&volume, &transfer, &camera, size, &converged(Kernel::BSpline).into());
    let high = Settings { gradient: Some(GradientEstimator::Own), ..Quality::High.settings() };
    let found = psnr(&render(&volume, &transfer, &camera, size, &high), &truth);
    eprintln!("fidelity plate of engine, lit: {found:.1} dB");
    assert!(found > PLATE - MARGIN, "{found} dB, not {PLATE}");
}

/// A thin shell of opacity: samples skip its values, so classification after interpolation misses it.
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
        |settings: Settings| psnr(&render(&volume, &shell, &camera, size, &Settings { shading: None, ..settings }), &truth);
    // Per pixel: the shell's edges are finer than any lattice.
    let high = Settings::from(Layered { evaluation: Evaluation::Direct, ..with_kernel(Quality::High, Kernel::Cubic) });
    let classified = [Classification::Post(Correction::Constant), Quality::High.splatted(), POINTS, layered(high).classification];
    let [kappa, sub_layers, once, twice] = classified
        .map(|classification| found(Settings { algorithm: Layered { classification, ..layered(high) }.into(), ..high }));
    eprintln!(
        "fidelity thin shell in engine: {kappa:.1} dB with kappa, {sub_layers:.1} with four sub-layers, pre-integrated {once:.1} \
         with one sample per layer, {twice:.1} with two"
    );
    assert!(once > kappa + LEAST_SHELL_GAIN && twice > sub_layers + LEAST_SHELL_GAIN, "{once}, {twice} dB");
}
