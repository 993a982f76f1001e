//! Shared test helpers: device, volumes, transfer functions, views and comparisons.
#![allow(dead_code, reason = "each test crate uses a part only")]

pub mod blends;
#[cfg(feature = "cli")]
pub mod command;
pub mod generated;
pub mod reference;
pub mod surfaces;

use glam::{DMat3, DVec3};
use layersplat::image::Comparison;
use layersplat::layers::{Correction, Density, Kernel, Ray, Rays};
use layersplat::renderer::Plan;
use layersplat::settings::{Algorithm, Classification, Evaluation, LayerAxis, Layered, Light, Lights};
use layersplat::volume::{Grid, Voxels};
use layersplat::{
    Camera, Device, DeviceChoice, Frame, Orbit, Projection, Quality, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::path::PathBuf;
use std::sync::LazyLock;

/// Splatted layers with two sub-layers, classified after interpolation.
pub const SPLATTED: Classification = Classification::Post(Correction::SubLayers(2));
/// Point-sampled layers, pre-integrated.
pub const POINTS: Classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 };
/// All combinations of sampling and classification of layers.
pub const CLASSIFICATIONS: [Classification; 3] =
    [SPLATTED, POINTS, Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 2 }];

/// The comparison algorithms of the paper.
pub const OTHERS: [Algorithm; 7] = [
    Algorithm::AxisSheets { layer_axis: LayerAxis::Auto },
    Algorithm::ViewSheets { sheet_distance: 1.0 },
    Algorithm::ViewSheets { sheet_distance: 0.5 },
    Algorithm::Slicing { step: 0.8 },
    Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 },
    Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.6 },
    Algorithm::Raycast { kernel: Kernel::Gaussian, step: 0.6 },
];

/// Ray casting in steps of 1/16: the converged integral on the device.
pub const CONVERGED: Algorithm = converged(Kernel::Cubic);

/// Ray casting in steps of 1/16 with any kernel.
pub const fn converged(kernel: Kernel) -> Algorithm {
    Algorithm::Raycast { kernel, step: 0.0625 }
}

/// A light of strength 1.
pub fn one_light(direction: DVec3) -> Lights {
    Lights::new(&[Light::towards(direction)]).unwrap()
}

/// Reconstruction kernel; splats and sheets are compared with the paper's cubic.
pub fn kernel_of(settings: &Settings) -> Kernel {
    match settings.algorithm {
        Algorithm::Layered(Layered { classification: Classification::Preintegrated { kernel, .. }, .. })
        | Algorithm::Raycast { kernel, .. } => kernel,
        _ => Kernel::Cubic,
    }
}

/// A quality with another kernel.
pub fn with_kernel(quality: Quality, kernel: Kernel) -> Layered {
    let own = quality.layered();
    let samples_per_layer = own.classification.samples_per_layer();
    Layered { classification: Classification::Preintegrated { kernel, samples_per_layer }, ..own }
}

/// Errors per sample: half an entry of 4096 in the table, and 1e-4 in the highlight's logarithm. Tens of samples add up. An 8-bit step is
/// 4e-3.
pub const DEVICE_TOLERANCE: f64 = 2e-3;

/// Device under test: `LAYERSPLAT_DEVICE`, or the default. All tests of a program, which run in parallel threads, share it, so that
/// kernels are built once.
pub fn device() -> Device {
    static DEVICE: LazyLock<Device> = LazyLock::new(own_device);
    DEVICE.clone()
}

/// Opens the device again, for tests that depend on its state.
pub fn own_device() -> Device {
    let choice = std::env::var("LAYERSPLAT_DEVICE").map_or(DeviceChoice::Default, DeviceChoice::Named);
    Device::open(&choice).expect("the tests need an OpenCL device: scripts/test installs PoCL")
}

/// A small generator (SplitMix64) with the same numbers on every platform.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 0 … 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Random bytes with surfaces: noise plus a bump in the centre.
pub fn random_bytes(dims: [usize; 3], seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    let mut values = Vec::new();
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            for i in 0..dims[0] {
                let p = DVec3::from_array(std::array::from_fn(|a| (([i, j, k][a] as f64 + 0.5) / dims[a] as f64 - 0.5) * 2.0));
                values.push(((1.0 - p.length() / 1.8) * 170.0 + random.unit() * 85.0).clamp(0.0, 255.0) as u8);
            }
        }
    }
    values
}

/// Layered options of settings.
pub fn layered(settings: Settings) -> Layered {
    settings.layered().expect("settings of layered rendering")
}

pub fn volume(dims: [usize; 3], spacing: DVec3, voxels: Voxels) -> Volume<'static> {
    Volume::new("test", Grid::new(dims, spacing).unwrap(), voxels).unwrap()
}

/// Random bytes with a background of 0.
pub fn random_volume(dims: [usize; 3], spacing: DVec3, seed: u64) -> Volume<'static> {
    volume(dims, spacing, Voxels::Uint8(random_bytes(dims, seed))).with_background(0.0).unwrap()
}

/// Each classification on its lattice and per pixel, and the other algorithms.
pub fn evaluations() -> Vec<Settings> {
    let settings = Settings { early_termination: false, ..Settings::default() };
    let evaluations = [Evaluation::Lattice(Density::AtLeast(2)), Evaluation::Direct];
    let choices = CLASSIFICATIONS.into_iter().flat_map(|c| evaluations.map(|e| (c, e)));
    choices
        .map(|(classification, evaluation)| Settings {
            algorithm: Layered { classification, evaluation, ..layered(settings) }.into(),
            ..settings
        })
        .chain(OTHERS.map(|algorithm| Settings { algorithm, ..settings }))
        .collect()
}

pub fn unshaded() -> Settings {
    Settings { shading: None, early_termination: false, ..Settings::default() }
}

/// A homogeneous volume with a background of 0.
pub fn cube(dims: [usize; 3], spacing: DVec3) -> Volume<'static> {
    volume(dims, spacing, Voxels::Uint8(vec![200; dims.iter().product()])).with_background(0.0).unwrap()
}

/// Colours and opacities without steps, for bytes; values below 20 are invisible.
pub fn smooth_transfer() -> TransferFunction {
    let colors = vec![(0.0, [0.1, 0.2, 0.9]), (90.0, [0.2, 0.9, 0.3]), (255.0, [1.0, 0.6, 0.1])];
    TransferFunction::new("smooth", colors, vec![(0.0, 0.0), (20.0, 0.0), (120.0, 0.15), (255.0, 0.5)]).unwrap()
}

/// A block of 255 in 0, opaque and of two hues: segments into it attenuate their own light.
pub fn block_of_hues() -> (Volume<'static>, TransferFunction) {
    let inside = |i: usize| (5..15).contains(&i);
    let block = |i: usize| if inside(i % 20) && inside(i / 20 % 20) && inside(i / 400) { 255 } else { 0 };
    let volume = volume([20; 3], DVec3::new(1.0, 0.9, 1.2), Voxels::Uint8((0..8000).map(block).collect()));
    let colors = vec![(0.0, [0.1, 0.2, 0.9]), (255.0, [0.9, 0.5, 0.1])];
    let hues = TransferFunction::new("hues", colors, vec![(0.0, 0.0), (30.0, 0.0), (60.0, 0.95), (255.0, 0.95)]).unwrap();
    (volume, hues)
}

/// White, with opacity `alpha` at and above `threshold`, transparent below.
pub fn step_transfer(threshold: f64, alpha: f64) -> TransferFunction {
    let opacities = vec![(0.0, 0.0), (threshold, 0.0), (threshold, alpha), (2.0 * threshold, alpha)];
    TransferFunction::new("step", vec![(0.0, [1.0; 3])], opacities).unwrap()
}

/// α = 1 − e^{−cρ}, whose τ is linear in the value, with 512 control points.
pub fn linear_extinction(c: f64) -> TransferFunction {
    let opacities = (0..=512).map(|i| f64::from(i) * 255.0 / 512.0).map(|v| (v, 1.0 - (-c * v).exp())).collect();
    TransferFunction::new("linear", vec![(0.0, [1.0; 3])], opacities).unwrap()
}

pub fn viewport(width: u32, height: u32) -> Viewport {
    Viewport::new(width, height).unwrap()
}

/// A parallel view that fits the volume in any orientation.
pub fn parallel(volume: &Volume, size: Viewport, azimuth: f64, elevation: f64) -> Camera {
    let orbit = Orbit { azimuth, elevation, roll: 0.0 };
    Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), size, orbit)
}

/// A perspective view that fits the volume in any orientation.
pub fn perspective(volume: &Volume, azimuth: f64, elevation: f64, field_of_view: f64) -> Camera {
    let orbit = Orbit { azimuth, elevation, roll: 0.0 };
    let square = viewport(1, 1);
    Camera::fit_perspective(volume.grid().centre(), volume.grid().diagonal(), field_of_view, square, orbit)
}

pub fn scaled(camera: Camera, scale: f64) -> Camera {
    Camera { projection: Projection::Parallel { scale }, ..camera }
}

/// The point of the screen that a ray passes through: centres of pixels at half-integers.
pub fn pixel_of(rays: &Rays, ray: &Ray) -> [f64; 2] {
    let [base, right, down] = if rays.is_parallel() { rays.origin } else { rays.direction };
    if rays.is_parallel() {
        let place = DMat3::from_cols(right, down, ray.direction).inverse() * (ray.origin - base);
        [place.x, place.y]
    } else {
        let place = DMat3::from_cols(right, down, base).inverse() * ray.direction;
        [place.x / place.z, place.y / place.z]
    }
}

pub fn render(volume: &Volume, transfer: &TransferFunction, camera: &Camera, size: Viewport, settings: &Settings) -> Frame {
    Renderer::new(&device(), volume, transfer).unwrap().render(camera, size, settings).unwrap().0
}

/// Layer axis of the direct plan of a view; `None` if each ray has its own.
pub fn direct_axis(volume: &Volume, camera: &Camera, size: Viewport, settings: &Settings) -> Option<layersplat::layers::Axis> {
    let rays = layersplat::layers::Rays::new(camera, size, volume.grid()).unwrap();
    let direct = Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(*settings) }.into(), ..*settings };
    match Plan::new(&rays, size, volume.grid(), &direct).unwrap() {
        Plan::Direct(axis, _) => axis,
        plan => panic!("{plan}"),
    }
}

pub fn compare(a: &Frame, b: &Frame) -> Comparison {
    a.compare(b).expect("pictures of one size")
}

/// Asserts that no channel, alpha included, differs by more than `tolerance`, and that the picture is not empty.
#[track_caller]
pub fn assert_close(what: &str, a: &Frame, b: &Frame, tolerance: f64) {
    let difference = compare(a, b).max_difference;
    assert!(difference <= tolerance, "{what}: differs by {difference}, more than {tolerance}");
    assert!(largest_opacity(a) > 0.02, "{what}: the picture is empty");
}

pub fn largest_opacity(frame: &Frame) -> f32 {
    frame.pixels().iter().map(|p| p[3]).fold(0.0, f32::max)
}

/// Shifts a frame by half a pixel to the right, which comparisons must detect.
pub fn shifted_by_half_a_pixel(frame: &Frame) -> Frame {
    let (w, h) = (frame.width(), frame.height());
    let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| {
        let (a, b) = (frame.pixel(x.saturating_sub(1), y), frame.pixel(x, y));
        std::array::from_fn(|c| (a[c] + b[c]) / 2.0)
    });
    Frame::new(viewport(w, h), pixels.collect())
}

/// Folder of real volumes and their transfer functions. Tests that need them carry `cfg_attr(not(real_volumes), ignore)`: build.rs sets
/// `real_volumes` if the folder exists.
pub fn real_volumes() -> PathBuf {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/volumes");
    std::env::var_os("LAYERSPLAT_VOLUMES").map_or(default.into(), PathBuf::from)
}

/// A file beside the real data sets, with a transfer function from the folder `../transfer`, or `fire`.
pub fn real(file: &str, spacing: Option<DVec3>, transfer: Option<&str>) -> (Volume<'static>, TransferFunction) {
    let folder = real_volumes();
    let options = layersplat::OpenOptions { spacing, ..Default::default() };
    let volume = Volume::open(folder.join(file).to_str().unwrap(), &options).unwrap();
    let transfer = match transfer {
        Some(name) => TransferFunction::from_file(&folder.join("../transfer").join(name), None).unwrap(),
        None => TransferFunction::builtin("fire", &volume).unwrap(),
    };
    (volume, transfer)
}

/// A real 8-bit data set with its transfer function, `../transfer/NAME.json` relative to the volumes' folder.
pub fn data_set(name: &str) -> (Volume<'static>, TransferFunction) {
    let folder = real_volumes();
    let is_it = |file: &str| file.starts_with(&format!("{name}_")) && file.contains("uint8");
    let mut files = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path());
    let file = files
        .find(|p| p.file_name().and_then(|n| n.to_str()).is_some_and(is_it))
        .unwrap_or_else(|| panic!("no {name} in {folder:?}"));
    let volume = Volume::open(file.to_str().unwrap(), &layersplat::OpenOptions::default()).unwrap();
    let transfer = TransferFunction::from_file(&folder.join("../transfer").join(format!("{name}.json")), None).unwrap();
    (volume, transfer)
}

/// The skull data set, which has a larger spacing along one axis.
pub fn skull() -> (Volume<'static>, TransferFunction) {
    real("cranium_ct_256x256x108_int16.raw.gz", Some(DVec3::new(0.957, 0.957, 1.5)), Some("cranium_ct_int16.json"))
}

/// Number of pixels that differ by more than a tolerance.
pub fn pixels_apart(a: &Frame, b: &Frame, tolerance: f64) -> usize {
    let apart = |(p, q): &(&[f32; 4], &[f32; 4])| p.iter().zip(*q).any(|(p, q)| f64::from((p - q).abs()) > tolerance);
    a.pixels().iter().zip(b.pixels()).filter(apart).count()
}
