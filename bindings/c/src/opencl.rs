//! Opaque OpenCL types as in CL/cl.h, so that the generated header does not include it.

use crate::Status;
use crate::boundary::{Failure, values};
use layersplat::opencl3::event::Event;
use std::mem::ManuallyDrop;

/// The type that a cl_context points to.
#[allow(non_camel_case_types)]
pub struct _cl_context {
    _opaque: [u8; 0],
}

/// The type that a cl_device_id points to.
#[allow(non_camel_case_types)]
pub struct _cl_device_id {
    _opaque: [u8; 0],
}

/// The type that a cl_command_queue points to.
#[allow(non_camel_case_types)]
pub struct _cl_command_queue {
    _opaque: [u8; 0],
}

/// The type that a cl_mem points to.
#[allow(non_camel_case_types)]
pub struct _cl_mem {
    _opaque: [u8; 0],
}

/// The type that a cl_event points to.
#[allow(non_camel_case_types)]
pub struct _cl_event {
    _opaque: [u8; 0],
}

/// Events owned by the caller. They are not released here.
pub(crate) struct WaitList(Vec<ManuallyDrop<Event>>);

impl WaitList {
    pub unsafe fn new(count: u32, events: *const *mut _cl_event) -> Result<Self, Failure> {
        // SAFETY: upheld by the caller.
        let events = unsafe { values(events, count as usize, "wait_list") }?;
        if let Some(n) = events.iter().position(|event| event.is_null()) {
            return Err(Failure::new(Status::NullArgument, format!("event {n} of wait_list is null")));
        }
        Ok(Self(events.iter().map(|event| ManuallyDrop::new(Event::new(event.cast()))).collect()))
    }

    pub fn events(&self) -> Vec<&Event> {
        self.0.iter().map(|event| &**event).collect()
    }
}

/// Transfers an event to the caller. If `to` is null, the event is released.
pub(crate) unsafe fn set_event(event: Event, to: *mut *mut _cl_event) {
    if !to.is_null() {
        let event = ManuallyDrop::new(event);
        // SAFETY: upheld by the caller: a non-null pointer is valid for writes.
        unsafe { to.write(event.get().cast()) };
    }
}
