//! How far tasks are that may take long: told to whoever watches, which in the library nobody does.

#[cfg(feature = "cli")]
use std::{
    sync::OnceLock,
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};

/// What is told: the task's name, how much of it is done, and how much there is to do; 0 where that is not known.
#[cfg(feature = "cli")]
type Watch = dyn Fn(&str, u64, u64) + Send + Sync;

#[cfg(feature = "cli")]
static WATCH: OnceLock<Box<Watch>> = OnceLock::new();

/// Tells of all tasks from now on, at every step of theirs, and that all is done when they end, however they do. The first who asks is told.
#[cfg(feature = "cli")]
pub(crate) fn watch(watch: impl Fn(&str, u64, u64) + Send + Sync + 'static) {
    let _ = WATCH.set(Box::new(watch));
}

/// Microseconds that building programs has taken in this process.
#[cfg(feature = "cli")]
static BUILDING: AtomicU64 = AtomicU64::new(0);

/// Adds the time that the build of a program took.
#[cfg(feature = "cli")]
pub(crate) fn add_building(taken: Duration) {
    BUILDING.fetch_add(taken.as_micros() as u64, Ordering::Relaxed);
}

/// How long programs were built in this process.
#[cfg(feature = "cli")]
pub(crate) fn building() -> Duration {
    Duration::from_micros(BUILDING.load(Ordering::Relaxed))
}

/// A task that may take long.
pub(crate) struct Task {
    #[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the command alone is told"))]
    what: String,
    total: u64,
    done: u64,
}

impl Task {
    /// `total` steps, or 0 where these are not known.
    pub fn new(what: impl Into<String>, total: u64) -> Self {
        Self { what: what.into(), total, done: 0 }
    }

    /// So many steps more are done.
    pub fn add(&mut self, steps: u64) {
        self.done = self.done.saturating_add(steps);
        self.tell();
    }

    fn tell(&self) {
        #[cfg(feature = "cli")]
        if let Some(watch) = WATCH.get() {
            watch(&self.what, self.done, self.total);
        }
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        // Who never began is not heard of.
        if self.done > 0 {
            (self.done, self.total) = (self.done.max(self.total), self.done.max(self.total));
            self.tell();
        }
    }
}
