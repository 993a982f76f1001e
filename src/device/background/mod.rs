//! Builds programs in the background, before a frame needs them.

mod build;
mod process;
mod progress;
mod queue;
#[cfg(test)]
mod tests;

pub use process::compile_for_parent;
pub use progress::ProgramBuilds;

use super::Device;
use super::launch::KernelRequest;
use super::program::Programs;
use crate::error::Error;
use progress::{Batch, OnReady};
use queue::JobQueue;
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Builds programs on its own thread. The thread starts with the first request and ends with the device.
pub(super) struct BackgroundBuilder {
    programs: Arc<Programs>,
    queue: Arc<JobQueue>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl BackgroundBuilder {
    pub fn new(programs: Arc<Programs>) -> Self {
        Self { programs, queue: Arc::default(), thread: Mutex::default() }
    }

    /// `add` adds the request to the queue.
    fn request(&self, on_ready: OnReady, add: impl FnOnce(&JobQueue, &Arc<Batch>)) -> ProgramBuilds {
        let batch = Arc::new(Batch::new(on_ready));
        add(&self.queue, &batch);
        let mut thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        if thread.is_none() {
            let (programs, queue) = (self.programs.clone(), self.queue.clone());
            *thread = Some(std::thread::spawn(move || queue.run(&programs)));
        }
        ProgramBuilds::new(batch)
    }
}

impl Drop for BackgroundBuilder {
    /// Abandons waiting builds, and waits for the current one: drivers crash if the process ends during a build.
    fn drop(&mut self) {
        self.queue.close();
        let thread = self.thread.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        // The callback of a request may own the last handle of the device, which is then dropped on the thread itself.
        if let Some(thread) = thread.filter(|thread| thread.thread().id() != std::thread::current().id()) {
            // The panic hook has already reported a panic of the thread.
            let _ = thread.join();
        }
    }
}

impl Device {
    /// Builds the kernels returned by `find` in the background. Calls `on_ready` when all are built, with the first error if any
    /// build failed. Both closures run on another thread.
    pub(crate) fn build_ahead(
        &self,
        find: impl FnOnce() -> Result<Vec<KernelRequest>, Error> + Send + 'static,
        on_ready: impl FnOnce(Result<(), Error>) + Send + 'static,
    ) -> ProgramBuilds {
        self.shared.background.request(Box::new(on_ready), |queue, batch| queue.push(Box::new(find), batch.clone()))
    }

    /// Builds these kernels in the background before all that wait.
    #[cfg(feature = "page")]
    pub(crate) fn build_first(&self, kernels: Vec<KernelRequest>) -> ProgramBuilds {
        self.shared.background.request(Box::new(|_| {}), |queue, batch| queue.push_first(kernels, batch))
    }

    /// Whether a kernel was built in the background, so that its launch compiles nothing.
    pub(crate) fn is_ready(&self, kernel: &KernelRequest) -> bool {
        self.shared.background.queue.is_ready(kernel)
    }

    /// Launches a kernel as after a build in the background: it must return at once, since otherwise it would divide by zero or read out of
    /// bounds.
    #[cfg(test)]
    pub(super) fn launch_without_work(&self, kernel: &KernelRequest) -> Result<(), Error> {
        build::build(&self.shared.programs, &mut None, kernel)
    }

    /// Lets another process compile the programs that are built in the background
    /// ([`Renderer::warm_up`](crate::Renderer::warm_up)). This helps with PoCL, which launches no kernel while it compiles
    /// another, so that compiling in this process would delay frames.
    ///
    /// `command` returns the command of the process. The process must call [`compile_for_parent`] first in its `main`, with the same
    /// build of this library. It may be the calling program itself, or `layersplat`. If the process cannot be started, or ends, this
    /// process compiles.
    ///
    /// ```
    /// use layersplat::{Device, DeviceChoice};
    /// use std::process::Command;
    ///
    /// let device = Device::open(&DeviceChoice::Default)?;
    /// let program = std::env::current_exe().expect("the path of this program");
    /// device.set_compiler_command(move || Command::new(&program));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn set_compiler_command(&self, command: impl Fn() -> Command + Send + Sync + 'static) {
        self.shared.background.queue.set_compiler_command(Arc::new(command));
    }
}
