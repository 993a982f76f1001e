//! Long calls: they release the GIL, convert panics to exceptions, and the longest ones can be interrupted with Ctrl-C.

use crate::errors::{Failure, Result};
use layersplat::Cancel;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Interval of signal checks: too short for a user to notice, and negligible compared to a frame.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Runs `work` with the GIL released.
///
/// # Errors
/// Those of `work`, and `InternalError` if it panics.
pub fn detached<T: Send>(py: Python, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    py.detach(|| without_panics(work))
}

/// Converts a panic to an error. State that `work` leaves inconsistent is behind a lock, which the panic poisons.
pub fn without_panics<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Failure::Panicked(format!("layersplat panicked: {}", message(&*panic)))))
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// Whether Python handles signals on this thread, which it does only on its main thread.
pub fn handles_signals(py: Python) -> PyResult<bool> {
    let threading = py.import("threading")?;
    let main = threading.call_method0("main_thread")?.getattr("ident")?;
    threading.call_method0("get_ident")?.eq(main)
}

/// Runs `work` on a worker thread, while the calling thread handles Python's signals. Call it on the main thread.
///
/// If a signal handler raises (KeyboardInterrupt), the exception is returned immediately and `cancel` is set. The worker runs until
/// `work` ends, since a running kernel or compilation cannot be interrupted. Its result is dropped.
///
/// # Errors
/// Those of `work`; `InternalError` if it panics; the exception of a signal handler.
pub fn interruptible<T: Send + 'static>(
    py: Python,
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T> + Send + 'static,
) -> Result<T> {
    let (sender, receiver) = sync_channel(1);
    let running = Running::new();
    let worker = thread::Builder::new().name("layersplat".into()).spawn(move || {
        // Fails if the call was interrupted.
        let _ = sender.send(without_panics(work));
        drop(running);
    });
    worker.map_err(|error| Failure::Python(error.into()))?;
    py.detach(move || {
        loop {
            match receiver.recv_timeout(SIGNAL_INTERVAL) {
                Ok(result) => return result,
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()).inspect_err(|_| cancel.cancel())?,
                Err(RecvTimeoutError::Disconnected) => unreachable!("the thread sends its result or its panic"),
            }
        }
    })
}

/// Runs work that cannot be cancelled, with the GIL released. On Python's main thread, the exception of a signal handler is returned
/// immediately; the work then ends in the background, and its result is dropped.
///
/// # Errors
/// Those of `work`; `InternalError` if it panics; the exception of a signal handler.
pub fn abandonable<T: Send + 'static>(py: Python, work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    if handles_signals(py)? { interruptible(py, &Cancel::new(), work) } else { detached(py, work) }
}

/// Number of running worker threads of [`interruptible`].
static RUNNING: Mutex<usize> = Mutex::new(0);
static ENDED: Condvar = Condvar::new();

/// Counts a worker thread while it exists.
struct Running;

impl Running {
    fn new() -> Self {
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        Self
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        ENDED.notify_all();
    }
}

/// Waits until the worker threads of all interrupted calls have ended. Python calls it at exit, since a driver that is unloaded while
/// a kernel runs crashes the process. Another signal ends the wait.
#[pyfunction]
pub fn wait_for_interrupted_calls(py: Python) -> PyResult<()> {
    py.detach(|| {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        while *running > 0 {
            running = ENDED.wait_timeout(running, SIGNAL_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
            Python::attach(|py| py.check_signals())?;
        }
        Ok(())
    })
}
