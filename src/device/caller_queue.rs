//! Contexts and queues created by the caller.

use super::commands::Sequence;
use super::{Device, Tuning, selection};
use crate::error::Error;
use opencl3::command_queue::{
    CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CL_QUEUE_PROFILING_ENABLE, CommandQueue, retain_command_queue,
};
use opencl3::context::{Context, context::retain_context};
use opencl3::device::Device as ClDevice;
use opencl3::error_codes::{CL_INVALID_COMMAND_QUEUE, ClError};
use opencl3::platform::Platform;
use opencl3::types::{cl_command_queue, cl_context, cl_device_id};
use std::sync::Arc;

impl Device {
    /// The device and context of the caller's queue. All commands go to this queue, which may be in-order or out-of-order. The
    /// commands of each renderer run in order on both.
    ///
    /// Queue and context are retained. They are released with the last clone of the device and the last renderer that uses it,
    /// and so are the programs built for this device.
    ///
    /// # Errors
    /// OpenCL errors.
    pub fn from_queue(queue: &CommandQueue) -> Result<Self, Error> {
        // SAFETY: the queue is alive.
        unsafe { Self::from_raw_queue(queue.get()) }
    }

    /// As [`from_queue`](Self::from_queue), with a raw `cl_command_queue`.
    ///
    /// # Errors
    /// A null handle; OpenCL errors.
    ///
    /// # Safety
    /// `queue` is null or a valid OpenCL queue during the call.
    pub unsafe fn from_raw_queue(queue: cl_command_queue) -> Result<Self, Error> {
        if queue.is_null() {
            return Err(queue_error("clRetainCommandQueue", CL_INVALID_COMMAND_QUEUE));
        }
        // SAFETY: guaranteed by the caller; `CommandQueue` releases this reference.
        unsafe { retain_command_queue(queue) }.map_err(|e| queue_error("clRetainCommandQueue", e))?;
        let queue = CommandQueue::new(queue, 1);
        let context = queue.context().map_err(|e| queue_error("clGetCommandQueueInfo", e.0))?;
        let device = ClDevice::new(queue.device().map_err(|e| queue_error("clGetCommandQueueInfo", e.0))?);
        let properties = queue.properties().map_err(|e| queue_error("clGetCommandQueueInfo", e.0))?;
        // SAFETY: the queue keeps its context alive; `Context` releases this reference.
        unsafe { retain_context(context) }.map_err(|e| queue_error("clRetainContext", e))?;
        let context = Context::new(context, &[device.id()]);
        let platform = device.platform().map(|id| Platform::new(id).name().unwrap_or_default()).unwrap_or_default();
        let mut info = selection::describe(&device, None, &platform);
        // Without profiling, events of the queue report no times.
        info.tuning.event_times &= properties & CL_QUEUE_PROFILING_ENABLE != 0;
        let in_order = properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE == 0;
        Ok(Self::new(info, context, Sequence::new(queue, in_order)))
    }

    /// As [`from_raw_queue`](Self::from_raw_queue), for libraries that provide context, device and queue.
    ///
    /// # Errors
    /// A queue of another context or another device; OpenCL errors.
    ///
    /// # Safety
    /// All handles that are not null must be valid OpenCL objects during the call.
    pub unsafe fn from_handles(context: cl_context, device: cl_device_id, queue: cl_command_queue) -> Result<Self, Error> {
        // SAFETY: guaranteed by the caller.
        let opened = unsafe { Self::from_raw_queue(queue) }?;
        if opened.context() != context {
            return Err(Error::Memory { what: "the queue", problem: "belongs to another context than the given one".into() });
        }
        if opened.id() != device {
            return Err(Error::Memory { what: "the queue", problem: "belongs to another device than the given one".into() });
        }
        Ok(opened)
    }

    /// The same device and programs with another queue of the same context, for renderers whose frames should overlap.
    ///
    /// # Errors
    /// A queue of another context or device; OpenCL errors.
    pub fn with_queue(&self, queue: &CommandQueue) -> Result<Self, Error> {
        let other = Self::from_queue(queue)?;
        if other.context() != self.context() || other.id() != self.id() {
            return Err(Error::Memory { what: "the queue", problem: "belongs to another context or device".into() });
        }
        // Only this value depends on the queue.
        let tuning = Tuning { event_times: other.tuning.event_times, ..self.tuning };
        Ok(Self { sequence: other.sequence, tuning, ..self.clone() })
    }

    /// The same device with a new queue, whose commands wait for no others.
    pub(crate) fn with_own_queue(&self) -> Result<Self, Error> {
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error("clCreateCommandQueue", e))?;
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&self.shared.programs.context, 0);
        let queue = queue.map_err(|e| self.error("clCreateCommandQueue", e))?;
        Ok(Self { sequence: Arc::new(Sequence::new(queue, true)), scratch: None, ..self.clone() })
    }

    /// The context, for creating buffers to render from or into. Valid as long as this device or a clone exists.
    pub fn context(&self) -> cl_context {
        self.shared.programs.context.get()
    }

    /// The OpenCL device handle.
    pub fn id(&self) -> cl_device_id {
        self.shared.programs.context.default_device()
    }

    /// The queue. Valid as long as this device or a clone exists.
    pub fn queue(&self) -> cl_command_queue {
        self.sequence.queue.get()
    }
}

/// An OpenCL error of the caller's queue, whose device is not known yet.
fn queue_error(call: &'static str, code: i32) -> Error {
    Error::OpenCl { call, device: "the caller's queue".into(), source: ClError(code) }
}
