//! NumPy arrays of shape (z, y, x).

use super::Written;
use crate::npy;
use crate::volume::ScalarType;

pub(super) fn head(written: &Written) -> Result<Vec<u8>, String> {
    let [x, y, z] = written.grid.dims();
    let size = written.scalar.bytes();
    let kind = match written.scalar {
        ScalarType::Uint8 | ScalarType::Uint16 | ScalarType::Uint32 | ScalarType::Uint64 => 'u',
        ScalarType::Int8 | ScalarType::Int16 | ScalarType::Int32 | ScalarType::Int64 => 'i',
        ScalarType::Float16 | ScalarType::Float32 | ScalarType::Float64 => 'f',
    };
    let order = if size == 1 { '|' } else { '<' };
    Ok(npy::header(&format!("{order}{kind}{size}"), &[z, y, x]))
}
