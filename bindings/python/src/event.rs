//! Events of enqueued frames.

use crate::calls::abandonable;
use crate::errors::Result;
use crate::handles::{command_failed, failed, retained};
use layersplat::opencl3::event::{CL_COMPLETE, Event as ClEvent};
use layersplat::opencl3::types::cl_event;
use pyo3::prelude::*;

/// An OpenCL event of enqueued commands.
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
    /// The `cl_event` handle, valid as long as this object: for `pyopencl.Event.from_int_ptr(event.int_ptr, retain=True)`.
    #[getter]
    fn int_ptr(&self) -> usize {
        self.raw() as usize
    }

    /// Waits until the event is complete, with the GIL released. Ctrl-C ends the wait, but not the command.
    ///
    /// Raises DeviceError if the command, or one in its wait list, has failed.
    fn wait(&self, py: Python) -> Result<()> {
        let event = retained(self.raw())?;
        abandonable(py, move || event.wait().map_err(|e| failed("clWaitForEvents", e.0)))
    }

    /// Whether the command is complete; False while it is queued or running.
    ///
    /// Raises DeviceError, with the OpenCL status, if the command has failed: it will never complete.
    #[getter]
    fn is_complete(&self) -> Result<bool> {
        match self.0.command_execution_status().map_err(|e| failed("clGetEventInfo", e.0))?.0 {
            status if status < 0 => Err(command_failed(status)),
            status => Ok(status == CL_COMPLETE),
        }
    }

    /// The same event as a pyopencl.Event, with its own reference.
    fn to_pyopencl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("pyopencl")?.getattr("Event")?.call_method1("from_int_ptr", (self.int_ptr(), true))
    }
}
