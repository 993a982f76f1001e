//! Errors of the library as exceptions of Python's.

use layersplat::Error;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// What a call can end with: an error of the library's, or an exception of Python's own.
pub enum Failure {
    Ours(Error),
    Python(PyErr),
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
        match failure {
            Failure::Python(error) => error,
            Failure::Ours(error) => Python::attach(|py| raised(py, &error).unwrap_or_else(|failed| failed)),
        }
    }
}

/// An exception of the class that an error belongs to, with its message and the fields at fault.
fn raised(py: Python, error: &Error) -> PyResult<PyErr> {
    let class = py.import("layersplat._errors")?.getattr(class(error))?;
    let exception = class.call1((error.to_string(),))?;
    exception.setattr("fields", PyTuple::new(py, error.fields())?)?;
    Ok(PyErr::from_value(exception))
}

/// The class of an error, of those in `layersplat/_errors.py`.
fn class(error: &Error) -> &'static str {
    match error {
        Error::Read { .. } | Error::Write { .. } => "FileError",
        Error::HostMemory { .. } | Error::DeviceMemory { .. } | Error::OutOfDeviceMemory { .. } => "OutOfMemory",
        Error::NoOpenCl { .. }
        | Error::NoDevice { .. }
        | Error::KernelCache { .. }
        | Error::Build { .. }
        | Error::TooLong { .. }
        | Error::Cancelled { .. }
        | Error::OpenCl { .. } => "DeviceError",
        _ => "InvalidValue",
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
