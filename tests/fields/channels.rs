//! Several fields in one picture, compared with the converged integral of their sum: on one grid, and on grids that are rotated and scaled
//! against each other. docs/guide/channels.md has the table.

use crate::common::compare;
use glam::{DAffine3, DMat3, DVec3};
use layersplat::device::DeviceChoice;
use layersplat::layers::Kernel;
use layersplat::reference::Sum;
use layersplat::renderer::{Channel, UploadedColors, UploadedVolume};
use layersplat::settings::{
    Algorithm, AmbientOcclusion, Blend, Classification, DepthCue, Layered, Light, Lights, Shading, Shadows,
};
use layersplat::volume::{Grid, Label, LabelSurfaces, LabelTable, Labels, ScalarType, Voxels};
use layersplat::{
    Camera, Device, Frame, OpenOptions, Orbit, Projection, Quality, Renderer, Settings, TransferFunction, Viewport, Volume,
};

const VIEWPORT: Viewport = Viewport { width: 88, height: 80 };
/// Of the sum, or at most `SLACK` below the worse of the fields alone.
const LEAST: f64 = 45.0;
const SLACK: f64 = 1.0;

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
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let grid = fields[0].volume.grid();
    for (azimuth, elevation) in [(25.0, 20.0), (80.0, -35.0)] {
        let orbit = Orbit { azimuth, elevation, roll: 0.0 };
        let camera = Camera::fit_parallel(grid.centre(), 1.1 * grid.diagonal(), VIEWPORT, orbit);
        let fidelity = |fields: &[&Placed]| psnr(&drawn(fields, &device, settings, &camera), &truth(fields, settings, &camera));
        let [one, other, both] = [fidelity(&fields[..1]), fidelity(&fields[1..]), fidelity(&fields)];
        println!("{name}, azimuth {azimuth}: {one:.1} and {other:.1} alone, {both:.1} dB together");
        assert!(both >= LEAST.min(one.min(other) - SLACK), "{name}, azimuth {azimuth}: {one}, {other}, {both}");
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

/// Also thin structures keep their fidelity: sheets of two voxels.
#[test]
fn fields_of_one_spacing_that_are_rotated() {
    let one = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0);
    let rotation = DMat3::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 0.5);
    let transform = DAffine3 { matrix3: rotation, translation: DVec3::new(-8.0, 2.0, 14.0) };
    let other = Placed::new("builtin:gyroid@48", [0.1, 0.4, 0.9], 0.4).at(transform);
    check("standard, one spacing", [&one, &other], &Quality::Standard.settings());
    let sheets = Volume::new("sheets", Grid::new([40; 3], DVec3::ONE).unwrap(), Voxels::Uint8(sheets([40; 3]))).unwrap();
    let transfer = TransferFunction::new("sheets", vec![(0.0, [0.1, 0.6, 0.9])], vec![(60.0, 0.0), (200.0, 0.5)]).unwrap();
    let thin = Placed { volume: sheets, transfer, factor: 1.0 }.at(transform);
    check("standard, thin sheets", [&one, &thin], &Quality::Standard.settings());
}

/// Bent sheets, two voxels thick, of 255 in 0.
fn sheets(dims: [usize; 3]) -> Vec<u8> {
    let voxel = |n: usize| {
        let [x, y, z] = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| i as f64);
        let height = z + 3.0 * (0.2 * x).sin() + 2.0 * (0.3 * y).cos();
        (255.0 * (1.0 - (height.rem_euclid(10.0) - 5.0).abs()).max(0.0)) as u8
    };
    (0..dims.iter().product()).map(voxel).collect()
}

/// Fields whose voxels are shifted by whole ones are the same fields on one larger grid, for every way of drawing, also where light is swept.
/// All is 0 near their ends, where filters of voxels would see them.
#[test]
fn whole_voxels_apart_are_one_grid() {
    /// Positions of other sizes are rounded, also those of light.
    const TOLERANCE: f64 = 2e-3;
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let (dims, larger) = ([22, 18, 20], [33, 31, 29]);
    const MARGIN: usize = 5;
    let values = |seed: usize| {
        move |i: [usize; 3]| {
            let inside = (0..3).all(|axis| (MARGIN..dims[axis] - MARGIN).contains(&i[axis]));
            if inside { (((i[0] * 37 + i[1] * 59 + i[2] * 83 + seed * 41) * 2654435761) >> 7) as u8 } else { 0 }
        }
    };
    let transfer = |color| TransferFunction::new("even", vec![(0.0, color)], vec![(40.0, 0.0), (255.0, 0.3)]).unwrap();
    let at = [[0, 0, 0], [9, 11, 7]];
    let volumes = |first: [usize; 3], seed: usize| {
        let own = |n: usize| values(seed)([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]]);
        let spacing = DVec3::new(1.0, 0.8, 1.3);
        let origin = DVec3::from_array(first.map(|n| n as f64)) * spacing;
        let grid = Grid::oriented(dims, spacing, origin, DMat3::IDENTITY).unwrap();
        let small = Volume::new("own", grid, Voxels::Uint8((0..dims.iter().product()).map(own).collect())).unwrap();
        let padded = |n: usize| {
            let place = [n % larger[0], n / larger[0] % larger[1], n / larger[0] / larger[1]];
            let inside = (0..3).all(|i| (first[i]..first[i] + dims[i]).contains(&place[i]));
            if inside { values(seed)(std::array::from_fn(|i| place[i] - first[i])) } else { 0 }
        };
        let grid = Grid::new(larger, spacing).unwrap();
        (small, Volume::new("padded", grid, Voxels::Uint8((0..larger.iter().product()).map(padded).collect())).unwrap())
    };
    let [one, other] = [volumes(at[0], 1), volumes(at[1], 2)];
    let channels = |one: &Volume, other: &Volume| {
        [(one, [0.9, 0.4, 0.1]), (other, [0.1, 0.5, 0.9])]
            .map(|(volume, color)| Channel::new(&UploadedVolume::new(&device, volume).unwrap(), &transfer(color)))
    };
    let shading = Settings::default();
    let cases = [
        ("standard", Quality::Standard.settings()),
        ("high", Quality::High.settings()),
        ("cast", Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..shading }),
        ("shadows", Settings { shadows: Some(Shadows::default()), depth_cue: Some(DepthCue::default()), ..shading }),
        ("surfaces", Settings { blend: Blend::Iso(120.0), ..shading }),
        (
            "post",
            Settings { algorithm: Layered { classification: Quality::High.splatted(), ..Layered::default() }.into(), ..shading },
        ),
    ];
    let centre = one.1.grid().centre();
    for orbit in [(20.0, 15.0), (75.0, -10.0)].map(|(azimuth, elevation)| Orbit { azimuth, elevation, roll: 0.0 }) {
        for camera in [
            Camera::fit_parallel(centre, one.1.grid().diagonal(), VIEWPORT, orbit),
            Camera::fit_perspective(centre, one.1.grid().diagonal(), 35.0, VIEWPORT, orbit),
        ] {
            for (what, settings) in cases {
                let draw = |channels: &[Channel]| {
                    Renderer::from_channels(channels).unwrap().render(&camera, VIEWPORT, &settings).unwrap().0
                };
                let (apart, together) = (draw(&channels(&one.0, &other.0)), draw(&channels(&one.1, &other.1)));
                let error = compare(&apart, &together).max_difference;
                assert!(error <= TOLERANCE, "{what}: {error}");
                let wrong = one.0.clone().with_grid(Grid::new(dims, DVec3::new(1.0, 0.8, 1.3)).unwrap()).unwrap();
                assert!(compare(&draw(&channels(&wrong, &one.0)), &together).max_difference > 10.0 * TOLERANCE, "{what}");
            }
        }
    }
}

/// Maximum, minimum and average of fields on grids of their own: each over its own extent, as each alone, and their colours add. Colour maps
/// that do not begin in black would show rays beyond.
#[test]
fn gathered_values_are_those_of_each_extent() {
    /// Lattices differ; pixels near the outline of a field are left out.
    const LEAST_OF_SUM: f64 = 38.0;
    const NEAR: i64 = 3;
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.6);
    let transform = DAffine3 { matrix3: rotation * 1.7, translation: DVec3::new(-10.0, 4.0, 12.0) };
    let map = |from, to| TransferFunction::new("map", vec![(0.0, from), (255.0, to)], vec![(0.0, 0.1), (255.0, 0.1)]).unwrap();
    let smooth = |dims: [usize; 3]| -> Vec<u8> {
        let value = |n: usize| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| (0.4 * i as f64).sin());
        (0..dims.iter().product()).map(|n| (127.0 + 60.0 * value(n).iter().sum::<f64>() / 1.5) as u8).collect()
    };
    let placed = |dims: [usize; 3], transfer| Placed {
        volume: Volume::new("smooth", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Uint8(smooth(dims))).unwrap(),
        transfer,
        factor: 1.0,
    };
    let one = placed([30, 24, 26], map([0.3, 0.0, 0.0], [0.0, 0.4, 0.2]));
    let other = placed([15, 12, 13], map([0.0, 0.2, 0.3], [0.5, 0.1, 0.0])).at(transform);
    let grid = one.volume.grid();
    let camera =
        Camera::fit_parallel(grid.centre(), 1.3 * grid.diagonal(), VIEWPORT, Orbit { azimuth: 25.0, elevation: 20.0, roll: 0.0 });
    for blend in [Blend::Maximum, Blend::Minimum, Blend::Average] {
        let settings = Settings { blend, shading: None, ..Quality::High.settings() };
        let [first, second, both] =
            [&[&one][..], &[&other], &[&one, &other]].map(|fields| drawn(fields, &device, &settings, &camera));
        let (width, height) = (i64::from(VIEWPORT.width), i64::from(VIEWPORT.height));
        let at =
            |frame: &Frame, x: i64, y: i64| frame.pixels()[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize];
        let (mut squares, mut compared) = (0.0, 0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let is_even = |frame: &Frame| {
                let mut around = (-NEAR..=NEAR).flat_map(|j| (-NEAR..=NEAR).map(move |i| (i, j)));
                around.all(|(i, j)| at(frame, x + i, y + j)[3] == at(frame, x, y)[3])
            };
            if is_even(&first) && is_even(&second) {
                let [a, b, found] = [&first, &second, &both].map(|frame| at(frame, x, y));
                squares += (0..4).map(|c| f64::from((a[c] + b[c]).min(1.0) - found[c]).powi(2)).sum::<f64>();
                compared += 4;
            }
        }
        let fidelity = -10.0 * (squares / f64::from(compared)).log10();
        println!("{blend:?}: {fidelity:.1} dB of {compared} values");
        assert!(fidelity >= LEAST_OF_SUM && compared > 4 * 3000, "{blend:?}: {fidelity}");
        assert!(psnr(&both, &first) < 20.0 && psnr(&both, &second) < 20.0, "each is seen");
    }
}

/// A partner that is 45 times as fine lies in a few voxels of the other. Nothing is resampled, so that its grid may be as fine as it is.
#[test]
fn a_field_that_is_much_finer() {
    let coarse = Placed::new("builtin:hydrogen@16", [0.9, 0.5, 0.1], 1.0);
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.4);
    let fine = Placed::new("builtin:gyroid@32", [0.1, 0.4, 0.9], 1.0);
    let transform = DAffine3 { matrix3: turned * (1.0 / 45.0), translation: DVec3::new(7.0, 7.2, 6.8) };
    let fine = fine.at(transform);
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let settings = Quality::Standard.settings();
    let centre = fine.volume.grid().centre();
    let camera = Camera::fit_parallel(centre, 1.3 * fine.volume.grid().diagonal(), VIEWPORT, Orbit::default());
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: kernel(&settings), step: 0.25 }, ..settings };
    let fidelity =
        |fields: &[&Placed]| psnr(&drawn(fields, &device, &settings, &camera), &drawn(fields, &device, &cast, &camera));
    let fields = [&coarse, &fine];
    let [one, other, both] = [fidelity(&fields[..1]), fidelity(&fields[1..]), fidelity(&fields)];
    println!("45 times as fine: {one:.1} and {other:.1} alone, {both:.1} dB together");
    assert!(both >= one.min(other) - SLACK, "{one}, {other}, {both}");
    let pictures = [&[&coarse][..], &[&fine], &fields].map(|fields| drawn(fields, &device, &settings, &camera));
    let [without_fine, without_coarse] = [&pictures[0], &pictures[1]].map(|picture| psnr(picture, &pictures[2]));
    assert!(without_fine < 35.0 && without_coarse < 35.0, "each is seen: {without_fine}, {without_coarse}");
}

#[test]
fn fields_whose_background_is_visible_end_with_their_grids() {
    let fine = Placed::new("builtin:hydrogen@48", [0.9, 0.5, 0.1], 1.0).filled();
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.6);
    let transform = DAffine3 { matrix3: rotation * 2.5, translation: DVec3::new(-18.0, 4.0, 2.0) };
    let coarse = Placed::new("builtin:gyroid@16", [0.1, 0.4, 0.9], 0.8).filled().at(transform);
    check("standard, filled", [&fine, &coarse], &Quality::Standard.settings());
    check("high, filled, unlit", [&fine, &coarse], &unlit(Quality::High.settings()));
    let raycast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 }, ..Settings::default() };
    check("ray casting, filled", [&fine, &coarse], &raycast);
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

/// Labels beside a scan: the ball's silhouette has its radius, whatever its opacity, and the scan is seen, too.
#[test]
fn labels_are_surfaces_beside_a_scan() {
    const RADIUS: f64 = 9.3;
    /// In voxels.
    const TOLERANCE: f64 = 0.2;
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let grid = Grid::new([32; 3], DVec3::ONE).unwrap();
    let is_inside =
        |n: usize| DVec3::new((n % 32) as f64, (n / 32 % 32) as f64, (n / 1024) as f64).distance(DVec3::splat(15.4)) < RADIUS;
    let ids: Vec<u8> = (0..32 * 32 * 32).map(|n| if is_inside(n) { 7 } else { 0 }).collect();
    let labels = |label: Label| {
        let table = LabelTable::new([label]).unwrap();
        Labels::from_numbers("ball", grid.clone(), ids.clone(), ScalarType::Uint8, table).unwrap()
    };
    let scan = Placed::new("builtin:gyroid@16", [0.2, 0.9, 0.4], 1.0).at(DAffine3::from_translation(DVec3::splat(40.0)));
    let size = Viewport::new(120, 120).unwrap();
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), size, Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 });
    let Projection::Parallel { scale } = camera.projection else { panic!("a parallel view") };
    let pixel = 2.0 * scale / 120.0;
    for opacity in [1.0, 0.3, 0.05] {
        let labels = labels(Label { opacity, ..Label::new(7) });
        let [layer] = labels.layers() else { panic!("one layer") };
        let indices = UploadedVolume::new(&device, &layer.indices(None).unwrap()).unwrap();
        let colors = UploadedColors::from_labels(&[(&indices, &layer.palette())], LabelSurfaces::Smooth).unwrap();
        let ball = Channel::from_colors(&colors).unwrap();
        for channels in [vec![scan.channel(&device), ball.clone()], vec![ball.clone()]] {
            let settings = Settings { shading: None, early_termination: false, ..Quality::High.settings() };
            let frame = Renderer::from_channels(&channels).unwrap().render(&camera, size, &settings).unwrap().0;
            // Around the ball alone.
            let centre = frame.pixel(60, 60)[3];
            assert!(centre > 0.5 * (1.0 - (1.0 - opacity as f32).powf(2.0 * RADIUS as f32)), "{opacity}: {centre}");
            let rim = 1.0 - (1.0 - opacity.min(0.999)).powf(2.0);
            let area = frame.pixels().iter().filter(|pixel| f64::from(pixel[3]) >= 0.5 * rim).count() as f64 * pixel * pixel;
            let radius = (area / std::f64::consts::PI).sqrt();
            println!("opacity {opacity}, {} fields: radius {radius:.2}", channels.len());
            if channels.len() == 1 {
                assert!((radius - RADIUS).abs() <= TOLERANCE, "{opacity}: {radius}");
            } else {
                assert!(frame.pixels().iter().filter(|pixel| pixel[1] > 2.0 * pixel[0]).count() > 20, "the scan is seen");
            }
        }
    }
}
