//! The library's renderer behind a Python object: one thread uses it at a time, and nobody after a panic.

use crate::calls::detached;
use crate::errors::{Failure, Result};
use layersplat::{Error, Renderer};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard};

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

    fn lock(&self) -> Result<MutexGuard<'_, Renderer>> {
        let refused =
            |_| Failure::Panicked("layersplat panicked in this renderer before: it cannot be used any more, make another".into());
        self.renderer.lock().map_err(refused)
    }
}
