//! The first directory, before the crate reads it: what its tags declare is set aside at once, within limits of the crate's own, for ours
//! can only be told once it is read.

use crate::error::Error;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Refuses tags with more numbers than a file of `len` bytes can hold. What the file does not have of its directory is left to the crate.
pub(super) fn check(path: &Path, file: &mut File, len: u64) -> Result<(), Error> {
    let failed = |e| Error::read(path, e);
    let found = match too_large(file, len) {
        Err(e) if ![io::ErrorKind::UnexpectedEof, io::ErrorKind::InvalidInput].contains(&e.kind()) => return Err(failed(e)),
        found => found.unwrap_or(None),
    };
    file.rewind().map_err(failed)?;
    match found {
        Some((tag, count)) => {
            let problem = format!("tag {tag} of its first page has {count} numbers, and it has {len} bytes: it is damaged");
            Err(Error::volume(path, problem))
        }
        None => Ok(()),
    }
}

/// The first tag with more than `most` numbers, and how many these are.
fn too_large(file: &mut File, most: u64) -> io::Result<Option<(u64, u64)>> {
    let mut numbers = Numbers { reader: BufReader::new(file), big_endian: false };
    numbers.big_endian = numbers.next(2)? == 0x4d4d;
    let large = numbers.next(2)? == 43;
    let (of_offset, of_entries) = if large { (8, 8) } else { (4, 2) };
    if large {
        // How many bytes offsets have, which is 8.
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
    /// The next whole number, of up to eight bytes.
    fn next(&mut self, bytes: usize) -> io::Result<u64> {
        let mut number = [0; 8];
        self.reader.read_exact(&mut number[..bytes])?;
        if self.big_endian {
            number[..bytes].reverse();
        }
        Ok(u64::from_le_bytes(number))
    }
}
