//! The only room that knows OpenCL: device, queue, buffers, programs and typed kernel launchers.

mod budget;
mod buffer;
mod cache;
mod kind;
pub(crate) mod launch;
mod pinning;
mod program;
mod selection;
mod sources;
mod stopwatch;
mod tuning;

pub(crate) use buffer::Buffer;
pub use cache::keep_compiled_kernels;
pub use kind::DeviceKind;
pub use pinning::pin_cpu_threads;
pub use selection::{DeviceChoice, DeviceInfo};
pub use stopwatch::StageTimes;
pub use tuning::Tuning;

use crate::error::Error;
use crate::memory;
use budget::Budget;
use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::kernel::Kernel;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use stopwatch::{Launched, Stopwatch};

/// An OpenCL device with a context and a queue of its own. Cheap to clone: clones share both, also from thread to thread.
#[derive(Clone)]
pub struct Device {
    inner: Arc<Inner>,
    tuning: Tuning,
    budget: Arc<Budget>,
    /// Of a frame that is timed.
    stopwatch: Option<Arc<Stopwatch>>,
}

struct Inner {
    info: DeviceInfo,
    queue: CommandQueue,
    context: Context,
    allocated: Arc<AtomicU64>,
    programs: Mutex<program::Programs>,
}

impl Device {
    /// All devices of all platforms, in the order of their indices. Empty platforms are left out; no OpenCL at all is
    /// an error that says what to install, and no device one that says what each platform answered.
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
        let inner = Inner { info, queue, context, allocated: Arc::default(), programs: Mutex::default() };
        Ok(Self { inner: Arc::new(inner), tuning, budget: Budget::unlimited(), stopwatch: None })
    }

    /// The same device with other tuning values, for what is rendered through this handle and its clones.
    pub fn with_tuning(&self, tuning: Tuning) -> Result<Self, Error> {
        tuning.check()?;
        Ok(Self { tuning, ..self.clone() })
    }

    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.inner.info
    }

    /// Bytes of buffers that are allocated at the moment.
    pub fn allocated_bytes(&self) -> u64 {
        self.inner.allocated.load(Ordering::Relaxed)
    }

    /// Refuses what would not fit: bytes on the device and beside it on the host. A processor has both in one memory; other devices are
    /// asked when buffers are made.
    pub(crate) fn require(&self, what: &str, on_device: u64, on_host: u64) -> Result<(), Error> {
        let shared = self.inner.info.kind == DeviceKind::Cpu;
        memory::require(what, if shared { on_device.saturating_add(on_host) } else { on_host })
    }

    /// The tuning values in use.
    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// A handle that times what is started through it, from now on.
    pub(crate) fn timed(&self) -> Self {
        Self { stopwatch: Some(Arc::default()), ..self.clone() }
    }

    /// Waits for everything that was started, and tells how long each stage took that was started through this handle; nothing where it
    /// is not timed.
    pub(crate) fn stage_times(&self) -> Result<StageTimes, Error> {
        let Some(stopwatch) = &self.stopwatch else { return Ok(StageTimes::new()) };
        self.finish()?;
        Ok(stopwatch.stage_times())
    }

    fn finish(&self) -> Result<(), Error> {
        self.inner.queue.finish().map_err(|e| self.error("clFinish", e))
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
        let Some(stopwatch) = &self.stopwatch else { return Ok(()) };
        let mut wall_ms = None;
        if !self.tuning.event_times {
            self.finish()?;
            wall_ms = Some(started.elapsed().as_secs_f64() * 1e3);
        }
        stopwatch.push(Launched { stage, event, wall_ms });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_shared_between_threads() {
        fn shared<T: Send + Sync>() {}
        shared::<Device>();
    }

    #[test]
    fn tuning_values_that_kernels_cannot_have_are_refused() {
        let device = Device::open(&DeviceChoice::Default).unwrap();
        let own = *device.tuning();
        assert_eq!(*device.with_tuning(Tuning { vector_width: 4, ..own }).unwrap().tuning(), Tuning { vector_width: 4, ..own });
        for wrong in [
            Tuning { vector_width: 3, ..own },
            Tuning { tile_vectors: 0, ..own },
            Tuning { point_tile_rows: 31, ..own },
            Tuning { block: [0, 1], ..own },
            Tuning { pixel_group: 0, ..own },
        ] {
            assert!(device.with_tuning(wrong).is_err(), "{wrong:?}");
        }
    }
}
