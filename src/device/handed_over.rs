//! Contexts and queues of the caller's own.

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

impl Device {
    /// The device of a caller's queue, in the queue's context. All that is enqueued goes into this queue, which may be in order or out of
    /// order; every renderer keeps its own order there.
    ///
    /// Queue and context are retained, and released with the last clone and the last renderer that was made from it. Programs are kept as
    /// long; nothing else knows of them.
    ///
    /// # Errors
    /// What OpenCL answers.
    pub fn of_queue(queue: &CommandQueue) -> Result<Self, Error> {
        // SAFETY: the queue is alive.
        unsafe { Self::from_queue(queue.get()) }
    }

    /// The same of a raw `cl_command_queue`.
    ///
    /// # Safety
    /// `queue` is a queue of OpenCL's and alive during the call.
    pub unsafe fn from_queue(queue: cl_command_queue) -> Result<Self, Error> {
        if queue.is_null() {
            return Err(handed_over("clRetainCommandQueue", CL_INVALID_COMMAND_QUEUE));
        }
        // SAFETY: the caller's promise; the reference that is counted here is released by `CommandQueue`.
        unsafe { retain_command_queue(queue) }.map_err(|e| handed_over("clRetainCommandQueue", e))?;
        let queue = CommandQueue::new(queue, 1);
        let context = queue.context().map_err(|e| handed_over("clGetCommandQueueInfo", e.0))?;
        let device = ClDevice::new(queue.device().map_err(|e| handed_over("clGetCommandQueueInfo", e.0))?);
        let properties = queue.properties().map_err(|e| handed_over("clGetCommandQueueInfo", e.0))?;
        // SAFETY: the queue holds its context; the reference that is counted here is released by `Context`.
        unsafe { retain_context(context) }.map_err(|e| handed_over("clRetainContext", e))?;
        let context = Context::new(context, &[device.id()]);
        let platform = device.platform().map(|id| Platform::new(id).name().unwrap_or_default()).unwrap_or_default();
        let mut info = selection::describe(&device, None, &platform);
        // Queues that do not profile have no event times to tell.
        info.tuning.event_times &= properties & CL_QUEUE_PROFILING_ENABLE != 0;
        let in_order = properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE == 0;
        Ok(Self::new(info, context, Sequence::new(queue, in_order)))
    }

    /// The device of a caller's context, device and queue, as other libraries hand them over: all three raw.
    ///
    /// # Errors
    /// A queue that is not of this context and this device, and what OpenCL answers.
    ///
    /// # Safety
    /// All three are OpenCL's, and alive during the call.
    pub unsafe fn from_handles(context: cl_context, device: cl_device_id, queue: cl_command_queue) -> Result<Self, Error> {
        // SAFETY: the caller's promise.
        let of_queue = unsafe { Self::from_queue(queue) }?;
        if of_queue.context() != context {
            return Err(Error::Memory { what: "the queue", problem: "is of another context than the one given".into() });
        }
        if of_queue.id() != device {
            return Err(Error::Memory { what: "the queue", problem: "is of another device than the one given".into() });
        }
        Ok(of_queue)
    }

    /// The same device and programs with another queue of the same context: for renderers whose frames should overlap.
    ///
    /// # Errors
    /// A queue of another context or device, and what OpenCL answers.
    pub fn with_queue(&self, queue: &CommandQueue) -> Result<Self, Error> {
        let other = Self::of_queue(queue)?;
        if other.context() != self.context() || other.id() != self.id() {
            return Err(Error::Memory { what: "the queue", problem: "is of another context or device".into() });
        }
        // Whether events have times is a matter of the queue, all other values of the device.
        let tuning = Tuning { event_times: other.tuning.event_times, ..self.tuning };
        Ok(Self { sequence: other.sequence, tuning, ..self.clone() })
    }

    /// The context, for buffers that are rendered from or into. It lives as long as this device or a clone of it does.
    pub fn context(&self) -> cl_context {
        self.shared.programs.context.get()
    }

    /// OpenCL's name for the device.
    pub fn id(&self) -> cl_device_id {
        self.shared.programs.context.default_device()
    }

    /// The queue, which lives as long as this device or a clone of it does.
    pub fn queue(&self) -> cl_command_queue {
        self.sequence.queue.get()
    }
}

/// An error of a call about a queue that was handed over: of which device is not known yet.
fn handed_over(call: &'static str, code: i32) -> Error {
    Error::OpenCl { call, device: "the queue that was handed over".into(), source: ClError(code) }
}
