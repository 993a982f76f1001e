//! Several fields in one picture, compared with the converged integral of their sum: on one grid, and on grids that are rotated and scaled
//! against each other. docs/guide/channels.md has the table.

use glam::{DAffine3, DMat3, DVec3};
use layersplat::device::DeviceChoice;
use layersplat::layers::Kernel;
use layersplat::reference::Sum;
use layersplat::renderer::{Channel, UploadedVolume};
use layersplat::settings::{Algorithm, AmbientOcclusion, Classification, Layered, Light, Lights, Shading, Shadows};
use layersplat::volume::Grid;
use layersplat::{Camera, Device, Frame, OpenOptions, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport, Volume};

const VIEWPORT: Viewport = Viewport { width: 88, height: 80 };
/// Of the sum, or at most `SLACK` below the worse of the fields alone.
const LEAST: f64 = 45.0;
const SLACK: f64 = 1.0;
/// Of fields that end within the common grid where they are visible. Their ends lie between voxels: 30 dB and more; without ends 11 dB.
const LEAST_WITH_ENDS: f64 = 29.0;

/// A field, its transfer function and its factor.
struct Placed {
    volume: Volume<'static>,
    transfer: TransferFunction,
    factor: f64,
}

impl Placed {
    fn new(source: &str, color: [f64; 3], factor: f64) -> Self {
        let volume = Volume::open(source, &OpenOptions::default()).unwrap();
        let (lo, hi) = volume.range();
        let at = |share: f64| lo + share * (hi - lo);
        let opacities = vec![(lo, 0.0), (at(0.3), 0.0), (at(0.6), 0.25), (hi, 0.4)];
        let transfer = TransferFunction::new("ramp", vec![(lo, color), (hi, [color[0], 1.0, color[2]])], opacities).unwrap();
        Self { volume, transfer, factor }
    }

    /// Makes all values visible.
    fn filled(self) -> Self {
        let opacities = self.transfer.opacities().iter().map(|&(value, opacity)| (value, opacity.max(0.03))).collect();
        Self { transfer: self.transfer.with_opacities(opacities).unwrap(), ..self }
    }

    fn at(self, transform: DAffine3) -> Self {
        let grid = self.volume.grid();
        let grid = Grid::from_affine(grid.dims(), transform * grid.index_to_world()).unwrap();
        Self { volume: self.volume.with_grid(grid).unwrap(), ..self }
    }

    fn channel(&self, device: &Device) -> Channel {
        Channel::new(&UploadedVolume::new(device, &self.volume).unwrap(), &self.transfer).with_factor(self.factor).unwrap()
    }
}

fn is_splatted(settings: &Settings) -> bool {
    matches!(settings.algorithm, Algorithm::Layered(Layered { classification: Classification::Post(_), .. }))
}

fn kernel(settings: &Settings) -> Kernel {
    match settings.algorithm {
        Algorithm::Layered(layered) => match layered.classification {
            Classification::Preintegrated { kernel, .. } => kernel,
            Classification::Post(_) => Kernel::Cubic,
        },
        Algorithm::Raycast { kernel, .. } => kernel,
        _ => panic!("no kernel"),
    }
}

/// The integral. Each field is reconstructed in its own voxels; splatted ones that do not have the grid of the finest are resampled before.
fn truth(fields: &[&Placed], settings: &Settings, camera: &Camera) -> Frame {
    let (kernel, shading) = (kernel(settings), settings.shading);
    let spacing = |field: &Placed| field.volume.grid().spacing().min_element();
    let finest = fields.iter().min_by(|a, b| spacing(a).total_cmp(&spacing(b))).unwrap().volume.grid();
    let sum = fields.iter().fold(Sum::default(), |sum, field| {
        if field.volume.grid() == finest || !is_splatted(settings) {
            sum.with_field(&field.volume, &field.transfer, field.factor, kernel)
        } else {
            sum.with_resampled_field(&field.volume, &field.transfer, field.factor)
        }
    });
    sum.with_shading(shading).render(camera, VIEWPORT).unwrap()
}

fn drawn(fields: &[&Placed], device: &Device, settings: &Settings, camera: &Camera) -> Frame {
    let channels: Vec<Channel> = fields.iter().map(|field| field.channel(device)).collect();
    Renderer::from_channels(&channels).unwrap().render(camera, VIEWPORT, settings).unwrap().0
}

/// PSNR in dB over RGBA.
fn psnr(one: &Frame, other: &Frame) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let squares: f64 = pairs.flat_map(|(a, b)| (0..4).map(|c| f64::from(a[c] - b[c]).powi(2)).collect::<Vec<_>>()).sum();
    -10.0 * (squares / (4 * one.pixels().len()) as f64).log10()
}

/// Fidelity of both fields together, and of each alone, over some views.
fn check(name: &str, fields: [&Placed; 2], settings: &Settings) {
    check_with(LEAST, name, fields, settings);
}

fn check_with(least: f64, name: &str, fields: [&Placed; 2], settings: &Settings) {
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let grid = fields[0].volume.grid();
    for (azimuth, elevation) in [(25.0, 20.0), (80.0, -35.0)] {
        let orbit = Orbit { azimuth, elevation, roll: 0.0 };
        let camera = Camera::fit_parallel(grid.centre(), 1.1 * grid.diagonal(), VIEWPORT, orbit);
        let fidelity = |fields: &[&Placed]| psnr(&drawn(fields, &device, settings, &camera), &truth(fields, settings, &camera));
        let [one, other, both] = [fidelity(&fields[..1]), fidelity(&fields[1..]), fidelity(&fields)];
        println!("{name}, azimuth {azimuth}: {one:.1} and {other:.1} alone, {both:.1} dB together");
        assert!(both >= least.min(one.min(other) - SLACK), "{name}, azimuth {azimuth}: {one}, {other}, {both}");
    }
    // Without the second field the picture is another.
    let camera =
        Camera::fit_parallel(grid.centre(), grid.diagonal(), VIEWPORT, Orbit { azimuth: 25.0, elevation: 20.0, roll: 0.0 });
    let alone = drawn(&fields[..1], &device, settings, &camera);
    assert!(psnr(&alone, &truth(&fields, settings, &camera)) < 35.0);
}

fn unlit(settings: Settings) -> Settings {
    Settings { shading: None, ..settings }
}

#[test]
fn two_fields_on_one_grid_have_the_integral_of_their_sum() {
    let fields =
        [Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0), Placed::new("builtin:gyroid@48", [0.1, 0.4, 0.9], 0.4)];
    let fields = fields.each_ref();
    check("standard", fields, &Quality::Standard.settings());
    check("high", fields, &Quality::High.settings());
    check("high, unlit", fields, &unlit(Quality::High.settings()));
    let raycast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
    check("ray casting", fields, &raycast);
}

/// Splatted layers, classified per pixel: on one grid, and with a coarse field that is rotated.
#[test]
fn splatted_fields_have_the_fidelity_of_each() {
    let layered = Layered { classification: Quality::High.splatted(), ..Quality::High.layered() };
    let settings = Settings { algorithm: layered.into(), ..Settings::default() };
    let fine = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0);
    check("post", [&fine, &Placed::new("builtin:gyroid@48", [0.1, 0.4, 0.9], 0.4)], &settings);
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.6);
    let transform = DAffine3 { matrix3: rotation * 2.5, translation: DVec3::new(10.0, 4.0, 2.0) };
    let coarse = Placed::new("builtin:gyroid@16", [0.1, 0.4, 0.9], 0.8).at(transform);
    check("post, rotated", [&fine, &coarse], &settings);
}

#[test]
fn a_coarse_field_that_is_rotated_in_a_fine_one() {
    let fine = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0);
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.6);
    let transform = DAffine3 { matrix3: rotation * 2.5, translation: DVec3::new(10.0, 4.0, 2.0) };
    let coarse = Placed::new("builtin:gyroid@16", [0.1, 0.4, 0.9], 0.8).at(transform);
    for fields in [[&fine, &coarse], [&coarse, &fine]] {
        check("standard, rotated", fields, &Quality::Standard.settings());
    }
    check("high, rotated, unlit", [&fine, &coarse], &unlit(Quality::High.settings()));
}

#[test]
fn fields_of_one_spacing_that_are_rotated() {
    let one = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0);
    let rotation = DMat3::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 0.5);
    let transform = DAffine3 { matrix3: rotation, translation: DVec3::new(-8.0, 2.0, 14.0) };
    let other = Placed::new("builtin:gyroid@48", [0.1, 0.4, 0.9], 0.4).at(transform);
    check("standard, one spacing", [&one, &other], &Quality::Standard.settings());
}

#[test]
fn fields_whose_background_is_visible_end_with_their_grids() {
    let fine = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0).filled();
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.6);
    let transform = DAffine3 { matrix3: rotation * 2.5, translation: DVec3::new(-18.0, 4.0, 2.0) };
    let coarse = Placed::new("builtin:gyroid@16", [0.1, 0.4, 0.9], 0.8).filled().at(transform);
    check_with(LEAST_WITH_ENDS, "standard, filled", [&fine, &coarse], &Quality::Standard.settings());
    check_with(LEAST_WITH_ENDS, "high, filled, unlit", [&fine, &coarse], &unlit(Quality::High.settings()));
    let raycast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
    check_with(LEAST_WITH_ENDS, "ray casting, filled", [&fine, &coarse], &raycast);
}

/// Shadows and ambient occlusion: rays to the lights pass through both fields. In small pictures, since these rays take long.
#[test]
fn two_fields_shade_each_other() {
    /// Light volumes interpolate between voxels, and have steps of 1/255.
    const LEAST_SHADED: f64 = 40.0;
    let size = Viewport { width: 32, height: 28 };
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let fields =
        [Placed::new("builtin:hydrogen@32", [0.9, 0.5, 0.1], 4.0), Placed::new("builtin:gyroid@32", [0.1, 0.4, 0.9], 1.0)];
    let grid = fields[0].volume.grid();
    let camera = Camera::fit_parallel(grid.centre(), 1.1 * grid.diagonal(), size, Orbit { azimuth: 25.0, ..Orbit::default() });
    let light = Light::towards(DVec3::new(-1.0, 1.2, 0.4));
    let shading = Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() });
    let shadows =
        Settings { shading, shadows: Some(Shadows { forgiveness: 1.0, ..Shadows::default() }), ..Quality::High.settings() };
    let occlusion = Some(AmbientOcclusion { reach: Some(8.0), gain: 1.5 });
    for (name, settings) in [("shadows", shadows), ("with occlusion", Settings { ambient_occlusion: occlusion, ..shadows })] {
        let psnr_of = |fields: &[&Placed]| {
            let channels: Vec<Channel> = fields.iter().map(|field| field.channel(&device)).collect();
            let drawn = Renderer::from_channels(&channels).unwrap().render(&camera, size, &settings).unwrap().0;
            let sum = fields.iter().fold(Sum::default(), |sum, field| {
                sum.with_field(&field.volume, &field.transfer, field.factor, kernel(&settings))
            });
            let apart = |sum: Sum| psnr(&drawn, &sum.render(&camera, size).unwrap());
            (apart(sum.clone().with_shadows(&settings)), apart(sum.with_shading(shading)))
        };
        let [[one, other], [both, unshaded]] =
            [fields.each_ref().map(|field| psnr_of(&[field]).0), psnr_of(&fields.each_ref()).into()];
        println!("{name}: {one:.1} and {other:.1} alone, {both:.1} dB together, {unshaded:.1} to the picture without");
        assert!(both >= LEAST_SHADED.min(one.min(other) - SLACK), "{name}: {one}, {other}, {both}");
        assert!(unshaded < 30.0, "missing shadows would be noticed: {unshaded}");
    }
}
