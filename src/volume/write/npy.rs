//! NumPy arrays of shape (z, y, x).

use super::Written;
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
    let text = format!("{{'descr': '{order}{kind}{size}', 'fortran_order': False, 'shape': ({z}, {y}, {x}), }}");
    // The header ends with a newline; numbers start at a multiple of 64.
    let len = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut head = b"\x93NUMPY\x01\x00".to_vec();
    head.extend((len as u16).to_le_bytes());
    head.extend(format!("{text:<width$}\n", width = len - 1).bytes());
    Ok(head)
}
