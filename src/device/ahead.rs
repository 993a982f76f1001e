//! Programs that are built in the background, before a frame needs them.

use super::compiler::Compiler;
use super::launch::KernelRequest;
use super::program::Programs;
use super::{Device, cache};
use crate::error::Error;
use opencl3::command_queue::CommandQueue;
use opencl3::kernel::{Kernel, set_kernel_arg};
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, ClMem, cl_mem};
use std::collections::{HashSet, VecDeque};
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Bytes of the buffer that kernels get for each of theirs when they start with nothing to do.
const PLACEHOLDER_BYTES: usize = 4096;

/// What is called when all programs of a request are built.
type OnReady = Box<dyn FnOnce(Result<(), Error>) + Send>;

/// Builds programs on a thread of its own, which starts with the first request and ends with the device.
pub(super) struct Ahead {
    programs: Arc<Programs>,
    jobs: Arc<Jobs>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

/// Makes what starts another process that compiles kernels.
type MakeCommand = dyn Fn() -> Command + Send + Sync;

/// What the thread has to do.
#[derive(Default)]
struct Jobs {
    state: Mutex<State>,
    changed: Condvar,
}

/// Finds out which kernels are needed.
type Find = Box<dyn FnOnce() -> Result<Vec<KernelRequest>, Error> + Send>;

/// One step of a request.
enum Job {
    Find(Find),
    Build(KernelRequest),
}

#[derive(Default)]
struct State {
    waiting: VecDeque<(Job, Arc<Batch>)>,
    /// Kernels that start without being compiled.
    ready: HashSet<KernelRequest>,
    /// Starts a process that compiles kernels.
    command: Option<Arc<MakeCommand>>,
    /// Such a process, as long as there is something to do.
    compiler: Option<Arc<Compiler>>,
    /// The device is gone.
    ending: bool,
}

/// Kernels that were requested together.
struct Batch {
    progress: Mutex<Progress>,
    changed: Condvar,
}

struct Progress {
    done: usize,
    /// `None` until they are found.
    all: Option<usize>,
    /// Why the first one that could not be built was not.
    failure: Option<Error>,
    /// Taken when it is called.
    on_ready: Option<OnReady>,
}

/// Programs that are being built in the background. Dropping it changes nothing: they are built all the same.
#[derive(Clone)]
pub struct ProgramBuilds {
    batch: Arc<Batch>,
}

impl ProgramBuilds {
    /// How many kernels are compiled, and of how many; these are `None` until they are found. Those that could not be built count as well.
    pub fn progress(&self) -> (usize, Option<usize>) {
        let progress = self.batch.progress();
        (progress.done, progress.all)
    }

    /// Whether none is left.
    pub fn is_ready(&self) -> bool {
        self.batch.progress().is_over()
    }

    /// Waits until none is left.
    pub fn wait(&self) {
        let progress = self.batch.progress();
        let waited = self.batch.changed.wait_while(progress, |progress| !progress.is_over());
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

impl Progress {
    fn is_over(&self) -> bool {
        self.all == Some(self.done)
    }
}

impl Batch {
    fn progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the progress; after the last kernel, tells the caller.
    fn update(&self, change: impl FnOnce(&mut Progress)) {
        let mut progress = self.progress();
        change(&mut progress);
        if !progress.is_over() {
            return;
        }
        let (on_ready, failure) = (progress.on_ready.take(), progress.failure.take());
        drop(progress);
        self.changed.notify_all();
        if let Some(on_ready) = on_ready {
            on_ready(failure.map_or(Ok(()), Err));
        }
    }

    /// Counts a kernel that is built, or could not be.
    fn count(&self, built: Result<(), Error>) {
        self.update(|progress| {
            progress.done += 1;
            progress.failure = progress.failure.take().or(built.err());
        });
    }

    /// Ends a request whose kernels were not found.
    fn fail(&self, error: Error) {
        self.update(|progress| {
            progress.all = Some(progress.done);
            progress.failure = Some(error);
        });
    }
}

impl Jobs {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next job, waited for; `None` when the device is gone.
    fn next(&self) -> Option<(Job, Arc<Batch>)> {
        let mut state = self.state();
        loop {
            if state.ending {
                return None;
            }
            if let Some(job) = state.waiting.pop_front() {
                return Some(job);
            }
            state.compiler = None;
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Jobs {
    /// Lets another process compile a kernel, where there is one: what that compiles is only loaded here. Where it fails, this one compiles.
    fn compile_elsewhere(&self, programs: &Programs, kernel: &KernelRequest) {
        let Some(compiler) = self.compiler(programs) else { return };
        if let Err(error) = compiler.compile(kernel) {
            tracing::debug!("another process did not compile {}: {error}", kernel.file);
            self.state().compiler = None;
        }
    }

    /// The process, started where it is not yet.
    fn compiler(&self, programs: &Programs) -> Option<Arc<Compiler>> {
        let mut state = self.state();
        if state.compiler.is_none() && !state.ending && cache::is_pocl(&programs.info.platform) {
            let command = state.command.clone()?;
            match Compiler::start(command(), &programs.info) {
                Ok(started) => state.compiler = Some(Arc::new(started)),
                Err(error) => {
                    tracing::warn!("no process that compiles kernels: {error}");
                    state.command = None;
                }
            }
        }
        state.compiler.clone()
    }

    fn is_ending(&self) -> bool {
        self.state().ending
    }

    /// Adds the kernels that a request needs.
    fn add(&self, kernels: Vec<KernelRequest>, batch: &Arc<Batch>) {
        let all = kernels.len();
        {
            let mut state = self.state();
            if state.ending {
                drop(state);
                return batch.fail(Error::NotBuilt { program: "no program" });
            }
            state.waiting.extend(kernels.into_iter().map(|kernel| (Job::Build(kernel), batch.clone())));
        }
        batch.update(|progress| progress.all = Some(all));
    }
}

impl Ahead {
    pub fn new(programs: Arc<Programs>) -> Self {
        Self { programs, jobs: Arc::default(), thread: Mutex::default() }
    }

    fn request(&self, find: Find, on_ready: OnReady) -> ProgramBuilds {
        let progress = Progress { done: 0, all: None, failure: None, on_ready: Some(on_ready) };
        let batch = Arc::new(Batch { progress: Mutex::new(progress), changed: Condvar::new() });
        self.jobs.state().waiting.push_back((Job::Find(find), batch.clone()));
        self.jobs.changed.notify_one();
        let mut thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        if thread.is_none() {
            let (programs, jobs) = (self.programs.clone(), self.jobs.clone());
            *thread = Some(std::thread::spawn(move || do_jobs(&programs, &jobs)));
        }
        ProgramBuilds { batch }
    }
}

impl Drop for Ahead {
    /// What waits is given up; a build that has begun is waited for, since drivers do not survive a process that ends during one.
    fn drop(&mut self) {
        let given_up = {
            let mut state = self.jobs.state();
            state.ending = true;
            if let Some(compiler) = &state.compiler {
                compiler.end();
            }
            std::mem::take(&mut state.waiting)
        };
        self.jobs.changed.notify_one();
        for (job, batch) in given_up {
            match job {
                Job::Find(_) => batch.fail(Error::NotBuilt { program: "no program" }),
                Job::Build(kernel) => batch.count(Err(Error::NotBuilt { program: kernel.file })),
            }
        }
        let thread = self.thread.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        // The thread itself may hold the last device, in what it calls when all is ready.
        if let Some(thread) = thread.filter(|thread| thread.thread().id() != std::thread::current().id()) {
            // A panic of the thread was reported there.
            let _ = thread.join();
        }
    }
}

/// What the thread does.
fn do_jobs(programs: &Programs, jobs: &Jobs) {
    let mut idle = None;
    while let Some((job, batch)) = jobs.next() {
        match job {
            Job::Find(find) => match find() {
                Ok(kernels) => jobs.add(kernels, &batch),
                Err(error) => batch.fail(error),
            },
            Job::Build(kernel) => {
                let known = jobs.state().ready.contains(&kernel);
                let built = if known { Ok(()) } else { build_quickly(programs, jobs, &mut idle, &kernel) };
                match &built {
                    Ok(()) => drop(jobs.state().ready.insert(kernel)),
                    Err(error) => tracing::debug!("not built ahead: {error}"),
                }
                batch.count(built);
            }
        }
    }
}

/// Builds a kernel, which holds up frames for as short as can be.
fn build_quickly(programs: &Programs, jobs: &Jobs, idle: &mut Option<Idle>, kernel: &KernelRequest) -> Result<(), Error> {
    jobs.compile_elsewhere(programs, kernel);
    if jobs.is_ending() { Err(Error::NotBuilt { program: kernel.file }) } else { build(programs, idle, kernel) }
}

/// Builds a kernel and starts it with nothing to do: PoCL compiles most of a kernel when it is first started, for its size of groups.
pub(super) fn build(programs: &Programs, idle: &mut Option<Idle>, request: &KernelRequest) -> Result<(), Error> {
    let kernel = programs.kernel(request.file, &request.kernel, &request.defines)?;
    let idle = match idle {
        Some(idle) => idle,
        empty => empty.insert(Idle::new(programs)?),
    };
    idle.start(programs, &kernel, request)
}

/// A queue and a buffer for kernels that have nothing to do.
pub(super) struct Idle {
    queue: CommandQueue,
    placeholder: ClBuffer<u8>,
}

impl Idle {
    fn new(programs: &Programs) -> Result<Self, Error> {
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&programs.context, 0).map_err(|e| programs.error("clCreateCommandQueue", e))?;
        // SAFETY: no host pointer is given.
        let placeholder =
            unsafe { ClBuffer::create(&programs.context, CL_MEM_READ_WRITE, PLACEHOLDER_BYTES, std::ptr::null_mut()) };
        Ok(Self { queue, placeholder: placeholder.map_err(|e| programs.error("clCreateBuffer", e))? })
    }

    /// Starts a kernel whose values are all 0: it has no work-item to run, and every kernel returns at once in those that it has not.
    fn start(&self, programs: &Programs, kernel: &Kernel, request: &KernelRequest) -> Result<(), Error> {
        self.set_nothing(kernel, &request.arguments).map_err(|e| programs.error("clSetKernelArg", e))?;
        let group = request.group.min(programs.largest_group(kernel)?);
        let items = KernelRequest::SMALL_GRID;
        let global = if request.wide { (items + 1).next_multiple_of(group) } else { (items / group).max(1) * group };
        // SAFETY: sizes live through the call, and every argument is set.
        let event = unsafe { self.queue.enqueue_nd_range_kernel(kernel.get(), 1, std::ptr::null(), &global, &group, &[]) };
        let event = event.map_err(|e| programs.error("clEnqueueNDRangeKernel", e))?;
        event.wait().map_err(|e| programs.error("clWaitForEvents", e))
    }

    fn set_nothing(&self, kernel: &Kernel, sizes: &[usize]) -> opencl3::Result<()> {
        let placeholder = self.placeholder.get();
        let largest = sizes.iter().copied().max().unwrap_or(0);
        // As aligned as any argument is.
        let zeros = vec![0u128; largest.div_ceil(size_of::<u128>())];
        for (index, &bytes) in (0..).zip(sizes) {
            let (bytes, value) = match bytes {
                0 => (size_of::<cl_mem>(), (&raw const placeholder).cast()),
                bytes => (bytes, zeros.as_ptr().cast()),
            };
            // SAFETY: a live buffer, or as many zeros as the value has bytes.
            unsafe { set_kernel_arg(kernel.get(), index, bytes, value) }?;
        }
        Ok(())
    }
}

impl Device {
    /// Builds the kernels that `find` finds in the background, and calls `on_ready` when all are built, or with the reason why the first that
    /// failed could not be. Both are called on another thread.
    pub(crate) fn build_ahead(
        &self,
        find: impl FnOnce() -> Result<Vec<KernelRequest>, Error> + Send + 'static,
        on_ready: impl FnOnce(Result<(), Error>) + Send + 'static,
    ) -> ProgramBuilds {
        self.shared.ahead.request(Box::new(find), Box::new(on_ready))
    }

    /// Whether a kernel was built in the background, and starts without being compiled.
    pub(super) fn is_ready(&self, kernel: &KernelRequest) -> bool {
        self.shared.ahead.jobs.state().ready.contains(kernel)
    }

    /// Lets another process compile what is built in the background ([`Renderer::warm_up`](crate::Renderer::warm_up)), where compiling in this
    /// one would hold up frames: with PoCL, which starts no kernel while it compiles another. `command` starts a program that calls
    /// [`compile_for_parent`](crate::device::compile_for_parent) first in its `main`, in the same build of this library: the program itself, or
    /// `layersplat`. Where the process cannot be started, or ends, this one compiles.
    ///
    /// ```
    /// use layersplat::{Device, DeviceChoice};
    /// use std::process::Command;
    ///
    /// let device = Device::open(&DeviceChoice::Default)?;
    /// let program = std::env::current_exe().expect("the name of this program");
    /// device.compile_by(move || Command::new(&program));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn compile_by(&self, command: impl Fn() -> Command + Send + Sync + 'static) {
        self.shared.ahead.jobs.state().command = Some(Arc::new(command));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Call, DeviceChoice};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;
    use std::time::Duration;

    /// Longer than a small program takes on a busy machine.
    const PATIENCE: Duration = Duration::from_secs(60);

    fn device() -> Device {
        Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
    }

    /// A kernel of few lines.
    fn small() -> KernelRequest {
        let arguments = vec![0, size_of::<f32>(), size_of::<i32>(), size_of::<i32>(), 0];
        KernelRequest {
            file: "layered/table.cl",
            kernel: "table".into(),
            defines: "-DVW=1".into(),
            group: 64,
            wide: false,
            arguments,
        }
    }

    fn answered(device: &Device, kernels: Vec<KernelRequest>) -> Result<(), Error> {
        let (tell, told) = mpsc::channel();
        device.build_ahead(move || Ok(kernels), move |built| tell.send(built).unwrap());
        told.recv_timeout(PATIENCE).expect("an answer")
    }

    #[test]
    fn what_was_built_ahead_is_not_built_again() {
        let device = device();
        let builds = Arc::new(AtomicUsize::new(0));
        let count = builds.clone();
        device.observe_builds(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
        });
        answered(&device, vec![small(), KernelRequest { wide: true, ..small() }, small()]).unwrap();
        answered(&device, vec![small()]).unwrap();
        answered(&device, Vec::new()).unwrap();
        device.kernel("layered/table.cl", "table", "-DVW=1").unwrap();
        assert_eq!(builds.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_failure_is_told_and_the_rest_is_built() {
        let device = device();
        device.fail(Call::Build, 0, opencl3::error_codes::CL_BUILD_PROGRAM_FAILURE);
        let other = KernelRequest { defines: "-DVW=1 -DOTHER".into(), ..small() };
        assert!(matches!(answered(&device, vec![small(), other]), Err(Error::Build { .. })));
        device.recover();
        assert_eq!(device.programs(), 1);
        let refused = Error::NotBuilt { program: "what was not found" };
        let (tell, told) = mpsc::channel();
        let builds = device.build_ahead(move || Err(refused), move |built| tell.send(built).unwrap());
        builds.wait();
        assert!(told.recv_timeout(PATIENCE).unwrap().is_err() && builds.is_ready());
    }

    #[test]
    fn a_device_that_goes_gives_up_what_waits() {
        let device = device();
        let (begun, begins) = mpsc::channel();
        device.observe_builds(move |_| {
            begun.send(()).unwrap();
            // What waits behind it is not begun before the device goes.
            std::thread::sleep(Duration::from_millis(300));
        });
        let (tell, told) = mpsc::channel();
        let others = (0..50).map(|n| KernelRequest { defines: format!("-DVW=1 -DOTHER={n}"), ..small() });
        let builds = device.build_ahead(move || Ok(others.collect()), move |built| tell.send(built).unwrap());
        begins.recv_timeout(PATIENCE).expect("a build begins");
        drop(device);
        assert!(matches!(told.recv_timeout(PATIENCE), Ok(Err(Error::NotBuilt { .. }))));
        builds.wait();
        assert!(begins.try_iter().count() < 10, "builds go on");
    }

    #[test]
    fn the_last_device_may_go_on_the_thread_that_builds() {
        let device = device();
        let (tell, told) = mpsc::channel();
        let last = device.clone();
        device.build_ahead(
            move || Ok(vec![small()]),
            move |_| {
                drop(last);
                tell.send(()).unwrap();
            },
        );
        drop(device);
        told.recv_timeout(PATIENCE).expect("an answer");
    }
}
