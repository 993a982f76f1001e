//! Volumes of colours and labels, compared with the converged integral of the interpolated extinctions and colours.

use glam::DVec3;
use layersplat::device::DeviceChoice;
use layersplat::layers::Kernel;
use layersplat::reference::{Colors, Sum};
use layersplat::renderer::{ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::settings::{
    Algorithm, Blend, Classification, Clipping, CropBox, Evaluation, GradientOpacity, Layered, Light, Lights, Shading, Shadows,
};
use layersplat::transfer::Extinction;
use layersplat::volume::{Grid, LabelSurfaces};
use layersplat::{
    Camera, Device, Error, Frame, GradientEstimator, Orbit, Projection, Quality, Renderer, Settings, TransferFunction, Viewport,
    Volume,
};

const VIEWPORT: Viewport = Viewport { width: 88, height: 80 };
/// PSNR in dB over RGBA: lit, with the samples of `standard`, and of `high`.
const LEAST: [f64; 2] = [40.0, 45.0];

fn device() -> Device {
    Device::open(&DeviceChoice::Default).unwrap()
}

fn grid() -> Grid {
    Grid::new([24, 20, 28], DVec3::new(1.0, 1.2, 0.9)).unwrap()
}

/// A volume of bytes by position, from -1 to 1 along each axis.
fn bytes(name: &str, value: impl Fn(DVec3) -> f64) -> Volume<'static> {
    let grid = grid();
    let [x, y, z] = grid.dims();
    let centre = DVec3::new(x as f64 - 1.0, y as f64 - 1.0, z as f64 - 1.0) / 2.0;
    let at = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64);
    let voxels: Vec<u8> = (0..x * y * z).map(|n| (255.0 * value((at(n) - centre) / centre)).clamp(0.0, 255.0) as u8).collect();
    Volume::new(name, grid, voxels).unwrap()
}

/// Red, green, blue and alpha: a soft ball whose hue turns, around a hole.
fn components() -> Vec<Volume<'static>> {
    vec![
        bytes("red", |p| 0.5 + 0.5 * p.x),
        bytes("green", |p| 0.5 + 0.4 * (4.0 * p.y).sin()),
        bytes("blue", |p| 0.9 - 0.6 * p.z.abs()),
        bytes("alpha", |p| 0.6 * (1.0 - (3.0 * (p.length() - 0.6)).powi(2)).max(0.0)),
    ]
}

/// The four fields as volumes, from their definition.
fn emission(components: &[Volume]) -> [Volume<'static>; 4] {
    let share = |volume: &Volume, n: usize| volume.value(n) / 255.0;
    std::array::from_fn(|c| {
        let voxels: Vec<f32> = (0..grid().voxel_count())
            .map(|n| {
                let extinction = -(1.0 - share(&components[3], n)).ln();
                (if c < 3 { extinction * share(&components[c], n) } else { extinction }) as f32
            })
            .collect();
        Volume::new("emission", grid(), voxels).unwrap()
    })
}

fn cameras() -> [Camera; 3] {
    let orbit = |azimuth| Orbit { azimuth, elevation: 20.0, roll: 0.0 };
    let (centre, diagonal) = (grid().centre(), grid().diagonal());
    let parallel = |azimuth| Camera::fit_parallel(centre, diagonal, VIEWPORT, orbit(azimuth));
    [parallel(25.0), parallel(75.0), Camera::fit_perspective(centre, diagonal, 30.0, VIEWPORT, orbit(200.0))]
}

fn psnr(one: &Frame, other: &Frame) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let squares: f64 = pairs.flat_map(|(a, b)| (0..4).map(|c| f64::from(a[c] - b[c]).powi(2)).collect::<Vec<_>>()).sum();
    -10.0 * (squares / (4 * one.pixels().len()) as f64).log10()
}

/// Ramps are never read: opacities are alpha.
fn unused() -> TransferFunction {
    TransferFunction::new("unused", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 1.0)]).unwrap()
}

fn opacity_of_extinction(emission: &[Volume; 4]) -> TransferFunction {
    let (_, largest) = emission[3].range();
    TransferFunction::new("extinction", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (largest, 0.9)]).unwrap()
}

#[test]
fn colors_have_the_integral_of_their_fields() {
    let device = device();
    let components = components();
    let emission = emission(&components);
    let transfer = opacity_of_extinction(&emission);
    let colors = UploadedColors::new(&device, &components, ColorOpacity::Alpha, &unused()).unwrap();
    let mut renderer = Renderer::from_colors(&colors).unwrap();
    for (quality, least) in [Quality::Standard, Quality::High].into_iter().zip(LEAST) {
        for shading in [None, quality.settings().shading] {
            let settings = Settings { shading, ..quality.settings() };
            let truth = Colors::new(emission.each_ref(), &transfer, Kernel::Cubic, GradientEstimator::for_kernel(Kernel::Cubic));
            let truth = truth.with_shading(shading);
            for camera in &cameras() {
                let drawn = renderer.render(camera, VIEWPORT, &settings).unwrap().0;
                let fidelity = psnr(&drawn, &truth.render(camera, VIEWPORT).unwrap());
                println!("{quality:?}, lit {}: {fidelity:.1} dB", shading.is_some());
                assert!(fidelity >= least, "{quality:?}, lit {}: {fidelity}", shading.is_some());
                // Culling changes nothing.
                let all = Settings { culling: false, ..settings };
                assert!(renderer.render(camera, VIEWPORT, &all).unwrap().0 == drawn);
            }
        }
    }
    // Swapped components would be noticed.
    let mut swapped = components;
    swapped.swap(0, 2);
    let colors = UploadedColors::new(&device, &swapped, ColorOpacity::Alpha, &unused()).unwrap();
    renderer.set_colors(&colors).unwrap();
    let unlit = Settings { shading: None, ..Settings::default() };
    let truth = Colors::new(emission.each_ref(), &transfer, Kernel::Cubic, GradientEstimator::for_kernel(Kernel::Cubic));
    let [camera, ..] = cameras();
    let drawn = renderer.render(&camera, VIEWPORT, &unlit).unwrap().0;
    assert!(psnr(&drawn, &truth.render(&camera, VIEWPORT).unwrap()) < 30.0);
}

/// Views that no lattice covers are cast: from within the volume, and at a very wide angle. So is every view on request.
#[test]
fn colors_are_seen_from_within_and_at_wide_angles() {
    /// PSNR in dB over RGBA: unlit, and lit. The light of a ridge of the extinction turns between two steps, of 1/8 of a spacing or 1/4.
    const LEAST: [f64; 2] = [60.0, 34.0];
    /// Lit, in steps of 1/20: the light converges, too.
    const LEAST_OF_FINE: f64 = 50.0;
    let size = Viewport { width: 48, height: 40 };
    let components = components();
    let emission = emission(&components);
    let transfer = opacity_of_extinction(&emission);
    let colors = UploadedColors::new(&device(), &components, ColorOpacity::Alpha, &unused()).unwrap();
    let mut renderer = Renderer::from_colors(&colors).unwrap();
    let orbit = |azimuth| Orbit { azimuth, elevation: 20.0, roll: 0.0 };
    let seen = |distance, azimuth, field_of_view| {
        Camera::orbit(grid().centre(), distance, orbit(azimuth), Projection::Perspective { field_of_view })
    };
    let fine = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.05 }, ..Settings::default() };
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::CatmullRom, step: 0.25 }, ..Settings::default() };
    let [parallel, ..] = cameras();
    let cases = [
        ("from within", seen(4.0, 30.0, 90.0), Settings::default()),
        ("from within, backwards", seen(9.0, 200.0, 60.0), Settings::default()),
        ("from within, backwards, in fine steps", seen(9.0, 200.0, 60.0), fine),
        ("wide", seen(20.0, 70.0, 150.0), Settings::default()),
        ("cast", parallel, cast),
    ];
    for (name, camera, settings) in cases {
        for shading in [None, settings.shading] {
            let settings = Settings { shading, ..settings };
            let truth = Colors::new(emission.each_ref(), &transfer, Kernel::Cubic, GradientEstimator::for_kernel(Kernel::Cubic));
            let truth = truth.with_shading(shading).render(&camera, size).unwrap();
            let drawn = renderer.render(&camera, size, &settings).unwrap().0;
            let fidelity = psnr(&drawn, &truth);
            println!("{name}, lit {}: {fidelity:.1} dB", shading.is_some());
            let least = if settings.algorithm == fine.algorithm { LEAST_OF_FINE } else { LEAST[usize::from(shading.is_some())] };
            assert!(fidelity >= least, "{name}, lit {}: {fidelity}", shading.is_some());
            assert!(truth.pixels().iter().any(|pixel| pixel[3] > 0.3), "{name}: something is seen");
            assert!(renderer.render(&camera, size, &Settings { culling: false, ..settings }).unwrap().0 == drawn, "{name}");
            // Swapped components would be noticed.
            let swapped = Colors::new(
                [1, 0, 2, 3].map(|n: usize| &emission[n]),
                &transfer,
                Kernel::Cubic,
                GradientEstimator::for_kernel(Kernel::Cubic),
            );
            let swapped = swapped.with_shading(shading).render(&camera, size).unwrap();
            assert!(psnr(&drawn, &swapped) < fidelity - 6.0, "{name}");
        }
    }
}

/// White colours are cast like a field with their extinction, lit, with depths, clipped, and with gradient opacity.
#[test]
fn white_colors_are_cast_like_their_extinction() {
    /// The field has a table of 4096 entries.
    const TOLERANCE: f32 = 2e-5;
    let size = Viewport { width: 48, height: 40 };
    let white = |name| bytes(name, |_| 1.0);
    let components = vec![white("red"), white("green"), white("blue"), components().remove(3)];
    let extinction = &emission(&components)[3];
    let (_, largest) = extinction.range();
    let opacities = (0..=4096).map(|n| largest * f64::from(n) / 4096.0).map(|tau| (tau, -(-tau).exp_m1())).collect();
    let transfer = TransferFunction::new("extinction", vec![(0.0, [1.0; 3])], opacities).unwrap();
    let mut colors =
        Renderer::from_colors(&UploadedColors::new(&device(), &components, ColorOpacity::Alpha, &unused()).unwrap()).unwrap();
    let mut field = Renderer::new(&device(), extinction, &transfer).unwrap();
    let camera = Camera::orbit(
        grid().centre(),
        9.0,
        Orbit { azimuth: 200.0, elevation: 20.0, roll: 0.0 },
        Projection::Perspective { field_of_view: 60.0 },
    );
    let base = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
    let crop = Some(CropBox { lowest: DVec3::new(2.0, 3.5, 1.0), highest: DVec3::new(20.0, 15.0, 21.3) });
    let thinned = GradientOpacity::new(&[(0.0, 0.3), (0.05, 1.0)]).unwrap();
    for (name, settings) in [
        ("lit", base),
        ("clipped", Settings { clipping: Clipping { crop, ..Clipping::default() }, ..base }),
        ("linear", Settings { extinction: Extinction::Linear, ..base }),
        ("thinned", Settings { gradient_opacity: Some(thinned), ..base }),
    ] {
        let [one, other] = [&mut colors, &mut field].map(|renderer| renderer.render(&camera, size, &settings).unwrap().0);
        let pairs = one.pixels().iter().zip(other.pixels());
        let largest = pairs.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max);
        println!("{name}: {largest:.1e} apart");
        assert!(largest <= TOLERANCE, "{name}: {largest}");
        assert!(one.pixels().iter().any(|pixel| pixel[3] > 0.3), "{name}: something is seen");
        let unlit = colors.render(&camera, size, &Settings { shading: None, ..settings }).unwrap().0;
        assert!(psnr(&unlit, &one) < 40.0, "{name}: light would be noticed");
    }
    // In layers, segments of colours are linear, while the table of the field knows the opacities between.
    let [parallel, ..] = cameras();
    let classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 2 };
    let layered = Layered { classification, adapts_to_opacity: false, ..Layered::default() };
    let linear = Settings { extinction: Extinction::Linear, shading: None, ..layered.into() };
    let [one, other] = [&mut colors, &mut field].map(|renderer| renderer.render(&parallel, VIEWPORT, &linear).unwrap().0);
    println!("linear extinction in layers: {:.1} dB", psnr(&one, &other));
    assert!(psnr(&one, &other) > 80.0, "{}", psnr(&one, &other));
    let exponential = Settings { extinction: Extinction::Exponential, ..linear };
    assert!(
        psnr(&one, &colors.render(&parallel, VIEWPORT, &exponential).unwrap().0) < 60.0,
        "another extinction would be noticed"
    );
}

/// White colours have the shadows of a field with their extinction.
#[test]
fn colors_cast_shadows() {
    /// In dB below the picture of that field, which is pre-integrated through a table.
    const SLACK: f64 = 1.0;
    let size = Viewport { width: 32, height: 28 };
    let white = |name| bytes(name, |_| 1.0);
    let components = vec![white("red"), white("green"), white("blue"), components().remove(3)];
    let extinction = &emission(&components)[3];
    let (_, largest) = extinction.range();
    let opacities = (0..=256).map(|n| largest * f64::from(n) / 256.0).map(|tau| (tau, -(-tau).exp_m1())).collect();
    let transfer = TransferFunction::new("extinction", vec![(0.0, [1.0; 3])], opacities).unwrap();
    let light = Light::towards(DVec3::new(-1.0, 1.2, 0.4));
    let shading = Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() });
    let shadows = Some(Shadows { forgiveness: 1.0, ..Shadows::default() });
    let settings = Settings { shading, shadows, ..Quality::High.settings() };
    let camera = Camera::fit_parallel(grid().centre(), grid().diagonal(), size, Orbit { azimuth: 25.0, ..Orbit::default() });
    let colors = UploadedColors::new(&device(), &components, ColorOpacity::Alpha, &unused()).unwrap();
    let drawn = Renderer::from_colors(&colors).unwrap().render(&camera, size, &settings).unwrap().0;
    let field = Renderer::new(&device(), extinction, &transfer).unwrap().render(&camera, size, &settings).unwrap().0;
    let sum = Sum::default().with_field(extinction, &transfer, 1.0, Kernel::Cubic);
    let truth = sum.clone().with_shadows(&settings).render(&camera, size).unwrap();
    let (shaded, of_field) = (psnr(&drawn, &truth), psnr(&field, &truth));
    let without = psnr(&drawn, &sum.with_shading(shading).render(&camera, size).unwrap());
    println!("colours with shadows: {shaded:.1} dB, the field {of_field:.1}, {without:.1} to the picture without");
    assert!(shaded >= of_field - SLACK && without < 25.0, "{shaded}, {of_field}, {without}");
}

/// A red half beside a transparent green one.
#[test]
fn transparent_voxels_do_not_bleed_their_color() {
    let left = |p: DVec3| f64::from(u8::from(p.x < 0.0));
    let components =
        [bytes("red", left), bytes("green", |p| 1.0 - left(p)), bytes("blue", |_| 0.0), bytes("alpha", |p| 0.5 * left(p))];
    let colors = UploadedColors::new(&device(), &components, ColorOpacity::Alpha, &unused()).unwrap();
    let mut renderer = Renderer::from_colors(&colors).unwrap();
    for kernel in [Kernel::Linear, Kernel::Cubic] {
        let classification = Classification::Preintegrated { kernel, samples_per_layer: 2 };
        let algorithm = Algorithm::Layered(Layered { classification, ..Layered::default() });
        let settings = Settings { algorithm, shading: None, ..Settings::default() };
        for camera in &cameras() {
            let frame = renderer.render(camera, VIEWPORT, &settings).unwrap().0;
            assert!(frame.pixels().iter().all(|pixel| pixel[1] == 0.0));
            assert!(frame.pixels().iter().any(|pixel| pixel[0] > 0.3));
        }
    }
}

/// Opacities of luminance and of the difference from a background, on a homogeneous volume: Beer-Lambert.
#[test]
fn opacities_come_from_luminance_or_background() {
    const TOLERANCE: f32 = 2e-3;
    let device = device();
    let components = [bytes("red", |_| 0.8), bytes("green", |_| 0.4), bytes("blue", |_| 0.2)];
    let [red, green, blue] = [204.0, 102.0, 51.0];
    let ramp = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 0.2)]).unwrap();
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let cases = [(ColorOpacity::Luminance, luminance), (ColorOpacity::FromBackground([0.0, 0.0, 1.0]), 204.0)];
    let grid = grid();
    let camera =
        Camera::fit_parallel(grid.centre(), grid.diagonal(), VIEWPORT, Orbit { azimuth: 0.0, elevation: 0.0, roll: 0.0 });
    for (opacity, value) in cases {
        let colors = UploadedColors::new(&device, &components, opacity, &ramp).unwrap();
        let mut renderer = Renderer::from_colors(&colors).unwrap();
        let frame = renderer.render(&camera, VIEWPORT, &Settings { shading: None, ..Settings::default() }).unwrap().0;
        let pixel = frame.pixels()[(VIEWPORT.height / 2 * VIEWPORT.width + VIEWPORT.width / 2) as usize];
        // Layers of 0.9 along z; the outermost half layers fade, and are as deep as one.
        let depth = 28.0 * 0.9 / 0.9 * (1.0f64 - 0.2 * value / 255.0).ln();
        let alpha = (1.0 - depth.exp()) as f32;
        assert!((pixel[3] - alpha).abs() <= TOLERANCE, "{opacity:?}: {} instead of {alpha}", pixel[3]);
        assert!((pixel[0] / pixel[3] - 0.8).abs() <= TOLERANCE);
    }
}

/// Vectors of one direction: its colour, and Beer-Lambert for the opacity of the norm. Zero vectors and those with a component that is not a
/// number are transparent.
#[test]
fn directions_are_colors() {
    const TOLERANCE: f32 = 2e-3;
    /// An invalid component where z is in this range of voxels, and zero vectors in the next.
    const INVALID: std::ops::Range<usize> = 0..4;
    const ZERO: std::ops::Range<usize> = 4..8;
    let device = device();
    let (vector, norm) = ([-6.0f32, 3.0, -2.0], 7.0);
    let [x, y, _] = grid().dims();
    let component = |n: usize, sign: f32| {
        let value = |index: usize| match index / x / y {
            z if INVALID.contains(&z) => [vector[0], f32::NAN, vector[2]][n],
            z if ZERO.contains(&z) => 0.0,
            _ => sign * vector[n],
        };
        Volume::new("flow", grid(), (0..grid().voxel_count()).map(value).collect::<Vec<f32>>()).unwrap()
    };
    let components = [0, 1, 2].map(|n| component(n, 1.0));
    let norms = layersplat::renderer::vector_norms(&components).unwrap();
    assert_eq!((norms.range(), norms.invalid()), ((0.0, norm), INVALID.len() * x * y));
    let transfer = TransferFunction::new("norm", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (2.0 * norm, 0.2)]).unwrap();
    let camera =
        Camera::fit_parallel(grid().centre(), grid().diagonal(), VIEWPORT, Orbit { azimuth: 0.0, elevation: 0.0, roll: 0.0 });
    let unlit = Settings { shading: None, ..Settings::default() };
    let draw = |components: &[Volume], transfer: &TransferFunction| {
        let colors = UploadedColors::from_vectors(&device, components, transfer).unwrap();
        let frame = Renderer::from_colors(&colors).unwrap().render(&camera, VIEWPORT, &unlit).unwrap().0;
        frame.pixels()[(VIEWPORT.height / 2 * VIEWPORT.width + VIEWPORT.width / 2) as usize]
    };
    let pixel = draw(&components, &transfer);
    // Layers along z. The half layers at both ends fade, and are as deep as one.
    let layers = (28 - INVALID.len() - ZERO.len()) as f64;
    let alpha = (1.0 - 0.9f64.powf(layers)) as f32;
    assert!((pixel[3] - alpha).abs() <= TOLERANCE, "{} instead of {alpha}", pixel[3]);
    for (n, exact) in [6.0, 3.0, 2.0].into_iter().enumerate() {
        assert!((pixel[n] / pixel[3] - exact / 7.0).abs() <= TOLERANCE, "component {n}: {pixel:?}");
    }
    // Opposite directions have one colour; another norm has another opacity.
    let opposite = [0, 1, 2].map(|n| component(n, -1.0));
    let turned = draw(&opposite, &transfer);
    assert_eq!(turned, pixel);
    assert!(draw(&components, &transfer.faded(0.5).unwrap()).map(f64::from)[3] < f64::from(alpha) - 0.1);
    // What are no vectors is refused.
    let two = UploadedColors::from_vectors(&device, &components[..2], &transfer);
    assert!(matches!(two, Err(Error::Settings { field: "colors", .. })));
}

/// Labels have their colours; a hidden one is not there.
#[test]
fn labels_have_their_colors() {
    let device = device();
    let labels = bytes("labels", |p| {
        if p.length() < 0.5 {
            2.5 / 255.0
        } else if p.length() < 0.8 {
            1.5 / 255.0
        } else {
            0.0
        }
    });
    let uploaded = UploadedVolume::new(&device, &labels).unwrap();
    let draw_with = |entries: &[[f64; 4]], surfaces| {
        let colors = UploadedColors::from_labels(&[(&uploaded, entries)], surfaces).unwrap();
        let mut renderer = Renderer::from_colors(&colors).unwrap();
        renderer.render(&cameras()[0], VIEWPORT, &Settings { shading: None, ..Settings::default() }).unwrap().0
    };
    let draw = |entries: &[[f64; 4]]| draw_with(entries, LabelSurfaces::Smooth);
    let centre = (VIEWPORT.height / 2 * VIEWPORT.width + VIEWPORT.width / 2) as usize;
    let outer = draw(&[[0.0; 4], [0.9, 0.1, 0.0, 0.9], [0.0, 0.2, 1.0, 1.0]]).pixels()[centre];
    assert!(outer[0] > 0.85 && outer[2] < 0.05, "{outer:?}");
    let inner = draw(&[[0.0; 4], [0.9, 0.1, 0.0, 0.0], [0.0, 0.2, 1.0, 1.0]]).pixels()[centre];
    assert!(inner[0] < 1e-6 && inner[2] > 0.95, "{inner:?}");
    // Layers that overlap: extinctions add, so that of two equal ones each may have half of it. Smooth surfaces share opacities.
    let colors: [[f64; 4]; 3] = [[0.0; 4], [0.9, 0.1, 0.0, 0.0], [0.0, 0.2, 1.0, 0.75]];
    let half = colors.map(|[r, g, b, opacity]| [r, g, b, 1.0 - (1.0 - opacity).sqrt()]);
    let layers = UploadedColors::from_labels(&[(&uploaded, &half), (&uploaded, &half)], LabelSurfaces::Voxels).unwrap();
    let unlit = Settings { shading: None, ..Settings::default() };
    let both = Renderer::from_colors(&layers).unwrap().render(&cameras()[0], VIEWPORT, &unlit).unwrap().0;
    let expected = draw_with(&colors, LabelSurfaces::Voxels);
    let pairs = both.pixels().iter().zip(expected.pixels());
    assert!(pairs.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max) < 1e-5);
    // Ids beyond the table.
    let error = UploadedColors::from_labels(&[(&uploaded, &[[0.0; 4]; 2])], LabelSurfaces::Smooth).err().unwrap();
    assert!(error.to_string().contains("label 2 has no colour"), "{error}");
}

#[test]
fn what_colors_do_not_have_is_refused() {
    let device = device();
    let components = components();
    let new = |components: &[Volume], opacity| UploadedColors::new(&device, components, opacity, &unused());
    assert!(matches!(new(&components[..3], ColorOpacity::Alpha), Err(Error::Settings { field: "colors", .. })));
    assert!(matches!(new(&components[..2], ColorOpacity::Luminance), Err(Error::Settings { field: "colors", .. })));
    let other = Volume::new("other", Grid::new([2; 3], DVec3::ONE).unwrap(), vec![1u8; 8]).unwrap();
    let mixed: Vec<Volume> = components.iter().take(2).cloned().chain([other]).collect();
    assert!(new(&mixed, ColorOpacity::Luminance).is_err());
    let signed = (0..3).map(|_| Volume::new("signed", grid(), vec![1i16; grid().voxel_count()]).unwrap()).collect::<Vec<_>>();
    assert!(new(&signed, ColorOpacity::Luminance).is_err());
    let mut renderer = Renderer::from_colors(&new(&components, ColorOpacity::Alpha).unwrap()).unwrap();
    for settings in [
        Settings { blend: Blend::Maximum, ..Settings::default() },
        Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Gaussian, step: 0.5 }, ..Settings::default() },
        Settings { algorithm: Algorithm::Slicing { step: 0.5 }, ..Settings::default() },
        Quality::Paper.settings(),
        Layered { evaluation: Evaluation::Direct, ..Layered::default() }.into(),
    ] {
        assert!(matches!(renderer.render(&cameras()[0], VIEWPORT, &settings), Err(Error::Settings { .. })));
    }
}
