//! Blosc containers, version 1. Each block holds the first bytes of all numbers, then the second bytes, and so on.

use super::codec::{packed_by, zlib, zstd};
use crate::memory;

/// Size of the header in bytes.
const HEADER: usize = 16;
/// Blocks are split into one stream per byte of a number, up to this many bytes and from this many numbers per block on.
const MOST_STREAMS: usize = 16;
const LEAST_NUMBERS: usize = 128;

/// Flags.
const SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const WHOLE_BLOCKS: u8 = 16;

/// Decompresses exactly `len` bytes.
pub(super) fn unpack(packed: &[u8], len: usize) -> Result<Vec<u8>, String> {
    let header = packed.get(..HEADER).ok_or("a chunk too short for a blosc header")?;
    let word = |at: usize| offset(header, at);
    let (flags, size, declared_len, block) = (header[2], usize::from(header[3]).max(1), word(4)?, word(8)?);
    if declared_len != len {
        return Err(format!("the blosc header declares {declared_len} bytes, expected {len}"));
    }
    if flags & STORED != 0 {
        let stored = packed.get(HEADER..HEADER + len).ok_or("a truncated chunk")?;
        return Ok(stored.to_vec());
    }
    if block == 0 {
        return if len == 0 { Ok(Vec::new()) } else { Err("blocks of 0 bytes".into()) };
    }
    let mut all = memory::zeroed("a chunk", len).map_err(|e| e.to_string())?;
    for (n, to) in all.chunks_mut(block).enumerate() {
        let start = offset(packed, HEADER + 4 * n)?;
        let from = packed.get(start..).ok_or("a block outside the chunk")?;
        let is_split = flags & WHOLE_BLOCKS == 0 && size <= MOST_STREAMS && block / size >= LEAST_NUMBERS && to.len() == block;
        let shuffled = streams(from, to.len(), if is_split { size } else { 1 }, flags >> 5)?;
        unshuffle(flags, size, &shuffled, to);
    }
    Ok(all)
}

fn offset(bytes: &[u8], at: usize) -> Result<usize, String> {
    let word = bytes.get(at..at + 4).ok_or("a truncated chunk")?;
    Ok(u32::from_le_bytes([word[0], word[1], word[2], word[3]]) as usize)
}

/// Decompresses a block of `count` streams, each after its length.
fn streams(mut from: &[u8], len: usize, count: usize, packing: u8) -> Result<Vec<u8>, String> {
    let each = len / count;
    let mut all = Vec::with_capacity(len);
    for _ in 0..count {
        let packed = offset(from, 0)?;
        let stream = from.get(4..4 + packed).ok_or("a truncated stream")?;
        let unpacked = match packing {
            _ if packed == each => stream.to_vec(),
            0 => return Err(packed_by("blosclz in blosc")),
            1 => {
                let mut unpacked = vec![0; each];
                let found = lz4_flex::block::decompress_into(stream, &mut unpacked).map_err(|e| e.to_string())?;
                unpacked.truncate(found);
                unpacked
            }
            2 => return Err(packed_by("snappy in blosc")),
            3 => zlib(stream, each)?,
            4 => zstd(stream, each)?,
            other => return Err(packed_by(&format!("number {other} in blosc"))),
        };
        if unpacked.len() != each {
            return Err(format!("a stream of {} bytes, expected {each}", unpacked.len()));
        }
        all.extend(unpacked);
        from = &from[4 + packed..];
    }
    all.resize(len, 0);
    Ok(all)
}

/// Reverses the byte or bit shuffle. Bytes after the last whole number are not shuffled.
fn unshuffle(flags: u8, size: usize, from: &[u8], to: &mut [u8]) {
    let count = from.len() / size;
    to.copy_from_slice(from);
    if flags & SHUFFLED != 0 && size > 1 {
        for (n, number) in to.chunks_exact_mut(size).enumerate() {
            number.iter_mut().enumerate().for_each(|(byte, to)| *to = from[byte * count + n]);
        }
    } else if flags & BITS_SHUFFLED != 0 && count.is_multiple_of(8) {
        let row = count / 8;
        for (n, number) in to.chunks_exact_mut(size).enumerate() {
            for (byte, to) in number.iter_mut().enumerate() {
                *to = (0..8).map(|bit| (from[(8 * byte + bit) * row + n / 8] >> (n % 8) & 1) << bit).sum();
            }
        }
    }
}
