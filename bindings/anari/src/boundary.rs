//! The functions that the shim calls: pointers become values, and panics become messages.
//!
//! The safety contract is that of the API: pointers are null or valid, strings end with a zero, and memory of arrays stays until it is
//! released.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use crate::arrays::{ApplicationMemory, Deleter};
use crate::device::Device;
use crate::handle::Handle;
use crate::introspection;
use crate::status::{Callback, Problem};
use crate::types::DataType;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

unsafe extern "C" {
    fn layersplat_anari_shim_new_library(library: *mut c_void, callback: Option<Callback>, user: *const c_void) -> *mut c_void;
}

/// Makes the library. `anariLoadLibrary` finds this function by its name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn anari_library_layersplat_new_library(
    library: *mut c_void,
    callback: Option<Callback>,
    user: *const c_void,
) -> *mut c_void {
    // SAFETY: upheld by the caller.
    unsafe { layersplat_anari_shim_new_library(library, callback, user) }
}

/// Runs the body of a call. A panic becomes a message, and the result `otherwise`.
fn guard<R>(device: Option<&Device>, otherwise: R, call: impl FnOnce() -> R) -> R {
    // Unwind safety: the state behind locks is consistent between calls of the library.
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| {
        let told = AssertUnwindSafe(|| {
            if let Some(device) = device {
                device.call(|state| state.tell(Handle::NULL, Problem::panic(&*panic)));
            }
        });
        let _ = catch_unwind(told);
        otherwise
    })
}

/// A string; empty for null.
unsafe fn text<'a>(pointer: *const c_char) -> &'a CStr {
    // SAFETY: upheld by the caller.
    if pointer.is_null() { c"" } else { unsafe { CStr::from_ptr(pointer) } }
}

/// The device of a call, which the shim made and has not freed.
unsafe fn of<'a>(device: *const Device) -> &'a Device {
    // SAFETY: upheld by the shim.
    unsafe { &*device }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_new(
    handle: *mut c_void,
    callback: Option<Callback>,
    user: *const c_void,
    subtype: *const c_char,
) -> *mut Device {
    // SAFETY: upheld by the caller.
    let subtype = unsafe { text(subtype) };
    Box::into_raw(Box::new(Device::new(Handle(handle as usize), callback, user as usize, subtype)))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_free(device: *mut Device) {
    // SAFETY: it comes from `layersplat_anari_new`, and is not used again.
    guard(None, (), || drop(unsafe { Box::from_raw(device) }));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_new_array(
    device: *const Device,
    memory: *const c_void,
    deleter: Option<Deleter>,
    user: *const c_void,
    element: DataType,
    n1: u64,
    n2: u64,
    n3: u64,
    rank: c_int,
) -> usize {
    // SAFETY: upheld by the caller, here and below.
    let device = unsafe { of(device) };
    let given = ApplicationMemory { memory, deleter, user };
    guard(Some(device), 0, || unsafe { device.new_array(given, element, [n1, n2, n3], rank as usize) }.0)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_new_object(device: *const Device, data_type: DataType, subtype: *const c_char) -> usize {
    // SAFETY: upheld by the caller.
    let (device, subtype) = unsafe { (of(device), text(subtype)) };
    guard(Some(device), 0, || device.new_object(data_type, subtype).0)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_set_parameter(
    device: *const Device,
    object: usize,
    name: *const c_char,
    data_type: DataType,
    value: *const c_void,
) {
    // SAFETY: upheld by the caller, here and below.
    let (device, name) = unsafe { (of(device), text(name)) };
    guard(Some(device), (), || unsafe { device.set_parameter(Handle(object), name, data_type, value) });
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_unset_parameter(device: *const Device, object: usize, name: *const c_char) {
    // SAFETY: upheld by the caller.
    let (device, name) = unsafe { (of(device), text(name)) };
    guard(Some(device), (), || device.unset_parameter(Handle(object), name));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_unset_all_parameters(device: *const Device, object: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.unset_all_parameters(Handle(object)));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_map_parameter_array(
    device: *const Device,
    object: usize,
    name: *const c_char,
    element: DataType,
    n1: u64,
    n2: u64,
    n3: u64,
    rank: c_int,
    stride: *mut u64,
) -> *mut u8 {
    // SAFETY: upheld by the caller.
    let (device, name) = unsafe { (of(device), text(name)) };
    let map = || device.map_parameter_array(Handle(object), name, element, [n1, n2, n3], rank as usize);
    let (first, distance) = guard(Some(device), None, map).unwrap_or((std::ptr::null_mut(), 0));
    // SAFETY: upheld by the caller.
    if let Some(stride) = unsafe { stride.as_mut() } {
        *stride = distance;
    }
    first
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_unmap_parameter_array(device: *const Device, object: usize, name: *const c_char) {
    // SAFETY: upheld by the caller.
    let (device, name) = unsafe { (of(device), text(name)) };
    guard(Some(device), (), || device.unmap_parameter_array(Handle(object), name));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_commit(device: *const Device, object: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.commit(Handle(object)));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_release(device: *const Device, object: usize) -> c_int {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), false, || device.release(Handle(object))).into()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_retain(device: *const Device, object: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.retain(Handle(object)));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_map_array(device: *const Device, array: usize) -> *mut u8 {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), std::ptr::null_mut(), || device.map_array(Handle(array)))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_unmap_array(device: *const Device, array: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.unmap_array(Handle(array)));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_get_property(
    device: *const Device,
    object: usize,
    name: *const c_char,
    data_type: DataType,
    memory: *mut u8,
    size: u64,
    wait: u32,
) -> c_int {
    // SAFETY: upheld by the caller, here and below.
    let (device, name) = unsafe { (of(device), text(name)) };
    let read = || unsafe { device.property(Handle(object), name, data_type, memory, size, wait != 0) };
    guard(Some(device), false, read).into()
}

#[unsafe(no_mangle)]
extern "C" fn layersplat_anari_extensions() -> *const *const c_char {
    guard(None, std::ptr::null(), introspection::extensions)
}

#[unsafe(no_mangle)]
extern "C" fn layersplat_anari_subtypes(data_type: DataType) -> *const *const c_char {
    guard(None, std::ptr::null(), || introspection::subtypes(data_type))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_object_info(
    data_type: DataType,
    subtype: *const c_char,
    info: *const c_char,
    info_type: DataType,
) -> *const c_void {
    // SAFETY: upheld by the caller.
    let (subtype, info) = unsafe { (text(subtype), text(info)) };
    guard(None, std::ptr::null(), || introspection::object_info(data_type, subtype, info, info_type))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_parameter_info(
    data_type: DataType,
    subtype: *const c_char,
    parameter: *const c_char,
    parameter_type: DataType,
    info: *const c_char,
    info_type: DataType,
) -> *const c_void {
    // SAFETY: upheld by the caller.
    let (subtype, parameter, info) = unsafe { (text(subtype), text(parameter), text(info)) };
    let find = || introspection::parameter_info(data_type, subtype, parameter, parameter_type, info, info_type);
    guard(None, std::ptr::null(), find)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_map_frame(
    device: *const Device,
    frame: usize,
    channel: *const c_char,
    width: *mut u32,
    height: *mut u32,
    data_type: *mut DataType,
) -> *const c_void {
    // SAFETY: upheld by the caller.
    let (device, channel) = unsafe { (of(device), text(channel)) };
    let mapped = guard(Some(device), None, || device.map_channel(Handle(frame), channel));
    let size = mapped.as_ref().map_or([0, 0], |mapped| mapped.size);
    // SAFETY: upheld by the caller.
    unsafe {
        width.as_mut().into_iter().for_each(|width| *width = size[0]);
        height.as_mut().into_iter().for_each(|height| *height = size[1]);
        data_type.as_mut().into_iter().for_each(|to| *to = mapped.as_ref().map_or(anari_sys::ANARI_UNKNOWN, |m| m.data_type));
    }
    mapped.map_or(std::ptr::null(), |mapped| mapped.pixels)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_unmap_frame(device: *const Device, frame: usize, channel: *const c_char) {
    // SAFETY: upheld by the caller.
    let (device, channel) = unsafe { (of(device), text(channel)) };
    guard(Some(device), (), || device.unmap_channel(Handle(frame), channel));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_render_frame(device: *const Device, frame: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.render(Handle(frame)));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_frame_ready(device: *const Device, frame: usize, wait: u32) -> c_int {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), true, || device.is_ready(Handle(frame), wait != 0)).into()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn layersplat_anari_discard_frame(device: *const Device, frame: usize) {
    // SAFETY: upheld by the caller.
    let device = unsafe { of(device) };
    guard(Some(device), (), || device.discard(Handle(frame)));
}
