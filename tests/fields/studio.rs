//! The look *studio* of several fields, of colours and of labels, against pictures of one field with the same matter.

use crate::common::{compare, device, volume};
use glam::{DMat3, DVec3};
use layersplat::color::reflectance;
use layersplat::layers::Kernel;
use layersplat::renderer::{Channel, ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::settings::{
    Algorithm, Blend, Clipping, CropBox, GradientOpacity, Light, LightGrid, Lights, Look, Shading, Sky, Studio,
};
use layersplat::volume::{Grid, LabelSurfaces, Voxels};
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

/// Layers, also cut and with gradient opacity, and rays.
fn methods() -> [(&'static str, Settings); 3] {
    let crop = Some(CropBox { lowest: DVec3::new(2.0, 3.5, 1.0), highest: DVec3::new(20.0, 15.0, 18.3) });
    let thinned = GradientOpacity::new(&[(0.0, 0.3), (0.05, 1.0)]).unwrap();
    [
        ("layers", layers()),
        ("cut", Settings { clipping: Clipping { crop, ..Clipping::default() }, gradient_opacity: Some(thinned), ..layers() }),
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
        assert!(drawn(&[one.clone(), one.clone().with_factor(0.0).unwrap()], &settings) == alone, "{name}");
    }
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
    for (name, settings) in [("layers", layers()), ("cast", cast())] {
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

/// Colours on a grid whose axes are others scatter light where they are.
#[test]
fn colors_on_another_grid_scatter_where_they_are() {
    let hues = |n: usize| move |p: DVec3| if n == 3 { 0.5 * ball(p) } else { 0.5 + 0.5 * [p.x, p.y, p.z][n] };
    let own: Vec<_> = (0..4).map(|n| bytes(hues(n))).collect();
    // Voxel (i, j, k) of the other lies where (k, i, j) does.
    let [x, y, z] = DIMS;
    let axes = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let grid = Grid::oriented([y, z, x], DVec3::new(SPACING.y, SPACING.z, SPACING.x), own[0].grid().origin(), axes).unwrap();
    let turned = |volume: &Volume| {
        let at = |n: usize| volume.value((n / y / z) + x * (n % y + y * (n / y % z))) as u8;
        Volume::new("turned", grid.clone(), (0..x * y * z).map(at).collect::<Vec<_>>()).unwrap()
    };
    let colors = |components: &[Volume]| {
        let unused = transfer([[1.0; 3]; 2]);
        Channel::from_colors(&UploadedColors::new(&device(), components, ColorOpacity::Alpha, &unused).unwrap()).unwrap()
    };
    let scan = bytes(|p| 0.4 + 0.3 * p.x);
    let with = |scan: &Volume, components: &[Volume]| drawn(&[channel(scan, &transfer(COLORS)), colors(components)], &cast());
    let one = with(&turned(&scan), &own);
    let turned: Vec<_> = own.iter().map(turned).collect();
    let (other, swapped) = (with(&scan, &turned), with(&scan, &[1, 2, 0, 3].map(|n: usize| turned[n].clone())));
    let apart = largest_difference(&one, &other);
    println!("{apart:.1e}, with other colours {:.2}", largest_difference(&one, &swapped));
    assert!(apart <= SAME && largest_difference(&one, &swapped) > OTHER, "{apart}");
}

/// Points of a disc whose parts of equal area they stand for.
fn disc(count: usize) -> impl Iterator<Item = (f64, f64)> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |n| {
        let radius = ((n as f64 + 0.5) / count as f64).sqrt();
        (radius * (golden * n as f64).cos(), radius * (golden * n as f64).sin())
    })
}

/// Mean light over a ball that the camera sees, in red, green and blue: on its own, it shades nothing of itself.
fn light_on_ball(settings: &Settings) -> DVec3 {
    let (sky, lights) = (settings.studio.unwrap().sky, settings.shading.unwrap().lights);
    let at_height = |(x, y): (f64, f64)| DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
    let of_sky = |normal: DVec3| {
        let (u, v) = normal.any_orthonormal_pair();
        let radiance = |d: DVec3| sky.radiance((d.x * u + d.y * v + d.z * normal).y);
        disc(400).map(|at| radiance(at_height(at))).sum::<DVec3>() / 400.0
    };
    let of_lights = |normal: DVec3| {
        let each = lights.as_slice().iter().map(|light| {
            let facing = normal.dot(light.direction.unwrap().normalize()).max(0.0);
            light.strength * facing * DVec3::from_array(light.color)
        });
        each.sum::<DVec3>()
    };
    disc(400).map(at_height).map(|normal| of_sky(normal) + of_lights(normal)).sum::<DVec3>() / 400.0
}

/// A ball in the light of the studio, as a surface: no light comes from the ball itself, whatever it reflects.
#[test]
fn a_ball_has_the_light_of_its_surroundings() {
    /// Share of the light by which cells of two voxels are wrong.
    const WRONG: f64 = 0.04;
    let middle = (DVec3::from_array(DIMS.map(|n| n as f64)) - 1.0) / 2.0 * SPACING;
    let volume = bytes(|p| (160.0 + 10.0 * (8.0 - (p * middle).length())) / 255.0);
    let sky = Sky { top: [1.0; 3], bottom: [1.0; 3], strength: 1.0, ..Sky::default() };
    for grey in [0.9, 0.3] {
        let solid = TransferFunction::new("solid", vec![(0.0, [grey; 3])], vec![(160.0, 0.0), (160.001, 1.0)]).unwrap();
        let field = [channel(&volume, &solid)];
        for (name, settings) in [("layers", layers()), ("cast", cast())] {
            let shading = settings.shading.map(|shading| Shading { specular: 0.0, ..shading });
            let dark = Lights::new(&[Light { strength: 0.0, ..Light::from_camera(DVec3::X) }]).unwrap();
            let even = Settings {
                studio: Some(Studio { sky, ..Studio::default() }),
                shading: shading.map(|shading| Shading { lights: dark, ..shading }),
                ..settings
            };
            for (light, settings) in [("studio", Settings { shading, ..settings }), ("sky of 1", even)] {
                let mean = |settings: &Settings| {
                    let frame = drawn(&field, settings);
                    let sum = |c: usize| frame.pixels().iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
                    DVec3::new(sum(0), sum(1), sum(2)) / sum(3) / reflectance(grey)
                };
                let (found, exact) = (mean(&Settings { blend: Blend::Iso(160.0), ..settings }), light_on_ball(&settings));
                println!("{name}, {grey}, {light}: {:.3}", found / exact);
                assert!((found / exact - 1.0).abs().max_element() < WRONG, "{name}: {found} instead of {exact}");
            }
        }
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

/// Light begins from the same value whatever was drawn before, so pictures have the same bits.
#[test]
fn light_is_the_same_after_any_history() {
    let (volume, transfer) = (bytes(ball), transfer(COLORS));
    let (device, camera) = (device(), camera(&volume));
    let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
    let expected = renderer.render(&camera, SIZE, &layers()).unwrap().0;
    let sky = Sky { strength: 3.0, ..Sky::default() };
    let brighter = Settings { studio: Some(Studio { sky, ..Studio::default() }), ..layers() };
    for other in [Settings::default(), Settings { light_grid: LightGrid::Quarter, ..layers() }, brighter, cast()] {
        let between = renderer.render(&camera, SIZE, &other).unwrap().0;
        assert!(largest_difference(&between, &expected) > 0.0, "other settings change the picture");
        let again = renderer.render(&camera, SIZE, &layers()).unwrap().0;
        assert_eq!(again.pixels(), expected.pixels());
    }
}

/// Under a sky of 1, matter of any shape and opacity reflects about that sky at most.
#[test]
fn matter_reflects_no_more_than_its_sky() {
    /// Mean radiance and flux make light from two sides of an edge 13 % brighter than it is; white reflects 0.9 of it.
    const MOST: f32 = 1.12;
    let sky = Sky { top: [1.0; 3], bottom: [1.0; 3], strength: 1.0, ..Sky::default() };
    let own = layers();
    let lights = Lights::new(&[Light { strength: 0.0, ..Light::towards(DVec3::Z) }]).unwrap();
    let shading = own.shading.map(|own| Shading { lights, ..own });
    let settings = Settings { studio: Some(Studio { sky, ..Studio::default() }), shading, ..own };
    for (dims, spacing) in
        [([1, 1, 1], DVec3::ONE), ([1, 40, 1], DVec3::ONE), ([20, 20, 2], DVec3::new(1.0, 1.0, 20.0)), ([21; 3], DVec3::ONE)]
    {
        for opacity in [0.0, 0.05, 0.7, 1.0] {
            let volume = volume(dims, spacing, Voxels::Uint8(vec![200; dims.iter().product()])).with_background(0.0).unwrap();
            let opacities = vec![(0.0, 0.0), (200.0, opacity)];
            let transfer = TransferFunction::new("white", vec![(0.0, [1.0; 3])], opacities).unwrap();
            let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
            let frame = renderer.render(&camera(&volume), SIZE, &settings).unwrap().0;
            let within = |pixel: &[f32; 4]| pixel[..3].iter().all(|&color| (0.0..=MOST * pixel[3]).contains(&color));
            assert!(frame.pixels().iter().all(within), "{dims:?}, opacity {opacity}");
            let is_seen = frame.pixels().iter().any(|pixel| pixel[0] > 0.1 * pixel[3] && pixel[3] > 0.01);
            assert_eq!(is_seen, opacity > 0.0, "{dims:?}, opacity {opacity}");
        }
    }
}
