//! Decoding of strips and tiles.

use super::directory::{Directory, Reader};
use super::page::{Packing, Page, Predictor};
use crate::memory;
use crate::volume::format::bits::spread;
use crate::volume::format::bytes::fill;
use crate::volume::format::runs::unpack;
use flate2::bufread::ZlibDecoder;
use std::io;
use weezl::decode::Configuration;
use weezl::{BitOrder, LzwStatus};

/// Upper bound of the compression ratio of deflate and LZW.
pub(super) const LIMIT: u64 = 2048;

/// One sample of all pixels of a page, little-endian.
pub(super) fn sample(reader: &mut Reader, directory: &Directory, page: &Page, sample: usize) -> io::Result<Vec<u8>> {
    let [offsets, counts] = if page.tiled { [324, 325] } else { [273, 279] }.map(|tag| reader.numbers(directory, tag));
    let (offsets, counts) = (offsets?, counts?);
    let [chunk_width, chunk_height] = page.chunk;
    let (across, down) = (page.width.div_ceil(chunk_width), page.height.div_ceil(chunk_height));
    let planes = if page.planar { page.samples } else { 1 };
    let (inside, size) = (page.samples_inside(), page.scalar.bytes());
    let expected = across.saturating_mul(down).saturating_mul(planes);
    if offsets.len() != expected || !(counts.len() == expected || counts.is_empty() && page.packing == Packing::None) {
        let (found, what) = (offsets.len(), if page.tiled { "tiles" } else { "strips" });
        return Err(damaged(format!("a page has {found} {what}, and its size requires {expected}")));
    }
    let mut numbers = memory::zeroed("a page", page.bytes() as usize).map_err(|e| io::Error::other(e.to_string()))?;
    let skipped = if page.planar { sample * across * down } else { 0 };
    for chunk in 0..across * down {
        let [left, top] = [chunk % across * chunk_width, chunk / across * chunk_height];
        let rows = chunk_height.min(page.height - top);
        let at = chunk + skipped;
        let packed_row = chunk_width.saturating_mul(inside).saturating_mul(page.bits).div_ceil(8);
        let whole = packed_row.saturating_mul(rows);
        let len = counts.get(at).copied().unwrap_or(whole as u64);
        // Sparse files leave out chunks of zeros.
        if len == 0 {
            continue;
        }
        if whole as u64 > len.saturating_mul(LIMIT) {
            return Err(damaged(format!("{len} bytes cannot hold {chunk_width}x{rows} pixels")));
        }
        let mut packed = reader.bytes_at(offsets[at], len)?;
        if page.lowest_first {
            packed.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
        }
        let mut stored = memory::zeroed("a tile", whole).map_err(|e| io::Error::other(e.to_string()))?;
        unpacked(page.packing, &packed, &mut stored)?;
        for (y, row) in stored.chunks_exact_mut(packed_row).enumerate() {
            let row = decoded(row, page, reader.big_endian);
            let first = if page.planar { 0 } else { sample };
            let width = chunk_width.min(page.width - left);
            let to = ((top + y) * page.width + left) * size;
            let to = numbers[to..to + width * size].chunks_exact_mut(size);
            let from = row.chunks_exact(size).skip(first).step_by(inside);
            to.zip(from).for_each(|(to, from)| to.copy_from_slice(from));
        }
    }
    Ok(numbers)
}

fn damaged(problem: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

/// Decompresses a chunk, of which `to` may be less than all.
fn unpacked(packing: Packing, mut packed: &[u8], to: &mut [u8]) -> io::Result<()> {
    let found = match packing {
        Packing::None => {
            let len = packed.len().min(to.len());
            to[..len].copy_from_slice(&packed[..len]);
            len
        }
        Packing::Deflate => fill(&mut ZlibDecoder::new(packed), to)?,
        Packing::PackBits => {
            let mut found = 0;
            unpack(packed, |value| {
                let place = to.get_mut(found);
                found += usize::from(place.is_some());
                place.map(|place| *place = value).is_some()
            });
            found
        }
        Packing::Lzw => {
            // Many writers leave out the code that ends the data.
            let configuration = Configuration::with_tiff_size_switch(BitOrder::Msb, 8).with_yield_on_full_buffer(true);
            let (mut decoder, mut found) = (configuration.build(), 0);
            loop {
                let step = decoder.decode_bytes(packed, &mut to[found..]);
                packed = &packed[step.consumed_in..];
                found += step.consumed_out;
                match step.status {
                    Ok(LzwStatus::Ok) if found < to.len() => {}
                    Ok(_) => break found,
                    Err(e) => return Err(damaged(format!("LZW: {e}"))),
                }
            }
        }
    };
    if found == to.len() { Ok(()) } else { Err(damaged(format!("a strip or tile has {found} bytes instead of {}", to.len()))) }
}

/// The numbers of a stored row, little-endian.
fn decoded(row: &mut [u8], page: &Page, big_endian: bool) -> Vec<u8> {
    let (size, samples) = (page.scalar.bytes(), page.samples_inside());
    if !page.bits.is_multiple_of(8) {
        return spread(row, page.bits, size);
    }
    if page.predictor == Predictor::Float {
        return of_planes(row, size, samples);
    }
    if big_endian {
        row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    if page.predictor == Predictor::Horizontal {
        match size {
            1 => sum_up::<1>(row, samples),
            2 => sum_up::<2>(row, samples),
            4 => sum_up::<4>(row, samples),
            _ => sum_up::<8>(row, samples),
        }
    }
    row.to_vec()
}

/// Adds to each number of `N` bytes the one `samples` numbers before it.
fn sum_up<const N: usize>(row: &mut [u8], samples: usize) {
    let step = N * samples;
    let number = |bytes: &[u8]| {
        let mut eight = [0; 8];
        eight[..N].copy_from_slice(bytes);
        u64::from_le_bytes(eight)
    };
    for at in (step..row.len() + 1 - N.min(row.len())).step_by(N) {
        let sum = number(&row[at..at + N]).wrapping_add(number(&row[at - step..at - step + N]));
        row[at..at + N].copy_from_slice(&sum.to_le_bytes()[..N]);
    }
}

/// Floats of which the differences of all first bytes are stored, then those of all second bytes, and so on, the highest one first.
fn of_planes(row: &mut [u8], size: usize, samples: usize) -> Vec<u8> {
    for at in samples..row.len() {
        row[at] = row[at].wrapping_add(row[at - samples]);
    }
    let count = row.len() / size;
    (0..count * size).map(|at| row[(size - 1 - at % size) * count + at / size]).collect()
}
