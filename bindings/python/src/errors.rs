//! Errors of the library as Python exceptions.

use layersplat::Error;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::io;
use std::path::Path;

/// Why a call fails.
pub enum Failure {
    /// An error of the library's.
    Ours(Error),
    /// An argument that is refused before the library sees it.
    Refused { class: Refusal, message: String, field: &'static str },
    /// A panic, now or in an earlier call.
    Panicked(String),
    /// An exception of the caller's own code, or one of Python's.
    Python(PyErr),
}

/// What is wrong with an argument.
#[derive(Clone, Copy)]
pub enum Refusal {
    Type,
    Value,
}

pub type Result<T> = std::result::Result<T, Failure>;

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Ours(error)
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Failure::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| raised(py, failure).unwrap_or_else(|failed| failed))
    }
}

/// An exception of the class that a failure belongs to, with its message and the fields at fault.
fn raised(py: Python, failure: Failure) -> PyResult<PyErr> {
    let made = |class: &str, message: String, fields: &[&'static str]| -> PyResult<Bound<PyAny>> {
        let exception = py.import("layersplat._errors")?.getattr(class)?.call1((message,))?;
        exception.setattr("fields", PyTuple::new(py, fields)?)?;
        Ok(exception)
    };
    let exception = match failure {
        Failure::Python(error) => return Ok(error),
        Failure::Refused { class: Refusal::Type, message, field } => made("InvalidType", message, &[argument(field)])?,
        Failure::Refused { class: Refusal::Value, message, field } => made("InvalidValue", message, &[argument(field)])?,
        Failure::Panicked(message) => made("InternalError", message, &[])?,
        Failure::Ours(error) => {
            let exception = made(class(&error), error.to_string(), error.fields())?;
            if let Some((path, errno)) = file(&error) {
                exception.setattr("filename", path)?;
                exception.setattr("errno", errno)?;
            }
            exception
        }
    };
    Ok(PyErr::from_value(exception))
}

/// The argument that a field is of: `shading` of `shading['power']`.
fn argument(field: &'static str) -> &'static str {
    field.split('[').next().unwrap_or(field)
}

/// The class of an error, of those in `layersplat/_errors.py`.
fn class(error: &Error) -> &'static str {
    match error {
        Error::Read { source, .. } | Error::Write { source, .. } => match source.kind() {
            io::ErrorKind::NotFound => "FileNotFound",
            io::ErrorKind::PermissionDenied => "PermissionDenied",
            _ => "FileError",
        },
        // Of a volume in memory, whose name stands for the path.
        Error::Volume { path, .. } if !path.exists() => "InvalidValue",
        Error::Volume { .. }
        | Error::FileSize { .. }
        | Error::Unnamed { .. }
        | Error::Image { .. }
        | Error::Cameras { .. }
        | Error::Keys { .. } => "InvalidFile",
        Error::HostMemory { .. } | Error::DeviceMemory { .. } | Error::OutOfDeviceMemory { .. } | Error::MemoryBudget { .. } => {
            "OutOfMemory"
        }
        Error::TooLong { .. } => "TimedOut",
        Error::Cancelled { .. } => "Cancelled",
        Error::VoxelCount { .. }
        | Error::Grid { .. }
        | Error::Transfer { .. }
        | Error::OutOfRange { .. }
        | Error::Camera { .. }
        | Error::Settings { .. }
        | Error::UnknownName { .. }
        | Error::NeedsWholeVolume { .. }
        | Error::Memory { .. } => "InvalidValue",
        // No OpenCL, no device, one that fails; and what the library adds.
        _ => "DeviceError",
    }
}

/// The file of an error, and the system's number.
fn file(error: &Error) -> Option<(&Path, Option<i32>)> {
    match error {
        Error::Read { path, source } | Error::Write { path, source } => Some((path, source.raw_os_error())),
        Error::Volume { path, .. } if !path.exists() => None,
        Error::Volume { path, .. }
        | Error::FileSize { path, .. }
        | Error::Unnamed { path, .. }
        | Error::Image { path, .. }
        | Error::Cameras { path, .. }
        | Error::Keys { path, .. } => Some((path, None)),
        _ => None,
    }
}

/// A value that is none of those that exist.
pub fn unknown(what: &'static str, name: &str, known: &str) -> Failure {
    Error::UnknownName { what, name: name.into(), known: known.into() }.into()
}

/// A number outside of its range.
pub fn out_of_range(name: &'static str, value: impl ToString, expected: &'static str) -> Failure {
    Error::OutOfRange { name, value: value.to_string(), expected }.into()
}

/// What contradicts something else.
pub fn conflict(field: &'static str, problem: impl Into<String>) -> Failure {
    Error::Settings { field, problem: problem.into() }.into()
}
