//! Python arguments. Error messages name the argument, its value and the accepted values.

use crate::errors::{Failure, Refusal, Result};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;
use pyo3::{Borrowed, PyClass};
use std::convert::Infallible;
use std::path::PathBuf;

/// An argument that is not converted yet. `extract!` converts it and knows its name.
pub enum Argument<'py, T> {
    Object(Bound<'py, PyAny>),
    Default(T),
}

impl<'a, 'py, T> FromPyObject<'a, 'py> for Argument<'py, T> {
    type Error = Infallible;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> std::result::Result<Self, Infallible> {
        Ok(Argument::Object(object.to_owned()))
    }
}

/// A type of argument. `accepted` describes its valid values, after "expected" in messages.
pub trait Accepted<'py>: FromPyObjectOwned<'py> {
    fn accepted() -> String;
}

/// Conversion of an argument whose name is known.
pub trait Named {
    type Value;

    /// The value.
    ///
    /// # Errors
    /// `InvalidType` for another type; `InvalidValue` if a number or a count is out of range.
    fn named(self, name: &'static str) -> Result<Self::Value>;
}

impl<'py, T: Accepted<'py>> Named for Argument<'py, T> {
    type Value = T;

    fn named(self, name: &'static str) -> Result<T> {
        match self {
            Argument::Object(object) => extracted(name, &object),
            Argument::Default(value) => Ok(value),
        }
    }
}

impl<T: Named> Named for Option<T> {
    type Value = Option<T::Value>;

    fn named(self, name: &'static str) -> Result<Option<T::Value>> {
        self.map(|argument| argument.named(name)).transpose()
    }
}

/// Replaces arguments by their values.
macro_rules! extract {
    ($($name:ident),+ $(,)?) => {
        $(let $name = $crate::argument::Named::named($name, stringify!($name))?;)+
    };
}
pub(crate) use extract;

/// The value of an argument, or of a part of one.
pub fn extracted<'py, T: Accepted<'py>>(name: &'static str, object: &Bound<'py, PyAny>) -> Result<T> {
    object.extract::<T>().map_err(|error| refused(name, object, error.into(), &T::accepted()))
}

/// The error of an object that is not accepted.
pub fn refused(name: &'static str, object: &Bound<PyAny>, error: PyErr, accepted: &str) -> Failure {
    let py = object.py();
    let class = if error.is_instance_of::<PyTypeError>(py) {
        Refusal::Type
    } else if error.is_instance_of::<PyOverflowError>(py) || error.is_instance_of::<PyValueError>(py) {
        Refusal::Value
    } else {
        // An exception of the object's own code.
        return error.into();
    };
    match shown(object) {
        Ok(value) => Failure::Refused { class, message: format!("{name} is {value}: expected {accepted}"), field: name },
        Err(error) => error.into(),
    }
}

/// The abbreviated `repr` of a value, and its type.
pub fn shown(object: &Bound<PyAny>) -> PyResult<String> {
    let value: String = object.py().import("reprlib")?.call_method1("repr", (object,))?.extract()?;
    if object.is_none() {
        return Ok(value);
    }
    Ok(format!("{value} ({})", object.get_type().name()?))
}

/// Extracts one of two types. If neither fits, the error is that of the second for sequences, and otherwise that of the first.
pub fn either<'a, 'py, A, B, T>(
    object: Borrowed<'a, 'py, PyAny>,
    first: impl FnOnce(A) -> T,
    second: impl FnOnce(B) -> T,
) -> PyResult<T>
where
    A: FromPyObject<'a, 'py>,
    B: FromPyObject<'a, 'py>,
{
    let error = match object.extract::<A>() {
        Ok(value) => return Ok(first(value)),
        Err(error) => error.into(),
    };
    match object.extract::<B>() {
        Ok(value) => Ok(second(value)),
        Err(other) if object.hasattr("__len__")? && !object.is_instance_of::<PyString>() => Err(other.into()),
        Err(_) => Err(error),
    }
}

macro_rules! accepted {
    ($($type:ty: $words:literal;)+) => {
        $(impl<'py> $crate::argument::Accepted<'py> for $type {
            fn accepted() -> String {
                $words.into()
            }
        })+
    };
}
pub(crate) use accepted;

accepted! {
    bool: "True or False";
    f64: "a number";
    u32: "a whole number from 0 on";
    u64: "a whole number from 0 on";
    usize: "a whole number from 0 on";
    isize: "a whole number";
    Vec<usize>: "a list of whole numbers from 0 on";
    String: "a string";
    Vec<String>: "a list of strings";
    PathBuf: "a path: a string or a pathlib.Path";
    (f64, f64): "two numbers";
    (usize, usize): "two whole numbers from 0 on";
    [(usize, usize); 3]: "three pairs of whole numbers from 0 on, ((x0, x1), (y0, y1), (z0, z1))";
    [usize; 3]: "three whole numbers from 0 on";
    [f64; 3]: "three numbers, (x, y, z)";
    Vec<(f64, f64)>: "a list of pairs of numbers";
    Vec<(f64, [f64; 3])>: "a list of (value, (red, green, blue))";
    Vec<Bound<'py, PyAny>>: "a list";
}

impl<'py, T: PyClass> Accepted<'py> for Bound<'py, T> {
    fn accepted() -> String {
        format!("a layersplat.{}", T::NAME)
    }
}
