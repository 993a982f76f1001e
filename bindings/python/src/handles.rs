//! Raw handles of OpenCL objects of other packages.

use crate::argument::refused;
use crate::errors::{Failure, Result};
use crate::event::Event;
use layersplat::Error;
use layersplat::device::DeviceMemory;
use layersplat::opencl3::event::{Event as ClEvent, retain_event};
use layersplat::opencl3::types::cl_event;
use pyo3::prelude::*;

/// The handle of an argument: the `int_ptr` of a pyopencl object, or an integer.
pub fn handle(name: &'static str, object: &Bound<PyAny>) -> Result<usize> {
    let number = object.getattr_opt("int_ptr")?;
    let number = number.as_ref().unwrap_or(object);
    number.extract::<usize>().map_err(|error| refused(name, object, error, "an object of pyopencl, or its int_ptr"))
}

/// A buffer or an image, retained.
pub fn memory(name: &'static str, object: &Bound<PyAny>) -> Result<DeviceMemory> {
    let handle = handle(name, object)?;
    // SAFETY: the documentation requires handles of live objects.
    Ok(unsafe { DeviceMemory::from_raw(handle as _) }?)
}

/// The wait list of a command, retained: events of this or of another package.
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

/// Retains an event.
pub fn retained(raw: cl_event) -> Result<ClEvent> {
    if raw.is_null() {
        return Err(Error::Memory { what: "an event to wait for", problem: "has a null handle".into() }.into());
    }
    // SAFETY: the documentation requires handles of live events. `ClEvent` releases this reference.
    unsafe { retain_event(raw) }.map_err(|code| failed("clRetainEvent", code))?;
    Ok(ClEvent::new(raw))
}

/// The error of an OpenCL call on an object of the caller.
pub fn failed(call: &'static str, code: i32) -> Failure {
    opencl_error(call, "an object of the caller", code)
}

/// The error of an enqueued command that ended with an error status.
pub fn command_failed(status: i32) -> Failure {
    opencl_error("the enqueued command", "its device", status)
}

fn opencl_error(call: &'static str, device: &str, code: i32) -> Failure {
    let source = layersplat::opencl3::error_codes::ClError(code);
    Error::OpenCl { call, device: device.into(), source }.into()
}
