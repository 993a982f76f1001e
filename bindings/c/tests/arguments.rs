//! Invalid arguments are reported, and the call has no effect.

mod common;

use common::{EMPTY, FLOATS, FROM, HEIGHT, Scene, WIDTH, last_error, made, refused, settings};
use layersplat_c::*;
use std::ffi::CStr;
use std::ptr::{null, null_mut};

/// Not UTF-8.
const ODD: &CStr = c"\xff";

/// Passes null for every pointer in turn.
#[test]
fn null_is_an_error_that_names_the_argument() {
    let scene = Scene::new();
    let grid = layersplat_grid_at_origin(1, 1, 1, 1.0, 1.0, 1.0);
    let [mut device, mut volume, mut transfer, mut renderer] = [(); 4].map(|_| null_mut::<u8>());
    let (device, volume) = (&raw mut device as *mut *mut Device, &raw mut volume as *mut *mut Volume);
    let (transfer, renderer) = (&raw mut transfer as *mut *mut Transfer, &raw mut renderer as *mut *mut Renderer);
    let (mut camera, mut name, mut count, mut size) = (EMPTY, [0; 99], 0, [0; 9]);
    let (mut bytes, mut floats) = (vec![0u8; FLOATS], vec![0f32; FLOATS]);
    let (bytes, floats) = (bytes.as_mut_ptr(), floats.as_mut_ptr());
    let (view, renders) = (&raw const scene.camera, scene.renderer);
    // SAFETY: pointers that are not null are valid.
    let calls = unsafe {
        [
            ("device", layersplat_device_open(null(), null_mut())),
            ("queue", layersplat_device_from_queue(null_mut(), null_mut(), null_mut(), device)),
            ("device", layersplat_device_with_memory(null(), 9, device)),
            ("limited", layersplat_device_with_memory(scene.device, 9, null_mut())),
            ("device", layersplat_device_name(null(), name.as_mut_ptr(), 99)),
            ("name", layersplat_device_name(scene.device, null_mut(), 99)),
            ("voxels", layersplat_volume_copy(null(), 1, 0, &grid, volume)),
            ("voxels", layersplat_volume_borrow(null(), 1, 0, &grid, volume)),
            ("grid", layersplat_volume_copy(bytes.cast(), 1, 0, null(), volume)),
            ("volume", layersplat_volume_copy(bytes.cast(), 1, 0, &grid, null_mut())),
            ("source", layersplat_volume_open(null(), volume)),
            ("source", layersplat_volume_open_part(null(), null(), 0, 0, volume)),
            ("volume", layersplat_volume_grid(null(), null_mut())),
            ("grid", layersplat_volume_grid(scene.volume, null_mut())),
            ("smallest", layersplat_volume_range(scene.volume, null_mut(), null_mut())),
            ("volume", layersplat_transfer_automatic(null(), transfer)),
            ("source", layersplat_transfer_open(null(), scene.volume, transfer)),
            ("colors", layersplat_transfer_points(null(), 1, null(), 0, transfer)),
            ("transfer", layersplat_transfer_stretched(null(), 0.0, 1.0, transfer)),
            ("centre", layersplat_camera_orbit(null(), 1.0, FROM, 0, 1.0, &mut camera)),
            ("camera", layersplat_camera_orbit([0.0; 3].as_ptr(), 1.0, FROM, 0, 1.0, null_mut())),
            ("grid", layersplat_camera_fit_grid(null(), FROM, 0.0, 9, 9, &mut camera)),
            ("transfer", layersplat_camera_fit_visible(scene.volume, null(), FROM, 0.0, 9, 9, &mut camera)),
            ("settings", layersplat_settings_default(1, null_mut(), size_of::<Settings>())),
            ("device", layersplat_renderer_new(null(), scene.volume, scene.transfer, renderer)),
            ("volume", layersplat_renderer_new(scene.device, null(), scene.transfer, renderer)),
            ("transfer", layersplat_renderer_new(scene.device, scene.volume, null(), renderer)),
            ("renderer", layersplat_renderer_new(scene.device, scene.volume, scene.transfer, null_mut())),
            ("voxels", layersplat_renderer_in_place(scene.device, null(), scene.transfer, renderer)),
            ("voxels", layersplat_voxels_find_range(scene.device, null_mut(), 0, null())),
            ("transfer", layersplat_renderer_set_transfer(renders, null())),
            ("renderer", layersplat_renderer_limit(null_mut(), 1.0)),
            ("camera", layersplat_render_rgba8(renders, null(), WIDTH, HEIGHT, null(), null(), bytes, FLOATS)),
            ("pixels", layersplat_render_rgba8(renders, view, WIDTH, HEIGHT, null(), null(), null_mut(), FLOATS)),
            ("renderer", layersplat_render_floats(null_mut(), view, WIDTH, HEIGHT, null(), floats, FLOATS)),
            ("pixels", layersplat_save(null(), FLOATS, WIDTH, HEIGHT, null(), null(), c"a.png".as_ptr())),
            ("path", layersplat_save(floats, FLOATS, WIDTH, HEIGHT, null(), null(), null())),
            ("picture", layersplat_renderer_enqueue(renders, view, 9, 9, null(), null(), 0, null(), null_mut())),
            ("renderer", layersplat_renderer_prepare(null_mut(), view, 9, 9, null())),
            ("wait_list", layersplat_renderer_volume_changed(renders, 1, null(), null_mut())),
            ("event 0 of wait_list", layersplat_renderer_volume_changed(renders, 1, &null_mut(), null_mut())),
            ("picture", layersplat_renderer_scratch_sizes(renders, view, 9, 9, null(), null(), size.as_mut_ptr(), 9, &mut count)),
            ("plan", layersplat_renderer_stream_plan(renders, view, 9, 9, null(), null_mut())),
            ("cancel", layersplat_cancel_new(null_mut())),
            ("cancel", layersplat_cancel_frames(null())),
            ("cancel", layersplat_cancel_reset(null())),
            ("renderer", layersplat_renderer_set_cancel(null_mut(), null())),
            ("buffers", layersplat_renderer_set_scratch(renders, null(), 1)),
        ]
        .map(|(name, status)| (name, status))
    };
    for (n, (name, status)) in calls.iter().enumerate() {
        assert_eq!(*status, Status::NullArgument, "call {n}, argument {name}");
    }
    assert_eq!(last_error(), "buffers is null");
    // SAFETY: null is accepted.
    unsafe {
        layersplat_device_free(null_mut());
        layersplat_volume_free(null_mut());
        layersplat_transfer_free(null_mut());
        layersplat_renderer_free(null_mut());
        layersplat_cancel_free(null_mut());
        assert!(layersplat_device_context(null()).is_null() && layersplat_device_queue(null()).is_null());
        assert!(layersplat_device_id(null()).is_null());
        assert!(!layersplat_device_context(scene.device).is_null() && !layersplat_device_queue(scene.device).is_null());
        assert!(!layersplat_device_id(scene.device).is_null());
    }
}

#[test]
fn invalid_names_are_reported() {
    let scene = Scene::new();
    let (mut device, mut volume, mut transfer) = (null_mut(), null_mut(), null_mut());
    let floats = vec![0f32; FLOATS];
    // SAFETY: all arguments are alive.
    unsafe {
        let odd = ODD.as_ptr();
        assert!(refused(layersplat_device_open(odd, &mut device), Status::NotUtf8).starts_with("name is not UTF-8"));
        refused(layersplat_volume_open(odd, &mut volume), Status::NotUtf8);
        refused(layersplat_transfer_open(odd, scene.volume, &mut transfer), Status::NotUtf8);
        refused(layersplat_save(floats.as_ptr(), FLOATS, WIDTH, HEIGHT, null(), null(), odd), Status::NotUtf8);
        let pink = c"pink";
        assert!(refused(layersplat_device_open(pink.as_ptr(), &mut device), Status::InvalidArgument).contains("pink"));
        assert!(
            refused(layersplat_transfer_open(pink.as_ptr(), null(), &mut transfer), Status::InvalidArgument).contains("fire")
        );
        refused(layersplat_volume_open(c"/nonexistent.raw".as_ptr(), &mut volume), Status::File);
        let zarr = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/formats/files/zarr/3_turned.zarr\0");
        let region = [1, 3, 0, 4, 2, 3];
        let part = layersplat_volume_open_part(zarr.as_ptr().cast(), region.as_ptr(), 0, 0, &mut volume);
        assert_eq!(part, Status::Ok);
        let mut grid = std::mem::zeroed::<Grid>();
        assert_eq!((layersplat_volume_grid(volume, &mut grid), grid.dims), (Status::Ok, [2, 4, 1]));
        layersplat_volume_free(volume);
        let none = [9, 9, 0, 4, 2, 3];
        let part = layersplat_volume_open_part(zarr.as_ptr().cast(), none.as_ptr(), 0, 0, &mut volume);
        assert!(refused(part, Status::InvalidArgument).contains("region"));
        refused(layersplat_volume_open(c"builtin:pink".as_ptr(), &mut volume), Status::InvalidArgument);
        assert!(device.is_null() && volume.is_null() && transfer.is_null(), "a failed call returns no handle");
    }
}

#[test]
fn invalid_numbers_are_reported() {
    let scene = Scene::new();
    let (mut volume, mut pixels, mut camera) = (null_mut(), vec![0f32; FLOATS], EMPTY);
    let voxels = [0u8; 8];
    let grid = layersplat_grid_at_origin(2, 2, 2, 1.0, 1.0, 1.0);
    // SAFETY: all arguments are alive.
    unsafe {
        let copy = |bytes, kind, grid: &Grid, volume: &mut *mut Volume| {
            refused(layersplat_volume_copy(voxels.as_ptr().cast(), bytes, kind, grid, volume), Status::InvalidArgument)
        };
        assert!(copy(7, 0, &grid, &mut volume).contains("8 bytes, found 7"));
        assert!(copy(8, 5, &grid, &mut volume).contains("5 is not a valid voxel type"));
        let huge = layersplat_grid_at_origin(usize::MAX, usize::MAX, 2, 1.0, 1.0, 1.0);
        copy(8, 0, &huge, &mut volume);
        copy(8, 0, &Grid { spacing: [0.0; 3], ..grid }, &mut volume);
        copy(8, 0, &Grid { direction: [[1.0; 3]; 3], ..grid }, &mut volume);

        let mut draw = |camera: &Camera, width, capacity, settings: *const Settings| {
            layersplat_render_floats(scene.renderer, camera, width, HEIGHT, settings, pixels.as_mut_ptr(), capacity)
        };
        let view = &scene.camera;
        let message = refused(draw(view, WIDTH, FLOATS - 1, null()), Status::TooSmall);
        assert!(message.contains(&format!("{} values, and {FLOATS} are needed", FLOATS - 1)), "{message}");
        refused(draw(view, 0, FLOATS, null()), Status::InvalidArgument);
        refused(draw(view, 1 << 20, FLOATS, null()), Status::InvalidArgument);
        refused(draw(&Camera { projection: 2, ..*view }, WIDTH, FLOATS, null()), Status::InvalidArgument);
        refused(draw(&Camera { extent: -1.0, ..*view }, WIDTH, FLOATS, null()), Status::InvalidArgument);
        refused(draw(&EMPTY, WIDTH, FLOATS, null()), Status::InvalidArgument);
        refused(draw(view, WIDTH, FLOATS, &Settings { size: 4, ..settings(1) }), Status::InvalidArgument);
        refused(draw(view, WIDTH, FLOATS, &Settings { step: -1.0, algorithm: 3, ..settings(1) }), Status::InvalidArgument);
        refused(draw(view, WIDTH, FLOATS, &Settings { unit_distance: f64::NAN, ..settings(1) }), Status::InvalidArgument);
        refused(draw(view, WIDTH, FLOATS, &Settings { gradient_point_count: 9, ..settings(1) }), Status::InvalidArgument);
        let shadowed = Settings { shadows: 1, ..settings(1) };
        let invalid = [
            Settings { shadow_strength: 1.5, ..shadowed },
            Settings { shadow_forgiveness: 0.5, ..shadowed },
            Settings { lit: 0, ..shadowed },
            Settings { algorithm: 3, ..shadowed },
            Settings { ambient_occlusion: 1, ao_reach: -1.0, ..settings(1) },
            Settings { ambient_occlusion: 1, ao_gain: 0.5, ..settings(1) },
        ];
        for invalid in &invalid {
            refused(draw(view, WIDTH, FLOATS, invalid), Status::InvalidArgument);
        }
        let unsorted = [[1.0, 0.5]; 8];
        let unsorted = Settings { gradient_point_count: 2, gradient_opacity: unsorted, ..settings(1) };
        refused(draw(view, WIDTH, FLOATS, &unsorted), Status::InvalidArgument);
        refused(layersplat_settings_default(4, &mut settings(1), size_of::<Settings>()), Status::InvalidArgument);
        refused(layersplat_settings_default(1, &mut settings(1), 12), Status::InvalidArgument);
        refused(layersplat_camera_orbit([0.0; 3].as_ptr(), 1.0, FROM, 7, 1.0, &mut camera), Status::InvalidArgument);
        let pink = [2.0f32, 0.0, 0.0];
        let mut bytes = vec![0u8; FLOATS];
        let bytes = bytes.as_mut_ptr();
        let status = layersplat_render_rgba8(scene.renderer, view, WIDTH, HEIGHT, null(), pink.as_ptr(), bytes, FLOATS);
        assert!(refused(status, Status::InvalidArgument).contains("background"));
        refused(
            layersplat_save(pixels.as_ptr(), FLOATS, WIDTH, HEIGHT + 1, null(), null(), c"a.png".as_ptr()),
            Status::InvalidArgument,
        );
        let mut name = [0; 2];
        refused(layersplat_device_name(scene.device, name.as_mut_ptr(), 2), Status::TooSmall);
    }
    assert!(volume.is_null());
    assert!(scene.floats(null()).iter().any(|&x| x > 0.0), "the renderer stays usable");
}

/// Several threads share a device, a volume and a transfer function, each with its own renderer.
#[test]
fn threads_share_immutable_handles() {
    struct Shared<'a>(&'a Scene);
    // SAFETY: the header documents these handles as thread-safe.
    unsafe impl Sync for Shared<'_> {}
    let scene = Scene::new();
    let expected = scene.floats(null());
    let shared = &Shared(&scene);
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                let scene = { shared }.0;
                let mut pixels = vec![0f32; FLOATS];
                // SAFETY: all arguments are alive.
                unsafe {
                    let renderer = made(|out| layersplat_renderer_new(scene.device, scene.volume, scene.transfer, out));
                    let pixels = pixels.as_mut_ptr();
                    common::ok(layersplat_render_floats(renderer, &scene.camera, WIDTH, HEIGHT, null(), pixels, FLOATS));
                    layersplat_renderer_free(renderer);
                }
                assert!(pixels == expected);
            });
        }
    });
}
