//! Progress of the kernels that were requested together.

use crate::error::Error;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
#[cfg(feature = "page")]
use std::time::Duration;

/// Called when all programs of a request are built.
pub(super) type OnReady = Box<dyn FnOnce(Result<(), Error>) + Send>;

/// Programs that are being built in the background. Dropping this handle does not cancel the builds.
#[derive(Clone)]
pub struct ProgramBuilds {
    batch: Arc<Batch>,
}

/// Kernels that were requested together.
pub(super) struct Batch {
    progress: Mutex<Progress>,
    changed: Condvar,
}

struct Progress {
    done: usize,
    /// `None` until the kernels of the request are known.
    total: Option<usize>,
    /// The first error.
    failure: Option<Error>,
    /// Taken when called.
    on_ready: Option<OnReady>,
}

impl ProgramBuilds {
    pub(super) fn new(batch: Arc<Batch>) -> Self {
        Self { batch }
    }

    /// Number of finished kernels, and of all kernels; `None` until that is known. Failed builds count as finished.
    pub fn progress(&self) -> (usize, Option<usize>) {
        let progress = self.batch.progress();
        (progress.done, progress.total)
    }

    /// Whether all kernels are finished.
    pub fn is_ready(&self) -> bool {
        self.batch.progress().is_complete()
    }

    /// Waits until a kernel or all are finished, for at most this time. Returns whether all are.
    #[cfg(feature = "page")]
    pub(crate) fn wait_for_next(&self, longest: Duration) -> bool {
        let progress = self.batch.progress();
        let (done, total) = (progress.done, progress.total);
        let is_same = |now: &mut Progress| !now.is_complete() && (now.done, now.total) == (done, total);
        let (progress, _) =
            self.batch.changed.wait_timeout_while(progress, longest, is_same).unwrap_or_else(PoisonError::into_inner);
        progress.is_complete()
    }

    /// Waits until all kernels are finished.
    pub fn wait(&self) {
        let progress = self.batch.progress();
        let waited = self.batch.changed.wait_while(progress, |progress| !progress.is_complete());
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

impl Progress {
    fn is_complete(&self) -> bool {
        self.total == Some(self.done)
    }
}

impl Batch {
    pub fn new(on_ready: OnReady) -> Self {
        let progress = Progress { done: 0, total: None, failure: None, on_ready: Some(on_ready) };
        Self { progress: Mutex::new(progress), changed: Condvar::new() }
    }

    fn progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the progress, and calls `on_ready` after the last kernel.
    fn update(&self, change: impl FnOnce(&mut Progress)) {
        let mut progress = self.progress();
        change(&mut progress);
        self.changed.notify_all();
        if !progress.is_complete() {
            return;
        }
        let (on_ready, failure) = (progress.on_ready.take(), progress.failure.take());
        drop(progress);
        if let Some(on_ready) = on_ready {
            on_ready(failure.map_or(Ok(()), Err));
        }
    }

    /// Sets the number of kernels of the request.
    pub fn set_total(&self, total: usize) {
        self.update(|progress| progress.total = Some(total));
    }

    /// Counts a kernel that was built or failed.
    pub fn count(&self, built: Result<(), Error>) {
        self.update(|progress| {
            progress.done += 1;
            progress.failure = progress.failure.take().or(built.err());
        });
    }

    /// Ends a request whose kernels could not be determined.
    pub fn fail(&self, error: Error) {
        self.update(|progress| {
            progress.total = Some(progress.done);
            progress.failure = Some(error);
        });
    }
}
