//! Exclusive access to the library's renderer of a Python object: one thread at a time, and none after a panic.

use crate::calls::{detached, handles_signals, interruptible};
use crate::errors::{Failure, Result};
use layersplat::renderer::VolumeRenderer;
use layersplat::{Cancel, Error};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A renderer that holds the whole volume, or one that streams it.
pub type AnyRenderer = dyn VolumeRenderer<'static> + Send;

/// A renderer shared by threads.
pub struct Exclusive {
    // Locked with the GIL released. Code that holds it never takes the GIL, so there is no deadlock.
    renderer: Mutex<Box<AnyRenderer>>,
    in_progress: Mutex<InProgress>,
    /// The Python object that owns voxels on the device. Fields drop in order: the renderer first.
    _owner: Option<Py<PyAny>>,
}

/// Calls that can be cancelled, including those that wait for the renderer.
#[derive(Default)]
struct InProgress {
    calls: BTreeMap<u64, Cancel>,
    next: u64,
}

/// A call in progress. Dropping it ends the call.
struct Call {
    shared: Arc<Exclusive>,
    number: u64,
    cancel: Cancel,
}

impl Call {
    fn new(shared: Arc<Exclusive>) -> Self {
        // One flag per call: Ctrl-C must not cancel frames of other threads.
        let cancel = Cancel::new();
        let mut in_progress = shared.in_progress();
        let number = in_progress.next;
        in_progress.next += 1;
        in_progress.calls.insert(number, cancel.clone());
        drop(in_progress);
        Self { shared, number, cancel }
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        self.shared.in_progress().calls.remove(&self.number);
    }
}

impl Exclusive {
    pub fn new(renderer: Box<AnyRenderer>, owner: Option<Py<PyAny>>) -> Self {
        Self { renderer: Mutex::new(renderer), in_progress: Mutex::default(), _owner: owner }
    }

    /// Calls `act` with the renderer as soon as no other thread uses it.
    ///
    /// # Errors
    /// Those of `act`, and `InternalError` if it or an earlier call panicked, since the renderer may be inconsistent. The C library
    /// does the same.
    pub fn with<T: Send>(
        &self,
        py: Python,
        act: impl FnOnce(&mut AnyRenderer) -> std::result::Result<T, Error> + Send,
    ) -> Result<T> {
        detached(py, || Ok(act(&mut **self.lock()?)?))
    }

    /// Like [`with`](Self::with) for long calls. Ctrl-C and [`cancel`](Self::cancel) end them, and their result is dropped.
    ///
    /// # Errors
    /// Those of [`with`](Self::with), [`Error::Cancelled`], and the exception of a signal handler.
    pub fn interruptible<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python,
        draw: impl FnOnce(&mut AnyRenderer) -> std::result::Result<T, Error> + Send + 'static,
    ) -> Result<T> {
        let call = Call::new(self.clone());
        let cancel = call.cancel.clone();
        let work = move || {
            let mut renderer = call.shared.lock()?;
            renderer.set_cancel(Some(call.cancel.clone()));
            let drawn = draw(&mut **renderer);
            renderer.set_cancel(None);
            Ok(drawn?)
        };
        if handles_signals(py)? { interruptible(py, &cancel, work) } else { detached(py, work) }
    }

    /// Cancels all current calls of [`interruptible`](Self::interruptible), but no later ones.
    pub fn cancel(&self) {
        self.in_progress().calls.values().for_each(Cancel::cancel);
    }

    fn in_progress(&self) -> MutexGuard<'_, InProgress> {
        self.in_progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> Result<MutexGuard<'_, Box<AnyRenderer>>> {
        let refused = |_| Failure::Panicked("layersplat panicked in this renderer before: make another".into());
        self.renderer.lock().map_err(refused)
    }
}
