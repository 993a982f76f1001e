//! Types of numbers, and their bytes.

use crate::volume::wide::Numbers;
use crate::volume::{Endian, ScalarType};
use hdf5_reader::error::{Error, Result};
use hdf5_reader::{ByteOrder, Dataset, Datatype, H5Type};

/// Scalar type and byte order of an HDF5 datatype. Enumerations, such as booleans, and bit fields are whole numbers.
pub(super) fn scalar(dtype: &Datatype) -> Option<(ScalarType, Endian)> {
    let (kind, size, order) = match dtype {
        Datatype::FixedPoint { size, signed, byte_order } => (if *signed { "int" } else { "uint" }, size, byte_order),
        Datatype::Bitfield { size, byte_order } => ("uint", size, byte_order),
        Datatype::FloatingPoint { size, byte_order } => ("float", size, byte_order),
        Datatype::Enum { base, .. } => return scalar(base),
        _ => return None,
    };
    let endian = if *order == ByteOrder::BigEndian { Endian::Big } else { Endian::Little };
    format!("{kind}{}", 8 * u32::from(*size)).parse().ok().map(|scalar| (scalar, endian))
}

/// Whether numbers are complex, as h5py and others store them: compounds of a real and an imaginary float.
pub(super) fn is_complex(dtype: &Datatype) -> bool {
    let Datatype::Compound { fields, .. } = dtype else { return false };
    let floats = fields.iter().all(|field| matches!(field.datatype, Datatype::FloatingPoint { .. }));
    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
    floats && [["r", "i"], ["real", "imag"], ["re", "im"]].iter().any(|known| names == known)
}

/// Bytes of a datatype message before the properties of numbers.
const PROPERTIES: usize = 8;

/// Whether floats are those of IEEE 754, and integers fill all their bits. HDF5 can describe others, such as bfloat16.
pub(super) fn are_usual(dataset: &Dataset) -> bool {
    let Ok(raw) = dataset.raw_datatype() else { return false };
    let word =
        |at: usize| raw.get(PROPERTIES + at..).and_then(|rest| rest.first_chunk()).map_or(0, |word| u16::from_le_bytes(*word));
    let bits = |size: u8| 8 * u16::from(size);
    match dataset.dtype() {
        Datatype::FloatingPoint { size, .. } => {
            let exponent = match size {
                2 => 5,
                4 => 8,
                _ => 11,
            };
            // The sizes of the exponent and of the mantissa.
            [raw.get(PROPERTIES + 5), raw.get(PROPERTIES + 7)] == [Some(&exponent), Some(&(8 * size - 1 - exponent))]
        }
        // The first bit, and the number of bits.
        Datatype::FixedPoint { size, signed: true, .. } => (word(0), word(2)) == (0, bits(*size)),
        _ => true,
    }
}

/// A number of `N` bytes as stored.
#[derive(Clone)]
#[repr(transparent)]
pub(super) struct Raw<const N: usize>(pub [u8; N]);

impl<const N: usize> H5Type for Raw<N> {
    fn hdf5_type() -> Datatype {
        Datatype::Opaque { size: N as u32, tag: String::new() }
    }

    fn from_bytes(bytes: &[u8], _: &Datatype) -> Result<Self> {
        bytes.first_chunk().copied().map(Self).ok_or_else(|| Error::InvalidData(format!("a number of fewer than {N} bytes")))
    }

    fn element_size(_: &Datatype) -> usize {
        N
    }

    fn native_copy_compatible(dtype: &Datatype) -> bool {
        scalar(dtype).is_some_and(|(scalar, _)| scalar.bytes() == N)
    }

    fn decode_vec(raw: &[u8], _: &Datatype, count: usize) -> Option<Result<Vec<Self>>> {
        Some(Ok(raw.as_chunks().0.get(..count)?.iter().map(|bytes| Self(*bytes)).collect()))
    }
}

/// The value of a number of any type.
#[derive(Clone)]
pub(super) struct Value(pub f64);

impl H5Type for Value {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], dtype: &Datatype) -> Result<Self> {
        let wrong = || Error::InvalidData(format!("a number of {} bytes, which is of another type", bytes.len()));
        let (scalar, endian) = scalar(dtype).ok_or_else(wrong)?;
        let bytes = bytes.get(..scalar.bytes()).ok_or_else(wrong)?;
        Ok(Self(Numbers { bytes, scalar, endian, missing: None }.stored(0)))
    }

    fn element_size(dtype: &Datatype) -> usize {
        scalar(dtype).map_or(0, |(scalar, _)| scalar.bytes())
    }
}
