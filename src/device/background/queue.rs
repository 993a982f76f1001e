//! The queue of background builds, and the loop of the thread that processes it.

use super::build::{EmptyLauncher, build};
use super::process::CompilerProcess;
use super::progress::Batch;
use crate::device::cache;
use crate::device::launch::KernelRequest;
use crate::device::program::Programs;
use crate::error::Error;
use std::collections::{HashSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Creates the command of a compiler process.
pub(super) type CompilerCommand = dyn Fn() -> Command + Send + Sync;

/// Determines the kernels of a request.
pub(super) type FindKernels = Box<dyn FnOnce() -> Result<Vec<KernelRequest>, Error> + Send>;

/// Jobs of the background thread.
#[derive(Default)]
pub(super) struct JobQueue {
    state: Mutex<State>,
    changed: Condvar,
}

/// One step of a request.
enum Job {
    Find(FindKernels),
    Build(KernelRequest),
}

#[derive(Default)]
struct State {
    waiting: VecDeque<(Job, Arc<Batch>)>,
    /// Built kernels, whose launch compiles nothing.
    ready: HashSet<KernelRequest>,
    command: Option<Arc<CompilerCommand>>,
    /// The compiler process, while there are jobs.
    compiler: Option<Arc<CompilerProcess>>,
    /// The device is being dropped.
    closed: bool,
}

/// Runs a job. If it panics, which the panic hook reports, it fails: others wait for its result.
fn guarded<T>(program: &'static str, job: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(job)).unwrap_or(Err(Error::NotBuilt { program, problem: "the build panicked" }))
}

/// The error of a program whose device was closed before it was built.
fn closed(program: &'static str) -> Error {
    Error::NotBuilt { program, problem: "its device was closed first" }
}

impl JobQueue {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a request.
    pub fn push(&self, find: FindKernels, batch: Arc<Batch>) {
        self.state().waiting.push_back((Job::Find(find), batch));
        self.changed.notify_one();
    }

    /// Adds kernels before all jobs that wait.
    #[cfg(feature = "page")]
    pub fn push_first(&self, kernels: Vec<KernelRequest>, batch: &Arc<Batch>) {
        let total = kernels.len();
        let is_closed = {
            let mut state = self.state();
            if !state.closed {
                kernels.into_iter().rev().for_each(|kernel| state.waiting.push_front((Job::Build(kernel), batch.clone())));
            }
            state.closed
        };
        match is_closed {
            true => batch.fail(closed("no program")),
            false => batch.set_total(total),
        }
        self.changed.notify_one();
    }

    /// Whether a kernel is built.
    pub fn is_ready(&self, kernel: &KernelRequest) -> bool {
        self.state().ready.contains(kernel)
    }

    pub fn set_compiler_command(&self, command: Arc<CompilerCommand>) {
        self.state().command = Some(command);
    }

    /// Ends the loop and the compiler process. Waiting jobs fail.
    pub fn close(&self) {
        let abandoned = {
            let mut state = self.state();
            state.closed = true;
            if let Some(compiler) = &state.compiler {
                compiler.end();
            }
            std::mem::take(&mut state.waiting)
        };
        self.changed.notify_one();
        for (job, batch) in abandoned {
            match job {
                Job::Find(_) => batch.fail(closed("no program")),
                Job::Build(kernel) => batch.count(Err(closed(kernel.file))),
            }
        }
    }

    /// Processes jobs until the queue is closed.
    pub fn run(&self, programs: &Programs) {
        let mut launcher = None;
        while let Some((job, batch)) = self.next() {
            match job {
                Job::Find(find) => match guarded("no program", find) {
                    Ok(kernels) => self.add(kernels, &batch),
                    Err(error) => batch.fail(error),
                },
                Job::Build(kernel) => {
                    let build = || if self.is_ready(&kernel) { Ok(()) } else { self.build(programs, &mut launcher, &kernel) };
                    let built = guarded(kernel.file, build);
                    match &built {
                        Ok(()) => drop(self.state().ready.insert(kernel)),
                        Err(error) => tracing::debug!("background build failed: {error}"),
                    }
                    batch.count(built);
                }
            }
        }
    }

    /// Waits for the next job; `None` once the queue is closed.
    fn next(&self) -> Option<(Job, Arc<Batch>)> {
        let mut state = self.state();
        loop {
            if state.closed {
                return None;
            }
            if let Some(job) = state.waiting.pop_front() {
                return Some(job);
            }
            state.compiler = None;
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Adds the kernels of a request.
    fn add(&self, kernels: Vec<KernelRequest>, batch: &Arc<Batch>) {
        let total = kernels.len();
        {
            let mut state = self.state();
            if state.closed {
                drop(state);
                return batch.fail(closed("no program"));
            }
            state.waiting.extend(kernels.into_iter().map(|kernel| (Job::Build(kernel), batch.clone())));
        }
        batch.set_total(total);
    }

    /// Builds a kernel. If a compiler process has compiled it, this process only loads the result, which delays frames least.
    fn build(&self, programs: &Programs, launcher: &mut Option<EmptyLauncher>, kernel: &KernelRequest) -> Result<(), Error> {
        self.compile_in_process(programs, kernel);
        let closed = self.state().closed;
        if closed { Err(self::closed(kernel.file)) } else { build(programs, launcher, kernel) }
    }

    /// Lets the compiler process compile a kernel, if there is one. After an error, this process compiles.
    fn compile_in_process(&self, programs: &Programs, kernel: &KernelRequest) {
        let Some(compiler) = self.compiler(programs) else { return };
        if let Err(error) = compiler.compile(kernel) {
            tracing::debug!("the compiler process did not compile {}: {error}", kernel.file);
            self.state().compiler = None;
        }
    }

    /// The compiler process, started if necessary. Only PoCL needs one.
    fn compiler(&self, programs: &Programs) -> Option<Arc<CompilerProcess>> {
        let mut state = self.state();
        if state.compiler.is_none() && !state.closed && cache::is_pocl(&programs.info.platform) {
            let command = state.command.clone()?;
            match CompilerProcess::start(command(), &programs.info) {
                Ok(started) => state.compiler = Some(Arc::new(started)),
                Err(error) => {
                    tracing::warn!("cannot start the compiler process: {error}");
                    state.command = None;
                }
            }
        }
        state.compiler.clone()
    }
}
