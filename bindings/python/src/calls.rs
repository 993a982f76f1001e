//! What calls that take long have in common: the interpreter's lock is released, and no panic reaches Python.

use crate::errors::{Failure, Result};
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

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
