//! What calls that take long have in common: the interpreter's lock is released, no panic reaches Python, and Ctrl-C ends what may take longest.

use crate::errors::{Failure, Result};
use layersplat::Cancel;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How often a call looks for signals: a person does not notice it, and it costs nothing beside a frame.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Does something with the interpreter's lock released.
///
/// # Errors
/// Those of `work`, and `InternalError` where it panics.
pub fn detached<T: Send>(py: Python, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    py.detach(|| without_panics(work))
}

/// Makes a panic an error. What `work` may leave half done is guarded by a lock, which is poisoned then.
pub fn without_panics<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Failure::Panicked(format!("layersplat panicked: {}", message(&*panic)))))
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// Whether Python handles signals on this thread: on its main thread only.
pub fn handles_signals(py: Python) -> PyResult<bool> {
    let threading = py.import("threading")?;
    let main = threading.call_method0("main_thread")?.getattr("ident")?;
    threading.call_method0("get_ident")?.eq(main)
}

/// Does something on a thread of its own, while this one handles Python's signals. It must be the main thread.
///
/// If a signal's handler raises (KeyboardInterrupt), that is returned at once and `cancel` is set. The thread goes on until `work` ends: a
/// kernel or a compilation in progress cannot be stopped. Its result is dropped.
///
/// # Errors
/// Those of `work`; `InternalError` where it panics; what a signal's handler raises.
pub fn interruptible<T: Send + 'static>(
    py: Python,
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T> + Send + 'static,
) -> Result<T> {
    let (sender, receiver) = sync_channel(1);
    let running = Running::new();
    let worker = thread::Builder::new().name("layersplat".into()).spawn(move || {
        // Nobody may be there to receive it.
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

/// Runs work that cannot be cancelled, with the interpreter's lock released. On Python's main thread, what a signal's handler raises is
/// returned at once; the work then ends in the background, and its result is dropped.
///
/// # Errors
/// Those of `work`; `InternalError` where it panics; what a signal's handler raises.
pub fn abandonable<T: Send + 'static>(py: Python, work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    if handles_signals(py)? { interruptible(py, &Cancel::new(), work) } else { detached(py, work) }
}

/// Threads of [`interruptible`] that have not ended.
static RUNNING: Mutex<usize> = Mutex::new(0);
static ENDED: Condvar = Condvar::new();

/// Counts one of them.
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

/// Waits until no thread of an interrupted call is left. Python calls it at exit, since a driver that unloads under a running kernel ends
/// the process with a fault. Another signal ends the wait.
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
