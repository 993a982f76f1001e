//! Invariances: axis permutations, mirroring, rotated worlds, units, voxel types, byte orders, repeated runs.

use crate::common::*;
use glam::{DMat3, DVec3};
use layersplat::image::Background;
use layersplat::layers::Density;
use layersplat::settings::{Blend, Evaluation, Layered, Shading};
use layersplat::volume::{Endian, Grid, Voxels};
use layersplat::{Camera, Frame, OpenOptions, Renderer, Settings, Volume};

/// The same sums in another order, in f32; an index that moves to the next table entry costs less than this.
const REORDERED: f64 = 1e-3;
/// Tolerance of slicing, whose table has 256 values.
const REORDERED_SLICES: f64 = 4e-3;

fn reordered(settings: &Settings) -> f64 {
    if settings.algorithm.name() == "slicing" { REORDERED_SLICES } else { REORDERED }
}

const VIEWS: [(f64, f64); 4] = [(20.0, 10.0), (-70.0, 25.0), (130.0, -50.0), (10.0, 75.0)];

/// The volume with permuted axes x → y → z → x.
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

/// A viewport much wider than high, and more samples along one axis of the layers than its shorter side is worth: whether there is a
/// lattice must not depend on which axis of the layers that is.
#[test]
fn turning_the_axes_in_a_wide_viewport() {
    let (dims, size) = ([30, 8, 9], viewport(200, 40));
    let bytes = random_bytes(dims, 11);
    let (turned_bytes, turned_dims) = turned(&bytes, dims);
    let a = volume(dims, DVec3::ONE, Voxels::Uint8(bytes));
    let b = volume(turned_dims, DVec3::ONE, Voxels::Uint8(turned_bytes));
    let camera = perspective(&a, 20.0, 75.0, 30.0);
    let other = map_camera(camera, a.grid().centre(), b.grid().centre(), cycle);
    for blend in [Blend::Average, Blend::Composite] {
        let layered =
            Layered { classification: POINTS, evaluation: Evaluation::Lattice(Density::Fixed(16)), ..Layered::default() };
        let settings = Settings { algorithm: layered.into(), blend, ..unshaded() };
        let sides = [(&a, camera), (&b, other)].map(|(volume, camera)| {
            let mut renderer = Renderer::new(&device(), volume, &smooth_transfer()).unwrap();
            renderer.lattice_picture(&camera, size, &settings).unwrap().map(|picture| picture.size)
        });
        assert!(sides[0].is_some_and(|[u, v]| u > 4 * 64 && v < u && sides[1] == Some([v, u])), "{blend:?}: {sides:?}");
        let [first, second] = [(&a, camera), (&b, other)].map(|(v, c)| render(v, &smooth_transfer(), &c, size, &settings));
        assert_close(&format!("{blend:?}"), &first, &second, REORDERED);
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

/// Volume, camera and light rotated, translated and mirrored together. The reference cannot test this: it shares grid, camera and rays.
#[test]
fn turning_the_world_with_camera_and_light() {
    let (dims, spacing) = ([9, 14, 11], DVec3::new(1.0, 1.3, 0.8));
    let bytes = random_bytes(dims, 10);
    let still = volume(dims, spacing, Voxels::Uint8(bytes.clone()));
    let turn = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(-1.9) * DMat3::from_rotation_y(0.4);
    let mirror = turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let size = viewport(40, 32);
    let lit = |settings: Settings, light: DVec3| {
        let shading =
            Shading { ambient: 0.1, ambient_color: [1.0; 3], diffuse: 0.6, specular: 0.5, power: 7.0, lights: one_light(light) };
        Settings { shading: Some(shading), ..settings }
    };
    let light = DVec3::new(3.0, 1.0, -0.5);
    for direction in [turn, mirror] {
        let grid = Grid::oriented(dims, spacing, DVec3::new(20.0, -7.0, 3.0), direction).unwrap();
        let moved = Volume::new("turned", grid, Voxels::Uint8(bytes.clone())).unwrap();
        for view in [parallel(&still, size, 20.0, 10.0), perspective(&still, -70.0, 25.0, 25.0)] {
            let other = map_camera(view, still.grid().centre(), moved.grid().centre(), |v| direction * v);
            for settings in evaluations() {
                let first = render(&still, &smooth_transfer(), &view, size, &lit(settings, light));
                let seen = |settings: &Settings| {
                    let frame = render(&moved, &smooth_transfer(), &other, size, settings);
                    if direction == turn { frame } else { mirrored(&frame) }
                };
                let second = seen(&lit(settings, direction * light));
                assert_close(&format!("{:?}", settings.algorithm), &first, &second, reordered(&settings));
                let unturned = seen(&lit(settings, light));
                assert!(compare(&first, &unturned).max_difference > 10.0 * REORDERED, "a fixed light must be detected");
            }
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
            assert!(compare(&first, &third).max_difference > 10.0 * REORDERED, "the unit distance must matter");
        }
    }
}

#[test]
fn voxel_types_and_byte_orders() {
    let dims = [13, 9, 7];
    let bytes = random_bytes(dims, 4);
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, data: Vec<u8>, endian: Endian| {
        // Files are mapped, so each needs a separate name.
        let path = folder.path().join(format!("{endian:?}_13x9x7_{name}.raw"));
        std::fs::write(&path, data).unwrap();
        Volume::open(path.to_str().unwrap(), &OpenOptions { endian: Some(endian), ..OpenOptions::default() }).unwrap()
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
        // Less than 1/4096 of the light is omitted; negative lobes of the warp can add a quarter.
        assert_close("early termination", &with, &without, 1.25 / 4096.0);
    }
}

/// A pixel over black in 8 bits: 255 times the value plus a half, exact in f64, rounded to f32 once and truncated.
fn rounded([r, g, b, _]: [f32; 4]) -> [u8; 4] {
    let byte = |c: f32| (f64::from(c) * 255.0 + 0.5) as f32 as u8;
    [byte(r), byte(g), byte(b), 255]
}

/// Bit-identical: with and without a lattice, with pixels of several voxels, and with two blended lattices.
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
    // For the last one, every channel lies on a half.
    let backgrounds = ["transparent", "black", "#3060c0", "0.3,0.1,0.7"].map(|b| b.parse().unwrap());
    for settings in evaluations() {
        for camera in cameras {
            let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
            for background in backgrounds {
                let (picture, _) = renderer.render_rgba8(&camera, size, &settings, background).unwrap();
                assert!(frame.to_rgba8(background) == picture, "{settings:?}, {camera:?}, {background:?}");
                if background == Background::BLACK {
                    let found = picture.as_chunks::<4>().0.iter();
                    assert!(frame.pixels().iter().zip(found).all(|(p, found)| rounded(*p) == *found), "{settings:?}");
                }
                assert!(frame.clone().over(background).to_rgba8(background) == picture, "{settings:?}, {background:?}");
            }
        }
    }
    let (empty, _) = renderer.render(&cameras[1], viewport(8, 8), &Settings::default()).unwrap();
    assert_eq!(empty.to_rgba8(backgrounds[3])[..4], [77, 26, 179, 255]);
}
