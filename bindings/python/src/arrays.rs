//! numpy arrays as voxels. Device voxel types are read in place, with any strides and byte order; other types are converted.
//!
//! Arrays come from `layersplat._arrays.placed`, which returns only immutable memory: a private copy, `bytes`, or a file mapped
//! read-only. Rust slices of it are therefore sound while other threads run.

use crate::errors::{Failure, Result, unknown};
use crate::warned::warned;
use layersplat::Volume;
use layersplat::volume::{Endian, Grid, ScalarType, Storage, VoxelType};
use numpy::{PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// Memory of an array, kept alive by a reference.
pub struct ArrayBytes {
    _array: Py<PyUntypedArray>,
    /// Address of its lowest byte.
    lowest: usize,
    bytes: usize,
}

impl AsRef<[u8]> for ArrayBytes {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: the array keeps these bytes alive, and they are immutable (see the module).
        unsafe { std::slice::from_raw_parts(self.lowest as *const u8, self.bytes) }
    }
}

/// A volume and the warnings of the library.
type Warned = (Volume<'static>, Vec<String>);

/// A volume of an array with the axes z, y, x.
///
/// # Errors
/// A type that `layersplat._arrays` should have converted, and the errors of the library.
pub fn volume(array: &Bound<PyUntypedArray>, name: &str, grid: Grid) -> Result<Warned> {
    let py = array.py();
    let name = name.to_owned();
    let storage = match (array.dtype().kind(), array.dtype().itemsize()) {
        (b'u', 1) => storage(array, VoxelType::Uint8),
        (b'i', 1) => storage(array, VoxelType::Int8),
        (b'u', 2) => storage(array, VoxelType::Uint16),
        (b'i', 2) => storage(array, VoxelType::Int16),
        (b'f', 4) => storage(array, VoxelType::Float32),
        (b'u', 4) => return wide::<u32>(array, name, grid),
        (b'i', 4) => return wide::<i32>(array, name, grid),
        (b'f', 8) => return wide::<f64>(array, name, grid),
        _ => return Err(unknown("voxel type", &array.dtype().to_string(), "integers or floats")),
    };
    // Scans all voxels for their range.
    warned(py, move || Ok(Volume::new(name, grid, storage)?))
}

/// The numbers of a contiguous array in native byte order, in place.
///
/// # Errors
/// For types that are no numbers.
pub fn numbers(array: &Bound<PyUntypedArray>) -> Result<(ArrayBytes, ScalarType)> {
    let kind = match array.dtype().kind() {
        b'u' => "uint",
        b'i' => "int",
        _ => "float",
    };
    let name = format!("{kind}{}", 8 * array.dtype().itemsize());
    let scalar = name.parse().map_err(|_| unknown("voxel type", &name, "integers or floats"))?;
    // SAFETY: the array is alive.
    let lowest = unsafe { (*array.as_array_ptr()).fields.data } as usize;
    let bytes = array.shape().iter().product::<usize>() * array.dtype().itemsize();
    Ok((ArrayBytes { _array: array.clone().unbind(), lowest, bytes }, scalar))
}

/// The voxels of an array, in place.
fn storage(array: &Bound<PyUntypedArray>, voxel_type: VoxelType) -> Storage<'static> {
    let extents = array.shape().iter().zip(array.strides()).map(|(&n, &stride)| (n as isize - 1) * stride);
    let before: isize = extents.clone().map(|e| e.min(0)).sum();
    let after: isize = extents.map(|e| e.max(0)).sum();
    // SAFETY: the array is alive.
    let data = unsafe { (*array.as_array_ptr()).fields.data } as usize;
    let bytes_of_array = ArrayBytes {
        _array: array.clone().unbind(),
        lowest: data.wrapping_add_signed(before),
        bytes: (after - before) as usize + voxel_type.bytes(),
    };
    let strides = array.strides();
    let storage = Storage::from_bytes(bytes_of_array, voxel_type)
        .with_first(before.unsigned_abs())
        .with_strides([strides[2], strides[1], strides[0]]);
    match array.dtype().byteorder() {
        b'>' => storage.with_endian(Endian::Big),
        b'<' => storage.with_endian(Endian::Little),
        _ => storage,
    }
}

/// A volume of an array of wide numbers, which devices do not support. `layersplat._arrays` has made it contiguous, in native byte
/// order.
fn wide<T>(array: &Bound<PyUntypedArray>, name: String, grid: Grid) -> Result<Warned>
where
    T: layersplat::volume::Wide + numpy::Element,
{
    let py = array.py();
    let flat = array.call_method1("reshape", (-1,))?;
    let flat: PyReadonlyArray1<T> = flat.extract().map_err(Failure::Python)?;
    let numbers = flat.as_slice().map_err(|error| Failure::Python(PyTypeError::new_err(error.to_string())))?;
    let count = numbers.len();
    let bytes = std::mem::size_of_val(numbers);
    let bytes_of_array = ArrayBytes { _array: flat.as_untyped().clone().unbind(), lowest: numbers.as_ptr() as usize, bytes };
    warned(py, move || {
        // SAFETY: `bytes_of_array` keeps this slice alive, and it is immutable (see the module).
        let numbers = unsafe { std::slice::from_raw_parts(bytes_of_array.as_ref().as_ptr().cast::<T>(), count) };
        Ok(Volume::from_wide(name, grid, numbers)?)
    })
}
