//! Pictures of the C functions are bit-identical to those of the library.

mod common;

use common::{EMPTY, FLOATS, FROM, HEIGHT, SOURCE, Scene, WIDTH, last_error, made, ok, refused, settings};
use layersplat::color::Tone;
use layersplat::glam::DVec3;
use layersplat::settings::{Algorithm, AmbientOcclusion, LightGrid, Lights, Look, Shading, Shadows};
use layersplat::volume::Grid as LibraryGrid;
use layersplat::{Background, DeviceChoice, OpenOptions, Orbit, TransferFunction, Viewport};
use layersplat_c::*;
use std::ffi::CString;
use std::ptr::{null, null_mut};

/// Number of frames after which another thread must have run.
const LONGEST_WAIT: usize = 100_000;

/// The library's own renderer of the scene, and its view.
fn library() -> (layersplat::Renderer, layersplat::Camera, Viewport) {
    let volume = layersplat::Volume::open(SOURCE, &OpenOptions::default()).unwrap();
    let device = layersplat::Device::open(&DeviceChoice::Default).unwrap();
    let renderer = layersplat::Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
    let viewport = Viewport::new(WIDTH, HEIGHT).unwrap();
    let orbit = Orbit { azimuth: FROM.azimuth, elevation: FROM.elevation, roll: FROM.roll };
    let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
    (renderer, camera, viewport)
}

/// The library's own picture of the scene.
fn expected(settings: layersplat::Settings) -> layersplat::Frame {
    let (mut renderer, camera, viewport) = library();
    renderer.render(&camera, viewport, &settings).unwrap().0
}

#[test]
fn depths_are_those_of_the_library() {
    let scene = Scene::new();
    let (mut renderer, camera, viewport) = library();
    let expected = renderer.depths(&camera, viewport, &layersplat::Settings::default()).unwrap();
    let pixels = viewport.pixels();
    let [mut first, mut mean] = [(); 2].map(|()| vec![-1.0f32; pixels + 1]);
    let mut find = |settings: *const Settings, floats| {
        // SAFETY: all arguments are alive.
        unsafe {
            let (first, mean) = (first.as_mut_ptr(), mean.as_mut_ptr());
            layersplat_render_depths(scene.renderer, &scene.camera, WIDTH, HEIGHT, settings, first, mean, floats)
        }
    };
    ok(find(null(), pixels + 1));
    assert_eq!(find(null(), pixels - 1), Status::TooSmall);
    let maximum = Settings { blend: BlendChoice::Maximum as i32, ..settings(0) };
    assert!(refused(find(&maximum, pixels), Status::InvalidArgument).contains("composite and iso"));
    assert!(expected.first().iter().any(|depth| depth.is_finite()));
    assert!(first[..pixels] == *expected.first() && mean[..pixels] == *expected.mean());
    assert_eq!((first[pixels], mean[pixels]), (-1.0, -1.0));
}

#[test]
fn pictures_have_the_bits_of_the_library() {
    let scene = Scene::new();
    let frame = expected(layersplat::Settings::default());
    let floats = scene.floats(null());
    assert!(floats.chunks(4).any(|p| p[3] > 0.1));
    assert!(floats == frame.pixels().as_flattened());
    assert!(scene.floats(&settings(QualityChoice::Standard as i32)) == floats);
    let color = [0.2, 0.4, 1.0f32];
    for background in [Background::Transparent, Background::Color(color)] {
        let pointer = if background == Background::Transparent { null() } else { color.as_ptr() };
        let mut pixels = vec![0u8; FLOATS + 3];
        // SAFETY: all arguments are alive.
        unsafe {
            let (pixels, capacity) = (pixels.as_mut_ptr(), pixels.len());
            ok(layersplat_render_rgba8(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), pointer, pixels, capacity));
        }
        assert!(pixels[..FLOATS] == frame.to_rgba8(background) && pixels[FLOATS..] == [0; 3]);
    }
    let slicing = Settings { algorithm: AlgorithmChoice::Slicing as i32, step: 0.8, ..settings(0) };
    assert!(scene.floats(&slicing) == expected(Algorithm::Slicing { step: 0.8 }.into()).pixels().as_flattened());
}

#[test]
fn shadows_have_the_bits_of_the_library() {
    let scene = Scene::new();
    let given = Settings { shadows: 1, ambient_occlusion: 1, light_grid: LightGridChoice::Half as i32, ..settings(1) };
    let lit = Shading { lights: Lights::BESIDE_CAMERA, ..Shading::default() };
    let shadowed = layersplat::Settings { shading: Some(lit), shadows: Some(Shadows::default()), ..Default::default() };
    let both =
        layersplat::Settings { ambient_occlusion: Some(AmbientOcclusion::default()), light_grid: LightGrid::Half, ..shadowed };
    let floats = scene.floats(&given);
    assert!(floats == expected(both).pixels().as_flattened());
    assert!(floats != expected(shadowed).pixels().as_flattened());
}

#[test]
fn the_studio_has_the_bits_of_the_library() {
    let scene = Scene::new();
    let plain = scene.floats(null());
    let look = Settings { look: LookChoice::Studio as i32, ..settings(1) };
    let own = layersplat::Settings::default().with_look(Look::Studio);
    let floats = scene.floats(&look);
    assert!(floats == expected(own).pixels().as_flattened() && floats != plain);
    let given = Settings { sky_top: [2.0, 0.5, 1.0], sky_strength: 0.75, scattering: 0.5, exposure: 1.5, tone: 0, ..look };
    let mut changed = own;
    let studio = changed.studio.as_mut().unwrap();
    (studio.sky.top, studio.sky.strength, studio.scattering) = ([2.0, 0.5, 1.0], 0.75, 0.5);
    (studio.exposure, studio.tone) = (1.5, Tone::None);
    let frame = expected(changed);
    assert!(scene.floats(&given) == frame.pixels().as_flattened());
    // The curve is that of bytes.
    let mut bytes = vec![0u8; FLOATS];
    // SAFETY: all arguments are alive.
    unsafe {
        ok(layersplat_render_rgba8(scene.renderer, &scene.camera, WIDTH, HEIGHT, &given, null(), bytes.as_mut_ptr(), FLOATS));
    }
    let curved = frame.to_rgba8(Background::Transparent);
    let largest = bytes.iter().zip(&curved).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(largest <= Some(1), "{largest:?}: the device and the host round alike to a step");
    // What the plain look has is refused, by its name.
    let both = Settings { shadows: 1, ..look };
    let mut none = [0f32; FLOATS];
    // SAFETY: all arguments are alive.
    let status =
        unsafe { layersplat_render_floats(scene.renderer, &scene.camera, WIDTH, HEIGHT, &both, none.as_mut_ptr(), FLOATS) };
    assert!(refused(status, Status::InvalidArgument).contains("the studio has shadows of its own"));
}

#[test]
fn saved_files_are_those_of_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let plain = expected(layersplat::Settings::default());
    let studio = expected(layersplat::Settings::default().with_look(Look::Studio));
    let look = Settings { look: LookChoice::Studio as i32, ..settings(1) };
    for (name, color, frame, given) in [
        ("a.png", None, &plain, null()),
        ("b.png", Some([1.0f32; 3]), &plain, null()),
        ("c.npy", None, &plain, null()),
        ("d.png", None, &studio, &raw const look),
        ("e.npy", None, &studio, &raw const look),
    ] {
        let floats = frame.pixels().as_flattened();
        let [ours, theirs] = ["ours", "theirs"].map(|which| folder.path().join(format!("{which}-{name}")));
        frame.save(&theirs, Some(color.map_or(Background::Transparent, Background::Color))).unwrap();
        let path = CString::new(ours.to_str().unwrap()).unwrap();
        let background = color.as_ref().map_or(null(), |c| c.as_ptr());
        // SAFETY: all arguments are alive.
        ok(unsafe { layersplat_save(floats.as_ptr(), FLOATS, WIDTH, HEIGHT, given, background, path.as_ptr()) });
        assert!(std::fs::read(ours).unwrap() == std::fs::read(theirs).unwrap(), "{name}");
    }
    let (path, floats) = (c"/nonexistent/a.png", plain.pixels().as_flattened());
    // SAFETY: all arguments are alive.
    let status = unsafe { layersplat_save(floats.as_ptr(), FLOATS, WIDTH, HEIGHT, null(), null(), path.as_ptr()) };
    assert!(refused(status, Status::File).contains("/nonexistent/a.png"));
}

/// Copied voxels may change afterwards; borrowed voxels are read in place.
#[test]
fn voxels_are_copied_or_borrowed() {
    let mut voxels: Vec<u8> = (0..27).collect();
    let grid = layersplat_grid_at_origin(3, 3, 3, 1.0, 2.0, 1.0);
    let first = voxels.as_mut_ptr();
    // SAFETY: all arguments are alive; borrowed voxels are not read while they change.
    unsafe {
        let copied = made(|out| layersplat_volume_copy(first.cast(), 27, VoxelType::Uint8 as i32, &grid, out));
        let borrowed = made(|out| layersplat_volume_borrow(first.cast(), 27, VoxelType::Uint8 as i32, &grid, out));
        let (mut smallest, mut largest) = (-1.0, -1.0);
        ok(layersplat_volume_range(copied, &mut smallest, &mut largest));
        assert_eq!((smallest, largest), (0.0, 26.0));
        let mut same = layersplat_grid_at_origin(0, 0, 0, 0.0, 0.0, 0.0);
        ok(layersplat_volume_grid(borrowed, &mut same));
        assert_eq!(same, grid);
        let device = made(|out| layersplat_device_open(null(), out));
        let transfer = made(|out| layersplat_transfer_open(c"grey".as_ptr(), copied, out));
        first.write_bytes(0, 27);
        let mut alphas = Vec::new();
        for volume in [copied, borrowed] {
            let renderer = made(|out| layersplat_renderer_new(device, volume, transfer, out));
            let mut pixels = vec![0f32; FLOATS];
            let camera = common::camera(volume);
            ok(layersplat_render_floats(renderer, &camera, WIDTH, HEIGHT, null(), pixels.as_mut_ptr(), FLOATS));
            alphas.push(pixels.chunks(4).map(|p| p[3]).fold(0.0, f32::max));
            layersplat_renderer_free(renderer);
            layersplat_volume_free(volume);
        }
        assert!(alphas[0] > 0.1 && alphas[1] == 0.0, "{alphas:?}");
        layersplat_transfer_free(transfer);
        layersplat_device_free(device);
    }
}

#[test]
fn cameras_are_those_of_the_library() {
    let grid = LibraryGrid::new([9, 8, 7], DVec3::new(1.0, 2.0, 3.0)).unwrap();
    let c_grid = layersplat_grid_at_origin(9, 8, 7, 1.0, 2.0, 3.0);
    let viewport = Viewport::new(WIDTH, HEIGHT).unwrap();
    let orbit = Orbit { azimuth: FROM.azimuth, elevation: FROM.elevation, roll: FROM.roll };
    let mut camera = EMPTY;
    // SAFETY: all arguments are alive.
    unsafe {
        ok(layersplat_camera_fit_grid(&c_grid, FROM, 30.0, WIDTH, HEIGHT, &mut camera));
        let made = layersplat::Camera::fit_perspective(grid.centre(), grid.diagonal(), 30.0, viewport, orbit);
        assert_eq!((camera.position, camera.view_up), (made.position.to_array(), made.view_up.to_array()));
        assert_eq!((camera.projection, camera.extent), (ProjectionChoice::Perspective as i32, 30.0));
        ok(layersplat_camera_orbit([1.0, 2.0, 3.0].as_ptr(), 5.0, FROM, ProjectionChoice::Parallel as i32, 2.0, &mut camera));
        assert_eq!((camera.focal_point, camera.projection, camera.extent), ([1.0, 2.0, 3.0], 0, 2.0));
        let nowhere = OrbitAngles { azimuth: f64::NAN, ..FROM };
        let status = layersplat_camera_fit_grid(&c_grid, nowhere, 30.0, WIDTH, HEIGHT, &mut camera);
        refused(status, Status::InvalidArgument);
        let scene = Scene::new();
        ok(layersplat_camera_fit_visible(scene.volume, scene.transfer, FROM, 0.0, WIDTH, HEIGHT, &mut camera));
        assert!(camera.extent > 0.0 && camera.extent < scene.camera.extent, "it is closer than the camera that fits the grid");
        let status = layersplat_camera_fit_visible(scene.volume, scene.transfer, nowhere, 0.0, WIDTH, HEIGHT, &mut camera);
        refused(status, Status::InvalidArgument);
    }
}

#[test]
fn a_frame_stops_at_its_time_limit() {
    let scene = Scene::new();
    let expected = scene.floats(null());
    let mut pixels = vec![7f32; FLOATS];
    // SAFETY: all arguments are alive.
    unsafe {
        ok(layersplat_renderer_limit(scene.renderer, 1e-9));
        let status = layersplat_render_floats(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), pixels.as_mut_ptr(), FLOATS);
        refused(status, Status::TooLong);
        assert!(pixels.iter().all(|&x| x == 7.0));
        ok(layersplat_renderer_limit(scene.renderer, 0.0));
    }
    assert!(scene.floats(null()) == expected);
}

#[test]
fn a_cancelled_frame_writes_no_pixels() {
    let scene = Scene::new();
    let expected = scene.floats(null());
    let mut pixels = vec![7f32; FLOATS];
    let pixels = pixels.as_mut_slice();
    // SAFETY: all arguments are alive.
    unsafe {
        let cancel = made(|out| layersplat_cancel_new(out));
        ok(layersplat_renderer_set_cancel(scene.renderer, cancel));
        assert!(scene.floats(null()) == expected);
        ok(layersplat_cancel_frames(cancel));
        let pointer = pixels.as_mut_ptr();
        let status = layersplat_render_floats(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), pointer, FLOATS);
        assert!(refused(status, Status::Cancelled).contains("cancelled"));
        assert!(pixels.iter().all(|&x| x == 7.0));
        ok(layersplat_cancel_reset(cancel));
        assert!(scene.floats(null()) == expected);
        ok(layersplat_cancel_frames(cancel));
        ok(layersplat_renderer_set_cancel(scene.renderer, null()));
        layersplat_cancel_free(cancel);
    }
    assert!(scene.floats(null()) == expected, "the flag is detached");
}

/// Another thread cancels while the renderer is in use. A call on the renderer itself would be rejected as busy.
#[test]
fn another_thread_cancels_frames() {
    struct Shared(*mut Cancel);
    // SAFETY: the header documents these handles as thread-safe.
    unsafe impl Sync for Shared {}
    let scene = Scene::new();
    let expected = scene.floats(null());
    // SAFETY: all arguments are alive.
    let cancel = Shared(made(|out| unsafe { layersplat_cancel_new(out) }));
    ok(unsafe { layersplat_renderer_set_cancel(scene.renderer, cancel.0) });
    let began = std::sync::Barrier::new(2);
    std::thread::scope(|scope| {
        let (cancel, began) = (&cancel, &began);
        scope.spawn(move || {
            began.wait();
            // SAFETY: it is alive.
            ok(unsafe { layersplat_cancel_frames(cancel.0) });
        });
        began.wait();
        let mut pixels = vec![0f32; FLOATS];
        // Frames go on until the other thread's call.
        let status = std::iter::repeat_with(|| unsafe {
            layersplat_render_floats(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), pixels.as_mut_ptr(), FLOATS)
        });
        let ended = status.take(LONGEST_WAIT).find(|&status| status != Status::Ok);
        assert_eq!(ended, Some(Status::Cancelled));
    });
    ok(unsafe { layersplat_cancel_reset(cancel.0) });
    assert!(scene.floats(null()) == expected);
    unsafe { layersplat_cancel_free(cancel.0) };
}

/// Transfer functions of points are used as given, and a renderer accepts a new one.
#[test]
fn transfer_functions_of_points() {
    let scene = Scene::new();
    let before = scene.floats(null());
    let colors = [ColorPoint { value: 0.0, color: [1.0, 0.0, 0.0] }];
    let opacities = [OpacityPoint { value: 0.0, opacity: 0.0 }, OpacityPoint { value: 255.0, opacity: 0.9 }];
    let mut none = null_mut();
    // SAFETY: all arguments are alive.
    unsafe {
        let transfer = made(|out| layersplat_transfer_points(colors.as_ptr(), 1, opacities.as_ptr(), 2, out));
        ok(layersplat_renderer_set_transfer(scene.renderer, transfer));
        layersplat_transfer_free(transfer);
        let status = layersplat_transfer_points(colors.as_ptr(), 1, null(), 0, &mut none);
        assert!(refused(status, Status::InvalidArgument).contains("at least one"));
    }
    let unlit = Settings { lit: 0, ..settings(1) };
    let after = scene.floats(&unlit);
    assert!(after != before && after.chunks(4).all(|p| p[1] == 0.0 && p[2] == 0.0 && p[0] <= p[3]), "{}", last_error());
}
