//! The array that a header describes, as voxels.

use crate::npy::Header;
use crate::volume::format::COMPLEX;
use crate::volume::{Endian, ScalarType};

/// An array of numbers that voxels can have.
pub(super) struct Array {
    pub scalar: ScalarType,
    pub endian: Endian,
    /// Sizes of the axes; the first axis is the slowest, or the fastest in Fortran order.
    pub shape: Vec<usize>,
    fortran: bool,
    /// Byte of the first number.
    pub end: u64,
}

impl Array {
    /// The error says what is wrong with the header.
    pub fn new(header: Header) -> Result<Self, String> {
        let Header { descr, fortran_order: fortran, shape, end } = header;
        let descr = descr.as_deref();
        if let Some(descr) = descr.filter(|descr| descr.get(1..).is_some_and(|name| name.starts_with('c'))) {
            return Err(format!("its type is {descr}: {COMPLEX}"));
        }
        let (scalar, endian) = descr
            .and_then(scalar)
            .ok_or_else(|| format!("its type is {}: expected numbers of 8 to 64 bits", descr.unwrap_or("not a plain number")))?;
        let all = shape.iter().try_fold(scalar.bytes() as u64, |n, &size| n.checked_mul(size as u64).filter(|&n| n > 0));
        match all {
            Some(all) if !shape.is_empty() && all < u64::MAX / 2 => Ok(Self { scalar, endian, shape, fortran, end }),
            _ => Err(format!("its shape {shape:?} is empty or too large")),
        }
    }

    /// Stride along each axis in bytes.
    pub fn strides(&self) -> Vec<u64> {
        let product = |axes: &[usize]| axes.iter().fold(self.scalar.bytes() as u64, |n, &size| n * size as u64);
        let along = |axis: usize| product(if self.fortran { &self.shape[..axis] } else { &self.shape[axis + 1..] });
        (0..self.shape.len()).map(along).collect()
    }
}

/// Parses a type such as `<f4`. Booleans are read as bytes.
fn scalar(descr: &str) -> Option<(ScalarType, Endian)> {
    let (order, name) = descr.split_at_checked(1)?;
    let endian = match order {
        "<" | "|" => Endian::Little,
        ">" => Endian::Big,
        "=" => Endian::NATIVE,
        _ => return None,
    };
    let (kind, size) = name.split_at_checked(1)?;
    let bits = 8 * size.parse::<usize>().ok().filter(|&size| size <= 8)?;
    let name = match kind {
        "b" => "uint8".into(),
        "u" => format!("uint{bits}"),
        "i" => format!("int{bits}"),
        "f" => format!("float{bits}"),
        _ => return None,
    };
    Some((name.parse().ok()?, endian))
}
