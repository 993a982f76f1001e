//! The library's renderer behind a Python object: one thread uses it at a time, and nobody after a panic.

use crate::calls::{detached, handles_signals, interruptible};
use crate::errors::{Failure, Result};
use layersplat::{Cancel, Error, Renderer};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard};

/// A renderer that threads share.
pub struct Exclusive {
    // Taken with the interpreter's lock released, and nothing under it takes that one: neither waits for the other.
    renderer: Mutex<Renderer>,
    /// The Python object that voxels on the device belong to. It goes after the renderer.
    _owner: Option<Py<PyAny>>,
}

impl Exclusive {
    pub fn new(renderer: Renderer, owner: Option<Py<PyAny>>) -> Self {
        Self { renderer: Mutex::new(renderer), _owner: owner }
    }

    /// Does something with the renderer once no other thread uses it.
    ///
    /// # Errors
    /// Those of `act`, and `InternalError` where it panics, or something did in an earlier call: the renderer may be left half changed.
    /// The C library refuses it too.
    pub fn with<T: Send>(
        &self,
        py: Python,
        act: impl FnOnce(&mut Renderer) -> std::result::Result<T, Error> + Send,
    ) -> Result<T> {
        detached(py, || Ok(act(&mut *self.lock()?)?))
    }

    /// The same for what may take long: Ctrl-C ends it. What `draw` returns is dropped then.
    ///
    /// # Errors
    /// Those of [`with`](Self::with), and what a signal's handler raises.
    pub fn interruptible<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python,
        draw: impl FnOnce(&mut Renderer) -> std::result::Result<T, Error> + Send + 'static,
    ) -> Result<T> {
        if !handles_signals(py)? {
            return self.with(py, draw);
        }
        // One of each call: a frame of another thread is not cancelled.
        let cancel = Cancel::new();
        let (shared, token) = (self.clone(), cancel.clone());
        interruptible(py, &cancel, move || {
            let mut renderer = shared.lock()?;
            renderer.set_cancel(Some(token));
            let drawn = draw(&mut renderer);
            renderer.set_cancel(None);
            Ok(drawn?)
        })
    }

    fn lock(&self) -> Result<MutexGuard<'_, Renderer>> {
        let refused =
            |_| Failure::Panicked("layersplat panicked in this renderer before: it cannot be used any more, make another".into());
        self.renderer.lock().map_err(refused)
    }
}
