//! How pieces of an array are packed. Nothing becomes more than its piece has.

use super::blosc;
use crate::memory;
use crate::volume::Endian;
use crate::volume::format::bytes;
use serde_json::Value;
use std::io::Read;

/// Bytes by which what is packed several times may be longer on the way than in the end: checksums and frames.
const ON_THE_WAY: usize = 1 << 10;

/// All that is done to a piece.
pub(super) struct Codec {
    /// Which axis of the array each axis of what is stored is.
    pub order: Vec<usize>,
    numbers: Numbers,
    /// What is done to the bytes then, in this order.
    packings: Vec<Packing>,
}

/// How numbers become bytes.
enum Numbers {
    Plain,
    /// Pieces of a piece, in one file.
    Shards {
        shape: Vec<usize>,
        inner: Box<Codec>,
        index: Box<Codec>,
        at_end: bool,
    },
}

enum Packing {
    Gzip,
    Zlib,
    Zstd,
    Blosc,
    /// A checksum of four bytes behind what it is of.
    Crc32c,
}

/// What is said of something that is packed in a way that is not read.
pub(super) fn packed_by(name: &str) -> String {
    format!("it is packed by {name}, which is not read: write it with gzip, zstd, or blosc with lz4 or zstd")
}

impl Codec {
    /// As version 2 tells it.
    pub fn of_version_2(array: &Value, axes: usize) -> Result<Self, String> {
        if let Some(filter) = array["filters"].as_array().and_then(|filters| filters.first()) {
            return Err(packed_by(&format!("the filter {}", filter["id"])));
        }
        let packings = match &array["compressor"] {
            Value::Null => Vec::new(),
            compressor => vec![Packing::new(compressor["id"].as_str().unwrap_or_default())?],
        };
        let mut order: Vec<usize> = (0..axes).collect();
        if array["order"] == "F" {
            order.reverse();
        }
        Ok(Self { order, numbers: Numbers::Plain, packings })
    }

    /// As version 3 tells it, with the byte order of numbers.
    pub fn of_version_3(codecs: &Value, axes: usize) -> Result<(Self, Endian), String> {
        let codecs = codecs.as_array().ok_or("it tells no codecs")?;
        let mut found = Self { order: (0..axes).collect(), numbers: Numbers::Plain, packings: Vec::new() };
        let mut endian = Endian::Little;
        for codec in codecs {
            let (name, settings) = (codec["name"].as_str().unwrap_or_default(), &codec["configuration"]);
            match name {
                "transpose" => found.order = transposed(&found.order, &settings["order"])?,
                "bytes" if settings["endian"] == "big" => endian = Endian::Big,
                "bytes" => {}
                "sharding_indexed" => {
                    let shape = super::array::sizes(&settings["chunk_shape"], "chunk_shape")?;
                    if shape.len() != axes {
                        return Err("its shards have another number of axes".into());
                    }
                    let (inner, of_inner) = Self::of_version_3(&settings["codecs"], axes)?;
                    let (index, of_index) = Self::of_version_3(&settings["index_codecs"], axes + 1)?;
                    if !matches!(index.numbers, Numbers::Plain) || of_index == Endian::Big {
                        return Err("the index of its shards is written in a way that is not read".into());
                    }
                    endian = of_inner;
                    let at_end = settings["index_location"] != "start";
                    found.numbers = Numbers::Shards { shape, inner: Box::new(inner), index: Box::new(index), at_end };
                }
                other => found.packings.push(Packing::new(other)?),
            }
        }
        Ok((found, endian))
    }

    /// Bytes that a packed piece of `len` may have at most: packing what cannot be packed makes it longer.
    pub fn longest(&self, len: usize) -> u64 {
        let index = match &self.numbers {
            Numbers::Plain => 0,
            // An index is at most as long as a number for every voxel would be.
            Numbers::Shards { .. } => 16 * len as u64,
        };
        len as u64 + len as u64 / 8 + index + (ON_THE_WAY << 6) as u64
    }

    /// Numbers of `size` bytes in the order that they are stored in: a piece of this shape, along the array's axes.
    pub fn unpack(&self, packed: Vec<u8>, shape: &[usize], size: usize, fill: &[u8]) -> Result<Vec<u8>, String> {
        let len = shape.iter().product::<usize>() * size;
        if let Numbers::Shards { .. } = self.numbers {
            let packed = self
                .packings
                .iter()
                .rev()
                .try_fold(packed, |packed, packing| packing.unpack(&packed, self.longest(len) as usize, false))?;
            return self.joined(&packed, shape, size, fill);
        }
        let mut bytes = packed;
        for (n, packing) in self.packings.iter().enumerate().rev() {
            let checksums = 4 * self.packings[..n].iter().filter(|packing| matches!(packing, Packing::Crc32c)).count();
            let last = self.packings[..n].iter().all(|packing| matches!(packing, Packing::Crc32c));
            bytes = packing.unpack(&bytes, if last { len + checksums } else { self.longest(len) as usize }, last)?;
        }
        if bytes.len() != len {
            return Err(format!("a piece has {} bytes, expected {len}", bytes.len()));
        }
        Ok(bytes)
    }

    /// A piece of pieces.
    fn joined(&self, packed: &[u8], shape: &[usize], size: usize, fill: &[u8]) -> Result<Vec<u8>, String> {
        let Numbers::Shards { shape: each, inner, index, at_end } = &self.numbers else { return Err("it has no shards".into()) };
        if self.order.iter().enumerate().any(|(i, &axis)| i != axis)
            || shape.iter().zip(each).any(|(whole, part)| whole % part != 0)
        {
            return Err("its shards are turned, or no whole number of pieces".into());
        }
        let counts: Vec<usize> = shape.iter().zip(each).map(|(whole, part)| whole / part).collect();
        let count: usize = counts.iter().product();
        let checksums = index.packings.iter().filter(|packing| matches!(packing, Packing::Crc32c)).count();
        if checksums != index.packings.len() {
            return Err("the index of its shards is packed".into());
        }
        let len = 16 * count + 4 * checksums;
        let start = if *at_end { packed.len().checked_sub(len).ok_or("a shard shorter than its index")? } else { 0 };
        let table = packed.get(start..start + len).ok_or("a shard shorter than its index")?;
        let table = index.unpack(table.to_vec(), &[count, 2], 8, &[0; 8])?;
        let mut all = memory::zeroed("a shard", shape.iter().product::<usize>() * size).map_err(|e| e.to_string())?;
        all.chunks_exact_mut(size).for_each(|number| number.copy_from_slice(fill));
        let to = super::strides(shape, size);
        for (n, entry) in table.chunks_exact(16).enumerate() {
            let [at, len] = [0, 8].map(|i| entry[i..].first_chunk().map_or(0, |word| u64::from_le_bytes(*word)));
            if at == u64::MAX && len == u64::MAX {
                continue;
            }
            let end = at.checked_add(len).filter(|&end| end <= packed.len() as u64).ok_or("a piece outside of its shard")?;
            let piece = inner.unpack(packed[at as usize..end as usize].to_vec(), each, size, fill)?;
            let place = super::place(n, &counts);
            let first: usize = place.iter().zip(each).zip(&to).map(|((place, part), stride)| place * part * stride).sum();
            super::copy(&piece, &inner.strides(each, size), &mut all[first..], &to, each, size);
        }
        Ok(all)
    }

    /// Bytes from a number of an unpacked piece to the next ones along the array's axes.
    pub fn strides(&self, shape: &[usize], size: usize) -> Vec<usize> {
        let stored: Vec<usize> = self.order.iter().map(|&axis| shape[axis]).collect();
        let mut strides = vec![0; shape.len()];
        for (&axis, stride) in self.order.iter().zip(super::strides(&stored, size)) {
            strides[axis] = stride;
        }
        strides
    }
}

/// Axes in the order that a list of numbers says.
fn transposed(order: &[usize], wanted: &Value) -> Result<Vec<usize>, String> {
    let wrong = || format!("its axes are transposed as {wanted}");
    let wanted: Vec<usize> = wanted.as_array().ok_or_else(wrong)?.iter().filter_map(|n| n.as_u64()).map(|n| n as usize).collect();
    let mut sorted = wanted.clone();
    sorted.sort_unstable();
    if sorted.into_iter().ne(0..order.len()) {
        return Err(wrong());
    }
    Ok(wanted.into_iter().map(|axis| order[axis]).collect())
}

impl Packing {
    fn new(name: &str) -> Result<Self, String> {
        Ok(match name {
            "gzip" => Self::Gzip,
            "zlib" | "numcodecs.zlib" => Self::Zlib,
            "zstd" | "numcodecs.zstd" => Self::Zstd,
            "blosc" | "numcodecs.blosc" => Self::Blosc,
            "crc32c" => Self::Crc32c,
            other => return Err(packed_by(other)),
        })
    }

    /// At most `most` bytes; so many that there are exactly, where that is known.
    fn unpack(&self, packed: &[u8], most: usize, exactly: bool) -> Result<Vec<u8>, String> {
        match self {
            Self::Gzip => unpacked(flate2::read::MultiGzDecoder::new(packed), most),
            Self::Zlib => zlib(packed, most),
            Self::Zstd => zstd(packed, most),
            Self::Blosc if exactly => blosc::unpack(packed, most),
            Self::Blosc => Err(packed_by("blosc before something else")),
            Self::Crc32c => {
                let (bytes, sum) = packed.split_last_chunk::<4>().ok_or("a piece without its checksum")?;
                if crc32c(bytes) != u32::from_le_bytes(*sum) {
                    return Err("a checksum that is wrong".into());
                }
                Ok(bytes.to_vec())
            }
        }
    }
}

pub(super) fn zlib(packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
    unpacked(flate2::read::ZlibDecoder::new(packed), most)
}

pub(super) fn zstd(packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| e.to_string())?;
    unpacked(decoder, most)
}

/// All that there is, if that is not more than `most`.
fn unpacked(mut from: impl Read, most: usize) -> Result<Vec<u8>, String> {
    let mut all = memory::zeroed("a piece", most).map_err(|e| e.to_string())?;
    let found = bytes::fill(&mut from, &mut all).map_err(|e| e.to_string())?;
    if found == most && bytes::fill(&mut from, &mut [0]).map_err(|e| e.to_string())? > 0 {
        return Err(format!("a piece that holds more than its {most} bytes"));
    }
    all.truncate(found);
    Ok(all)
}

/// Castagnoli's checksum.
fn crc32c(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0x82f6_3b78;
    let step = |sum: u32| if sum & 1 == 1 { sum >> 1 ^ POLYNOMIAL } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), |sum, _| step(sum)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_that_others_tell() {
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
    }

    #[test]
    fn a_piece_is_no_longer_than_it_should_be() {
        let mut packed = Vec::new();
        let mut encoder = flate2::read::ZlibEncoder::new(&[7; 100][..], flate2::Compression::fast());
        encoder.read_to_end(&mut packed).unwrap();
        assert_eq!(zlib(&packed, 100).unwrap(), [7; 100]);
        assert!(zlib(&packed, 99).unwrap_err().contains("more than its 99"));
    }
}
