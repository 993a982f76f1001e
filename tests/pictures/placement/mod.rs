//! Positions in pictures by elementary trigonometry. The crate's cameras and rays are not used, because the reference shares them with the
//! code under test.

mod decoded;
mod fit;
mod trigonometry;

use crate::common::*;
use decoded::Picture;
use glam::DVec3;
use layersplat::layers::Density;
use layersplat::layers::Kernel;
use layersplat::settings::{Classification, Evaluation, Footprints, Layered};
use layersplat::volume::Voxels;
use layersplat::{
    Background, Camera, Correction, Frame, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use trigonometry::View;

/// Largest distance of a voxel's blot from the expected position, in pixels. Blots are point-symmetric, except for the finite resolution of
/// pixels, lattice samples and table entries.
const OFF: f64 = 0.07;
/// In a perspective, the nearer half of a blot is larger, and seen at another angle.
const OFF_IN_PERSPECTIVE: f64 = 0.15;
/// For a blot as wide as its distance.
const OFF_NEARBY: f64 = 0.3;
/// Least distance of a mistaken position from the correct one, so that the test detects it.
const TELLING: f64 = 1.0;
/// Red, green and blue, all different.
const COLOR: [f64; 3] = [0.875, 0.5, 0.125];

const DIMS: [usize; 3] = [17, 14, 12];
const SPACING: [f64; 3] = [0.8, 1.3, 1.0];
const VOXEL: [usize; 3] = [13, 3, 8];

/// Empty except for one voxel; the first index is fastest.
fn one_voxel(dims: [usize; 3], spacing: [f64; 3], [i, j, k]: [usize; 3]) -> Volume<'static> {
    let mut bytes = vec![0; dims.iter().product()];
    bytes[i + dims[0] * (j + dims[1] * k)] = 255;
    volume(dims, DVec3::from_array(spacing), Voxels::Uint8(bytes))
}

/// One colour for all values; opacity increases with the value.
fn colored() -> TransferFunction {
    TransferFunction::new("colored", vec![(0.0, COLOR)], vec![(0.0, 0.0), (10.0, 0.0), (255.0, 0.9)]).unwrap()
}

/// All algorithms, unlit, so that a blot has one colour.
fn ways() -> Vec<Settings> {
    let post = Classification::Post(Correction::SubLayers(2));
    let points = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 };
    let (lattice, direct) = (Evaluation::Lattice(Density::AtLeast(3)), Evaluation::Direct);
    let layered = [(lattice, post), (lattice, points), (direct, post), (direct, points)].map(|(evaluation, classification)| {
        Layered { evaluation, classification, footprints: Footprints::Exact, ..Layered::default() }.into()
    });
    let ways = layered.into_iter().chain(OTHERS.map(Settings::from));
    ways.map(|settings| Settings { shading: None, ..settings }).collect()
}

/// Size, centre, orbit and projection of each picture.
fn views() -> Vec<View> {
    let middle = [6.4, 8.45, 5.5];
    let beside = [7.2, 7.1, 6.6];
    let parallel = |scale| trigonometry::Projection::Parallel { scale };
    let perspective = |degrees, distance| trigonometry::Projection::Perspective { degrees, distance };
    vec![
        View { size: [70, 44], centre: middle, orbit: [0.0, 0.0, 0.0], projection: parallel(9.0) },
        View { size: [44, 70], centre: middle, orbit: [30.0, 20.0, 0.0], projection: parallel(10.0) },
        View { size: [63, 45], centre: beside, orbit: [-80.0, -35.0, -150.0], projection: parallel(9.5) },
        View { size: [45, 63], centre: beside, orbit: [-80.0, -35.0, -60.0], projection: parallel(11.0) },
        View { size: [70, 44], centre: middle, orbit: [0.0, 0.0, 0.0], projection: perspective(50.0, 20.0) },
        View { size: [44, 70], centre: middle, orbit: [25.0, 15.0, 0.0], projection: perspective(70.0, 16.0) },
        View { size: [63, 45], centre: beside, orbit: [50.0, 30.0, 50.0], projection: perspective(60.0, 17.0) },
        View { size: [45, 63], centre: beside, orbit: [85.0, 30.0, 50.0], projection: perspective(80.0, 15.0) },
    ]
}

fn camera(view: &View) -> Camera {
    let [azimuth, elevation, roll] = view.orbit;
    let (distance, projection) = match view.projection {
        trigonometry::Projection::Parallel { scale } => (30.0, Projection::Parallel { scale }),
        trigonometry::Projection::Perspective { degrees, distance } => {
            (distance, Projection::Perspective { field_of_view: degrees })
        }
    };
    Camera::orbit(DVec3::from_array(view.centre), distance, Orbit { azimuth, elevation, roll }, projection)
}

fn size_of(view: &View) -> Viewport {
    viewport(view.size[0], view.size[1])
}

fn allowed(view: &View) -> f64 {
    match view.projection {
        trigonometry::Projection::Parallel { .. } => OFF,
        trigonometry::Projection::Perspective { .. } => OFF_IN_PERSPECTIVE,
    }
}

fn world(voxel: [usize; 3], spacing: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| voxel[a] as f64 * spacing[a])
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Asserts position and colour of the visible blot.
#[track_caller]
fn assert_at(what: &str, picture: &Picture, expected: [f64; 2], allowed: f64) {
    let found = picture.middle();
    assert!(distance(found, expected) < allowed, "{what}: at {found:.3?}, not at {expected:.3?}");
    assert!(picture.most() > 0.1, "{what}: barely visible");
}

#[test]
fn a_voxel_is_where_trigonometry_puts_it() {
    let (volume, transfer) = (one_voxel(DIMS, SPACING, VOXEL), colored());
    for view in views() {
        let expected = view.place(world(VOXEL, SPACING));
        for mistake in view.mistakes(world(VOXEL, SPACING)) {
            assert!(distance(mistake, expected) > TELLING, "{view:?}: {mistake:?} is too near {expected:?} to be noticed");
        }
        for settings in ways() {
            let frame = render(&volume, &transfer, &camera(&view), size_of(&view), &settings);
            let what = format!("{:?} {view:?}", settings.algorithm);
            assert_at(&what, &Picture::of(&frame), expected, allowed(&view));
        }
    }
}

/// From inside, and at angles without a lattice, ray casting is used.
#[test]
fn a_voxel_is_there_too_when_seen_from_inside() {
    let (volume, transfer) = (one_voxel(DIMS, SPACING, VOXEL), colored());
    let projection = trigonometry::Projection::Perspective { degrees: 110.0, distance: 1.0 };
    let view = View { size: [90, 64], centre: [8.0, 5.2, 4.4], orbit: [-150.0, 15.0, 20.0], projection };
    let expected = view.place(world(VOXEL, SPACING));
    for settings in ways().into_iter().filter(|s| s.layered().is_some()) {
        let frame = render(&volume, &transfer, &camera(&view), size_of(&view), &settings);
        assert_at(&format!("{:?}", settings.algorithm), &Picture::of(&frame), expected, OFF_NEARBY);
    }
}

/// Fixed sides in words: right, above and near.
#[test]
fn sides_are_as_one_would_say() {
    let transfer = colored();
    let dims = [11; 3];
    // A voxel three to one side of the centre, the view, and its position in the picture: right, up.
    for (voxel, orbit, right, up) in [
        // From +z: x points right, y up.
        ([8, 5, 5], [0.0, 0.0, 0.0], 3.0, 0.0),
        ([5, 8, 5], [0.0, 0.0, 0.0], 0.0, 3.0),
        // From +x: z points left.
        ([5, 5, 8], [90.0, 0.0, 0.0], -3.0, 0.0),
        ([5, 8, 5], [90.0, 0.0, 0.0], 0.0, 3.0),
        // From behind: x points left.
        ([8, 5, 5], [180.0, 0.0, 0.0], -3.0, 0.0),
        // From above: z, which pointed to the viewer, points down.
        ([5, 5, 8], [0.0, 90.0, 0.0], 0.0, -3.0),
        ([8, 5, 5], [0.0, 90.0, 0.0], 3.0, 0.0),
        // A roll by 90°, as of vtkCamera::Roll, makes x point up.
        ([8, 5, 5], [0.0, 0.0, 90.0], 0.0, 3.0),
        ([5, 8, 5], [0.0, 0.0, 90.0], -3.0, 0.0),
    ] {
        let volume = one_voxel(dims, [1.0; 3], voxel);
        let projection = trigonometry::Projection::Parallel { scale: 5.5 };
        let view = View { size: [66, 44], centre: [5.0; 3], orbit, projection };
        let frame = render(&volume, &transfer, &camera(&view), size_of(&view), &ways()[1]);
        // 44 rows for 11 voxels.
        let expected = [33.0 + 4.0 * right, 22.0 - 4.0 * up];
        assert_at(&format!("{voxel:?} {orbit:?}"), &Picture::of(&frame), expected, OFF);
        assert!(distance(expected, view.place(world(voxel, [1.0; 3]))) < 1e-9, "the trigonometry of these tests");
    }
}

/// Cameras without an orbit: only the component of view-up perpendicular to the view matters.
#[test]
fn a_camera_may_be_put_anywhere() {
    let (volume, transfer) = (one_voxel([11; 3], [1.0; 3], [8, 7, 5]), colored());
    let projection = Projection::Parallel { scale: 5.5 };
    let (position, focal_point) = (DVec3::new(5.0, 5.0, -20.0), DVec3::splat(5.0));
    // From −z with +x up, right is up × (from the focal point to the eye) = x × −z = y.
    let camera = Camera { position, focal_point, view_up: DVec3::new(2.0, 0.0, 7.0), projection };
    let frame = render(&volume, &transfer, &camera, viewport(66, 44), &ways()[1]);
    assert_at("x up", &Picture::of(&frame), [33.0 + 4.0 * 2.0, 22.0 - 4.0 * 3.0], OFF);
    let perspective = Camera { projection: Projection::Perspective { field_of_view: 30.0 }, ..camera };
    let frame = render(&volume, &transfer, &perspective, viewport(66, 44), &ways()[1]);
    let pixels = 22.0 / (25.0 * 15f64.to_radians().tan());
    assert_at("x up, perspective", &Picture::of(&frame), [33.0 + 2.0 * pixels, 22.0 - 3.0 * pixels], OFF_IN_PERSPECTIVE);
}

/// A frame in memory, its 8-bit picture from the device, and both files, decoded independently.
#[test]
fn files_show_it_there_in_its_colour() {
    let (volume, transfer) = (one_voxel(DIMS, SPACING, VOXEL), colored());
    let folder = tempfile::tempdir().unwrap();
    let (png, npy) = (folder.path().join("a.png"), folder.path().join("a.npy"));
    let settings = ways()[1];
    for view in views() {
        let expected = view.place(world(VOXEL, SPACING));
        let frame: Frame = render(&volume, &transfer, &camera(&view), size_of(&view), &settings);
        frame.save(&png, Some(Background::Transparent)).unwrap();
        frame.save(&npy, None).unwrap();
        let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
        let shown = renderer.render_rgba8(&camera(&view), size_of(&view), &settings, Background::Transparent).unwrap().0;
        for (what, picture, step) in [
            ("frame", Picture::of(&frame), 1e-4),
            ("npy", Picture::npy(&std::fs::read(&npy).unwrap()), 1e-4),
            ("png", Picture::png(&png), 1.0 / 255.0),
            ("rgba8", Picture::bytes(view.size, &shown), 1.0 / 255.0),
        ] {
            assert_eq!(picture.size, view.size, "{what}");
            assert_at(what, &picture, expected, allowed(&view));
            let [r, g, b, a] = picture.brightest();
            for (channel, wanted) in [r, g, b].into_iter().zip(COLOR) {
                assert!((channel / a - wanted).abs() < 2.0 * step, "{what}: {:?} is not {COLOR:?}", [r / a, g / a, b / a]);
            }
        }
    }
}
