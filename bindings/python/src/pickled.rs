//! Pickling and copying: an object is made again by the call that makes an equal one.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{IntoPyObjectExt, PyClass};

/// What `__reduce__` returns: `class(**arguments)`, as every protocol of pickle writes it.
pub type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

pub fn reduced<'py, T: PyClass>(py: Python<'py>, arguments: Bound<'py, PyDict>) -> PyResult<Reduced<'py>> {
    let make = py.import("copyreg")?.getattr("__newobj_ex__")?;
    let call = [py.get_type::<T>().into_bound_py_any(py)?, PyTuple::empty(py).into_any(), arguments.into_any()];
    Ok((make, PyTuple::new(py, call)?))
}
