//! Chunk codecs. Decompression never produces more bytes than the chunk declares.

use super::blosc;
use crate::memory;
use crate::volume::Endian;
use crate::volume::format::bytes;
use crate::volume::format::strided;
use serde_json::Value;
use std::io::Read;

/// Extra bytes that intermediate results of several codecs may have, for checksums and headers.
const ON_THE_WAY: usize = 1 << 10;

/// All codecs of a chunk.
pub(super) struct Codec {
    /// Array axis of each stored axis.
    pub order: Vec<usize>,
    numbers: Numbers,
    /// Codecs applied to the bytes, in order of compression.
    packings: Vec<Packing>,
}

/// Conversion of numbers to bytes.
enum Numbers {
    Plain,
    /// Several inner chunks in one file.
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
    /// A four-byte checksum after the data.
    Crc32c,
}

/// Parses an array of positive sizes.
pub(super) fn sizes(metadata: &Value, name: &str) -> Result<Vec<usize>, String> {
    let size = |n: &Value| n.as_u64().and_then(|n| usize::try_from(n).ok()).filter(|&n| n > 0);
    let found: Option<Vec<usize>> = metadata.as_array().and_then(|sizes| sizes.iter().map(size).collect());
    found.ok_or_else(|| format!("its {name} is {metadata}: expected numbers above 0"))
}

/// Error message for an unsupported codec.
pub(super) fn packed_by(name: &str) -> String {
    format!("it is compressed with {name}, which is not supported: use gzip, zstd, or blosc with lz4 or zstd")
}

impl Codec {
    /// Codecs of Zarr version 2.
    pub fn from_version_2(array: &Value, axes: usize) -> Result<Self, String> {
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

    /// Codecs of Zarr version 3, and the byte order of numbers.
    pub fn from_version_3(codecs: &Value, axes: usize) -> Result<(Self, Endian), String> {
        let codecs = codecs.as_array().ok_or("it has no codecs")?;
        let mut found = Self { order: (0..axes).collect(), numbers: Numbers::Plain, packings: Vec::new() };
        let mut endian = Endian::Little;
        for codec in codecs {
            let (name, settings) = (codec["name"].as_str().unwrap_or_default(), &codec["configuration"]);
            match name {
                "transpose" => found.order = transposed(&found.order, &settings["order"])?,
                "bytes" if settings["endian"] == "big" => endian = Endian::Big,
                "bytes" => {}
                "sharding_indexed" => {
                    let shape = sizes(&settings["chunk_shape"], "chunk_shape")?;
                    if shape.len() != axes {
                        return Err("its shards have a different number of axes".into());
                    }
                    let (inner, inner_endian) = Self::from_version_3(&settings["codecs"], axes)?;
                    let (index, index_endian) = Self::from_version_3(&settings["index_codecs"], axes + 1)?;
                    if !matches!(index.numbers, Numbers::Plain) || index_endian == Endian::Big {
                        return Err("the index codecs of its shards are not supported".into());
                    }
                    endian = inner_endian;
                    let at_end = settings["index_location"] != "start";
                    found.numbers = Numbers::Shards { shape, inner: Box::new(inner), index: Box::new(index), at_end };
                }
                other => found.packings.push(Packing::new(other)?),
            }
        }
        Ok((found, endian))
    }

    /// Upper bound of the compressed size of a chunk of `len` bytes: incompressible data grow.
    pub fn longest(&self, len: usize) -> u64 {
        let index = match &self.numbers {
            Numbers::Plain => 0,
            // The index is at most as long as one entry per voxel.
            Numbers::Shards { .. } => 16 * len as u64,
        };
        len as u64 + len as u64 / 8 + index + (ON_THE_WAY << 6) as u64
    }

    /// Decodes a chunk of `shape` to numbers of `size` bytes in stored order.
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
            return Err(format!("a chunk has {} bytes, expected {len}", bytes.len()));
        }
        Ok(bytes)
    }

    /// Decodes a shard from its inner chunks.
    fn joined(&self, packed: &[u8], shape: &[usize], size: usize, fill: &[u8]) -> Result<Vec<u8>, String> {
        let Numbers::Shards { shape: each, inner, index, at_end } = &self.numbers else { return Err("it has no shards".into()) };
        if self.order.iter().enumerate().any(|(i, &axis)| i != axis)
            || shape.iter().zip(each).any(|(whole, part)| whole % part != 0)
        {
            return Err("its shards are transposed, or not a multiple of the inner chunks".into());
        }
        let counts: Vec<usize> = shape.iter().zip(each).map(|(whole, part)| whole / part).collect();
        let count: usize = counts.iter().product();
        let checksums = index.packings.iter().filter(|packing| matches!(packing, Packing::Crc32c)).count();
        if checksums != index.packings.len() {
            return Err("the index of its shards is compressed, which is not supported".into());
        }
        let len = 16 * count + 4 * checksums;
        let start = if *at_end { packed.len().checked_sub(len).ok_or("a shard shorter than its index")? } else { 0 };
        let table = packed.get(start..start + len).ok_or("a shard shorter than its index")?;
        let table = index.unpack(table.to_vec(), &[count, 2], 8, &[0; 8])?;
        let mut all = memory::zeroed("a shard", shape.iter().product::<usize>() * size).map_err(|e| e.to_string())?;
        all.chunks_exact_mut(size).for_each(|number| number.copy_from_slice(fill));
        let to = strided::strides(shape, size);
        for (n, entry) in table.chunks_exact(16).enumerate() {
            let [at, len] = [0, 8].map(|i| entry[i..].first_chunk().map_or(0, |word| u64::from_le_bytes(*word)));
            if at == u64::MAX && len == u64::MAX {
                continue;
            }
            let end = at.checked_add(len).filter(|&end| end <= packed.len() as u64).ok_or("an inner chunk outside its shard")?;
            let piece = inner.unpack(packed[at as usize..end as usize].to_vec(), each, size, fill)?;
            let place = strided::place(n, &counts);
            let first: usize = place.iter().zip(each).zip(&to).map(|((place, part), stride)| place * part * stride).sum();
            strided::copy(&piece, &inner.strides(each, size), &mut all[first..], &to, each, size);
        }
        Ok(all)
    }

    /// Strides in bytes of a decoded chunk, along the axes of the array.
    pub fn strides(&self, shape: &[usize], size: usize) -> Vec<usize> {
        let stored: Vec<usize> = self.order.iter().map(|&axis| shape[axis]).collect();
        let mut strides = vec![0; shape.len()];
        for (&axis, stride) in self.order.iter().zip(strided::strides(&stored, size)) {
            strides[axis] = stride;
        }
        strides
    }
}

/// Permutes axes by a JSON list.
fn transposed(order: &[usize], wanted: &Value) -> Result<Vec<usize>, String> {
    let wrong = || format!("its transpose order {wanted} is not a permutation of its axes");
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

    /// Decompresses at most `most` bytes; exactly `most` if `exactly`.
    fn unpack(&self, packed: &[u8], most: usize, exactly: bool) -> Result<Vec<u8>, String> {
        match self {
            Self::Gzip => unpacked(flate2::read::MultiGzDecoder::new(packed), most),
            Self::Zlib => zlib(packed, most),
            Self::Zstd => zstd(packed, most),
            Self::Blosc if exactly => blosc::unpack(packed, most),
            Self::Blosc => Err(packed_by("blosc followed by another codec")),
            Self::Crc32c => {
                let (bytes, sum) = packed.split_last_chunk::<4>().ok_or("a chunk without its checksum")?;
                if crc32c(bytes) != u32::from_le_bytes(*sum) {
                    return Err("a wrong checksum".into());
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

/// Reads everything, or fails if there are more than `most` bytes.
fn unpacked(mut from: impl Read, most: usize) -> Result<Vec<u8>, String> {
    let mut all = memory::zeroed("a chunk", most).map_err(|e| e.to_string())?;
    let found = bytes::fill(&mut from, &mut all).map_err(|e| e.to_string())?;
    if found == most && bytes::fill(&mut from, &mut [0]).map_err(|e| e.to_string())? > 0 {
        return Err(format!("a chunk with more than {most} bytes"));
    }
    all.truncate(found);
    Ok(all)
}

/// CRC-32C checksum (Castagnoli).
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
        assert!(zlib(&packed, 99).unwrap_err().contains("more than 99"));
    }
}
