//! Objects, references and memory of arrays.

use crate::client::Device;
use crate::scene::{OPACITIES, SIDE, Scene, difference, voxels};
use anari_sys::*;
use std::ffi::c_void;
use std::ptr::null;
use std::sync::atomic::{AtomicU32, Ordering};

/// Counts its calls.
unsafe extern "C" fn count(user: *const c_void, _: *const c_void) {
    // SAFETY: the counter outlives the arrays.
    unsafe { &*user.cast::<AtomicU32>() }.fetch_add(1, Ordering::SeqCst);
}

#[test]
fn memory_that_was_given_away_is_freed_once() {
    let (device, freed) = (Device::new(), AtomicU32::new(0));
    let user = (&raw const freed).cast();
    let values = [0.5f32; 8];
    let array = device.given(ANARI_FLOAT32, &[2, 2, 2], values.as_ptr(), Some(count), user);
    let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
    field.set_object(c"data", &array).commit();
    drop(array);
    assert_eq!(freed.load(Ordering::SeqCst), 0, "the field needs it");
    field.unset(c"data");
    assert_eq!(freed.load(Ordering::SeqCst), 0, "the unset is not committed");
    field.set_raw(c"data", ANARI_ARRAY3D, null());
    device.expect("is null");
    drop(field);
    assert_eq!(freed.load(Ordering::SeqCst), 1);
    // Arrays that cannot be made free their memory, too.
    drop(device.given(ANARI_UNKNOWN, &[8], values.as_ptr(), Some(count), user));
    device.expect("arrays cannot have elements");
    drop(device.given(ANARI_FLOAT32, &[u64::MAX, u64::MAX, 8], values.as_ptr(), Some(count), user));
    device.expect("cannot be made");
    assert_eq!(freed.load(Ordering::SeqCst), 3);
    drop(device.shared(ANARI_FLOAT64, &[1 << 20, 1 << 20, 1 << 10], null::<f64>()));
    device.expect("no memory");
}

/// After its release, the application may do what it wants with shared memory.
#[test]
fn shared_memory_is_copied_when_it_is_released() {
    let scene = Scene::new();
    let expected = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let mut memory = voxels().to_vec();
    let array = scene.device.shared(ANARI_FLOAT32, &[SIDE; 3], memory.as_ptr());
    scene.field.set_object(c"data", &array).commit();
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), expected);
    drop(array);
    memory.fill(1.0);
    drop(memory);
    // A change that makes the volume anew.
    scene.field.set(c"spacing", [1.0f32, 1.0, 1.5]).commit();
    let stretched = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    scene.field.unset(c"spacing").commit();
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), expected);
    assert!(difference(&stretched, &expected) > 20.0);
    scene.device.expect_nothing();
}

#[test]
fn mapped_arrays_change_the_next_frame() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    // SAFETY: it has this many elements.
    unsafe {
        let values = anariMapArray(scene.device.handle, scene.data.handle).cast::<f32>();
        scene.frame.render();
        scene.device.expect("is mapped");
        std::slice::from_raw_parts_mut(values, voxels().len()).iter_mut().for_each(|value| *value = 1.0 - *value);
        anariUnmapArray(scene.device.handle, scene.data.handle);
        anariUnmapArray(scene.device.handle, scene.data.handle);
    }
    scene.device.expect("not mapped");
    scene.frame.render();
    assert!(difference(&before, &scene.frame.channel(c"channel.color", ANARI_UFIXED8_VEC4)) > 50.0);
}

#[test]
fn arrays_of_parameters_are_mapped_directly() {
    let scene = Scene::new();
    let expected = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let (device, volume) = (scene.device.handle, scene.volume.handle);
    scene.volume.unset(c"opacity").commit();
    let mut stride = 0;
    let name = c"opacity".as_ptr();
    // SAFETY: it has this many elements.
    unsafe {
        let values = anariMapParameterArray1D(device, volume, name, ANARI_FLOAT32, OPACITIES.len() as u64, &raw mut stride);
        assert_eq!(stride, 4);
        values.cast::<f32>().copy_from_nonoverlapping(OPACITIES.as_ptr(), OPACITIES.len());
        scene.volume.set(c"opacity", 0.5f32);
        scene.device.expect("is mapped");
        anariUnmapParameterArray(device, volume, name);
        scene.volume.commit();
        assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), expected);
        scene.device.expect_nothing();
        let mut refused = |name: &std::ffi::CStr, element| {
            let values = anariMapParameterArray1D(device, volume, name.as_ptr(), element, 4, &raw mut stride);
            assert!(values.is_null());
        };
        refused(c"opacity", ANARI_FLOAT32_VEC3);
        scene.device.expect("cannot be an array of FLOAT32_VEC3");
        refused(c"nonsense", ANARI_FLOAT32);
        scene.device.expect("not a parameter");
        anariUnmapParameterArray(device, volume, c"value".as_ptr());
        scene.device.expect("not mapped");
    }
}

#[test]
fn parameters_count_from_the_commit_on() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    scene.volume.set(c"unitDistance", 9.0f32);
    scene.camera.unset(c"position");
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), before);
    scene.volume.commit();
    let after = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    assert!(difference(&before, &after) > 20.0);
    // SAFETY: the device lives.
    unsafe { anariUnsetAllParameters(scene.device.handle, scene.volume.handle) };
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), after);
    scene.device.expect_nothing();
    scene.volume.commit();
    scene.device.expect("required parameters are not set: value");
}

/// Objects stay as long as the scene needs them; their handles are unknown afterwards.
#[test]
fn references_of_the_application_and_of_objects() {
    let Scene { device, data, field, volume, light, world, camera, renderer, frame } = Scene::new();
    let before = frame.render().channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4);
    let released = field.handle;
    drop((data, field, volume, light, world, camera, renderer));
    assert_eq!(frame.render().channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), before);
    device.expect_nothing();
    // SAFETY: handles are numbers.
    unsafe { anariRelease(device.handle, released) };
    device.expect("released already");
    drop(frame);
    unsafe {
        anariRetain(device.handle, released);
        anariCommitParameters(device.handle, released);
        anariRelease(device.handle, released);
        anariRelease(device.handle, null::<c_void>().cast_mut());
    }
    assert_eq!(device.messages().len(), 3, "null is no object, and not an error");
}

#[test]
fn every_wrong_parameter_is_told() {
    let scene = Scene::new();
    let (device, volume) = (&scene.device, &scene.volume);
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    volume.set(c"nonsense", 1.0f32);
    device.expect("VOLUME has no parameter 'nonsense'");
    volume.set(c"unitDistance", 1u32);
    device.expect("unitDistance is FLOAT32, not UINT32");
    volume.set(c"unitDistance", f32::NAN);
    device.expect("contains NaN");
    volume.set_object(c"value", &scene.camera);
    device.expect("value is SPATIAL_FIELD, not CAMERA");
    let unknown = 12_345_678usize;
    volume.set_raw(c"value", ANARI_SPATIAL_FIELD, (&raw const unknown).cast());
    device.expect("does not know");
    volume.set_object(c"color", &scene.data);
    device.expect("not ARRAY3D");
    volume.set_object(c"opacity", &device.array(ANARI_UFIXED8, &[2], &[0u8, 255]));
    device.expect("an array of FLOAT32, not of UFIXED8");
    scene.field.set_text(c"filter", c"nearest");
    device.expect("filter is linear, cubic, not 'nearest'");
    scene.frame.set_type(c"channel.color", ANARI_FLOAT64);
    device.expect("not FLOAT64");
    scene.frame.set_type(c"channel.color", 123_456);
    device.expect("unknown type 123456");
    scene.renderer.set_text(c"quality", c"best");
    device.expect("draft, standard, high, paper");
    for object in [volume, &scene.field, &scene.renderer] {
        object.set_text(c"name", c"a name is no problem").commit();
    }
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), before, "all stayed as it was");
    device.expect_nothing();
    volume.set(c"valueRange", [1.0f64, 0.0]).commit();
    scene.frame.render();
    device.expect("the first must not be above the second");
    scene.renderer.set(c"pixelSamples", 100i32);
    device.expect("100, beyond its limits: 16");
    scene.frame.set(c"size", [0u32, 10]).commit().render();
    device.expect("not drawn");
    scene.camera.set(c"direction", [0.0f32; 3]).commit();
    scene.frame.set(c"size", [8u32, 8]).commit().render();
    assert!(device.messages().iter().any(|message| message.contains("position and focal point")));
}

/// Surfaces, other lights, other volumes: messages, and a picture without them.
#[test]
fn unsupported_objects_are_told_and_harmless() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let device = &scene.device;
    let geometry = device.make(ANARI_GEOMETRY, c"triangle");
    device.expect("GEOMETRY 'triangle' is not supported");
    let positions = device.array(ANARI_FLOAT32_VEC3, &[3], &[[0.0f32; 3]; 3]);
    geometry.set_object(c"vertex.position", &positions).commit();
    let mut stride = 0;
    // SAFETY: it has this many elements.
    unsafe {
        let name = c"primitive.index".as_ptr();
        let to = anariMapParameterArray1D(device.handle, geometry.handle, name, ANARI_UINT32_VEC3, 100, &raw mut stride);
        assert!(!to.is_null() && stride == 12, "programs may write it without a look");
        to.cast::<u8>().write_bytes(1, 1200);
        anariUnmapParameterArray(device.handle, geometry.handle, name);
    }
    let material = device.make(ANARI_MATERIAL, c"matte");
    device.expect("MATERIAL 'matte'");
    let surface = device.make(ANARI_SURFACE, c"");
    surface.set_object(c"geometry", &geometry).set_object(c"material", &material).commit();
    let point = device.make(ANARI_LIGHT, c"point");
    device.expect("LIGHT 'point'");
    let other = device.make(ANARI_VOLUME, c"other");
    device.expect("VOLUME 'other'");
    let sampler = device.make(ANARI_SAMPLER, c"image2D");
    device.expect("SAMPLER 'image2D'");
    let instance = device.make(ANARI_INSTANCE, c"motionTransform");
    device.expect("it is 'transform'");
    drop((sampler, instance));
    scene.world.set_object(c"surface", &device.objects(&[&surface]));
    scene.world.set_object(c"light", &device.objects(&[&scene.light, &point]));
    scene.world.set_object(c"volume", &device.objects(&[&other, &scene.volume])).commit();
    scene.frame.render();
    device.expect("1 surfaces are not drawn");
    assert_eq!(scene.frame.channel::<[u8; 4]>(c"channel.color", ANARI_UFIXED8_VEC4), before);
    let omnidirectional = device.make(ANARI_CAMERA, c"omnidirectional");
    device.expect("CAMERA 'omnidirectional'");
    scene.frame.set_object(c"camera", &omnidirectional).commit().render();
    assert!(device.messages().iter().any(|message| message.contains("no camera")));
}

/// pynari declares the elements of all arrays of objects as OBJECT.
#[test]
fn arrays_of_any_objects_are_of_the_type_of_the_first() {
    let scene = Scene::new();
    let before = scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4);
    let device = &scene.device;
    let handles = [scene.volume.handle];
    let volumes = device.shared(ANARI_OBJECT, &[1], handles.as_ptr());
    scene.world.unset(c"volume").commit().set_object(c"volume", &volumes).commit();
    assert_eq!(scene.colors::<[u8; 4]>(ANARI_UFIXED8_VEC4), before);
    device.expect_nothing();
    scene.world.set_object(c"light", &volumes);
    device.expect("an array of LIGHT, not of VOLUME");
    // An instance of a group must not be an object of that group.
    let (group, instance) = (device.make(ANARI_GROUP, c""), device.make(ANARI_INSTANCE, c"transform"));
    let empty = device.shared(ANARI_OBJECT, &[1], null::<ANARIObject>());
    group.set_object(c"volume", &empty);
    device.expect("not of OBJECT");
    instance.set_object(c"group", &group).commit();
    let handles = [instance.handle, device.handle, scene.world.handle];
    let array = device.shared(ANARI_OBJECT, &[3], handles.as_ptr());
    device.expect("2 elements are not INSTANCE");
    group.set_object(c"volume", &array);
    device.expect("an array of VOLUME, not of INSTANCE");
}
