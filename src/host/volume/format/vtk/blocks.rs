//! Block-compressed arrays: a table followed by the blocks.

use crate::error::Error;
use crate::memory;
use crate::volume::Endian;
use crate::volume::format::bytes::{self, Bytes};
use flate2::read::ZlibDecoder;
use std::io;
use std::path::Path;

/// Compression of blocks.
#[derive(Clone, Copy)]
pub(super) enum Method {
    Zlib,
    Lz4,
}

impl Method {
    /// Largest compression ratio.
    fn limit(self) -> u64 {
        match self {
            Method::Zlib => 1032,
            Method::Lz4 => 255,
        }
    }
}

/// Reads an unsigned integer of up to eight bytes; 0 for none.
pub(super) fn number(bytes: &[u8], endian: Endian) -> u64 {
    let add = |n: u64, byte: &u8| n << 8 | u64::from(*byte);
    match endian {
        Endian::Big => bytes.iter().fold(0, add),
        Endian::Little => bytes.iter().rev().fold(0, add),
    }
}

/// Compressed blocks and their offsets.
struct Blocks {
    packed: Box<dyn Bytes>,
    ends: Vec<u64>,
    /// Byte of the first block, after the table.
    first: u64,
    /// Uncompressed bytes per block, and in total.
    each: u64,
    all: u64,
    method: Method,
    /// The most recently decompressed block.
    current: Option<(usize, Vec<u8>)>,
}

/// Reads the table: number of blocks, uncompressed size, uncompressed size of a shorter last block, compressed size of each.
pub(super) fn unpacked(
    path: &Path,
    mut packed: Box<dyn Bytes>,
    count: usize,
    endian: Endian,
    method: Method,
) -> Result<Box<dyn Bytes>, Error> {
    let damaged = |what: &str| Error::volume(path, format!("its block table is damaged: {what}"));
    let mut read = |at: u64, bytes: &mut [u8]| match packed.read(at, bytes) {
        Ok(found) if found == bytes.len() => Ok(()),
        Ok(_) => Err(damaged("it is truncated")),
        Err(e) => Err(Error::read(path, e)),
    };
    let mut start = [0; 24];
    read(0, &mut start[..3 * count])?;
    let [blocks, each, last] = [0, 1, 2].map(|i| number(&start[i * count..(i + 1) * count], endian));
    let table = blocks.saturating_mul(count as u64);
    let first = table.saturating_add(3 * count as u64);
    if first > packed.most() || last > each {
        return Err(damaged("it declares more blocks than fit into the file"));
    }
    let mut sizes = memory::zeroed::<u8>(&path.display().to_string(), table as usize)?;
    let found = packed.read(3 * count as u64, &mut sizes).map_err(|e| Error::read(path, e))?;
    if found < sizes.len() {
        return Err(damaged("it is truncated"));
    }
    let mut end = first;
    let mut ends = Vec::new();
    for size in sizes.chunks_exact(count).map(|size| number(size, endian)) {
        end = end.saturating_add(size);
        ends.push(end);
        if end > packed.most() || each > size.saturating_mul(method.limit()).saturating_add(64) && ends.len() < blocks as usize {
            return Err(damaged("block sizes exceed the file or the largest compression ratio"));
        }
    }
    let missing = if last > 0 { each - last } else { 0 };
    let all = each.saturating_mul(blocks).saturating_sub(missing);
    if all > packed.most().saturating_mul(method.limit()) {
        return Err(damaged("it declares more bytes than its blocks can hold"));
    }
    Ok(Box::new(Blocks { packed, ends, first, each, all, method, current: None }))
}

impl Blocks {
    /// Uncompressed bytes of a block.
    fn len(&self, block: usize) -> u64 {
        (self.all - self.each * block as u64).min(self.each)
    }

    fn unpack(&mut self, block: usize) -> io::Result<&[u8]> {
        if self.current.as_ref().is_none_or(|(current, _)| *current != block) {
            let start = if block == 0 { self.first } else { self.ends[block - 1] };
            let mut packed = vec![0; (self.ends[block] - start) as usize];
            let found = self.packed.read(start, &mut packed)?;
            packed.truncate(found);
            let mut bytes = vec![0; self.len(block) as usize];
            let found = match self.method {
                Method::Zlib => bytes::fill(&mut ZlibDecoder::new(&packed[..]), &mut bytes)?,
                Method::Lz4 => lz4_flex::block::decompress_into(&packed, &mut bytes)
                    .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.to_string()))?,
            };
            if found < bytes.len() {
                return Err(io::Error::new(io::ErrorKind::InvalidData, format!("block {block} is too short")));
            }
            self.current = Some((block, bytes));
        }
        Ok(self.current.as_ref().map_or(&[], |(_, bytes)| bytes))
    }
}

impl Bytes for Blocks {
    fn most(&self) -> u64 {
        self.all
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        let mut found = 0;
        while found < bytes.len() {
            let at = at + found as u64;
            if at >= self.all {
                break;
            }
            let (block, within) = ((at / self.each) as usize, (at % self.each) as usize);
            let unpacked = &self.unpack(block)?[within..];
            let more = unpacked.len().min(bytes.len() - found);
            bytes[found..found + more].copy_from_slice(&unpacked[..more]);
            found += more;
        }
        Ok(found)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.all == end)
    }
}
