//! Directories of a file and their tags. Nothing is allocated that is larger than the file.

use crate::error::Error;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Most pages of a file.
pub(super) const MOST: usize = 1 << 20;

/// A tag: type and number of its values, and the field that has them, or where they are.
#[derive(Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    field: [u8; 8],
}

/// The tags of a page.
pub(super) struct Directory {
    entries: BTreeMap<u16, Entry>,
    /// Offset of the next directory, or 0.
    next: u64,
}

/// A file, its byte order and the size of its offsets.
pub(super) struct Reader {
    file: BufReader<File>,
    pub len: u64,
    pub big_endian: bool,
    large: bool,
    first: u64,
}

/// Bytes of a value of a type; 0 of unknown types.
fn size_of(kind: u16) -> u64 {
    match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 0,
    }
}

fn damaged(problem: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

impl Reader {
    pub fn new(path: &Path) -> Result<Self, Error> {
        let read = || {
            let file = File::open(path)?;
            let len = file.metadata()?.len();
            let mut reader = Self { file: BufReader::new(file), len, big_endian: false, large: false, first: 0 };
            let mut mark = [0; 4];
            reader.file.read_exact(&mut mark)?;
            reader.big_endian = mark[0] == b'M';
            reader.large = mark.contains(&b'+');
            let mut head = vec![0; if reader.large { 12 } else { 4 }];
            reader.file.read_exact(&mut head)?;
            // Before the offset of large files stand its size, always 8, and padding.
            reader.first = reader.number(if reader.large { &head[4..] } else { &head });
            Ok(reader)
        };
        read().map_err(|e| failed(path, &e))
    }

    /// An unsigned integer of up to eight bytes.
    fn number(&self, bytes: &[u8]) -> u64 {
        let next = |n: u64, byte: &u8| n << 8 | u64::from(*byte);
        if self.big_endian { bytes.iter().fold(0, next) } else { bytes.iter().rev().fold(0, next) }
    }

    /// Reads `len` bytes, which the file must have.
    pub fn bytes_at(&mut self, at: u64, len: u64) -> io::Result<Vec<u8>> {
        if at.checked_add(len).is_none_or(|end| end > self.len) {
            return Err(damaged(format!("{len} bytes at {at} are beyond its end at {}", self.len)));
        }
        let mut bytes = vec![0; len as usize];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Offsets of all directories.
    pub fn directories(&mut self) -> io::Result<Vec<u64>> {
        let (mut found, mut at, mut left) = (Vec::new(), self.first, self.len);
        while at != 0 {
            let directory = self.directory(at)?;
            // Directories that overlap are damaged, and may go on for ever.
            let used = 12 * directory.entries.len() as u64 + 2;
            left = left.checked_sub(used).ok_or_else(|| damaged("its pages overlap".into()))?;
            found.push(at);
            if found.len() > MOST {
                return Err(damaged(format!("it has more than {MOST} pages")));
            }
            at = directory.next;
        }
        if found.is_empty() { Err(damaged("it has no page".into())) } else { Ok(found) }
    }

    /// Reads a directory.
    pub fn directory(&mut self, at: u64) -> io::Result<Directory> {
        let (before, each, offset) = if self.large { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.bytes_at(at, before)?;
        let count = self.number(&count);
        let len = count.checked_mul(each).and_then(|len| len.checked_add(offset));
        let len = len.ok_or_else(|| damaged(format!("a page has {count} tags")))?;
        let bytes = self.bytes_at(at + before, len)?;
        let (tags, next) = bytes.split_at((len - offset) as usize);
        let mut entries = BTreeMap::new();
        for entry in tags.chunks_exact(each as usize) {
            let (head, value) = entry.split_at(entry.len() - offset as usize);
            let [tag, kind] = [&head[..2], &head[2..4]].map(|two| self.number(two) as u16);
            let mut field = [0; 8];
            field[..value.len()].copy_from_slice(value);
            // Of tags that occur twice, the first one counts.
            entries.entry(tag).or_insert(Entry { kind, count: self.number(&head[4..]), field });
        }
        Ok(Directory { entries, next: self.number(next) })
    }

    /// The bytes of the values of a tag; empty if it is missing.
    pub fn bytes(&mut self, directory: &Directory, tag: u16) -> io::Result<Vec<u8>> {
        let Some(&Entry { kind, count, field }) = directory.entries.get(&tag) else { return Ok(Vec::new()) };
        let len = count.checked_mul(size_of(kind)).filter(|&len| len <= self.len);
        let len = len.ok_or_else(|| damaged(format!("tag {tag} has {count} numbers, and it has {} bytes", self.len)))?;
        let inline = if self.large { 8 } else { 4 };
        if len <= inline {
            return Ok(field[..len as usize].to_vec());
        }
        let at = self.number(&field[..inline as usize]);
        self.bytes_at(at, len)
    }

    /// The unsigned integers of a tag; empty if it is missing or has other values.
    pub fn numbers(&mut self, directory: &Directory, tag: u16) -> io::Result<Vec<u64>> {
        let kind = directory.entries.get(&tag).map_or(0, |entry| entry.kind);
        if !matches!(kind, 1 | 3 | 4 | 13 | 16 | 18) {
            return Ok(Vec::new());
        }
        let bytes = self.bytes(directory, tag)?;
        Ok(bytes.chunks_exact(size_of(kind) as usize).map(|number| self.number(number)).collect())
    }

    /// The first of [`numbers`](Self::numbers).
    pub fn whole(&mut self, directory: &Directory, tag: u16) -> io::Result<Option<u64>> {
        Ok(self.numbers(directory, tag)?.first().copied())
    }

    /// The quotient that a tag has.
    pub fn quotient(&mut self, directory: &Directory, tag: u16) -> io::Result<Option<f64>> {
        let bytes = self.bytes(directory, tag)?;
        let is_quotient = directory.entries.get(&tag).is_some_and(|entry| entry.kind == 5) && bytes.len() == 8;
        Ok(is_quotient.then(|| self.number(&bytes[..4]) as f64 / self.number(&bytes[4..]) as f64))
    }

    /// The text of a tag; empty if it is missing.
    pub fn text(&mut self, directory: &Directory, tag: u16) -> io::Result<String> {
        let bytes = self.bytes(directory, tag)?;
        let text = bytes.split(|&byte| byte == 0).next().unwrap_or_default();
        // Old writers use Latin-1.
        let latin = || text.iter().map(|&byte| char::from(byte)).collect();
        Ok(std::str::from_utf8(text).map_or_else(|_| latin(), String::from))
    }
}

/// What is wrong with a file that cannot be read.
pub(super) fn failed(path: &Path, e: &io::Error) -> Error {
    match e.kind() {
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData => {
            Error::volume(path, format!("its pages cannot be read: {e}: it is truncated or damaged"))
        }
        kind => Error::read(path, io::Error::new(kind, e.to_string())),
    }
}
