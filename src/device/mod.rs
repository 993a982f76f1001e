//! The only room that knows OpenCL: device, queue, buffers, programs and typed kernel launchers.

mod buffer;
pub(crate) mod launch;
mod pinning;
mod program;
mod selection;
mod tuning;

pub(crate) use buffer::Buffer;
pub use pinning::pin_cpu_threads;
pub use selection::{DeviceChoice, DeviceInfo, DeviceKind};
pub use tuning::Tuning;

use crate::error::Error;
use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Milliseconds per stage of a frame, in the order in which stages first ran.
pub type StageTimes = Vec<(&'static str, f64)>;

/// An OpenCL device with a context and a queue of its own. Cheap to clone: clones share both.
#[derive(Clone)]
pub struct Device {
    inner: Rc<Inner>,
}

struct Inner {
    info: DeviceInfo,
    tuning: Tuning,
    queue: CommandQueue,
    context: Context,
    allocated: Arc<AtomicU64>,
    running: RefCell<Vec<Launched>>,
    programs: RefCell<program::Programs>,
}

/// A kernel on its way: its event, or its wall time where the device's events say nothing.
struct Launched {
    stage: &'static str,
    event: Event,
    wall_ms: Option<f64>,
}

impl Device {
    /// All devices of all platforms, in the order of their indices. Empty platforms are left out; no OpenCL at all is
    /// an error that says what to install.
    pub fn list() -> Result<Vec<DeviceInfo>, Error> {
        selection::list()
    }

    /// Opens the chosen device.
    pub fn open(choice: &DeviceChoice) -> Result<Self, Error> {
        let (device, info) = selection::choose(choice)?;
        let error = |call: &'static str| {
            let device = info.name.clone();
            move |source| Error::OpenCl { call, device, source }
        };
        let context = Context::from_device(&device).map_err(error("clCreateContext"))?;
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, CL_QUEUE_PROFILING_ENABLE).map_err(error("clCreateCommandQueue"))?;
        tracing::debug!("rendering on {} ({})", info.name, info.platform);
        let tuning = info.tuning;
        let inner = Inner {
            info,
            tuning,
            queue,
            context,
            allocated: Arc::default(),
            running: RefCell::default(),
            programs: RefCell::default(),
        };
        Ok(Self { inner: Rc::new(inner) })
    }

    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.inner.info
    }

    /// Bytes of buffers that are allocated at the moment.
    pub fn allocated_bytes(&self) -> u64 {
        self.inner.allocated.load(Ordering::Relaxed)
    }

    pub(crate) fn tuning(&self) -> &Tuning {
        &self.inner.tuning
    }

    /// Waits for everything that was started, and tells how long each stage took.
    pub(crate) fn finish(&self) -> Result<StageTimes, Error> {
        self.inner.queue.finish().map_err(|e| self.error("clFinish", e))?;
        let mut times = StageTimes::new();
        for launched in self.inner.running.borrow_mut().drain(..) {
            let ms = launched.wall_ms.unwrap_or_else(|| {
                let start = launched.event.profiling_command_start().unwrap_or(0);
                launched.event.profiling_command_end().unwrap_or(0).saturating_sub(start) as f64 / 1e6
            });
            match times.iter_mut().find(|(stage, _)| *stage == launched.stage) {
                Some((_, total)) => *total += ms,
                None => times.push((launched.stage, ms)),
            }
        }
        Ok(times)
    }

    fn error(&self, call: &'static str, source: opencl3::error_codes::ClError) -> Error {
        Error::OpenCl { call, device: self.inner.info.name.clone(), source }
    }

    /// Starts `kernel`, whose arguments are set, with at least `items` work-items in groups of `group`.
    fn start(&self, stage: &'static str, kernel: &Kernel, items: usize, group: usize) -> Result<(), Error> {
        let started = Instant::now();
        let global = items.div_ceil(group) * group;
        let queue = &self.inner.queue;
        // SAFETY: sizes live through the call, and the launchers have set every argument.
        let event = unsafe { queue.enqueue_nd_range_kernel(kernel.get(), 1, std::ptr::null(), &global, &group, &[]) }
            .map_err(|e| self.error(stage, e))?;
        let mut wall_ms = None;
        if !self.inner.tuning.event_times {
            queue.finish().map_err(|e| self.error("clFinish", e))?;
            wall_ms = Some(started.elapsed().as_secs_f64() * 1e3);
        }
        self.inner.running.borrow_mut().push(Launched { stage, event, wall_ms });
        Ok(())
    }
}
