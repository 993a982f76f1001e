//! The look *studio* of several fields, of colours and of labels, against pictures of one field with the same matter.

use crate::common::{compare, device, volume};
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::renderer::{Channel, ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::settings::{Algorithm, Clipping, CropBox, GradientOpacity, Light, LightGrid, Lights, Look, Shading};
use layersplat::volume::{LabelSurfaces, Voxels};
use layersplat::{Camera, Frame, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport, Volume};

const SIZE: Viewport = Viewport { width: 48, height: 40 };
const DIMS: [usize; 3] = [26, 22, 24];
const SPACING: DVec3 = DVec3::new(1.0, 1.2, 0.9);
/// Largest difference of pictures of the same matter: other kernels round differently. The light is the same to half a bit of its words.
const SAME: f32 = 4e-3;
/// Smallest difference that other light makes.
const OTHER: f32 = 0.03;

/// A volume of bytes by position, from -1 to 1 along each axis.
fn bytes(value: impl Fn(DVec3) -> f64) -> Volume<'static> {
    let [x, y, z] = DIMS;
    let middle = DVec3::new(x as f64 - 1.0, y as f64 - 1.0, z as f64 - 1.0) / 2.0;
    let at = |n: usize| (DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64) - middle) / middle;
    volume(DIMS, SPACING, Voxels::Uint8((0..x * y * z).map(|n| (255.0 * value(at(n))).clamp(0.0, 255.0).round() as u8).collect()))
}

/// A soft ball in a bowl.
fn ball(p: DVec3) -> f64 {
    let bowl = if p.z < 0.2 { 1.0 - 6.0 * ((p.length() - 0.8).abs() - 0.05).max(0.0) } else { 0.0 };
    bowl.max(1.0 - 4.0 * (p.length() - 0.35).max(0.0)).max(0.0)
}

fn transfer(colors: [[f64; 3]; 2]) -> TransferFunction {
    let opacities = vec![(0.0, 0.0), (60.0, 0.0), (120.0, 0.15), (255.0, 0.7)];
    TransferFunction::new("ball", vec![(0.0, colors[0]), (255.0, colors[1])], opacities).unwrap()
}

const COLORS: [[f64; 3]; 2] = [[0.9, 0.4, 0.2], [0.95, 0.9, 1.0]];

fn channel(volume: &Volume, transfer: &TransferFunction) -> Channel {
    Channel::new(&UploadedVolume::new(&device(), volume).unwrap(), transfer)
}

fn camera(volume: &Volume) -> Camera {
    let orbit = Orbit { azimuth: 25.0, elevation: 20.0, roll: 0.0 };
    Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), SIZE, orbit)
}

fn drawn(channels: &[Channel], settings: &Settings) -> Frame {
    let volume = bytes(|_| 0.0);
    Renderer::from_channels(channels).unwrap().render(&camera(&volume), SIZE, settings).unwrap().0
}

fn largest_difference(one: &Frame, other: &Frame) -> f32 {
    let pairs = one.pixels().iter().zip(other.pixels());
    pairs.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs()).collect::<Vec<_>>()).fold(0.0, f32::max)
}

fn psnr(one: &Frame, other: &Frame) -> f64 {
    compare(one, other).psnr.unwrap_or(f64::INFINITY)
}

fn brightness(frame: &Frame) -> f32 {
    frame.pixels().iter().map(|pixel| pixel[0] + pixel[1] + pixel[2]).sum()
}

fn layers() -> Settings {
    Quality::Standard.settings().with_look(Look::Studio)
}

fn cast() -> Settings {
    Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..layers() }
}

/// Layers, also on quarter cells, cut and with gradient opacity; and rays.
fn methods() -> [(&'static str, Settings); 5] {
    let crop = Some(CropBox { lowest: DVec3::new(2.0, 3.5, 1.0), highest: DVec3::new(20.0, 15.0, 18.3) });
    let thinned = GradientOpacity::new(&[(0.0, 0.3), (0.05, 1.0)]).unwrap();
    [
        ("layers", layers()),
        ("quarter", Settings { light_grid: LightGrid::Quarter, ..layers() }),
        ("cropped", Settings { clipping: Clipping { crop, ..Clipping::default() }, ..layers() }),
        ("thinned", Settings { gradient_opacity: Some(thinned), ..layers() }),
        ("cast", cast()),
    ]
}

/// Two fields with half of the extinction each, and two that have the smaller and the larger values, are the whole.
#[test]
fn parts_of_a_field_scatter_as_the_whole() {
    let volume = bytes(ball);
    let whole = transfer(COLORS);
    let values = |shown: std::ops::RangeInclusive<f64>| {
        let shown = |n: i32| if shown.contains(&(f64::from(n) / 2.0)) { whole.opacity(f64::from(n) / 2.0) } else { 0.0 };
        whole.with_opacities((0..=510).map(|n| (f64::from(n) / 2.0, shown(n))).collect()).unwrap()
    };
    let one = channel(&volume, &whole);
    let half = || one.clone().with_factor(0.5).unwrap();
    let [smaller, larger] = [0.0..=180.0, 180.5..=255.0].map(|shown| channel(&volume, &values(shown)));
    for (name, settings) in methods() {
        let alone = drawn(std::slice::from_ref(&one), &settings);
        let apart = largest_difference(&drawn(&[half(), half()], &settings), &alone);
        let split = drawn(&[smaller.clone(), larger.clone()], &settings);
        let decibels = psnr(&split, &alone);
        let less = largest_difference(&drawn(&[half()], &settings), &alone);
        println!("{name}: {apart:.1e}, split {decibels:.1} dB; half of it {less:.2}");
        assert!(apart <= SAME, "{name}: {apart}");
        // The values between two entries are in both fields.
        assert!(decibels > 40.0, "{name}: {decibels} dB");
        assert!(less > OTHER, "{name}: {less}");
    }
}

/// What a field takes of the light is missing in the other.
#[test]
fn fields_shade_each_other() {
    let black = transfer([[0.0; 3]; 2]);
    let lower = channel(&bytes(|p| if p.y < 0.0 { ball(p) } else { 0.0 }), &transfer(COLORS));
    let upper = channel(&bytes(|p| if p.y < 0.2 { 0.0 } else { ball(p) }), &black);
    let [alone, both] = [vec![lower.clone()], vec![lower, upper]].map(|channels| drawn(&channels, &layers()));
    let rest = SIZE.width as usize * SIZE.height as usize * 3 / 4;
    let below = |frame: &Frame| -> f32 { frame.pixels()[rest..].iter().map(|pixel| pixel[0]).sum() };
    println!("{} with a black field above, {} without", below(&both), below(&alone));
    assert!(below(&both) < 0.95 * below(&alone) && below(&both) > 0.1 * below(&alone));
}

/// A volume of one colour, and labels of one colour, are a field of that colour.
#[test]
fn colors_and_labels_alone_are_lit_as_fields() {
    let color = [204.0, 101.0, 51.0].map(|c| c / 255.0);
    let alpha = bytes(|p| 0.6 * ball(p));
    let [red, green, blue] = color.map(|c| bytes(|_| c));
    let largest = -(1.0f64 - 0.6).ln();
    let extinction: Vec<f32> = (0..alpha.grid().voxel_count()).map(|n| -(1.0 - alpha.value(n) / 255.0).ln() as f32).collect();
    let opacities = (0..=1024).map(|n| largest * f64::from(n) / 1024.0).map(|tau| (tau, -(-tau).exp_m1())).collect();
    let of_extinction = TransferFunction::new("extinction", vec![(0.0, color)], opacities).unwrap();
    let unused = transfer([[1.0; 3]; 2]);
    let field = channel(&volume(DIMS, SPACING, Voxels::Float32(extinction)), &of_extinction);
    let colors = UploadedColors::new(&device(), &[red, green, blue, alpha], ColorOpacity::Alpha, &unused).unwrap();
    let labels = UploadedVolume::new(&device(), &bytes(|p| if ball(p) > 0.5 { 1.0 / 255.0 } else { 0.0 })).unwrap();
    let entries = [[0.0; 4], [color[0], color[1], color[2], 0.5]];
    let of_labels = |surfaces| UploadedColors::from_labels(&[(&labels, &entries)], surfaces).unwrap();
    for (name, settings) in methods() {
        let draw = |colors: &UploadedColors| {
            let camera = camera(&bytes(|_| 0.0));
            Renderer::from_colors(colors).unwrap().render(&camera, SIZE, &settings).unwrap().0
        };
        let (alone, of_field) = (draw(&colors), drawn(std::slice::from_ref(&field), &settings));
        let decibels = psnr(&alone, &of_field);
        let beside = largest_difference(&drawn(&[Channel::from_colors(&colors).unwrap()], &settings), &of_field);
        println!("{name}: colours {decibels:.1} dB, as a field {beside:.1e}");
        assert!(decibels > 42.0, "{name}: {decibels} dB");
        assert!(beside <= SAME, "{name}: {beside}");
        let [voxels, smooth] = [LabelSurfaces::Voxels, LabelSurfaces::Smooth].map(|surfaces| draw(&of_labels(surfaces)));
        let beside = drawn(&[Channel::from_colors(&of_labels(LabelSurfaces::Voxels)).unwrap()], &settings);
        let ratio = brightness(&smooth) / brightness(&voxels);
        println!("{name}: labels {:.1} dB, smooth ones {ratio:.3} times as bright", psnr(&beside, &voxels));
        assert!(psnr(&beside, &voxels) > 38.0, "{name}");
        assert!((ratio - 1.0).abs() < 0.1, "{name}: {ratio}");
    }
}

/// White lights light red, green and blue as coloured ones do that are nearly white.
#[test]
fn white_lights_are_as_bright_as_coloured_ones() {
    let volume = bytes(ball);
    let lights = |color| {
        let light = Light { color, ..Light::towards(DVec3::new(-1.0, 1.2, 0.4)) };
        Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() })
    };
    let [white, nearly] = [1.0, 1.0 - 1e-7].map(|c| {
        let settings = Settings { shading: lights([c; 3]), ..layers() };
        drawn(&[channel(&volume, &transfer(COLORS))], &settings)
    });
    assert!(largest_difference(&white, &nearly) < 1e-5);
}
