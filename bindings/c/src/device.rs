//! Devices.

use crate::Status;
use crate::boundary::{Failure, Out, borrowed, copy, free, guard, text};
use crate::opencl::{_cl_command_queue, _cl_context, _cl_device_id};
use layersplat::DeviceChoice;
use std::ffi::c_char;

/// An OpenCL device with a context, a queue and its compiled kernels. Several threads may use it at the same time.
pub struct Device(pub(crate) layersplat::Device);

/// Opens a device with its own context and queue. `name` is an index, or part of a device or platform name (case-insensitive). Null
/// selects the first GPU, or the first CPU if there is no GPU. To be freed by layersplat_device_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_open(name: *const c_char, device: *mut *mut Device) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        let out = unsafe { Out::handle(device, "device") }?;
        let choice = match name.is_null() {
            true => DeviceChoice::Default,
            // SAFETY: upheld by the caller.
            false => DeviceChoice::Named(unsafe { text(name, "name") }?.into()),
        };
        out.set_handle(Device(layersplat::Device::open(&choice)?));
        Ok(())
    })
}

/// Creates a device from a cl_command_queue of the caller. All commands go to this queue, which may be in-order or out-of-order.
/// `context` and `id` are the queue's cl_context and cl_device_id, checked against it; null skips the check.
///
/// Queue and context are retained. They are released when the device and all its renderers are freed. To be freed by
/// layersplat_device_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_from_queue(
    context: *mut _cl_context,
    id: *mut _cl_device_id,
    queue: *mut _cl_command_queue,
    device: *mut *mut Device,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        let out = unsafe { Out::handle(device, "device") }?;
        if queue.is_null() {
            return Err(Failure::new(Status::NullArgument, "queue is null"));
        }
        // SAFETY: upheld by the caller: it is a queue, and alive.
        let opened = unsafe { layersplat::Device::from_raw_queue(queue.cast()) }?;
        let context = if context.is_null() { opened.context() } else { context.cast() };
        let id = if id.is_null() { opened.id() } else { id.cast() };
        if opened.context() != context || opened.id() != id {
            return Err(Failure::new(Status::Unsuitable, "the queue belongs to another context or device than context and id"));
        }
        out.set_handle(Device(opened));
        Ok(())
    })
}

/// A handle to the same device with a memory budget: the buffers of all renderers made with it take at most `bytes` together.
/// Volumes that do not fit are streamed in parts; the picture is identical. Streaming supports layers on a lattice. Views and
/// settings that need all voxels at once return LAYERSPLAT_STATUS_OUT_OF_MEMORY, and the message states how many bytes are enough.
/// Calls that need the whole volume return LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME. Each handle has its own budget. To be freed by
/// layersplat_device_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_with_memory(device: *const Device, bytes: u64, limited: *mut *mut Device) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(limited, "limited") }?;
        let device = unsafe { borrowed(device, "device") }?;
        out.set_handle(Device(device.0.with_memory(bytes)));
        Ok(())
    })
}

/// Copies the name of the device, zero-terminated, to `name`, an array of `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_name(device: *const Device, name: *mut c_char, capacity: usize) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        let device = unsafe { borrowed(device, "device") }?;
        let text: Vec<c_char> = device.0.info().name.bytes().chain([0]).map(|byte| byte as c_char).collect();
        // SAFETY: upheld by the caller.
        unsafe { copy(&text, name, capacity, "name") }
    })
}

/// The device's cl_context, for example to create buffers for voxels and pictures. It is not retained: it lives as long as the
/// device. Null if `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_context(device: *const Device) -> *mut _cl_context {
    // SAFETY: upheld by the caller.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.context().cast())
}

/// The device's cl_device_id; null if `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_id(device: *const Device) -> *mut _cl_device_id {
    // SAFETY: upheld by the caller.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.id().cast())
}

/// The device's cl_command_queue, not retained: it lives as long as the device. Null if `device` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_queue(device: *const Device) -> *mut _cl_command_queue {
    // SAFETY: upheld by the caller.
    unsafe { device.as_ref() }.map_or(std::ptr::null_mut(), |device| device.0.queue().cast())
}

/// Frees a device. Renderers that were made from it stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_device_free(device: *mut Device) {
    // SAFETY: upheld by the caller.
    unsafe { free(device) }
}
