//! Volumes of colours and labels among fields of values, in one picture.

use crate::common::{compare, device, kernel_of};
use glam::{DMat3, DVec3};
use layersplat::layers::Kernel;
use layersplat::reference::Sum;
use layersplat::renderer::{Channel, ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::settings::{Algorithm, Light, Lights, Look, Shading, Shadows};
use layersplat::volume::Grid;
use layersplat::{Camera, Frame, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport, Volume};

const SIZE: Viewport = Viewport { width: 48, height: 40 };
/// Largest opacity whose extinction is exact.
const LARGEST_OPACITY: f64 = 0.99999;

/// A grid whose corner lies in the origin, or one that is rotated against it.
fn grid(rotated: bool) -> Grid {
    let spacing = DVec3::new(1.0, 1.2, 0.9);
    if !rotated {
        return Grid::new([24, 20, 28], spacing).unwrap();
    }
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.5);
    Grid::oriented([24, 20, 28], spacing, DVec3::new(-3.0, 2.0, 1.5), turned).unwrap()
}

/// A volume of bytes by position, from -1 to 1 along each axis.
fn bytes(grid: &Grid, value: impl Fn(DVec3) -> f64) -> Volume<'static> {
    let [x, y, z] = grid.dims();
    let centre = DVec3::new(x as f64 - 1.0, y as f64 - 1.0, z as f64 - 1.0) / 2.0;
    let at = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64);
    let voxels: Vec<u8> =
        (0..x * y * z).map(|n| (255.0 * value((at(n) - centre) / centre)).clamp(0.0, 255.0).round() as u8).collect();
    Volume::new("bytes", grid.clone(), voxels).unwrap()
}

/// Alpha of a soft ball around a hole.
fn ball(p: DVec3) -> f64 {
    0.6 * (1.0 - (3.0 * (p.length() - 0.6)).powi(2)).max(0.0)
}

fn components(grid: &Grid) -> Vec<Volume<'static>> {
    vec![
        bytes(grid, |p| 0.5 + 0.5 * p.x),
        bytes(grid, |p| 0.5 + 0.4 * (4.0 * p.y).sin()),
        bytes(grid, |p| 0.9 - 0.6 * p.z.abs()),
        bytes(grid, ball),
    ]
}

/// Extinction times red, green and blue, and extinction, from their definition.
fn emission(components: &[Volume]) -> [Volume<'static>; 4] {
    let grid = components[0].grid();
    let share = |volume: &Volume, n: usize| volume.value(n) / 255.0;
    std::array::from_fn(|c| {
        let value = |n: usize| {
            let extinction = -(1.0 - share(&components[3], n).min(LARGEST_OPACITY)).ln();
            (if c < 3 { extinction * share(&components[c], n) } else { extinction }) as f32
        };
        Volume::new("emission", grid.clone(), (0..grid.voxel_count()).map(value).collect::<Vec<_>>()).unwrap()
    })
}

/// The transfer function of extinctions: 1 - e^(-τ).
fn of_extinction(extinction: &Volume, color: [f64; 3]) -> TransferFunction {
    let (_, largest) = extinction.range();
    let opacities = (0..=1024).map(|n| largest * f64::from(n) / 1024.0).map(|tau| (tau, -(-tau).exp_m1())).collect();
    TransferFunction::new("extinction", vec![(0.0, color)], opacities).unwrap()
}

/// Opacities are alpha: these are not read.
fn unused() -> TransferFunction {
    TransferFunction::new("unused", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 1.0)]).unwrap()
}

fn colors(components: &[Volume]) -> Channel {
    Channel::from_colors(&UploadedColors::new(&device(), components, ColorOpacity::Alpha, &unused()).unwrap()).unwrap()
}

fn values(volume: &Volume, transfer: &TransferFunction) -> Channel {
    Channel::new(&UploadedVolume::new(&device(), volume).unwrap(), transfer)
}

/// A scan of values, whose voxels are bytes, and its transfer function.
fn scan() -> (Volume<'static>, TransferFunction) {
    let volume = bytes(&grid(false), |p| 0.5 + 0.5 * (3.0 * p.x).sin() * (2.0 * p.y + p.z).cos());
    let transfer = TransferFunction::new(
        "scan",
        vec![(0.0, [0.9, 0.5, 0.1]), (255.0, [0.9, 1.0, 0.1])],
        vec![(0.0, 0.0), (130.0, 0.0), (190.0, 0.1), (255.0, 0.2)],
    );
    (volume, transfer.unwrap())
}

fn cameras() -> [Camera; 3] {
    let (centre, diagonal) = (grid(false).centre(), 1.2 * grid(false).diagonal());
    let orbit = |azimuth, elevation| Orbit { azimuth, elevation, roll: 0.0 };
    let parallel = |azimuth, elevation| Camera::fit_parallel(centre, diagonal, SIZE, orbit(azimuth, elevation));
    [parallel(25.0, 20.0), parallel(80.0, -35.0), Camera::fit_perspective(centre, diagonal, 30.0, SIZE, orbit(200.0, 20.0))]
}

fn drawn(channels: &[Channel], camera: &Camera, settings: &Settings) -> Frame {
    Renderer::from_channels(channels).unwrap().render(camera, SIZE, settings).unwrap().0
}

fn psnr(one: &Frame, other: &Frame) -> f64 {
    compare(one, other).psnr.unwrap_or(f64::INFINITY)
}

fn largest_difference(one: &Frame, other: &Frame) -> f32 {
    let pairs = one.pixels().iter().zip(other.pixels());
    pairs.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs()).collect::<Vec<_>>()).fold(0.0, f32::max)
}

/// Layers and rays, and layers with shadows and in the studio.
fn methods() -> Vec<(&'static str, Settings)> {
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
    let shading =
        Some(Shading { lights: Lights::new(&[Light::towards(DVec3::new(-1.0, 1.2, 0.4))]).unwrap(), ..Shading::default() });
    let shadows = Settings { shading, shadows: Some(Shadows::default()), ..Quality::Standard.settings() };
    vec![
        ("standard", Quality::Standard.settings()),
        ("high", Quality::High.settings()),
        ("cast", cast),
        ("shadows", shadows),
        ("studio", Quality::Standard.settings().with_look(Look::Studio)),
    ]
}

/// A volume of one colour is a field of its extinction in that colour.
#[test]
fn one_color_is_that_of_a_transfer_function() {
    /// Of colours in bytes.
    const TOLERANCE: f32 = 0.5 / 255.0;
    let color = [204.0, 101.0, 51.0].map(|c| c / 255.0);
    let (volume, transfer) = scan();
    for rotated in [false, true] {
        let grid = grid(rotated);
        let [red, green, blue] = color.map(|c| bytes(&grid, |_| c));
        let components = [red, green, blue, bytes(&grid, ball)];
        let extinction = &emission(&components)[3];
        let field = values(extinction, &of_extinction(extinction, color));
        let [scan, colors] = [values(&volume, &transfer), colors(&components)];
        for (name, settings) in methods() {
            for camera in &cameras()[if rotated { 2..3 } else { 0..2 }] {
                let one = drawn(&[scan.clone(), colors.clone()], camera, &settings);
                let other = drawn(&[scan.clone(), field.clone()], camera, &settings);
                let apart = largest_difference(&one, &other);
                println!("rotated {rotated}, {name}: {apart:.1e}");
                assert!(apart <= TOLERANCE, "rotated {rotated}, {name}: {apart}");
                // Which comes first does not matter.
                let swapped = drawn(&[colors.clone(), scan.clone()], camera, &settings);
                let apart = largest_difference(&one, &swapped);
                assert!(rotated || apart <= 1e-5, "{name}, swapped: {apart}");
            }
        }
        let [camera, ..] = &cameras();
        let alone = drawn(&[scan], camera, &Settings::default());
        assert!(psnr(&alone, &drawn(&[values(&volume, &transfer), colors], camera, &Settings::default())) < 30.0);
    }
}

/// Two media of one colour and one extinction each: Beer-Lambert.
#[test]
fn two_media_absorb_by_beer_lambert() {
    /// Colours in bytes, and the half layers at both ends.
    const TOLERANCE: f32 = 3e-3;
    let (alpha, opacity) = (0.04, 0.02);
    let (color, other) = ([0.8, 0.2, 0.4], [0.1, 0.9, 0.6]);
    let grid = grid(false);
    let [red, green, blue] = color.map(|c| bytes(&grid, |_| c));
    let components = [red, green, blue, bytes(&grid, |_| alpha)];
    let values = values(
        &bytes(&grid, |_| 1.0).with_background(0.0).unwrap(),
        &TransferFunction::new("scan", vec![(0.0, other)], vec![(0.0, 0.0), (254.0, 0.0), (255.0, opacity)]).unwrap(),
    );
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 0.0, elevation: 0.0, roll: 0.0 });
    let unlit = Settings { shading: None, ..Settings::default() };
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Linear, step: 0.1 }, ..unlit };
    for settings in [unlit, cast] {
        let both = drawn(&[colors(&components), values.clone()], &camera, &settings);
        let pixel = both.pixels()[(SIZE.height / 2 * SIZE.width + SIZE.width / 2) as usize];
        let depths = [(10.0f64 / 255.0), opacity].map(|alpha| -(1.0 - alpha).ln());
        // Layers of 0.9 along z, the smallest spacing; 27 between the outer voxels of the values, which end at once.
        let exact = |layers: [f64; 2]| {
            let depth = layers[0] * depths[0] + layers[1] * depths[1];
            let mixed = |n: usize| (layers[0] * depths[0] * color[n] + layers[1] * depths[1] * other[n]) / depth;
            let opacity = 1.0 - (-depth).exp();
            [mixed(0) * opacity, mixed(1) * opacity, mixed(2) * opacity, opacity]
        };
        println!("{pixel:?}, {:?}", exact([28.0, 27.0]));
        for (c, exact) in exact([28.0, 27.0]).into_iter().enumerate() {
            assert!((pixel[c] - exact as f32).abs() <= TOLERANCE, "{c}: {} instead of {exact}", pixel[c]);
        }
    }
}

/// Against the integral in `f64`, beside a scan, on its grid and on one that is rotated against it.
#[test]
fn colors_beside_a_scan_have_the_integral_of_both() {
    /// PSNR in dB over RGBA, of what `standard`, `high` and rays in steps of 1/4 draw.
    const LEAST: [f64; 3] = [38.0, 40.0, 44.0];
    let (volume, transfer) = scan();
    for rotated in [false, true] {
        let components = components(&grid(rotated));
        let emission = emission(&components);
        let of_extinction = of_extinction(&emission[3], [1.0; 3]);
        let channels = [values(&volume, &transfer), colors(&components)];
        let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
        for (settings, least) in [Quality::Standard.settings(), Quality::High.settings(), cast].into_iter().zip(LEAST) {
            let kernel = kernel_of(&settings);
            let sum = |emission: [&Volume; 4]| {
                let sum = Sum::default().with_field(&volume, &transfer, 1.0, kernel);
                let sum = sum.with_colors(emission, &of_extinction, 1.0, kernel).with_shading(settings.shading);
                sum.render(&cameras()[0], SIZE).unwrap()
            };
            let one = drawn(&channels, &cameras()[0], &settings);
            let fidelity = psnr(&one, &sum(emission.each_ref()));
            println!("rotated {rotated}: {fidelity:.1} dB");
            assert!(fidelity >= least, "rotated {rotated}: {fidelity}");
            if !rotated {
                let swapped = psnr(&one, &sum([1, 0, 2, 3].map(|n: usize| &emission[n])));
                assert!(swapped < fidelity - 8.0, "{fidelity}, {swapped}");
            }
        }
    }
}

#[test]
fn a_hidden_field_changes_no_bit() {
    let (volume, transfer) = scan();
    for rotated in [false, true] {
        let [scan, colors] = [values(&volume, &transfer), colors(&components(&grid(rotated)))];
        let hidden = |channel: &Channel| channel.clone().with_visibility(false);
        for (name, settings) in methods() {
            let [camera, ..] = &cameras();
            for (one, other) in [(&scan, &colors), (&colors, &scan)] {
                let alone = drawn(std::slice::from_ref(one), camera, &settings);
                assert!(drawn(&[one.clone(), hidden(other)], camera, &settings) == alone, "{name}, rotated {rotated}");
                assert!(drawn(&[one.clone(), other.clone()], camera, &settings) != alone, "{name}, rotated {rotated}");
            }
        }
    }
}
