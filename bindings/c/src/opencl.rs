//! OpenCL's objects as CL/cl.h declares them, so that a program needs that header only if it uses OpenCL itself.

use crate::Status;
use crate::border::{Failure, values};
use layersplat::opencl3::event::Event;
use std::mem::ManuallyDrop;

/// What a cl_context points to.
#[allow(non_camel_case_types)]
pub struct _cl_context {
    _opaque: [u8; 0],
}

/// What a cl_device_id points to.
#[allow(non_camel_case_types)]
pub struct _cl_device_id {
    _opaque: [u8; 0],
}

/// What a cl_command_queue points to.
#[allow(non_camel_case_types)]
pub struct _cl_command_queue {
    _opaque: [u8; 0],
}

/// What a cl_mem points to.
#[allow(non_camel_case_types)]
pub struct _cl_mem {
    _opaque: [u8; 0],
}

/// What a cl_event points to.
#[allow(non_camel_case_types)]
pub struct _cl_event {
    _opaque: [u8; 0],
}

/// Events of the caller's, who goes on owning them.
pub(crate) struct WaitList(Vec<ManuallyDrop<Event>>);

impl WaitList {
    pub unsafe fn new(count: u32, events: *const *mut _cl_event) -> Result<Self, Failure> {
        // SAFETY: the caller's promise is passed on.
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

/// Makes an event the caller's, or releases it where none is wanted.
pub(crate) unsafe fn give(event: Event, to: *mut *mut _cl_event) {
    if !to.is_null() {
        let event = ManuallyDrop::new(event);
        // SAFETY: the caller's promise: there is room for one.
        unsafe { to.write(event.get().cast()) };
    }
}
