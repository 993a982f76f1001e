//! The studio against a path tracer: mean square errors to two halves of it whose noise is independent.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{GradientEstimator, Kernel};
use layersplat::reference::{PathTracer, against_halves};
use layersplat::settings::{LightGrid, Look};
use layersplat::{Camera, Quality, Settings, TransferFunction, Volume};

/// Settings of the studio as the reference knows it.
fn studio(camera: &Camera) -> Settings {
    let settings = Settings::from(with_kernel(Quality::High, Kernel::Linear)).with_look(Look::Studio);
    Settings { gradient: Some(GradientEstimator::Central), ..settings.with_light_in_world(camera).unwrap() }
}

/// dB to the truth, and brightness relative to it, of every `stride`th pixel.
fn measured(
    (name, grid): (&str, LightGrid),
    (volume, transfer): &(Volume, TransferFunction),
    [size, stride]: [u32; 2],
    samples: usize,
) -> (f64, f64) {
    let size = viewport(size, size);
    let camera = parallel(volume, size, 30.0, 20.0);
    let settings = Settings { light_grid: grid, ..studio(&camera) };
    let halves = PathTracer::new(volume, transfer, &settings).halves(&camera, size, stride, samples).unwrap();
    let (error, brightness) = against_halves(&render(volume, transfer, &camera, size, &settings), &halves, stride);
    let decibels = -10.0 * error.max(1e-9).log10();
    println!("{name}, {grid:?}: {decibels:.1} dB, brightness {brightness:.3}");
    (decibels, brightness)
}

/// A dense ball with a translucent shell.
fn shell() -> (Volume<'static>, TransferFunction) {
    let n = 48;
    let value = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - DVec3::splat(23.5);
        (255.0 * ((20.0 - p.length()) / 12.0).clamp(0.0, 1.0)).round() as u8
    };
    let voxels = (0..n * n * n).map(value).collect();
    let colors = vec![(0.0, [0.9, 0.5, 0.4]), (150.0, [0.9, 0.6, 0.4]), (200.0, [1.0, 0.95, 0.9])];
    let opacities = vec![(20.0, 0.0), (60.0, 0.04), (150.0, 0.08), (200.0, 0.9)];
    (
        volume([n; 3], DVec3::ONE, layersplat::volume::Voxels::Uint8(voxels)),
        TransferFunction::new("shell", colors, opacities).unwrap(),
    )
}

/// Brightness relative to the truth may differ by this: cells are wider than the layer from which surfaces reflect.
const BRIGHTNESS: f64 = 0.06;

/// The noise of the paths is worth 1 dB here; the shell has 42.4 dB.
#[test]
fn shells_glow_as_they_do_in_truth() {
    let (decibels, brightness) = measured(("shell", LightGrid::Full), &shell(), [64, 2], 64);
    assert!(decibels > 39.0 && (brightness - 1.0).abs() < BRIGHTNESS, "{decibels} dB, {brightness}");
}

/// Measured: engine 46.9 and 45.3 dB, lobster 46.6 and 46.0; noise is worth 1 dB.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs the real data sets")]
fn data_sets_are_lit_as_in_truth() {
    for (name, grid, least) in [
        ("engine", LightGrid::Full, 41.0),
        ("engine", LightGrid::Quarter, 40.0),
        ("lobster", LightGrid::Full, 43.0),
        ("lobster", LightGrid::Quarter, 42.5),
    ] {
        let (decibels, brightness) = measured((name, grid), &data_set(name), [256, 4], 32);
        assert!(decibels > least && (brightness - 1.0).abs() < BRIGHTNESS, "{name}, {grid:?}: {decibels} dB, {brightness}");
    }
}
