//! Events of frames.

use crate::calls::abandonable;
use crate::errors::Result;
use crate::handles::{command_failed, failed, retained};
use layersplat::opencl3::event::{CL_COMPLETE, Event as ClEvent};
use layersplat::opencl3::types::cl_event;
use pyo3::prelude::*;

/// An OpenCL event: complete when what was enqueued is.
#[pyclass(frozen, module = "layersplat")]
pub struct Event(ClEvent);

impl Event {
    pub fn new(event: ClEvent) -> Self {
        Self(event)
    }

    pub fn raw(&self) -> cl_event {
        self.0.get()
    }
}

#[pymethods]
impl Event {
    /// The handle, a `cl_event`, as long as this lives: for `pyopencl.Event.from_int_ptr(event.int_ptr, retain=True)`.
    #[getter]
    fn int_ptr(&self) -> usize {
        self.raw() as usize
    }

    /// Waits until it is complete, with the interpreter's lock released. Ctrl-C ends the wait, and not the command.
    ///
    /// Raises DeviceError where what was enqueued, or what that waited for, has failed.
    fn wait(&self, py: Python) -> Result<()> {
        let event = retained(self.raw())?;
        abandonable(py, move || event.wait().map_err(|e| failed("clWaitForEvents", e.0)))
    }

    /// Whether what was enqueued is complete; False while it waits or runs.
    ///
    /// Raises DeviceError, with OpenCL's status, where it has failed: it will never be complete.
    #[getter]
    fn is_complete(&self) -> Result<bool> {
        match self.0.command_execution_status().map_err(|e| failed("clGetEventInfo", e.0))?.0 {
            status if status < 0 => Err(command_failed(status)),
            status => Ok(status == CL_COMPLETE),
        }
    }

    /// The same event as one of pyopencl's, with a reference of its own.
    fn to_pyopencl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("pyopencl")?.getattr("Event")?.call_method1("from_int_ptr", (self.int_ptr(), true))
    }
}
