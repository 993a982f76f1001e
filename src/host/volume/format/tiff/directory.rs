//! Directories, read before the crate reads them: it allocates what the tags of the first one declare, and it inverts the samples of pages
//! whose photometric interpretation is WhiteIsZero.

use super::pages::MOST;
use crate::error::Error;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Tag of the photometric interpretation: 0 is WhiteIsZero, 1 BlackIsZero.
const PHOTOMETRIC: u64 = 262;

/// A TIFF file in which pages that are WhiteIsZero appear as BlackIsZero.
///
/// That tag tells how to display numbers. Voxels are the numbers as stored; the crate would return 1 − v for floats and the largest number
/// less v for integers, and refuse signed ones.
pub(super) struct AsStored {
    file: File,
    position: u64,
    /// Bytes that hold a 0 for WhiteIsZero, in ascending order.
    photometric: Vec<u64>,
}

impl AsStored {
    /// # Errors
    /// Rejects a first page whose tags have more numbers than the file's `len` bytes can hold. Directories that are incomplete are left to
    /// the crate.
    pub fn new(path: &Path, mut file: File, len: u64) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let mut found = Found::default();
        match read(&mut file, len, &mut found) {
            Err(e) if ![io::ErrorKind::UnexpectedEof, io::ErrorKind::InvalidInput].contains(&e.kind()) => return Err(failed(e)),
            _ => file.rewind().map_err(failed)?,
        }
        if let Some((tag, count)) = found.too_large {
            let problem = format!("tag {tag} of its first page has {count} numbers, and it has {len} bytes: it is damaged");
            return Err(Error::volume(path, problem));
        }
        found.photometric.sort_unstable();
        Ok(Self { file, position: 0, photometric: found.photometric })
    }
}

impl Read for AsStored {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(bytes)?;
        let end = self.position + read as u64;
        let first = self.photometric.partition_point(|&at| at < self.position);
        for at in self.photometric[first..].iter().take_while(|&&at| at < end) {
            bytes[(at - self.position) as usize] = 1;
        }
        self.position = end;
        Ok(read)
    }
}

impl Seek for AsStored {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.file.seek(to)?;
        Ok(self.position)
    }
}

/// What the directories say.
#[derive(Default)]
struct Found {
    /// The first tag of the first page with more numbers than the file has bytes, and how many.
    too_large: Option<(u64, u64)>,
    photometric: Vec<u64>,
}

/// Reads all directories, up to the first one that is not there.
fn read(file: &mut File, len: u64, found: &mut Found) -> io::Result<()> {
    let mut numbers = Numbers { reader: BufReader::new(file), big_endian: false };
    numbers.big_endian = numbers.next(2)? == 0x4d4d;
    let large = numbers.next(2)? == 43;
    let (offset_bytes, count_bytes) = if large { (8, 8) } else { (4, 2) };
    if large {
        // Size of offsets, always 8, and padding.
        numbers.next(4)?;
    }
    // Directories that overlap are damaged, and may go on for ever.
    let mut left = len;
    for page in 0..=MOST {
        let directory = numbers.next(offset_bytes)?;
        if directory == 0 {
            break;
        }
        numbers.reader.seek(SeekFrom::Start(directory))?;
        let (entries, size) = (numbers.next(count_bytes)?, 4 + 2 * offset_bytes as u64);
        let Some(rest) = left.checked_sub(entries.saturating_mul(size)) else { break };
        left = rest;
        for n in 0..entries {
            let [tag, kind, count] = [numbers.next(2)?, numbers.next(2)?, numbers.next(offset_bytes)?];
            if page == 0 && count > len {
                found.too_large = Some((tag, count));
                return Ok(());
            }
            let value = numbers.next(offset_bytes)?;
            if tag == PHOTOMETRIC && is_zero(value, kind, numbers.big_endian, offset_bytes) {
                let at = directory + count_bytes as u64 + n * size + 4 + offset_bytes as u64;
                found.photometric.push(at + if numbers.big_endian { bytes_of(kind) as u64 - 1 } else { 0 });
            }
        }
    }
    Ok(())
}

/// Bytes of a whole number of a type; 0 of other types.
fn bytes_of(kind: u64) -> usize {
    match kind {
        1 => 1,
        3 => 2,
        4 => 4,
        _ => 0,
    }
}

/// Whether the number at the beginning of a field of `field` bytes is 0.
fn is_zero(value: u64, kind: u64, big_endian: bool, field: usize) -> bool {
    let bytes = bytes_of(kind);
    let unused = if big_endian { 8 * (field - bytes) } else { 0 };
    bytes > 0 && value >> unused & ((1 << (8 * bytes)) - 1) == 0
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
