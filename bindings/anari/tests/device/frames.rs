//! Frames are drawn while the application goes on.

use crate::client::Device;
use crate::scene::{SIZE, Scene};
use anari_sys::*;
use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::Mutex;

/// What a callback saw.
#[derive(Default)]
struct Seen {
    calls: u32,
    first_pixel: Option<[u8; 4]>,
}

/// Maps the frame, which is complete.
unsafe extern "C" fn completed(user: *const c_void, device: ANARIDevice, frame: ANARIFrame) {
    // SAFETY: what it saw outlives the frame, and the frame lives.
    unsafe {
        let mut seen = (*user.cast::<Mutex<Seen>>()).lock().unwrap();
        seen.calls += 1;
        assert_eq!(anariFrameReady(device, frame, ANARI_WAIT), 1, "it does not wait for itself");
        let name = c"channel.color".as_ptr();
        let (mut width, mut height, mut data_type) = (0, 0, 0);
        let pixels = anariMapFrame(device, frame, name, &raw mut width, &raw mut height, &raw mut data_type);
        assert_eq!([width, height], SIZE);
        seen.first_pixel = Some(*pixels.cast::<[u8; 4]>());
        anariUnmapFrame(device, frame, name);
        // Calls for other objects are possible, too.
        anariRelease(device, anariNewWorld(device));
    }
}

#[test]
fn callbacks_see_the_complete_frame() {
    let (scene, seen) = (Scene::new(), Mutex::new(Seen::default()));
    let callback: ANARIFrameCompletionCallback = Some(completed);
    scene.frame.set_raw(c"frameCompletionCallback", ANARI_FRAME_COMPLETION_CALLBACK, (&raw const callback).cast());
    scene.frame.set_raw(c"frameCompletionCallbackUserData", ANARI_VOID_POINTER, (&raw const seen).cast()).commit();
    for calls in 1..=3 {
        // Waiting includes the callback.
        scene.frame.render();
        assert_eq!(seen.lock().unwrap().calls, calls);
    }
    let pixels = scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4);
    let bottom = (SIZE[1] as usize - 1) * SIZE[0] as usize;
    assert_eq!(seen.lock().unwrap().first_pixel, Some(pixels[bottom]));
    scene.frame.unset(c"frameCompletionCallback").commit().render();
    assert_eq!(seen.lock().unwrap().calls, 3);
    assert!(scene.frame.property::<f32>(c"duration").is_some_and(|duration| duration > 0.0));
    scene.device.expect_nothing();
}

/// Begins a frame without waiting for it.
fn begin(scene: &Scene) {
    // SAFETY: the device lives.
    unsafe { anariRenderFrame(scene.device.handle, scene.frame.handle) }
}

#[test]
fn frames_show_the_scene_of_their_beginning() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    // All that changes before the frame is complete counts for the next one.
    begin(&scene);
    scene.volume.set(c"unitDistance", 9.0f32).commit();
    scene.field.set(c"spacing", [2.0f32; 3]).commit();
    scene.world.unset(c"light").commit();
    assert_eq!(scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), before);
    scene.device.expect_nothing();
}

#[test]
fn discarded_frames_end_and_the_next_is_whole() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    for _ in 0..4 {
        begin(&scene);
        // SAFETY: the device lives.
        unsafe {
            anariDiscardFrame(scene.device.handle, scene.frame.handle);
            while anariFrameReady(scene.device.handle, scene.frame.handle, ANARI_NO_WAIT) == 0 {
                std::thread::yield_now();
            }
        }
    }
    scene.frame.render();
    assert_eq!(scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), before);
    scene.device.expect_nothing();
}

/// Everything may be released while a frame is being drawn.
#[test]
fn releases_during_a_frame() {
    let scene = Scene::new();
    scene.frame.set(c"size", [200u32, 150]).commit();
    begin(&scene);
    drop(scene);
    let scene = Scene::new();
    begin(&scene);
    let mut memory = vec![0.5f32; 1000];
    let array = scene.device.shared(ANARI_FLOAT32, &[10; 3], memory.as_ptr());
    scene.field.set_object(c"data", &array).commit();
    begin(&scene);
    scene.field.set_object(c"data", &scene.data).commit();
    drop(array);
    memory.fill(f32::NAN);
    drop(memory);
    scene.frame.render();
    scene.device.expect_nothing();
}

#[test]
fn frames_that_were_not_rendered_have_no_channels() {
    let device = Device::new();
    let frame = device.make(ANARI_FRAME, c"");
    let (mut width, mut height, mut data_type) = (1, 1, 1);
    // SAFETY: the device lives.
    unsafe {
        let name = c"channel.color".as_ptr();
        let pixels = anariMapFrame(device.handle, frame.handle, name, &raw mut width, &raw mut height, &raw mut data_type);
        assert!(pixels.is_null() && [width, height] == [0, 0] && data_type == ANARI_UNKNOWN);
        device.expect("was not rendered");
        assert_eq!(anariFrameReady(device.handle, frame.handle, ANARI_WAIT), 1);
        anariRenderFrame(device.handle, frame.handle);
        device.expect("has no size");
        frame.set(c"size", [4u32, 4]).commit();
        assert!(device.messages().iter().any(|message| message.contains("world, camera, renderer")));
        frame.render();
        assert_eq!(device.messages().len(), 3, "no world, no camera, no renderer");
        assert!(anariMapFrame(device.handle, frame.handle, name, null_mut(), null_mut(), null_mut()).is_null());
        device.expect("cannot be mapped");
        anariRenderFrame(device.handle, device.make(ANARI_WORLD, c"").handle);
        device.expect("only frames are rendered");
    }
}

/// Frames in the queue read arrays as they were when the frames began.
#[test]
fn mapping_and_releasing_wait_for_frames() {
    let scene = Scene::new();
    let device = &scene.device;
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    // A long frame, before one whose voxels are not uploaded yet.
    let long = device.make(ANARI_FRAME, c"");
    long.set_object(c"world", &scene.world).set_object(c"camera", &scene.camera).set_object(c"renderer", &scene.renderer);
    long.set(c"size", [200u32, 200]).set_type(c"channel.color", ANARI_FLOAT32_VEC4).commit();
    let mut memory = crate::scene::voxels().to_vec();
    for is_shared in [false, true] {
        let data = match is_shared {
            true => device.shared(ANARI_FLOAT32, &[crate::scene::SIDE; 3], memory.as_ptr()),
            false => device.array(ANARI_FLOAT32, &[crate::scene::SIDE; 3], &memory),
        };
        // SAFETY: the device lives, and the array has this many elements.
        unsafe {
            scene.field.set_object(c"data", &scene.data).commit();
            anariRenderFrame(device.handle, long.handle);
            scene.field.set_object(c"data", &data).commit();
            begin(&scene);
            if is_shared {
                scene.field.set_object(c"data", &scene.data).commit();
                drop(data);
                memory.fill(0.0);
            } else {
                let values = anariMapArray(device.handle, data.handle).cast::<f32>();
                std::slice::from_raw_parts_mut(values, memory.len()).fill(0.0);
                anariUnmapArray(device.handle, data.handle);
            }
        }
        let found = scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4);
        assert!(found == before, "shared: {is_shared}");
    }
    device.expect_nothing();
}
