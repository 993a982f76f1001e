//! Headers of NumPy arrays, of volumes and pictures (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).

use std::io;

/// First bytes of a file.
pub const MARK: &[u8] = b"\x93NUMPY";

/// Largest header in bytes; those of plain arrays have about a hundred.
const LARGEST: usize = 1 << 16;
/// Limit of axes.
const MOST_AXES: usize = 64;

/// A parsed header.
pub struct Header {
    /// Type of the numbers, such as `<f4`; `None` if it is not a plain type.
    pub descr: Option<String>,
    /// Whether the first axis is the fastest, not the slowest.
    pub fortran_order: bool,
    /// Sizes of the axes.
    pub shape: Vec<usize>,
    /// Byte of the first number.
    pub end: u64,
}

impl Header {
    /// Reads the header of a file. `read` reads from a byte on and returns how many bytes it has read. The inner error says what is wrong.
    pub fn read(mut read: impl FnMut(u64, &mut [u8]) -> io::Result<usize>) -> io::Result<Result<Self, String>> {
        let mut start = [0; 12];
        let found = read(0, &mut start)?;
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
        let found = read(before, &mut text)?;
        text.truncate(found);
        Ok(Self::parse(&String::from_utf8_lossy(&text), before + len as u64))
    }

    /// Reads the header of a file in memory.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let read = |at: u64, into: &mut [u8]| {
            let rest = &bytes[bytes.len().min(at as usize)..];
            let len = rest.len().min(into.len());
            into[..len].copy_from_slice(&rest[..len]);
            Ok(len)
        };
        Self::read(read).unwrap_or_else(|e| Err(e.to_string()))
    }

    /// Parses a Python dictionary: `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }`.
    fn parse(text: &str, end: u64) -> Result<Self, String> {
        let value = |key: &str| {
            let behind = text.split_once(&format!("'{key}'"))?.1;
            Some(behind.trim_start().strip_prefix(':')?.trim_start())
        };
        let damaged = |what: &str| format!("its header has no {what}: it is damaged, or not a plain array of numbers");
        let descr = value("descr").and_then(|rest| rest.strip_prefix('\'')?.split_once('\'')).map(|(descr, _)| descr.into());
        let fortran_order = value("fortran_order").ok_or_else(|| damaged("order"))?.starts_with("True");
        let shape = value("shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')')).map(|(shape, _)| shape);
        let words = shape.ok_or_else(|| damaged("shape"))?.split(',').map(|word| word.trim().trim_end_matches('L'));
        let shape: Option<Vec<usize>> = words.filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect();
        let shape = shape.filter(|shape| shape.len() <= MOST_AXES).ok_or_else(|| damaged("shape"))?;
        Ok(Self { descr, fortran_order, shape, end })
    }
}

/// The header of an array in C order. It ends with a newline, and numbers start at a multiple of 64 bytes.
pub fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let shape = match shape {
        [size] => format!("{size},"),
        sizes => sizes.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    };
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    let len = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut head = [MARK, b"\x01\x00"].concat();
    head.extend((len as u16).to_le_bytes());
    head.extend(format!("{text:<width$}\n", width = len - 1).bytes());
    head
}

/// Writes an array of numbers in C order.
pub fn write(out: &mut dyn io::Write, shape: &[usize], numbers: &[f32]) -> io::Result<()> {
    out.write_all(&header("<f4", shape))?;
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_as_they_were_written() {
        for shape in [&[7][..], &[3, 4], &[480, 640, 4]] {
            let bytes = header("<f4", shape);
            let read = Header::from_bytes(&bytes).unwrap();
            assert_eq!((read.descr.as_deref(), read.fortran_order, &read.shape[..]), (Some("<f4"), false, shape));
            assert_eq!((read.end, bytes.len() % 64, bytes.last()), (bytes.len() as u64, 0, Some(&b'\n')));
        }
        // What Python parses as a tuple of one number.
        assert!(String::from_utf8_lossy(&header("|u1", &[7])).contains("(7,)"));
    }

    #[test]
    fn damaged_headers_are_refused() {
        let bytes = header("<f4", &[2, 2]);
        assert!(Header::from_bytes(&bytes[..11]).is_err());
        assert!(Header::from_bytes(&bytes[..40]).is_err());
        let version = [&bytes[..6], b"\x04", &bytes[7..]].concat();
        assert!(Header::from_bytes(&version).err().unwrap().contains("version 4"));
    }
}
