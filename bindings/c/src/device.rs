//! Devices.

use crate::Status;
use crate::border::{Failure, Out, borrowed, copy, free, guard, text};
use crate::opencl::{_cl_command_queue, _cl_context, _cl_device_id};
use layersplat::DeviceChoice;
use std::ffi::c_char;

/// An OpenCL device with a context and a queue, and the kernels that were built for it. Any thread may use it, several at a time.
pub struct Device(pub(crate) layersplat::Device);

/// Opens a device with a context and a queue of its own. `name` is an index, or part of a device's or a platform's name in any case;
/// null takes the first GPU, or where there is none, the first CPU. To be freed by layersplat_device_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_open(name: *const c_char, device: *mut *mut Device) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { Out::handle(device, "device") }?;
        let choice = match name.is_null() {
            true => DeviceChoice::Default,
            // SAFETY: the caller's promise.
            false => DeviceChoice::Named(unsafe { text(name, "name") }?.into()),
        };
        out.give(Device(layersplat::Device::open(&choice)?));
        Ok(())
    })
}

/// The device of a cl_command_queue of the caller's, which may be in order or out of order, and is used for everything. `context` and
/// `id` are the queue's cl_context and cl_device_id; null takes whatever the queue has.
///
/// Queue and context are retained, and released when the device and all renderers that were made from it are freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_from_queue(
    context: *mut _cl_context,
    id: *mut _cl_device_id,
    queue: *mut _cl_command_queue,
    device: *mut *mut Device,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { Out::handle(device, "device") }?;
        if queue.is_null() {
            return Err(Failure::new(Status::NullArgument, "queue is null"));
        }
        // SAFETY: the caller's promise: it is a queue, and alive.
        let of_queue = unsafe { layersplat::Device::from_raw_queue(queue.cast()) }?;
        let context = if context.is_null() { of_queue.context() } else { context.cast() };
        let id = if id.is_null() { of_queue.id() } else { id.cast() };
        if of_queue.context() != context || of_queue.id() != id {
            return Err(Failure::new(Status::Unsuitable, "the queue is of another context or device than those given"));
        }
        out.give(Device(of_queue));
        Ok(())
    })
}

/// The same device with a memory budget: buffers that renderers make through the new handle take at most `bytes` together. Volumes that do
/// not fit are streamed in parts, to the same picture. Streaming covers layers on a lattice; views and settings that need all
/// voxels at once return LAYERSPLAT_STATUS_OUT_OF_MEMORY, and calls that do LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME. The message of
/// layersplat_last_error() says how many bytes are enough. Each handle has a budget of its own. To be freed by layersplat_device_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_with_memory(device: *const Device, bytes: u64, limited: *mut *mut Device) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(limited, "limited") }?;
        let device = unsafe { borrowed(device, "device") }?;
        out.give(Device(device.0.with_memory(bytes)));
        Ok(())
    })
}

/// The device's name, with the zero byte at its end, into `room` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_name(device: *const Device, name: *mut c_char, room: usize) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        let device = unsafe { borrowed(device, "device") }?;
        let text: Vec<c_char> = device.0.info().name.bytes().chain([0]).map(|byte| byte as c_char).collect();
        // SAFETY: the caller's promise.
        unsafe { copy(&text, name, room, "name") }
    })
}

/// The device's cl_context, for buffers of its own to render from or into. It is not retained: it lives as long as the device. Null if
/// `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_context(device: *const Device) -> *mut _cl_context {
    // SAFETY: the caller's promise.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.context().cast())
}

/// The device's cl_device_id; null if `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_id(device: *const Device) -> *mut _cl_device_id {
    // SAFETY: the caller's promise.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.id().cast())
}

/// The device's cl_command_queue, not retained: it lives as long as the device. Null if `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_queue(device: *const Device) -> *mut _cl_command_queue {
    // SAFETY: the caller's promise.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.queue().cast())
}

/// Frees a device. Renderers that were made from it go on. Null is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_free(device: *mut Device) {
    // SAFETY: the caller's promise.
    unsafe { free(device) }
}
