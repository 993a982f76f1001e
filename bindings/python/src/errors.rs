//! Errors of the library as Python exceptions.

use layersplat::Error;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::io;
use std::path::Path;

/// An error that becomes a Python exception.
pub enum Failure {
    /// An error of the library.
    Ours(Error),
    /// An argument that is rejected before the library is called.
    Refused { class: Refusal, message: String, field: &'static str },
    /// A panic, now or in an earlier call.
    Panicked(String),
    /// An exception of Python or of the caller's code.
    Python(PyErr),
}

/// Why an argument is rejected.
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

/// The exception of a failure, with its message and the fields at fault.
fn raised(py: Python, failure: Failure) -> PyResult<PyErr> {
    let exception = |class: &str, message: String, fields: &[&'static str]| -> PyResult<Bound<PyAny>> {
        let exception = py.import("layersplat._errors")?.getattr(class)?.call1((message,))?;
        exception.setattr("fields", PyTuple::new(py, fields)?)?;
        Ok(exception)
    };
    let exception = match failure {
        Failure::Python(error) => return Ok(error),
        Failure::Refused { class: Refusal::Type, message, field } => exception("InvalidType", message, &[argument(field)])?,
        Failure::Refused { class: Refusal::Value, message, field } => exception("InvalidValue", message, &[argument(field)])?,
        Failure::Panicked(message) => exception("InternalError", message, &[])?,
        Failure::Ours(error) => {
            let exception = exception(class(&error), message(&error), error.fields())?;
            if let Some((path, errno)) = file(&error) {
                exception.setattr("filename", path)?;
                exception.setattr("errno", errno)?;
            }
            exception
        }
    };
    Ok(PyErr::from_value(exception))
}

/// The argument that contains a field: `shading` for `shading['power']`.
fn argument(field: &'static str) -> &'static str {
    field.split('[').next().unwrap_or(field)
}

/// The message of an error. Without OpenCL, PyPI has one for the processors that pyproject.toml names.
fn message(error: &Error) -> String {
    match error {
        Error::NoOpenCl { .. } if cfg!(all(target_os = "linux", target_arch = "x86_64")) => {
            format!("{error}; or run: pip install 'layersplat[pocl]'")
        }
        _ => error.to_string(),
    }
}

/// The exception class of an error, defined in `layersplat/_errors.py`.
fn class(error: &Error) -> &'static str {
    match error {
        Error::Read { source, .. } | Error::Write { source, .. } => match source.kind() {
            io::ErrorKind::NotFound => "FileNotFound",
            io::ErrorKind::PermissionDenied => "PermissionDenied",
            _ => "FileError",
        },
        Error::Volume { path, .. } if is_in_memory(path) => "InvalidValue",
        Error::Volume { .. }
        | Error::FileSize { .. }
        | Error::Sheared { .. }
        | Error::Unnamed { .. }
        | Error::Image { .. }
        | Error::Labels { .. }
        | Error::Cameras { .. }
        | Error::Keys { .. } => "InvalidFile",
        Error::HostMemory { .. }
        | Error::DeviceMemory { .. }
        | Error::OutOfDeviceMemory { .. }
        | Error::MemoryBudget { .. }
        | Error::LightMemory { .. } => "OutOfMemory",
        Error::TooLong { .. } => "TimedOut",
        Error::Cancelled { .. } => "Cancelled",
        Error::VoxelCount { .. }
        | Error::Grid { .. }
        | Error::Surface { .. }
        | Error::Transfer { .. }
        | Error::OutOfRange { .. }
        | Error::Argument { .. }
        | Error::Camera { .. }
        | Error::Settings { .. }
        | Error::UnknownName { .. }
        | Error::NeedsWholeVolume { .. }
        | Error::Memory { .. } => "InvalidValue",
        // No OpenCL, no device, a failed call, and errors that the library adds later.
        _ => "DeviceError",
    }
}

/// Whether the name of a volume is in the place of the path.
fn is_in_memory(path: &Path) -> bool {
    !path.exists() && !path.to_string_lossy().contains("://")
}

/// The file of an error, and the errno of the system if there is one.
fn file(error: &Error) -> Option<(&Path, Option<i32>)> {
    match error {
        Error::Read { path, source } | Error::Write { path, source } => Some((path, source.raw_os_error())),
        Error::Volume { path, .. } if is_in_memory(path) => None,
        Error::Volume { path, .. }
        | Error::FileSize { path, .. }
        | Error::Sheared { path, .. }
        | Error::Unnamed { path, .. }
        | Error::Image { path, .. }
        | Error::Labels { path, .. }
        | Error::Cameras { path, .. }
        | Error::Keys { path, .. } => Some((path, None)),
        _ => None,
    }
}

/// An unknown name of `what`; `known` lists the valid ones.
pub fn unknown(what: &'static str, name: &str, known: &str) -> Failure {
    Error::UnknownName { what, name: name.into(), known: known.into() }.into()
}

/// A number outside its range.
pub fn out_of_range(name: &'static str, value: impl ToString, expected: &'static str) -> Failure {
    Error::OutOfRange { name, value: value.to_string(), expected }.into()
}

/// An argument that conflicts with another one.
pub fn conflict(field: &'static str, problem: impl Into<String>) -> Failure {
    Error::Settings { field, problem: problem.into() }.into()
}
