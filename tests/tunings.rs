//! Every vector width, and GPU tuning values, against the f64 reference, on any device.

mod common;

use common::blends::*;
use common::reference::{Pair, differing};
use common::*;
use glam::DVec3;
use layersplat::device::{DeviceKind, Tuning};
use layersplat::layers::{Density, Kernel};
use layersplat::renderer::{Channel, ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::settings::{Algorithm, Blend, Classification, Clipping, Evaluation, Layered, Look};
use layersplat::surface::{Spheres, Surface, Triangles};
use layersplat::volume::LabelSurfaces;
use layersplat::{Camera, Device, Frame, Orbit, Projection, Renderer, Settings};

/// Sums of floats in another order, because rows and tiles start elsewhere.
const REORDERED: f64 = 2e-5;
/// But for few rays, on which a value then rounds to another entry of the table.
const ANOTHER_ENTRY: f64 = 2e-4;
const ANOTHER_ENTRY_SHARE: f64 = 6e-3;

/// Colours of fragments have half precision: lit in another order, they round to another one.
const OF_COLORS: f64 = 1e-3;

/// Samples of columns that lean are interpolated along them on CPUs, and along the axes on GPUs.
const OF_LEANING_COLUMNS: f64 = 1e-2;

/// Pixels aligned with samples compared with one ray per pixel: rounding of positions, amplified by a steep ramp.
const OF_ONE_RAY: f64 = 2e-4;

/// All vector widths of the kernels, and the tuning of the other kind of device.
fn devices() -> Vec<(String, Device)> {
    let device = device();
    let own = *device.tuning();
    let with = |name: String, tuning| (name, device.with_tuning(tuning).unwrap());
    let widths = [16, 8, 4, 1].map(|width| with(format!("vectors of {width}"), Tuning { vector_width: width, ..own }));
    let [cpu, gpu] = [DeviceKind::Cpu, DeviceKind::Gpu].map(|kind| Tuning::new(kind, "", 1, 4));
    let other = if own.lattice_schedule == gpu.lattice_schedule { cpu } else { gpu };
    assert!(other.lattice_schedule != own.lattice_schedule, "the device's own tuning shows nothing new");
    widths.into_iter().chain([with("the tuning of the other kind of device".into(), other)]).collect()
}

/// All algorithms with blend modes, and the sheets.
fn everything() -> Vec<Algorithm> {
    let sheets = OTHERS.into_iter().filter(|a| matches!(a, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. }));
    let smooth = [Kernel::CatmullRom, Kernel::BSpline].map(|kernel| {
        // Kernels without a lattice have one width.
        let classification = Classification::Preintegrated { kernel, samples_per_layer: 2 };
        Layered { classification, evaluation: Evaluation::Lattice(Density::Fixed(2)), ..Layered::default() }.into()
    });
    let cast = Algorithm::Raycast { kernel: Kernel::BSpline, step: 0.6 };
    algorithms().into_iter().chain(sheets).chain(smooth).chain([cast]).collect()
}

/// Each tile is rendered once, in whatever order: also if runs are longer than a row, or than the whole picture.
#[test]
fn the_order_of_tiles_changes_nothing() {
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(150, 130));
    let camera = parallel(&volume, size, 25.0, 15.0);
    let device = device();
    let frame = |tile_run| {
        let device = device.with_tuning(Tuning { tile_run, point_tile_rows: 4, ..*device.tuning() }).unwrap();
        Renderer::new(&device, &volume, &transfer).unwrap().render(&camera, size, &Settings::default()).unwrap().0
    };
    let first = frame(1);
    assert!(first.pixels().iter().filter(|pixel| pixel[3] > 0.1).count() > 1000);
    for tile_run in [2, 3, 8, 19, 4096] {
        assert!(frame(tile_run).pixels() == first.pixels(), "runs of {tile_run} tiles");
    }
}

#[test]
fn every_width_and_tuning() {
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(21, 19));
    let cameras = [parallel(&volume, size, 25.0, 15.0), perspective(&volume, 100.0, -20.0, 30.0)];
    let devices = devices();
    for (n, algorithm) in everything().into_iter().enumerate() {
        // Each in one projection, every other one clipped, because programs take long to build.
        let (camera, parallel) = (&cameras[n % 2], n % 2 == 0);
        let settings = composited(algorithm, if n % 4 < 2 { cuts() } else { Clipping::default() });
        let mut first: Option<Vec<_>> = None;
        for (name, device) in &devices {
            let what = format!("{name}: {algorithm:?}, {:?}", camera.projection);
            let pair = Pair::on(device, &volume, &transfer, camera, size, &settings);
            pair.assert_same(&what, tolerance_of(&settings, parallel));
            // Beside each other widths differ much less.
            let first = first.get_or_insert_with(|| pair.found.clone());
            for (most, allowed) in [(REORDERED, ANOTHER_ENTRY_SHARE), (ANOTHER_ENTRY, 0.0)] {
                let apart = differing(&pair.found, first, most);
                assert!(apart <= allowed, "{what}: {apart} of the rays differ from the first width's by more than {most}");
            }
        }
    }
}

/// If each pixel coincides with a sample, tile columns are staggered and rows become patches. With any vector width and number of rows,
/// pictures equal those of one ray per pixel.
#[test]
fn staggered_columns_at_every_width() {
    let (volume, transfer, size) = (random_volume([33, 30, 28], DVec3::ONE, 3), smooth_transfer(), viewport(71, 58));
    let device = device();
    let rows = [5, 6, 30].map(|rows| {
        let tuning = Tuning { point_tile_rows: rows, ..*device.tuning() };
        (format!("{rows} rows"), device.with_tuning(tuning).unwrap())
    });
    let smooth = Classification::Preintegrated { kernel: Kernel::CatmullRom, samples_per_layer: 2 };
    for (azimuth, layered) in [
        (25.0, Layered::default()),
        (250.0, Layered { classification: smooth, evaluation: Evaluation::Lattice(Density::Fine), ..Layered::default() }),
    ] {
        let camera = parallel(&volume, size, azimuth, 15.0);
        let settings = Settings { early_termination: false, ..layered.into() };
        let direct = Layered { evaluation: Evaluation::Direct, ..layered };
        let expected = render(&volume, &transfer, &camera, size, &Settings { algorithm: direct.into(), ..settings });
        for (name, device) in devices().iter().chain(&rows) {
            let mut renderer = Renderer::new(device, &volume, &transfer).unwrap();
            let (found, _) = renderer.render(&camera, size, &settings).unwrap();
            assert_close(&format!("{name}, azimuth {azimuth}"), &found, &expected, OF_ONE_RAY);
        }
        let shifted = compare(&shifted_by_half_a_pixel(&expected), &expected).max_difference;
        assert!(shifted > 100.0 * OF_ONE_RAY, "half a pixel must be noticed: {shifted}");
    }
}

/// Surfaces: their fragments, the cuts of rays, and the volume between them.
#[test]
fn surfaces_at_every_width() {
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(53, 37));
    let middle = volume.grid().centre();
    let mut spheres = Surface::new("spheres", Spheres::new(vec![middle, middle + 3.0], vec![4.0, 2.0]).unwrap());
    spheres.opacity = 0.4;
    let corner = |x: f64, y: f64| middle + DVec3::new(9.0 * x, 7.0 * y, 2.0 * x - 3.0);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let surfaces = [spheres, Surface::new("square", Triangles::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap())];
    let settings = Settings { early_termination: false, ..Settings::default() };
    for camera in [parallel(&volume, size, 25.0, 15.0), perspective(&volume, 100.0, -20.0, 30.0)] {
        let mut first: Option<Frame> = None;
        for (name, device) in devices() {
            let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
            let (without, _) = renderer.render(&camera, size, &settings).unwrap();
            renderer.set_surfaces(&surfaces).unwrap();
            let (found, _) = renderer.render(&camera, size, &settings).unwrap();
            assert!(compare(&found, &without).max_difference > 0.1, "{name}: surfaces must be seen");
            let first = first.get_or_insert_with(|| found.clone());
            let leans = matches!(camera.projection, Projection::Perspective { .. }) && !name.starts_with("vectors");
            let tolerance = if leans { OF_LEANING_COLUMNS } else { OF_COLORS };
            assert_close(&format!("{name}, {:?}", camera.projection), &found, first, tolerance);
        }
    }
}

/// Other block sizes: sums of sixteen samples in another order.
const OF_ANOTHER_BLOCK: f64 = 1e-5;

/// The picture does not depend on the block size of the warp, for upright and for oblique lattice lines.
#[test]
fn blocks_of_the_warp_change_nothing() {
    let (volume, transfer, size) = (random_volume([33, 30, 28], DVec3::ONE, 3), smooth_transfer(), viewport(71, 58));
    let device = device();
    let upright = parallel(&volume, size, 25.0, 15.0);
    let rolled = Orbit { azimuth: 25.0, elevation: 15.0, roll: 10.0 };
    let rolled = Camera::orbit(volume.grid().centre(), 100.0, rolled, Projection::Parallel { scale: 20.0 });
    let views = [
        (upright, Density::Fixed(1)),
        (upright, Density::Relaxed),
        (rolled, Density::Fixed(2)),
        (parallel(&volume, size, 25.0, 70.0), Density::Fixed(3)),
    ];
    for (n, (camera, density)) in views.into_iter().enumerate() {
        let settings = Settings::from(Layered { evaluation: Evaluation::Lattice(density), ..Layered::default() });
        let draw = |block| {
            let device = device.with_tuning(Tuning { block, ..*device.tuning() }).unwrap();
            let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
            renderer.render(&camera, size, &settings).unwrap().0
        };
        let expected = draw([32, 8]);
        for block in [[1, 1], [5, 3], [16, 2], [128, 8]] {
            assert_close(&format!("view {n}, {block:?}"), &draw(block), &expected, OF_ANOTHER_BLOCK);
        }
        let shifted = compare(&shifted_by_half_a_pixel(&expected), &expected).max_difference;
        assert!(shifted > 100.0 * OF_ANOTHER_BLOCK, "half a pixel must be noticed: {shifted}");
    }
}

/// Splats are counted, summed and listed in parallel: pictures are bit-identical for any distribution of the lists.
#[test]
fn lists_of_splats_change_no_bit() {
    let (volume, transfer, size) = (random_volume([19, 17, 14], DVec3::ONE, 5), smooth_transfer(), viewport(53, 37));
    let device = device();
    let one = Tuning { vector_width: 1, screen_tile_rows: 1, ..*device.tuning() };
    let tunings = [
        Tuning { list_tiles: 1, scan_group: 1, splat_chunks: 1, ..one },
        Tuning { list_tiles: 3, scan_group: 7, splat_chunks: 5, ..one },
        Tuning { list_tiles: 8, scan_group: 256, splat_chunks: 512, ..one },
        Tuning { list_tiles: 30, scan_group: 64, splat_chunks: 4096, ..one },
        Tuning { list_tiles: 2, scan_group: 3, splat_chunks: 64, screen_tile_rows: 4, ..one },
    ];
    let sheets = OTHERS.into_iter().filter(|a| matches!(a, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. }));
    let mut drawn = Vec::new();
    for (n, algorithm) in sheets.enumerate() {
        let camera = parallel(&volume, size, 25.0 + 65.0 * n as f64, 15.0);
        let draw = |tuning: &Tuning| {
            let device = device.with_tuning(*tuning).unwrap();
            let mut renderer = Renderer::new(&device, &volume, &transfer).unwrap();
            renderer.render(&camera, size, &Settings { shading: None, ..algorithm.into() }).unwrap().0
        };
        let first = draw(&tunings[0]);
        assert!(first.pixels().iter().filter(|pixel| pixel[3] > 0.05).count() > 300, "{algorithm:?}: nothing to see");
        for tuning in &tunings[1..] {
            assert_eq!(first.pixels(), draw(tuning).pixels(), "{algorithm:?}: {tuning:?}");
        }
        drawn.push(first);
    }
    assert_ne!(drawn[0].pixels(), drawn[1].pixels(), "different pictures must be detected");
}

/// Several fields and colours, which have one schedule each, together and in the studio, with every vector width.
#[test]
fn fields_and_colors_at_every_width() {
    /// Positions are rounded in another order, and one table entry is another.
    const WIDTHS: f64 = 2e-3;
    let (volume, transfer, size) = (bump(), smooth_transfer(), viewport(21, 19));
    let camera = parallel(&volume, size, 25.0, 15.0);
    let entries: Vec<[f64; 4]> = (0..256).map(|n| [n as f64 / 255.0, 0.5, 1.0 - n as f64 / 255.0, n as f64 / 400.0]).collect();
    let ids: Vec<u8> = (0..volume.grid().voxel_count()).map(|n| (n * 7 % 251) as u8).collect();
    let labels = layersplat::Volume::new("labels", volume.grid().clone(), ids).unwrap();
    let cast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..Settings::default() };
    let studio = Settings::default().with_look(Look::Studio);
    let mut first: Option<Vec<layersplat::Frame>> = None;
    for (name, device) in &devices() {
        let uploaded = UploadedVolume::new(device, &volume).unwrap();
        let channels = [0.3, 1.5].map(|factor| Channel::new(&uploaded, &transfer).with_factor(factor).unwrap());
        let mut several = Renderer::from_channels(&channels).unwrap();
        let labels = UploadedVolume::new(device, &labels).unwrap();
        let of_labels = UploadedColors::from_labels(&[(&labels, &entries)], LabelSurfaces::Smooth).unwrap();
        let mut colors = Renderer::from_colors(&of_labels).unwrap();
        let components = [&volume, &volume, &volume, &volume].map(|component| UploadedVolume::new(device, component).unwrap());
        let of_colors = UploadedColors::from_components(&components, ColorOpacity::Alpha, &transfer).unwrap();
        let beside = [Channel::new(&uploaded, &transfer), Channel::from_colors(&of_colors).unwrap()];
        let mut mixed = Renderer::from_channels(&beside).unwrap();
        let draw = |renderer: &mut Renderer, settings: &Settings| renderer.render(&camera, size, settings).unwrap().0;
        let maximum = Settings { blend: Blend::Maximum, shading: None, ..Settings::default() };
        let found = vec![
            draw(&mut several, &Settings::default()),
            draw(&mut several, &cast),
            draw(&mut several, &maximum),
            draw(&mut colors, &Settings::default()),
            draw(&mut mixed, &Settings::default()),
            draw(&mut mixed, &studio),
        ];
        let first = first.get_or_insert_with(|| found.clone());
        for (n, (found, first)) in found.iter().zip(first.iter()).enumerate() {
            assert_close(&format!("{name}, picture {n}"), found, first, WIDTHS);
            assert!(found.pixels().iter().any(|pixel| pixel[3] > 0.1), "{name}, picture {n} shows something");
        }
    }
}
