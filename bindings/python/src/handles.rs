//! Raw handles of other packages' OpenCL objects.

use crate::errors::{Failure, Result};
use crate::event::Event;
use crate::given::refused;
use layersplat::Error;
use layersplat::device::DeviceMemory;
use layersplat::opencl3::event::{Event as ClEvent, retain_event};
use layersplat::opencl3::types::cl_event;
use pyo3::prelude::*;

/// The handle of an object that was given for an argument: its `int_ptr`, as pyopencl's objects have it, or a number.
pub fn handle(name: &'static str, object: &Bound<PyAny>) -> Result<usize> {
    let number = object.getattr_opt("int_ptr")?;
    let number = number.as_ref().unwrap_or(object);
    number.extract::<usize>().map_err(|error| refused(name, object, error, "an object of pyopencl, or its int_ptr"))
}

/// A buffer or an image, retained.
pub fn memory(name: &'static str, object: &Bound<PyAny>) -> Result<DeviceMemory> {
    let handle = handle(name, object)?;
    // SAFETY: the handle of a live object, which is what the documentation asks for.
    Ok(unsafe { DeviceMemory::from_raw(handle as _) }?)
}

/// What a command waits for, retained: events of ours and of others.
pub fn events(wait_for: Option<Vec<Bound<PyAny>>>) -> Result<Vec<ClEvent>> {
    wait_for.unwrap_or_default().iter().map(event).collect()
}

fn event(object: &Bound<PyAny>) -> Result<ClEvent> {
    let raw = match object.cast::<Event>() {
        Ok(ours) => ours.get().raw(),
        Err(_) => handle("wait_for", object)? as cl_event,
    };
    retained(raw)
}

/// Another reference to an event.
pub fn retained(raw: cl_event) -> Result<ClEvent> {
    if raw.is_null() {
        return Err(Error::Memory { what: "an event to wait for", problem: "is no event: the handle is null".into() }.into());
    }
    // SAFETY: the handle of a live event, which is what the documentation asks for; `ClEvent` releases this reference.
    unsafe { retain_event(raw) }.map_err(|code| failed("clRetainEvent", code))?;
    Ok(ClEvent::new(raw))
}

/// An OpenCL call on an object of the caller's has failed.
pub fn failed(call: &'static str, code: i32) -> Failure {
    opencl_error(call, "the object that was given", code)
}

/// An enqueued command has ended with an error status.
pub fn command_failed(status: i32) -> Failure {
    opencl_error("the enqueued command", "its device", status)
}

fn opencl_error(call: &'static str, device: &str, code: i32) -> Failure {
    let source = layersplat::opencl3::error_codes::ClError(code);
    Error::OpenCl { call, device: device.into(), source }.into()
}
