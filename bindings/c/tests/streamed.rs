//! Volumes larger than a memory budget are streamed; the picture is identical.

mod common;

use common::{FLOATS, HEIGHT, Scene, WIDTH, made, ok, refused, settings};
use layersplat_c::*;
use std::ptr::{null, null_mut};

/// Voxels along each side. They take more memory than the tables of a frame, about a megabyte.
const SIDE: usize = 160;
/// Half of the voxels.
const BUDGET: u64 = (SIDE * SIDE * SIDE / 2) as u64;

/// A scene of this size, whose renderer holds the whole volume.
fn scene() -> Scene {
    Scene::open(&format!("builtin:hydrogen@{SIDE}"))
}

/// Replaces the scene's renderer by one with a memory budget.
fn with_budget(scene: &mut Scene, bytes: u64) {
    // SAFETY: all arguments are alive.
    unsafe {
        let limited = made(|out| layersplat_device_with_memory(scene.device, bytes, out));
        layersplat_renderer_free(scene.renderer);
        scene.renderer = made(|out| layersplat_renderer_new(limited, scene.volume, scene.transfer, out));
        layersplat_device_free(limited);
    }
}

fn plan(scene: &Scene, settings: *const Settings) -> (Status, StreamPlan) {
    let mut plan = StreamPlan::default();
    // SAFETY: all arguments are alive.
    let status = unsafe { layersplat_renderer_stream_plan(scene.renderer, &scene.camera, WIDTH, HEIGHT, settings, &mut plan) };
    (status, plan)
}

#[test]
fn a_streamed_volume_has_the_same_picture() {
    let mut scene = scene();
    let expected = scene.floats(null());
    assert!(expected.iter().any(|&x| x > 0.1));
    assert_eq!(plan(&scene, null()), (Status::Ok, StreamPlan { parts: 1, ..StreamPlan::default() }));
    with_budget(&mut scene, BUDGET);
    let (status, plan) = plan(&scene, null());
    ok(status);
    assert!(plan.parts > 1 && plan.device_bytes <= BUDGET, "{plan:?}");
    assert_eq!((plan.volume_bytes, plan.available_bytes), (2 * BUDGET, BUDGET));
    // As in the library's tests/rendering/streamed.rs, no difference is allowed.
    assert!(scene.floats(null()) == expected);
    let mut bytes = vec![0u8; FLOATS];
    // SAFETY: all arguments are alive. The streaming renderer keeps the volume.
    unsafe {
        layersplat_volume_free(scene.volume);
        scene.volume = null_mut();
        let pixels = bytes.as_mut_ptr();
        ok(layersplat_render_rgba8(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), null(), pixels, FLOATS));
        ok(layersplat_renderer_prepare(scene.renderer, &scene.camera, WIDTH, HEIGHT, null()));
    }
    assert!(bytes.iter().any(|&x| x > 20));
    assert!(scene.floats(null()) == expected);
}

/// By a renderer that streams, and by one that holds the whole volume.
#[test]
fn another_volume_replaces_the_first() {
    let other = Scene::open(&format!("builtin:marschner-lobb@{}", SIDE / 2));
    for budget in [None, Some(BUDGET)] {
        let mut scene = scene();
        let mut expected = Scene::open(&format!("builtin:marschner-lobb@{}", SIDE / 2));
        if let Some(bytes) = budget {
            with_budget(&mut scene, bytes);
        }
        assert!(scene.floats(null()).iter().any(|&x| x > 0.1));
        // SAFETY: all arguments are alive.
        unsafe {
            ok(layersplat_renderer_set_volume(scene.renderer, other.volume));
            ok(layersplat_renderer_set_transfer(expected.renderer, scene.transfer));
            expected.camera = scene.camera;
            refused(layersplat_renderer_set_volume(scene.renderer, null()), Status::NullArgument);
        }
        assert!(scene.floats(null()) == expected.floats(null()), "{budget:?}");
    }
}

#[test]
fn calls_that_need_the_whole_volume_are_rejected() {
    let mut scene = scene();
    with_budget(&mut scene, BUDGET);
    let slicing = Settings { algorithm: AlgorithmChoice::Slicing as i32, step: 0.8, ..settings(0) };
    assert!(refused(plan(&scene, &slicing).0, Status::OutOfMemory).contains("whole volume"));
    let mut depths = vec![0f32; FLOATS];
    let (renderer, depths) = (scene.renderer, depths.as_mut_ptr());
    // SAFETY: all arguments are alive.
    unsafe {
        let status = layersplat_render_depths(renderer, &scene.camera, WIDTH, HEIGHT, null(), depths, depths, FLOATS);
        assert!(refused(status, Status::OutOfMemory).contains("set at least"));
        let message = refused(layersplat_renderer_volume_changed(renderer, 0, null(), null_mut()), Status::NeedsWholeVolume);
        assert!(message.starts_with("layersplat_renderer_volume_changed needs"), "{message}");
        assert!(message.contains("render into host memory instead"), "{message}");
        refused(layersplat_renderer_set_scratch(renderer, null(), 0), Status::NeedsWholeVolume);
    }
    assert!(scene.floats(null()).iter().any(|&x| x > 0.1), "the renderer stays usable");
}

#[test]
fn a_budget_too_small_for_one_layer_is_an_error() {
    let mut scene = scene();
    with_budget(&mut scene, 1000);
    let mut pixels = vec![7f32; FLOATS];
    // SAFETY: all arguments are alive.
    let status =
        unsafe { layersplat_render_floats(scene.renderer, &scene.camera, WIDTH, HEIGHT, null(), pixels.as_mut_ptr(), FLOATS) };
    let message = refused(status, Status::OutOfMemory);
    assert!(message.contains("the memory budget is 1000: set at least"), "{message}");
    assert!(pixels.iter().all(|&x| x == 7.0));
    refused(plan(&scene, null()).0, Status::OutOfMemory);
}
