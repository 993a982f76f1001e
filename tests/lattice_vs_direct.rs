//! The lattice, warped to the screen, against the same splat sums per pixel.

mod common;

use common::*;
use glam::DVec3;
use layersplat::layers::{Correction, Density, Rays};
use layersplat::renderer::Plan;
use layersplat::settings::{Classification, Evaluation, Layered};
use layersplat::{Camera, RawOptions, Settings, TransferFunction, Volume};

/// PSNR over RGBA of noise, the hardest case: its finest detail is two voxels, four to six samples.
const NOISE_PSNR: f64 = 38.0;
/// PSNR of a smooth volume.
const SMOOTH_PSNR: f64 = 50.0;

const VIEWS: [(f64, f64); 8] =
    [(0.0, 0.0), (45.0, 0.0), (0.0, 45.0), (30.0, 20.0), (120.0, -35.0), (-100.0, 10.0), (72.0, 70.0), (180.0, 0.0)];

fn smooth_volume() -> Volume<'static> {
    Volume::open("builtin:hydrogen@40x36x44", &RawOptions::default()).unwrap()
}

fn psnr(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) -> f64 {
    let size = viewport(96, 80);
    let direct = Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(*settings) }.into(), ..*settings };
    let rays = Rays::new(camera, size, volume.grid()).unwrap();
    assert!(!matches!(Plan::new(&rays, size, volume.grid(), settings).unwrap(), Plan::Direct(..)), "no lattice to compare");
    let [a, b] = [settings, &direct].map(|s| render(volume, transfer, camera, size, s));
    assert!(largest_opacity(&b) > 0.05);
    let shifted = compare(&shifted_by_half_a_pixel(&a), &b).psnr_rgba.expect("shifted pictures differ");
    let psnr = compare(&a, &b).psnr_rgba.unwrap_or(f64::INFINITY);
    assert!(psnr > shifted + 3.0, "half a pixel must be noticed: {psnr} dB, shifted {shifted} dB");
    psnr
}

#[test]
fn parallel_and_perspective_views() {
    let noise = random_volume([28, 33, 25], DVec3::new(1.0, 0.8, 1.2), 1);
    for (volume, limit) in [(noise, NOISE_PSNR), (smooth_volume(), SMOOTH_PSNR)] {
        for (azimuth, elevation) in VIEWS {
            for shading in [true, false] {
                let mut settings = Settings {
                    algorithm: Layered { evaluation: Evaluation::Lattice(Density::AtLeast(3)), ..Layered::default() }.into(),
                    ..Settings::default()
                };
                if !shading {
                    settings.shading = None;
                }
                let size = viewport(96, 80);
                for camera in [parallel(&volume, size, azimuth, elevation), perspective(&volume, azimuth, elevation, 20.0)] {
                    let found = psnr(&volume, &smooth_transfer(), &camera, &settings);
                    let what = format!("{} at {azimuth}, {elevation}, shading {shading}, {:?}", volume.name(), camera.projection);
                    assert!(found > limit, "{what}: {found} dB");
                }
            }
        }
    }
}

#[test]
fn more_samples_per_voxel_come_closer() {
    let volume = random_volume([28, 33, 25], DVec3::ONE, 2);
    let camera = parallel(&volume, viewport(96, 80), 30.0, 20.0);
    let at = |m| {
        psnr(
            &volume,
            &smooth_transfer(),
            &camera,
            &Settings {
                algorithm: Layered { evaluation: Evaluation::Lattice(Density::Fixed(m)), ..Layered::default() }.into(),
                ..Settings::default()
            },
        )
    };
    let found = [2, 4, 8].map(at);
    assert!(found[0] + 3.0 < found[1] && found[1] + 3.0 < found[2], "{found:?}");
}

/// The 45° switch: both layer axes forced on the same view at exactly 45° in voxel units.
fn popping(volume: &Volume, transfer: &TransferFunction, correction: Correction) -> f64 {
    use layersplat::layers::Axis;
    use layersplat::settings::LayerAxis;
    let size = viewport(256, 256);
    let camera = parallel(volume, size, 45.0, 0.0);
    let settings = Settings {
        algorithm: Layered {
            classification: Classification::Post(correction),
            evaluation: Evaluation::Lattice(Density::AtLeast(3)),
            ..Layered::default()
        }
        .into(),
        shading: None,
        ..Settings::default()
    };
    let [x, z] = [Axis::X, Axis::Z].map(|axis| {
        render(
            volume,
            transfer,
            &camera,
            size,
            &Settings { algorithm: Layered { layer_axis: LayerAxis::Forced(axis), ..layered(settings) }.into(), ..settings },
        )
    });
    compare(&x, &z).psnr.expect("the axes differ")
}

/// What κ must gain on every volume, in dB.
const LEAST_GAIN: f64 = 0.5;
/// And in the mean of the paper's data sets.
const LEAST_MEAN: f64 = 2.0;

/// Returns the mean gain.
fn assert_kappa_softens_the_switch(sets: impl IntoIterator<Item = (Volume<'static>, TransferFunction)>) -> f64 {
    let mut gains = Vec::new();
    for (volume, transfer) in sets {
        let without = popping(&volume, &transfer, Correction::None);
        let with = popping(&volume, &transfer, Correction::Constant);
        eprintln!("45° switch, {}: {without:.1} dB without kappa, {with:.1} dB with", volume.name());
        gains.push(with - without);
        assert!(with > without + LEAST_GAIN && with > 30.0, "{}: {without} dB without, {with} with kappa", volume.name());
    }
    gains.iter().sum::<f64>() / gains.len() as f64
}

#[test]
fn kappa_softens_the_switch_of_the_layer_axis() {
    let noise = random_volume([28, 33, 25], DVec3::ONE, 3);
    assert_kappa_softens_the_switch([(noise, smooth_transfer()), (smooth_volume(), smooth_transfer())]);
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn kappa_softens_the_switch_on_real_volumes() {
    let mean = assert_kappa_softens_the_switch(["fuel", "neghip", "lobster", "engine", "aneurism"].map(data_set));
    assert!(mean > LEAST_MEAN, "{mean} dB in the mean");
}
