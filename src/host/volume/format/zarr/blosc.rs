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
    let shuffled = flags & SHUFFLED != 0 && size > 1;
    let bits_shuffled = !shuffled && flags & BITS_SHUFFLED != 0;
    let mut block_of_streams = vec![0; if shuffled || bits_shuffled { block.min(len) } else { 0 }];
    for (n, to) in all.chunks_mut(block).enumerate() {
        let start = offset(packed, HEADER + 4 * n)?;
        let from = packed.get(start..).ok_or("a block outside the chunk")?;
        let is_split = flags & WHOLE_BLOCKS == 0 && size <= MOST_STREAMS && block / size >= LEAST_NUMBERS && to.len() == block;
        let count = if is_split { size } else { 1 };
        if !shuffled && !bits_shuffled {
            streams(from, to, count, flags >> 5)?;
            continue;
        }
        let unpacked = &mut block_of_streams[..to.len()];
        streams(from, unpacked, count, flags >> 5)?;
        if shuffled {
            unshuffle(size, unpacked, to);
        } else {
            unshuffle_bits(size, unpacked, to);
        }
    }
    Ok(all)
}

fn offset(bytes: &[u8], at: usize) -> Result<usize, String> {
    let word = bytes.get(at..at + 4).ok_or("a truncated chunk")?;
    Ok(u32::from_le_bytes([word[0], word[1], word[2], word[3]]) as usize)
}

/// Decompresses a block of `count` streams, each after its length.
fn streams(mut from: &[u8], to: &mut [u8], count: usize, packing: u8) -> Result<(), String> {
    let each = to.len() / count;
    // Bytes after the last whole number, which no stream has, are 0.
    let (parts, rest) = to.split_at_mut(each * count);
    rest.fill(0);
    for to in parts.chunks_exact_mut(each) {
        let packed = offset(from, 0)?;
        let stream = from.get(4..4 + packed).ok_or("a truncated stream")?;
        let found = match packing {
            _ if packed == each => {
                to.copy_from_slice(stream);
                each
            }
            0 => blosclz(stream, to)?,
            1 => lz4_flex::block::decompress_into(stream, to).map_err(|e| e.to_string())?,
            2 => return Err(packed_by("snappy in blosc")),
            3 => {
                let unpacked = zlib(stream, each)?;
                to[..unpacked.len()].copy_from_slice(&unpacked);
                unpacked.len()
            }
            4 => zstd(stream, to)?,
            other => return Err(packed_by(&format!("number {other} in blosc"))),
        };
        if found != each {
            return Err(format!("a stream of {found} bytes, expected {each}"));
        }
        from = &from[4 + packed..];
    }
    Ok(())
}

/// Decompresses a stream of BloscLZ, and returns the number of bytes: literals, and copies of earlier bytes, as in FastLZ.
fn blosclz(from: &[u8], to: &mut [u8]) -> Result<usize, String> {
    const TRUNCATED: &str = "a truncated stream";
    const FARTHEST_NEAR: usize = 8191;
    let mut bytes = from.iter().map(|&byte| usize::from(byte));
    let mut next = move || bytes.next().ok_or(TRUNCATED);
    let (mut read, mut at) = (1, 0usize);
    let mut control = next()? & 31;
    loop {
        if control >= 32 {
            let mut len = (control >> 5) - 1;
            let mut far = (control & 31) << 8;
            if len == 6 {
                loop {
                    let more = next()?;
                    read += 1;
                    len += more;
                    if more < 255 {
                        break;
                    }
                }
            }
            far += next()?;
            read += 1;
            if far == FARTHEST_NEAR {
                far += (next()? << 8) + next()?;
                read += 2;
            }
            let (len, start) = (len + 3, at.checked_sub(far + 1).ok_or("a stream that copies bytes before its first")?);
            if at + len > to.len() {
                return Err(format!("a stream with more than {} bytes", to.len()));
            }
            // Copies may overlap what they copy.
            for n in 0..len {
                to[at + n] = to[start + n];
            }
            at += len;
        } else {
            let len = control + 1;
            let literals = to.get_mut(at..at + len).ok_or("a stream with too many bytes")?;
            for literal in literals {
                *literal = next()? as u8;
            }
            (read, at) = (read + len, at + len);
        }
        if read >= from.len() {
            return Ok(at);
        }
        control = next()?;
        read += 1;
    }
}

/// Reverses the byte shuffle. Bytes after the last whole number are not shuffled.
pub(super) fn unshuffle(size: usize, from: &[u8], to: &mut [u8]) {
    let count = from.len() / size;
    let (planes, rest) = from.split_at(count * size);
    let (numbers, last) = to.split_at_mut(count * size);
    last.copy_from_slice(rest);
    let plane = |byte: usize| &planes[byte * count..][..count];
    // Loops over few planes of the same length become vector instructions.
    match size {
        2 => numbers.chunks_exact_mut(2).zip(plane(0)).zip(plane(1)).for_each(|((to, a), b)| to.copy_from_slice(&[*a, *b])),
        4 => {
            let planes = plane(0).iter().zip(plane(1)).zip(plane(2)).zip(plane(3));
            numbers.chunks_exact_mut(4).zip(planes).for_each(|(to, (((a, b), c), d))| to.copy_from_slice(&[*a, *b, *c, *d]));
        }
        _ => {
            for (n, number) in numbers.chunks_exact_mut(size).enumerate() {
                number.iter_mut().enumerate().for_each(|(byte, to)| *to = planes[byte * count + n]);
            }
        }
    }
}

/// Reverses the bit shuffle.
fn unshuffle_bits(size: usize, from: &[u8], to: &mut [u8]) {
    let count = from.len() / size;
    to.copy_from_slice(from);
    if count.is_multiple_of(8) {
        let row = count / 8;
        for (n, number) in to.chunks_exact_mut(size).enumerate() {
            for (byte, to) in number.iter_mut().enumerate() {
                *to = (0..8).map(|bit| (from[(8 * byte + bit) * row + n / 8] >> (n % 8) & 1) << bit).sum();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Literals, a long overlapping copy, and a copy from farther back than two bytes say.
    #[test]
    fn blosclz_copies_from_near_and_far() {
        // Z and A, 8718 more of A, B and C, and four bytes from 8722 before.
        let run = [&[7 << 5][..], &[255; 34], &[39, 0]].concat();
        let far = [&[2 << 5 | 31, 255][..], &(8722u16 - 8192).to_be_bytes()].concat();
        let stream = [b"\x01ZA", &run[..], b"\x01BC", &far].concat();
        let expected = [b"Z", &[b'A'; 8719][..], b"BC", b"ZAAA"].concat();
        let mut found = vec![0; expected.len()];
        assert_eq!(blosclz(&stream, &mut found), Ok(found.len()));
        assert_eq!(found, expected);
        for end in 0..stream.len() {
            let _ = blosclz(&stream[..end], &mut found);
        }
        assert!(blosclz(&stream, &mut found[..100]).unwrap_err().contains("more than 100"));
        assert!(blosclz(&[0, 1, 1 << 5, 9], &mut found).unwrap_err().contains("before its first"));
    }
}
