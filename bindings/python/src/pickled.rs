//! Pickling and copying, by calling the constructor with arguments that make an equal object.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{IntoPyObjectExt, PyClass};

/// The result of `__reduce__`: `class(**arguments)`, in a form that every pickle protocol supports.
pub type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

pub fn reduced<'py, T: PyClass>(py: Python<'py>, arguments: Bound<'py, PyDict>) -> PyResult<Reduced<'py>> {
    let make = py.import("copyreg")?.getattr("__newobj_ex__")?;
    let call = [py.get_type::<T>().into_bound_py_any(py)?, PyTuple::empty(py).into_any(), arguments.into_any()];
    Ok((make, PyTuple::new(py, call)?))
}
