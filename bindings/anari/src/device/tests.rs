//! What the API does not show: voxels on the OpenCL device.

use super::*;
use crate::arrays::ApplicationMemory;

/// Sets a parameter to an object.
fn set(device: &Device, object: Handle, name: &CStr, value: Handle) {
    // SAFETY: the value is a handle.
    unsafe { device.set_parameter(object, name, ANARI_OBJECT, (&raw const value.0).cast()) }
}

fn array(device: &Device, element: DataType, dims: [u64; 3], rank: usize, memory: *const c_void) -> Handle {
    // SAFETY: the memory has the elements, and stays until the array is released.
    unsafe { device.new_array(ApplicationMemory { memory, deleter: None, user: std::ptr::null() }, element, dims, rank) }
}

/// A field of 2³ values.
fn field(device: &Device) -> Handle {
    let data = array(device, ANARI_FLOAT32, [2; 3], 3, std::ptr::null());
    let field = device.new_object(ANARI_SPATIAL_FIELD, c"structuredRegular");
    set(device, field, c"data", data);
    device.commit(field);
    device.release(data);
    field
}

#[test]
fn voxels_leave_the_opencl_device_with_their_field() {
    let device = Device::new(Handle(1), None, 0, c"default");
    let volume = device.new_object(ANARI_VOLUME, c"transferFunction1D");
    let volumes = array(&device, ANARI_VOLUME, [1; 3], 1, (&raw const volume.0).cast());
    let (world, frame) = (device.new_object(ANARI_WORLD, c""), device.new_object(ANARI_FRAME, c""));
    set(&device, world, c"volume", volumes);
    device.commit(world);
    let camera = device.new_object(ANARI_CAMERA, c"perspective");
    let renderer = device.new_object(ANARI_RENDERER, c"default");
    for (name, value) in [(c"world", world), (c"camera", camera), (c"renderer", renderer)] {
        set(&device, frame, name, value);
    }
    let (size, format) = ([4u32, 4], ANARI_UFIXED8_VEC4);
    // SAFETY: the values are of these types.
    unsafe {
        device.set_parameter(frame, c"size", ANARI_UINT32_VEC2, size.as_ptr().cast());
        device.set_parameter(frame, c"channel.color", ANARI_DATA_TYPE, (&raw const format).cast());
    }
    device.commit(frame);
    // More fields than renderers are kept.
    let fields: Vec<_> = (0..6).map(|_| field(&device)).collect();
    for (i, &field) in fields.iter().enumerate() {
        set(&device, volume, c"value", field);
        device.commit(volume);
        device.render(frame);
        assert!(device.is_ready(frame, true));
        assert_eq!(device.worker.painter().count(), (i + 1).min(4));
    }
    // Two volumes together have one renderer, which goes with any of their fields.
    let second = device.new_object(ANARI_VOLUME, c"transferFunction1D");
    set(&device, second, c"value", fields[0]);
    device.commit(second);
    let both = array(&device, ANARI_VOLUME, [2, 1, 1], 1, [volume.0, second.0].as_ptr().cast());
    set(&device, world, c"volume", both);
    device.commit(world);
    device.render(frame);
    assert!(device.is_ready(frame, true));
    assert_eq!(device.worker.painter().count(), 4);
    for &field in &fields[1..5] {
        device.release(field);
    }
    assert_eq!(device.worker.painter().count(), 2, "those of the last field and of both volumes");
    set(&device, world, c"volume", volumes);
    device.commit(world);
    for object in [both, second, fields[0]] {
        device.release(object);
    }
    assert_eq!(device.worker.painter().count(), 1, "that of both volumes went with a field");
    device.release(fields[5]);
    assert_eq!(device.worker.painter().count(), 1, "the volume has the last field");
    for object in [volume, volumes, world, frame, camera, renderer] {
        device.release(object);
    }
    assert_eq!(device.worker.painter().count(), 0);
}
