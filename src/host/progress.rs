//! Progress of long tasks, reported to an observer. Only the command installs one.

use std::{
    cell::RefCell,
    io,
    sync::atomic::{AtomicU64, Ordering},
    sync::{Arc, OnceLock},
    time::{Duration, Instant},
};

/// An observer: task name, completed steps and total steps, which is 0 if unknown.
type Watch = dyn Fn(&str, u64, u64) + Send + Sync;

static WATCH: OnceLock<Box<Watch>> = OnceLock::new();

/// Installs the observer of all tasks. It is called after every step, and with completed = total when a task ends. Only the first
/// call has an effect.
pub fn watch(watch: impl Fn(&str, u64, u64) + Send + Sync + 'static) {
    let _ = WATCH.set(Box::new(watch));
}

/// An observer of the tasks that one thread begins, which can end them. For programs with several at once.
pub trait Observer: Send + Sync {
    /// As an observer of all tasks ([`watch`]).
    fn step(&self, what: &str, done: u64, total: u64);
    /// Whether tasks are to end.
    fn is_cancelled(&self) -> bool;
}

thread_local! {
    static OBSERVER: RefCell<Option<Arc<dyn Observer>>> = const { RefCell::new(None) };
}

/// Runs work whose tasks are observed.
pub fn observed<T>(observer: Arc<dyn Observer>, work: impl FnOnce() -> T) -> T {
    struct Reset(Option<Arc<dyn Observer>>);
    impl Drop for Reset {
        fn drop(&mut self) {
            OBSERVER.with(|own| *own.borrow_mut() = self.0.take());
        }
    }
    let _reset = Reset(OBSERVER.with(|own| own.borrow_mut().replace(observer)));
    work()
}

/// The observer of this thread, for another thread that works for it.
pub fn observer() -> Option<Arc<dyn Observer>> {
    OBSERVER.with(|own| own.borrow().clone())
}

/// Fails if the observer of this thread ends its tasks.
///
/// # Errors
/// That the task was cancelled.
pub fn check() -> io::Result<()> {
    observer().map_or(Ok(()), |observer| still_wanted(observer.as_ref()))
}

/// Runs work that is cancelled.
#[cfg(test)]
pub(crate) fn cancelled<T>(work: impl FnOnce() -> T) -> T {
    struct Cancelled;
    impl Observer for Cancelled {
        fn step(&self, _: &str, _: u64, _: u64) {}

        fn is_cancelled(&self) -> bool {
            true
        }
    }
    observed(Arc::new(Cancelled), work)
}

fn still_wanted(observer: &dyn Observer) -> io::Result<()> {
    if observer.is_cancelled() { Err(io::Error::other("it was cancelled")) } else { Ok(()) }
}

/// Total build time of programs in this process, in microseconds.
static BUILDING: AtomicU64 = AtomicU64::new(0);

/// Number of programs that are being built in this process.
static BUILDS: AtomicU64 = AtomicU64::new(0);

/// Builds a program; counts it meanwhile, and its build time afterwards.
pub fn count_build<T>(build: impl FnOnce() -> T) -> T {
    let _counted = Building::begin();
    build()
}

/// A program that is being built.
struct Building {
    started: Instant,
}

impl Building {
    fn begin() -> Self {
        BUILDS.fetch_add(1, Ordering::Relaxed);
        Self { started: Instant::now() }
    }
}

impl Drop for Building {
    fn drop(&mut self) {
        BUILDS.fetch_sub(1, Ordering::Relaxed);
        BUILDING.fetch_add(self.started.elapsed().as_micros() as u64, Ordering::Relaxed);
    }
}

/// Whether any program is being built in this process.
pub fn is_building() -> bool {
    BUILDS.load(Ordering::Relaxed) > 0
}

/// Total build time of programs in this process.
pub fn building() -> Duration {
    Duration::from_micros(BUILDING.load(Ordering::Relaxed))
}

/// A long task, which several threads may work on.
pub struct Task {
    what: String,
    total: u64,
    done: AtomicU64,
    observer: Option<Arc<dyn Observer>>,
}

impl Task {
    /// Starts a task of `total` steps; 0 if unknown.
    pub fn new(what: impl Into<String>, total: u64) -> Self {
        Self { what: what.into(), total, done: AtomicU64::new(0), observer: observer() }
    }

    /// Fails if the observer ends the task.
    ///
    /// # Errors
    /// That the task was cancelled.
    pub fn check(&self) -> io::Result<()> {
        self.observer.as_deref().map_or(Ok(()), still_wanted)
    }

    /// Does some steps; none once the observer ends the task, which then uses no result of it.
    pub fn work<T: Default>(&self, steps: u64, work: impl FnOnce() -> T) -> T {
        if self.check().is_err() {
            return T::default();
        }
        let done = work();
        self.add(steps);
        done
    }

    /// Adds completed steps.
    pub fn add(&self, steps: u64) {
        let before = self.done.fetch_add(steps, Ordering::Relaxed);
        self.notify(before.saturating_add(steps), self.total);
    }

    fn notify(&self, done: u64, total: u64) {
        if let Some(watch) = WATCH.get() {
            watch(&self.what, done, total);
        }
        if let Some(observer) = &self.observer {
            observer.step(&self.what, done, total);
        }
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        let done = *self.done.get_mut();
        // A task without any steps is never reported.
        if done > 0 && self.check().is_ok() {
            let all = done.max(self.total);
            self.notify(all, all);
        }
    }
}
