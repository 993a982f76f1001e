//! What must not change a picture: axis permutations, mirrors, units, voxel types, byte orders, culling, another run.

mod common;

use common::*;
use glam::DVec3;
use layersplat::layers::Density;
use layersplat::settings::{Evaluation, Layered};
use layersplat::volume::{Endian, Voxels};
use layersplat::{Camera, Frame, RawOptions, Renderer, Settings, TransferFunction, Volume};

/// The same sums in another order, in floats; a table index that flips by one entry costs less than this.
const REORDERED: f64 = 1e-3;
/// Of slicing, whose table has 256 values.
const REORDERED_SLICES: f64 = 4e-3;

fn reordered(settings: &Settings) -> f64 {
    if settings.algorithm.name() == "slicing" { REORDERED_SLICES } else { REORDERED }
}

/// A splat that no voxel within three of it makes visible can still weigh a thousandth in a sample that others do.
const SPLATS_LEFT_OUT: f64 = 1e-3;

const VIEWS: [(f64, f64); 4] = [(20.0, 10.0), (-70.0, 25.0), (130.0, -50.0), (10.0, 75.0)];

/// Each classification on its lattice and per pixel, and the other algorithms.
fn evaluations() -> Vec<Settings> {
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

/// The volume with its axes turned x → y → z → x.
fn turned(bytes: &[u8], [x, y, z]: [usize; 3]) -> (Vec<u8>, [usize; 3]) {
    let mut out = Vec::new();
    for k in 0..y {
        for j in 0..x {
            for i in 0..z {
                out.push(bytes[j + x * (k + y * i)]);
            }
        }
    }
    (out, [z, x, y])
}

fn cycle(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.x, v.y)
}

fn map_camera(camera: Camera, from: DVec3, to: DVec3, f: impl Fn(DVec3) -> DVec3) -> Camera {
    let place = |p: DVec3| to + f(p - from);
    Camera { position: place(camera.position), focal_point: place(camera.focal_point), view_up: f(camera.view_up), ..camera }
}

fn mirrored(frame: &Frame) -> Frame {
    let w = frame.width();
    let pixels = (0..frame.height()).flat_map(|y| (0..w).map(move |x| (w - 1 - x, y))).map(|(x, y)| frame.pixel(x, y));
    Frame::new(viewport(w, frame.height()), pixels.collect())
}

#[test]
fn turning_the_axes_with_the_view() {
    let (dims, spacing) = ([9, 14, 11], DVec3::new(1.0, 1.3, 0.8));
    let bytes = random_bytes(dims, 1);
    let (turned_bytes, turned_dims) = turned(&bytes, dims);
    let a = volume(dims, spacing, Voxels::Uint8(bytes));
    let b = volume(turned_dims, cycle(spacing), Voxels::Uint8(turned_bytes));
    let size = viewport(40, 32);
    for (azimuth, elevation) in VIEWS {
        let views = [parallel(&a, size, azimuth, elevation), perspective(&a, azimuth, elevation, 25.0)];
        for (settings, camera) in evaluations().iter().flat_map(|s| views.map(|c| (s, c))) {
            let other = map_camera(camera, a.grid().centre(), b.grid().centre(), cycle);
            let first = render(&a, &smooth_transfer(), &camera, size, settings);
            let second = render(&b, &smooth_transfer(), &other, size, settings);
            assert_close(&format!("{azimuth}, {elevation}"), &first, &second, reordered(settings));
            let unturned = render(&b, &smooth_transfer(), &parallel(&b, size, azimuth, elevation), size, settings);
            assert!(compare(&first, &unturned).max_difference > 10.0 * REORDERED, "a swapped axis must be noticed");
        }
    }
}

#[test]
fn mirroring_volume_and_view() {
    let dims = [10, 9, 12];
    let bytes = random_bytes(dims, 2);
    let flipped: Vec<u8> = bytes.chunks(dims[0]).flat_map(|row| row.iter().rev().copied()).collect();
    let a = volume(dims, DVec3::ONE, Voxels::Uint8(bytes));
    let b = volume(dims, DVec3::ONE, Voxels::Uint8(flipped));
    let size = viewport(40, 32);
    for (azimuth, elevation) in VIEWS {
        let views = [parallel(&a, size, azimuth, elevation), perspective(&a, azimuth, elevation, 25.0)];
        for (settings, camera) in evaluations().iter().flat_map(|s| views.map(|c| (s, c))) {
            let other = map_camera(camera, a.grid().centre(), b.grid().centre(), |v| v * DVec3::new(-1.0, 1.0, 1.0));
            let first = render(&a, &smooth_transfer(), &camera, size, settings);
            let second = render(&b, &smooth_transfer(), &other, size, settings);
            assert_close(&format!("{azimuth}, {elevation}"), &first, &mirrored(&second), reordered(settings));
            assert!(compare(&first, &second).max_difference > 10.0 * REORDERED, "a missing mirror must be noticed");
        }
    }
}

#[test]
fn doubling_spacing_and_unit_distance() {
    let dims = [10, 9, 12];
    let bytes = random_bytes(dims, 3);
    let spacing = DVec3::new(1.0, 0.7, 1.9);
    let [a, b] = [1.0, 2.0].map(|f| volume(dims, spacing * f, Voxels::Uint8(bytes.clone())));
    let size = viewport(40, 32);
    for (azimuth, elevation) in VIEWS {
        for settings in evaluations() {
            let first = render(&a, &smooth_transfer(), &parallel(&a, size, azimuth, elevation), size, &settings);
            let second = render(&b, &smooth_transfer(), &parallel(&b, size, azimuth, elevation), size, &settings);
            assert_close(&format!("{azimuth}, {elevation}"), &first, &second, reordered(&settings));
            let fixed = Settings { unit_distance: Some(0.7), ..settings };
            let third = render(&b, &smooth_transfer(), &parallel(&b, size, azimuth, elevation), size, &fixed);
            assert!(compare(&first, &third).max_difference > 10.0 * REORDERED, "the unit distance must count");
        }
    }
}

#[test]
fn voxel_types_and_byte_orders() {
    let dims = [13, 9, 7];
    let bytes = random_bytes(dims, 4);
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, data: Vec<u8>, endian: Endian| {
        // Files are mapped: each needs a name of its own.
        let path = folder.path().join(format!("{endian:?}_13x9x7_{name}.raw"));
        std::fs::write(&path, data).unwrap();
        Volume::open(path.to_str().unwrap(), &RawOptions { endian: Some(endian), ..RawOptions::default() }).unwrap()
    };
    let wide = |f: fn(u8) -> Vec<u8>| -> Vec<u8> { bytes.iter().flat_map(|&b| f(b)).collect() };
    let volumes = [
        file("uint8", bytes.clone(), Endian::Little),
        file("uint16", wide(|b| u16::from(b).to_le_bytes().to_vec()), Endian::Little),
        file("uint16", wide(|b| u16::from(b).to_be_bytes().to_vec()), Endian::Big),
        file("int16", wide(|b| i16::from(b).to_le_bytes().to_vec()), Endian::Little),
        file("int16", wide(|b| i16::from(b).to_be_bytes().to_vec()), Endian::Big),
        file("float32", wide(|b| f32::from(b).to_le_bytes().to_vec()), Endian::Little),
        file("float32", wide(|b| f32::from(b).to_be_bytes().to_vec()), Endian::Big),
        file("float64", wide(|b| f64::from(b).to_le_bytes().to_vec()), Endian::Little),
    ];
    let size = viewport(32, 32);
    for settings in evaluations() {
        let pictures = volumes.each_ref().map(|v| render(v, &smooth_transfer(), &parallel(v, size, 80.0, 20.0), size, &settings));
        assert!(largest_opacity(&pictures[0]) > 0.1);
        for (volume, picture) in volumes.iter().zip(&pictures) {
            assert_eq!(picture, &pictures[0], "{}", volume.name());
        }
    }
    let wrong = file("uint16", wide(|b| u16::from(b).to_be_bytes().to_vec()), Endian::Little);
    let picture = render(&wrong, &smooth_transfer(), &parallel(&wrong, size, 80.0, 20.0), size, &Settings::default());
    let right = render(&volumes[0], &smooth_transfer(), &parallel(&volumes[0], size, 80.0, 20.0), size, &Settings::default());
    assert_ne!(picture, right, "a wrong byte order must be noticed");
}

/// A mostly empty volume of 0 and 255, seen where only values between are visible: interpolated values between two
/// invisible voxels.
fn between() -> (Volume<'static>, TransferFunction) {
    let dims = [70, 41, 53];
    let mut random = Random(5);
    let mut bytes = vec![0u8; dims.iter().product()];
    for _ in 0..60 {
        let at = random.next() as usize % bytes.len();
        bytes[at] = 255;
    }
    let opacities = vec![(0.0, 0.0), (60.0, 0.0), (120.0, 0.8), (200.0, 0.0), (255.0, 0.0)];
    let transfer = TransferFunction::new("between", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
    (volume(dims, DVec3::ONE, Voxels::Uint8(bytes)), transfer)
}

/// A thick ball of 255 in 0, of which a narrow band of values between shows: invisible voxels inside and out.
fn shell() -> (Volume<'static>, TransferFunction) {
    let n = 40;
    let inside = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - DVec3::splat(n as f64 / 2.0);
        p.length() < 14.3
    };
    let bytes = (0..n * n * n).map(|i| if inside(i) { 255 } else { 0 }).collect();
    let opacities = vec![(0.0, 0.0), (110.0, 0.0), (128.0, 0.7), (146.0, 0.0), (255.0, 0.0)];
    let transfer = TransferFunction::new("shell", vec![(0.0, [1.0, 0.8, 0.6])], opacities).unwrap();
    (volume([n; 3], DVec3::ONE, Voxels::Uint8(bytes)), transfer)
}

#[test]
fn culling_never_changes_a_bit() {
    let fog =
        TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(0.0, 0.02), (10.0, 0.0), (250.0, 0.0), (255.0, 0.5)]).unwrap();
    let random = random_volume([45, 30, 37], DVec3::new(1.0, 1.5, 0.8), 6);
    let size = viewport(64, 64);
    for (volume, transfer) in [between(), shell(), (between().0, fog), (random, smooth_transfer())] {
        for (azimuth, elevation) in [(0.0, 0.0), (45.0, 0.0), (30.0, 20.0), (100.0, -40.0), (10.0, 80.0)] {
            let views = [
                parallel(&volume, size, azimuth, elevation),
                perspective(&volume, azimuth, elevation, 30.0),
                perspective(&volume, azimuth, elevation, 90.0),
                perspective(&volume, azimuth, elevation, 150.0),
            ];
            for camera in views {
                for settings in evaluations() {
                    let culled = render(&volume, &transfer, &camera, size, &settings);
                    let whole = render(&volume, &transfer, &camera, size, &Settings { culling: false, ..settings });
                    let name = settings.algorithm.name();
                    // What sheets leave out may weigh a little; everything else is exact.
                    let limit = if name == "view-sheets" { SPLATS_LEFT_OUT } else { 0.0 };
                    let difference = compare(&culled, &whole).max_difference;
                    assert!(difference <= limit, "{azimuth}, {elevation}, {name}: {difference}");
                    // What is visible only between voxels, classification before splatting does not see, and single samples
                    // jump over.
                    let sees_all = name != "axis-sheets" && !(name == "layered" && layered(settings).classification == SPLATTED);
                    let seen = largest_opacity(&culled) > 0.01 || !sees_all;
                    assert!(seen, "{azimuth}, {elevation}, {name}, {:?}: the picture is empty", camera.projection);
                }
            }
        }
    }
}

/// A flat volume far from zero with one higher voxel, and edges of opacity just above the flat value.
#[test]
fn culling_survives_rounding_and_the_footprint_set() {
    use layersplat::settings::Footprints;
    let size = viewport(64, 64);
    let dims = [24; 3];
    let mut seen: f32 = 0.0;
    for (flat, peak) in [(100u16, 255u16), (60_000, 65_535)] {
        let mut values = vec![flat; 24 * 24 * 24];
        values[12 * 24 * 24 + 11 * 24 + 13] = peak;
        let volume = volume(dims, DVec3::ONE, Voxels::Uint16(values));
        for edge in [0.01, 0.1, 0.3, 0.5] {
            let edge = f64::from(flat) + edge;
            let opacities = vec![(0.0, 0.0), (edge, 0.0), (edge + 2.0, 0.5), (65_535.0, 0.5)];
            let transfer = TransferFunction::new("edge", vec![(0.0, [1.0; 3])], opacities).unwrap();
            let unshaded = Settings { shading: None, early_termination: false, ..Settings::default() };
            let direct = Settings {
                algorithm: Layered { classification: SPLATTED, evaluation: Evaluation::Direct, ..layered(unshaded) }.into(),
                ..unshaded
            };
            let set = Settings { algorithm: Layered { footprints: Footprints::Set, ..layered(direct) }.into(), ..direct };
            for settings in [
                direct,
                set,
                unshaded,
                Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(unshaded) }.into(), ..unshaded },
            ] {
                let camera = parallel(&volume, size, 45.0, 35.0);
                let culled = render(&volume, &transfer, &camera, size, &settings);
                let whole = render(&volume, &transfer, &camera, size, &Settings { culling: false, ..settings });
                assert!(culled == whole, "{flat}, {edge}, {:?}: {:?}", layered(settings).footprints, compare(&culled, &whole));
                seen = seen.max(largest_opacity(&whole));
            }
        }
    }
    assert!(seen > 0.1);
}

#[test]
fn runs_are_the_same_bit_for_bit() {
    let volume = random_volume([33, 34, 35], DVec3::ONE, 7);
    let size = viewport(100, 80);
    for settings in evaluations() {
        let camera = parallel(&volume, size, 50.0, 30.0);
        let first = render(&volume, &smooth_transfer(), &camera, size, &settings);
        // Another renderer, and the same one after other views and another transfer function.
        let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
        for azimuth in [0.0, 120.0] {
            renderer.render(&parallel(&volume, size, azimuth, 0.0), viewport(120, 90), &settings).unwrap();
        }
        renderer.set_transfer_function(&step_transfer(50.0, 0.5));
        let stepped = renderer.render(&camera, size, &settings).unwrap().0;
        renderer.set_transfer_function(&smooth_transfer());
        let again = renderer.render(&camera, size, &settings).unwrap().0;
        assert_eq!(first, again);
        assert_ne!(first, stepped);
    }
}

#[test]
fn early_termination_stays_below_its_threshold() {
    let volume = random_volume([40, 40, 40], DVec3::ONE, 8);
    let size = viewport(64, 64);
    for on in evaluations().into_iter().map(|s| Settings { early_termination: true, ..s }) {
        let camera = parallel(&volume, size, 30.0, 20.0);
        let off = Settings { early_termination: false, ..on };
        let [with, without] = [on, off].map(|s| render(&volume, &smooth_transfer(), &camera, size, &s));
        // The warp's negative lobes can add a quarter.
        assert_close("early termination", &with, &without, 1.25 * Settings::OPAQUE);
    }
}

/// To the bit: with a lattice and without, where a pixel covers several voxels, where two lattices share the picture.
#[test]
fn the_devices_8_bit_picture_is_the_frames() {
    let volume = random_volume([20, 20, 20], DVec3::ONE, 9);
    let size = viewport(50, 40);
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let oblique = parallel(&volume, size, 30.0, 20.0);
    let cameras = [
        oblique,
        scaled(oblique, 8.0 * volume.grid().diagonal()),
        parallel(&volume, size, 44.5, 0.0),
        perspective(&volume, 30.0, 20.0, 40.0),
    ];
    // Of the last, every channel lies on a half.
    let backgrounds = ["transparent", "black", "#3060c0", "0.3,0.1,0.7"].map(|b| b.parse().unwrap());
    for settings in evaluations() {
        for camera in cameras {
            let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
            for background in backgrounds {
                let (picture, _) = renderer.render_rgba8(&camera, size, &settings, background).unwrap();
                assert!(frame.to_rgba8(background) == picture, "{settings:?}, {camera:?}, {background:?}");
                assert!(frame.clone().over(background).to_rgba8(background) == picture, "{settings:?}, {background:?}");
            }
        }
    }
    let (empty, _) = renderer.render(&cameras[1], viewport(8, 8), &Settings::default()).unwrap();
    assert_eq!(empty.to_rgba8(backgrounds[3])[..4], [77, 26, 179, 255]);
}
