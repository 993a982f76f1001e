//! Checks the first directory before the tiff crate reads it. The crate allocates memory for declared tags immediately, because our limits
//! can only be set after it has parsed the directory.

use crate::error::Error;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Rejects tags with more numbers than a file of `len` bytes can hold. Truncated directories are left to the crate.
pub(super) fn check(path: &Path, file: &mut File, len: u64) -> Result<(), Error> {
    let failed = |e| Error::read(path, e);
    let found = match too_large(file, len) {
        Err(e) if ![io::ErrorKind::UnexpectedEof, io::ErrorKind::InvalidInput].contains(&e.kind()) => return Err(failed(e)),
        found => found.unwrap_or(None),
    };
    file.rewind().map_err(failed)?;
    match found {
        Some((tag, count)) => {
            let problem = format!(
                "tag {tag} of its first page declares {count} numbers, but the file has {len} bytes: it is \
                                   damaged"
            );
            Err(Error::volume(path, problem))
        }
        None => Ok(()),
    }
}

/// The first tag with more than `most` numbers, and its count.
fn too_large(file: &mut File, most: u64) -> io::Result<Option<(u64, u64)>> {
    let mut numbers = Numbers { reader: BufReader::new(file), big_endian: false };
    numbers.big_endian = numbers.next(2)? == 0x4d4d;
    let large = numbers.next(2)? == 43;
    let (of_offset, of_entries) = if large { (8, 8) } else { (4, 2) };
    if large {
        // Size of offsets, always 8, and padding.
        numbers.next(4)?;
    }
    let directory = numbers.next(of_offset)?;
    numbers.reader.seek(SeekFrom::Start(directory))?;
    for _ in 0..numbers.next(of_entries)? {
        let tag = numbers.next(2)?;
        let _of_type = numbers.next(2)?;
        let count = numbers.next(of_offset)?;
        if count > most {
            return Ok(Some((tag, count)));
        }
        let _value = numbers.next(of_offset)?;
    }
    Ok(None)
}

struct Numbers<R> {
    reader: R,
    big_endian: bool,
}

impl<R: Read> Numbers<R> {
    /// The next unsigned integer of up to eight bytes.
    fn next(&mut self, bytes: usize) -> io::Result<u64> {
        let mut number = [0; 8];
        self.reader.read_exact(&mut number[..bytes])?;
        if self.big_endian {
            number[..bytes].reverse();
        }
        Ok(u64::from_le_bytes(number))
    }
}
