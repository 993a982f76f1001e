//! Header of a NumPy array.

use crate::volume::format::COMPLEX;
use crate::volume::format::bytes::Bytes;
use crate::volume::{Endian, ScalarType};
use std::io;

pub(super) const MARK: &[u8] = b"\x93NUMPY";

/// Largest header in bytes; those of plain arrays have about a hundred.
const LARGEST: usize = 1 << 16;
/// Limit of axes.
const MOST: usize = 64;

/// A parsed header.
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
    /// Stride along each axis in bytes.
    pub fn strides(&self) -> Vec<u64> {
        let product = |axes: &[usize]| axes.iter().fold(self.scalar.bytes() as u64, |n, &size| n * size as u64);
        let along = |axis: usize| product(if self.fortran { &self.shape[..axis] } else { &self.shape[axis + 1..] });
        (0..self.shape.len()).map(along).collect()
    }
}

/// Reads the header. The inner error says what is wrong with it.
pub(super) fn read(bytes: &mut dyn Bytes) -> io::Result<Result<Array, String>> {
    let mut start = [0; 12];
    let found = bytes.read(0, &mut start)?;
    if found < start.len() || !start.starts_with(MARK) {
        return Ok(Err("its header is truncated".into()));
    }
    let [.., a, b, c, d] = start;
    let (before, len) = match start[6] {
        1 => (10, usize::from(u16::from_le_bytes([a, b]))),
        2 | 3 => (12, u32::from_le_bytes([a, b, c, d]) as usize),
        version => return Ok(Err(format!("its format has version {version}: expected 1 to 3"))),
    };
    if len > LARGEST {
        return Ok(Err(format!("its header of {len} bytes is too long for a plain array of numbers")));
    }
    let mut text = vec![0; len];
    let found = bytes.read(before, &mut text)?;
    text.truncate(found);
    Ok(parsed(&String::from_utf8_lossy(&text), before + len as u64))
}

/// Parses a Python dictionary: `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }`.
fn parsed(text: &str, end: u64) -> Result<Array, String> {
    let value = |key: &str| {
        let behind = text.split_once(&format!("'{key}'"))?.1;
        Some(behind.trim_start().strip_prefix(':')?.trim_start())
    };
    let damaged = |what: &str| format!("its header has no {what}: it is damaged, or not a plain array of numbers");
    let descr = value("descr").and_then(|rest| rest.strip_prefix('\'')?.split_once('\'')).map(|(descr, _)| descr);
    if let Some(descr) = descr.filter(|descr| descr.get(1..).is_some_and(|name| name.starts_with('c'))) {
        return Err(format!("its type is {descr}: {COMPLEX}"));
    }
    let (scalar, endian) = descr
        .and_then(scalar)
        .ok_or_else(|| format!("its type is {}: expected numbers of 8 to 64 bits", descr.unwrap_or("not a plain number")))?;
    let fortran = value("fortran_order").ok_or_else(|| damaged("order"))?.starts_with("True");
    let shape = value("shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')')).map(|(shape, _)| shape);
    let words = shape.ok_or_else(|| damaged("shape"))?.split(',').map(|word| word.trim().trim_end_matches('L'));
    let shape: Option<Vec<usize>> = words.filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect();
    let shape = shape.filter(|shape| shape.len() <= MOST).ok_or_else(|| damaged("shape"))?;
    let all = shape.iter().try_fold(scalar.bytes() as u64, |n, &size| n.checked_mul(size as u64).filter(|&n| n > 0));
    match all {
        Some(all) if !shape.is_empty() && all < u64::MAX / 2 => Ok(Array { scalar, endian, shape, fortran, end }),
        _ => Err(format!("its shape {shape:?} is empty or too large")),
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
