//! OpenCL: device, queue, buffers, programs and typed kernel launchers. Other modules do not call OpenCL themselves.

mod background;
mod bands;
mod budget;
mod buffer;
mod build_log;
mod cache;
mod caller_queue;
mod commands;
#[cfg(feature = "gl-interop")]
mod current_gl;
mod device_memory;
#[cfg(test)]
mod faults;
mod general;
mod kind;
pub(crate) mod launch;
mod limits;
mod loader;
mod pinning;
mod produced;
mod program;
mod rehearsal;
mod scratch;
mod selection;
#[cfg(feature = "gl-interop")]
mod shared_gl;
mod sources;
#[cfg(test)]
mod started;
mod stopwatch;
mod tuning;

pub use background::{ProgramBuilds, compile_for_parent};
pub use bands::Bands;
pub(crate) use buffer::Buffer;
pub use cache::keep_compiled_kernels;
#[cfg(feature = "cli")]
pub(crate) use cache::unusable_cache;
pub use device_memory::{DeviceMemory, ImageFormat};
#[cfg(test)]
pub(crate) use faults::Call;
pub use kind::DeviceKind;
pub use limits::Cancel;
pub(crate) use limits::Limits;
pub use pinning::pin_cpu_threads;
#[cfg(feature = "cli")]
pub(crate) use program::compiler_options;
pub use selection::{DeviceChoice, DeviceInfo};
#[cfg(feature = "cli")]
pub(crate) use sources::hash as kernel_sources_hash;
#[cfg(test)]
pub(crate) use sources::kernel_names;
#[cfg(test)]
pub(crate) use started::Started;
pub use stopwatch::StageTimes;
pub use tuning::{LatticeSchedule, Tuning};

pub(crate) use device_memory::MemoryKind;
pub(crate) use produced::{Produced, Usability};
pub(crate) use rehearsal::Rehearsal;
pub(crate) use scratch::ScratchMemory;
#[cfg(feature = "gl-interop")]
pub(crate) use shared_gl::SharedTexture;

use crate::error::Error;
use crate::memory;
use background::BackgroundBuilder;
use budget::Budget;
use commands::Sequence;
use general::GeneralPrograms;
use limits::Begun;
use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::kernel::Kernel;
use program::Programs;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use stopwatch::{Launched, Stopwatch};

/// An OpenCL device with a context and a queue, created here ([`open`](Self::open)) or by the caller
/// ([`from_queue`](Self::from_queue)). Cheap to clone: clones share context and queue, also across threads.
///
/// ```
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// println!("{} on {}", device.info().name, device.info().platform);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone)]
pub struct Device {
    shared: Arc<Shared>,
    sequence: Arc<Sequence>,
    tuning: Tuning,
    budget: Arc<Budget>,
    /// Present if the frame is timed.
    stopwatch: Option<Arc<Stopwatch>>,
    /// Present if the caller provides the scratch memory of the frame.
    scratch: Option<Arc<ScratchMemory>>,
    /// Present if the frame of this handle has a time limit or can be cancelled.
    begun: Option<Begun>,
    /// Present in a dry run, where kernels are recorded instead of launched.
    rehearsal: Option<Arc<Rehearsal>>,
    /// Present if the frame may use general programs.
    general_programs: Option<Arc<GeneralPrograms>>,
}

/// State shared by all queues of a device in one context.
struct Shared {
    programs: Arc<Programs>,
    background: BackgroundBuilder,
    allocated: Arc<AtomicU64>,
    /// Warns only once that pictures are copied to textures through host memory.
    #[cfg(feature = "gl-interop")]
    through_host: std::sync::Once,
    #[cfg(test)]
    started: started::AllStarted,
}

impl Device {
    /// All devices of all platforms, in the order of their indices. Platforms without devices are omitted.
    ///
    /// # Errors
    /// No OpenCL implementation: the error says what to install. No device: the error lists the answer of each platform.
    pub fn list() -> Result<Vec<DeviceInfo>, Error> {
        selection::list()
    }

    /// Opens the chosen device with its own context and queue.
    ///
    /// # Errors
    /// As [`list`](Self::list); an unknown name or index; OpenCL errors.
    pub fn open(choice: &DeviceChoice) -> Result<Self, Error> {
        let (device, info) = selection::choose(choice)?;
        Self::with_new_context(&device, info)
    }

    fn with_new_context(device: &ClDevice, info: DeviceInfo) -> Result<Self, Error> {
        let context = Context::from_device(device);
        let context = context.map_err(|source| Error::OpenCl { call: "clCreateContext", device: info.name.clone(), source })?;
        Self::with_new_queue(info, context)
    }

    fn with_new_queue(info: DeviceInfo, context: Context) -> Result<Self, Error> {
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, CL_QUEUE_PROFILING_ENABLE);
        let queue = queue.map_err(|source| Error::OpenCl { call: "clCreateCommandQueue", device: info.name.clone(), source })?;
        tracing::debug!("rendering on {} ({})", info.name, info.platform);
        Ok(Self::new(info, context, Sequence::new(queue, true)))
    }

    fn new(info: DeviceInfo, context: Context, sequence: Sequence) -> Self {
        let tuning = info.tuning;
        let programs = Arc::new(Programs::new(info, context));
        let shared = Shared {
            background: BackgroundBuilder::new(programs.clone()),
            programs,
            allocated: Arc::default(),
            #[cfg(feature = "gl-interop")]
            through_host: std::sync::Once::new(),
            #[cfg(test)]
            started: Default::default(),
        };
        Self {
            shared: Arc::new(shared),
            sequence: Arc::new(sequence),
            tuning,
            budget: Budget::unlimited(),
            stopwatch: None,
            scratch: None,
            begun: None,
            rehearsal: None,
            general_programs: None,
        }
    }

    /// The same device with other tuning values. They apply to everything rendered through the returned handle and its clones.
    ///
    /// # Errors
    /// Values outside the ranges that kernels support.
    pub fn with_tuning(&self, tuning: Tuning) -> Result<Self, Error> {
        tuning.check()?;
        Ok(Self { tuning, ..self.clone() })
    }

    /// Properties of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.programs.info
    }

    /// Bytes in all currently allocated buffers, through any handle of the device.
    pub fn allocated_bytes(&self) -> u64 {
        self.shared.allocated.load(Ordering::Relaxed)
    }

    /// Number of programs built so far. They are kept and shared by all renderers on this device.
    pub fn programs(&self) -> usize {
        self.shared.programs.count()
    }

    /// Checks that enough memory is available for bytes on the device and on the host. A CPU device takes both from host memory.
    /// On other devices, buffer creation detects a lack of device memory.
    pub(crate) fn require(&self, what: &str, on_device: u64, on_host: u64) -> Result<(), Error> {
        let shared = self.info().kind == DeviceKind::Cpu;
        memory::require(what, if shared { on_device.saturating_add(on_host) } else { on_host })
    }

    /// Checks additional device memory against the budget of this handle, and as [`require`](Self::require).
    pub(crate) fn require_within_budget(&self, what: &str, on_device: u64, on_host: u64) -> Result<(), Error> {
        self.budget.require(what, on_device)?;
        self.require(what, on_device, on_host)
    }

    /// Tuning values in use.
    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// The caller's scratch memory, if any.
    pub(crate) fn scratch(&self) -> Option<&Arc<ScratchMemory>> {
        self.scratch.as_ref()
    }

    /// A handle for frames that use the caller's scratch memory; with `None`, they allocate their own.
    pub(crate) fn with_scratch(&self, scratch: Option<Arc<ScratchMemory>>) -> Self {
        Self { scratch, ..self.clone() }
    }

    /// A handle that measures the time of each kernel started through it.
    pub(crate) fn timed(&self) -> Self {
        Self { stopwatch: Some(Arc::default()), ..self.clone() }
    }

    /// Waits for all commands of this handle and returns the time of each stage. Empty unless the handle is
    /// [`timed`](Self::timed).
    pub(crate) fn stage_times(&self) -> Result<StageTimes, Error> {
        let Some(stopwatch) = &self.stopwatch else { return Ok(StageTimes::new()) };
        self.finish()?;
        Ok(stopwatch.stage_times())
    }

    fn error(&self, call: &'static str, source: opencl3::error_codes::ClError) -> Error {
        self.shared.programs.error(call, source)
    }

    /// Enqueues `kernel`, whose arguments are set, with at least `items` work-items in work-groups of `group`.
    fn start(&self, stage: &'static str, kernel: &Kernel, items: usize, group: usize) -> Result<(), Error> {
        self.check_limits(stage)?;
        self.enqueue(stage, kernel, items, group)
    }

    /// As [`start`](Self::start), after the limits have been checked.
    fn enqueue(&self, stage: &'static str, kernel: &Kernel, items: usize, group: usize) -> Result<(), Error> {
        let started = Instant::now();
        let global = items.div_ceil(group) * group;
        let event = self.command(stage, |queue, wait| {
            // SAFETY: the sizes outlive the call, and the launchers have set every argument.
            unsafe { queue.enqueue_nd_range_kernel(kernel.get(), 1, std::ptr::null(), &global, &group, wait) }
        })?;
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
impl Device {
    /// The default device, shared by the tests of a process, so that each kernel is built once.
    pub(crate) fn shared() -> Self {
        static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(|| {
            Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
        });
        DEVICE.clone()
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
    fn tuning_values_out_of_range_are_rejected() {
        let device = Device::open(&DeviceChoice::Default).unwrap();
        let own = *device.tuning();
        assert_eq!(*device.with_tuning(Tuning { vector_width: 4, ..own }).unwrap().tuning(), Tuning { vector_width: 4, ..own });
        for wrong in [
            Tuning { vector_width: 3, ..own },
            Tuning { tile_rows: 0, ..own },
            Tuning { point_tile_rows: 31, ..own },
            Tuning { sample_tile: [12, 8], ..own },
            Tuning { sample_tile: [8, 0], ..own },
            Tuning { sample_tile: [1 << 31, 1 << 31], ..own },
            Tuning { block: [0, 1], ..own },
            Tuning { pixel_group: 0, ..own },
            Tuning { tile_group: 257, ..own },
            Tuning { scan_group: 0, ..own },
            Tuning { list_tiles: 31, ..own },
        ] {
            assert!(device.with_tuning(wrong).is_err(), "{wrong:?}");
        }
    }
}
