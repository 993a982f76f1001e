//! Voxels stored as text.

use crate::error::Error;
use crate::memory;
use crate::volume::ScalarType;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// Limit of text in bytes, which is read at once.
const MOST_TEXT: u64 = 1 << 32;

/// Text of a file from a byte to the end.
pub(super) fn read_from(path: &Path, file: File, start: u64) -> Result<Vec<u8>, Error> {
    read_range(path, file, start..u64::MAX)
}

/// Text in a byte range of a file, clipped at its end.
pub(super) fn read_range(path: &Path, mut file: File, part: Range<u64>) -> Result<Vec<u8>, Error> {
    let failed = |e| Error::read(path, e);
    let end = file.metadata().map_err(failed)?.len().min(part.end);
    let len = end.saturating_sub(part.start);
    if len > MOST_TEXT {
        return Err(Error::volume(path, format!("its {len} bytes of text are too many: write it as binary data")));
    }
    memory::require(&path.display().to_string(), len)?;
    file.seek(SeekFrom::Start(part.start)).map_err(failed)?;
    let mut text = Vec::new();
    file.take(len).read_to_end(&mut text).map_err(failed)?;
    Ok(text)
}

/// Parses `count` numbers, separated by white space or commas, to bytes in native order.
///
/// # Errors
/// If there are fewer numbers, or one is invalid for the type.
pub(super) fn numbers(path: &Path, text: &[u8], count: u64, scalar: ScalarType) -> Result<Vec<u8>, Error> {
    // A number takes at least a digit and a separator. Check before allocating.
    if count > (text.len() as u64).div_ceil(2) {
        return Err(Error::volume(
            path,
            format!("{count} numbers are declared, but {} bytes of text cannot hold them", text.len()),
        ));
    }
    let size = scalar.bytes();
    let mut bytes = memory::zeroed::<u8>(&path.display().to_string(), count as usize * size)?;
    let mut words = text.split(|byte| byte.is_ascii_whitespace() || *byte == b',').filter(|word| !word.is_empty());
    for (index, number) in bytes.chunks_exact_mut(size).enumerate() {
        let Some(word) = words.next() else {
            return Err(Error::volume(
                path,
                format!("its text ends after {index} of {count} numbers: it is truncated or damaged"),
            ));
        };
        let parsed = std::str::from_utf8(word).ok().is_some_and(|word| put(word, scalar, number));
        if !parsed {
            let word = String::from_utf8_lossy(&word[..word.len().min(40)]);
            return Err(Error::volume(path, format!("number {index} of its text is '{word}', which is not a valid {scalar}")));
        }
    }
    Ok(bytes)
}

/// Parses a number of a type into its bytes. Returns false if it is invalid.
fn put(word: &str, scalar: ScalarType, bytes: &mut [u8]) -> bool {
    macro_rules! whole {
        ($type:ty) => {
            // Some writers append a decimal point to integers.
            word.parse::<$type>()
                .ok()
                .or_else(|| whole(word).map(|n| n as $type).filter(|&n| Some(n as f64) == whole(word)))
                .map(|n| bytes.copy_from_slice(&n.to_ne_bytes()))
                .is_some()
        };
    }
    match scalar {
        ScalarType::Uint8 => whole!(u8),
        ScalarType::Int8 => whole!(i8),
        ScalarType::Uint16 => whole!(u16),
        ScalarType::Int16 => whole!(i16),
        ScalarType::Uint32 => whole!(u32),
        ScalarType::Int32 => whole!(i32),
        ScalarType::Uint64 => whole!(u64),
        ScalarType::Int64 => whole!(i64),
        ScalarType::Float16 => word.parse().map(|n: f64| bytes.copy_from_slice(&half::f16::from_f64(n).to_ne_bytes())).is_ok(),
        ScalarType::Float32 => word.parse().map(|n: f32| bytes.copy_from_slice(&n.to_ne_bytes())).is_ok(),
        ScalarType::Float64 => word.parse().map(|n: f64| bytes.copy_from_slice(&n.to_ne_bytes())).is_ok(),
    }
}

fn whole(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|n| n.fract() == 0.0)
}

/// Decodes pairs of hexadecimal digits, ignoring white space.
pub(super) fn hexadecimal(path: &Path, text: &[u8]) -> Result<Vec<u8>, Error> {
    let mut digits = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    let mut bytes = Vec::with_capacity(text.len() / 2);
    while let Some(&high) = digits.next() {
        let digit = |byte: u8| char::from(byte).to_digit(16);
        let low = digits.next().copied().and_then(digit);
        let (Some(high), Some(low)) = (digit(high), low) else {
            return Err(Error::volume(path, format!("byte {} of its hexadecimal data is not two digits", bytes.len())));
        };
        bytes.push((high * 16 + low) as u8);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_becomes_numbers_of_its_type() {
        let path = Path::new("a.txt");
        let found = numbers(path, b"1 -2,3.0\n 4 ", 4, ScalarType::Int16).unwrap();
        assert_eq!(found, [1i16, -2, 3, 4].map(i16::to_ne_bytes).concat());
        let found = numbers(path, b"1e-3\tnan", 2, ScalarType::Float32).unwrap();
        assert_eq!(found[..4], 1e-3f32.to_ne_bytes());
        let largest = numbers(path, b"18446744073709551615 0", 2, ScalarType::Uint64).unwrap();
        assert_eq!(largest[..8], u64::MAX.to_ne_bytes());
        for (text, count, scalar) in [
            ("1 2", 3, ScalarType::Uint8),
            ("1 256", 2, ScalarType::Uint8),
            ("1 -1", 2, ScalarType::Uint16),
            ("1 x", 2, ScalarType::Float64),
        ] {
            assert!(numbers(path, text.as_bytes(), count, scalar).is_err(), "{text}");
        }
        assert!(numbers(path, b"1", u64::MAX, ScalarType::Uint8).is_err());
    }

    #[test]
    fn digits_become_bytes() {
        let path = Path::new("a.nrrd");
        assert_eq!(hexadecimal(path, b"00ff\n7F 1\n0").unwrap(), [0, 255, 127, 16]);
        assert!(hexadecimal(path, b"00f").is_err() && hexadecimal(path, b"0g").is_err());
    }
}
