//! Chunk codecs. Decompression never produces more bytes than the chunk declares.

use super::blosc;
use super::crc32c::crc32c;
use super::shards::Shards;
use crate::memory;
use crate::volume::Endian;
use crate::volume::format::bytes;
use crate::volume::format::strided;
use serde_json::Value;
use std::borrow::Cow;
use std::io::Read;

/// Extra bytes that intermediate results of several codecs may have, for checksums and headers.
const ON_THE_WAY: usize = 1 << 10;

/// All codecs of a chunk.
pub(super) struct Codec {
    /// Array axis of each stored axis.
    pub order: Vec<usize>,
    /// Codecs applied to the bytes, in order of compression.
    packings: Vec<Packing>,
}

enum Packing {
    Gzip,
    Zlib,
    Zstd,
    Blosc,
    /// A block after its length, as numcodecs writes it.
    Lz4,
    /// The first bytes of all numbers of this size, then the second bytes, and so on.
    Shuffle(usize),
    /// Differences of whole numbers of this size.
    Delta(usize),
    /// A four-byte checksum after the data.
    Crc32c,
}

/// Error message for an unsupported codec.
pub(super) fn packed_by(name: &str) -> String {
    format!("it is compressed with {name}, which is not supported: use gzip, zstd, or blosc with lz4 or zstd")
}

impl Codec {
    /// Codecs of Zarr version 2.
    pub fn from_version_2(array: &Value, axes: usize) -> Result<Self, String> {
        let mut packings = Vec::new();
        for filter in array["filters"].as_array().into_iter().flatten() {
            packings.extend(Packing::new(filter["id"].as_str().unwrap_or_default(), filter)?);
        }
        match &array["compressor"] {
            Value::Null => {}
            compressor => packings.extend(Packing::new(compressor["id"].as_str().unwrap_or_default(), compressor)?),
        }
        let mut order: Vec<usize> = (0..axes).collect();
        if array["order"] == "F" {
            order.reverse();
        }
        Ok(Self { order, packings })
    }

    /// Codecs of Zarr version 3, the byte order of numbers, and how chunks of this shape are shards.
    pub fn from_version_3(codecs: &Value, chunks: &[usize]) -> Result<(Self, Endian, Option<Shards>), String> {
        let codecs = codecs.as_array().ok_or("it has no codecs")?;
        let mut found = Self { order: (0..chunks.len()).collect(), packings: Vec::new() };
        let mut endian = Endian::Little;
        for codec in codecs {
            // Without settings, the name alone may stand for the codec.
            let (name, settings) = (codec["name"].as_str().or(codec.as_str()).unwrap_or_default(), &codec["configuration"]);
            match name {
                "transpose" => found.order = transposed(&found.order, &settings["order"])?,
                "bytes" if settings["endian"] == "big" => endian = Endian::Big,
                "bytes" => {}
                "sharding_indexed" if codecs.len() == 1 => {
                    let shards = Shards::new(settings, chunks)?;
                    let (inner, endian, None) = Self::from_version_3(&settings["codecs"], &shards.chunk)? else {
                        return Err("its shards hold shards, which is not supported".into());
                    };
                    return Ok((inner, endian, Some(shards)));
                }
                "sharding_indexed" => return Err("its shards are transposed or compressed, which is not supported".into()),
                // Of numbers, whose order and byte order other codecs change.
                "numcodecs.delta" => return Err(packed_by(name)),
                other => found.packings.extend(Packing::new(other.strip_prefix("numcodecs.").unwrap_or(other), settings)?),
            }
        }
        Ok((found, endian, None))
    }

    /// Upper bound of the compressed size of a chunk of `len` bytes: incompressible data grow.
    pub fn longest(len: usize) -> u64 {
        len as u64 + len as u64 / 8 + (ON_THE_WAY << 6) as u64
    }

    /// Decodes a chunk to `len` bytes of numbers in stored order.
    pub fn unpack<'a>(&self, packed: &'a [u8], len: usize) -> Result<Cow<'a, [u8]>, String> {
        let mut bytes = Cow::Borrowed(packed);
        for (n, packing) in self.packings.iter().enumerate().rev() {
            let growths = self.packings[..n].iter().map(Packing::growth);
            let known = growths.sum::<Option<usize>>().map(|more| len + more);
            bytes = packing.unpack(bytes, known.unwrap_or(Self::longest(len) as usize), known.is_some())?;
        }
        if bytes.len() != len {
            return Err(format!("a chunk has {} bytes, expected {len}", bytes.len()));
        }
        Ok(bytes)
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
    /// A codec by its name and settings; `None` if it leaves the bytes as they are.
    fn new(name: &str, settings: &Value) -> Result<Option<Self>, String> {
        Ok(Some(match name {
            "gzip" => Self::Gzip,
            "zlib" => Self::Zlib,
            "zstd" => Self::Zstd,
            "blosc" => Self::Blosc,
            "lz4" => Self::Lz4,
            "shuffle" => match settings["elementsize"].as_u64().unwrap_or(4) {
                size @ 1..=16 => Self::Shuffle(size as usize),
                size => return Err(format!("its filter shuffle has numbers of {size} bytes: expected 1 to 16")),
            },
            "delta" => Self::Delta(delta(settings)?),
            // Values that were rounded before they were stored.
            "quantize" | "bitround" if settings["astype"].is_null() || settings["astype"] == settings["dtype"] => {
                return Ok(None);
            }
            "crc32c" => Self::Crc32c,
            other => return Err(packed_by(other)),
        }))
    }

    /// Bytes that it adds; `None` if that depends on the data.
    fn growth(&self) -> Option<usize> {
        match self {
            Self::Crc32c => Some(4),
            Self::Shuffle(_) | Self::Delta(_) => Some(0),
            _ => None,
        }
    }

    /// Decompresses at most `most` bytes; exactly `most` if `exactly`.
    fn unpack<'a>(&self, packed: Cow<'a, [u8]>, most: usize, exactly: bool) -> Result<Cow<'a, [u8]>, String> {
        let unpacked = match self {
            Self::Gzip => unpacked(flate2::read::MultiGzDecoder::new(&packed[..]), most)?,
            Self::Zlib => zlib(&packed, most)?,
            Self::Zstd => {
                let mut all = memory::zeroed("a chunk", most).map_err(|e| e.to_string())?;
                let found = zstd(&packed, &mut all)?;
                all.truncate(found);
                all
            }
            Self::Blosc if exactly => blosc::unpack(&packed, most)?,
            Self::Blosc => return Err(packed_by("blosc followed by another codec")),
            Self::Lz4 => {
                let (len, block) = packed.split_first_chunk().ok_or("a chunk without its length")?;
                let len = u32::from_le_bytes(*len) as usize;
                if len > most {
                    return Err(format!("a chunk with more than {most} bytes"));
                }
                let mut all = memory::zeroed("a chunk", len).map_err(|e| e.to_string())?;
                let found = lz4_flex::block::decompress_into(block, &mut all).map_err(|e| e.to_string())?;
                all.truncate(found);
                all
            }
            Self::Shuffle(size) => {
                let mut all = memory::zeroed("a chunk", packed.len()).map_err(|e| e.to_string())?;
                blosc::unshuffle(*size, &packed, &mut all);
                all
            }
            Self::Delta(size) => {
                let mut all = packed.into_owned();
                sum(*size, &mut all);
                all
            }
            Self::Crc32c => {
                let (bytes, sum) = packed.split_last_chunk::<4>().ok_or("a chunk without its checksum")?;
                if crc32c(bytes) != u32::from_le_bytes(*sum) {
                    return Err("a wrong checksum".into());
                }
                bytes.to_vec()
            }
        };
        Ok(unpacked.into())
    }
}

/// Bytes of the numbers of the filter delta.
fn delta(settings: &Value) -> Result<usize, String> {
    let kind = settings["dtype"].as_str().unwrap_or_default();
    let same = settings["astype"].is_null() || settings["astype"] == kind;
    match kind.strip_prefix(['<', '|']) {
        Some("i1" | "u1") if same => Ok(1),
        Some("i2" | "u2") if same => Ok(2),
        Some("i4" | "u4") if same => Ok(4),
        Some("i8" | "u8") if same => Ok(8),
        _ => Err(packed_by(&format!("the filter delta of {}", settings["dtype"]))),
    }
}

/// Replaces differences of little-endian numbers by the numbers.
fn sum(size: usize, bytes: &mut [u8]) {
    let mut last = 0u64;
    for number in bytes.chunks_exact_mut(size) {
        let mut all = [0; 8];
        all[..size].copy_from_slice(number);
        last = last.wrapping_add(u64::from_le_bytes(all));
        number.copy_from_slice(&last.to_le_bytes()[..size]);
    }
}

pub(super) fn zlib(packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
    unpacked(flate2::read::ZlibDecoder::new(packed), most)
}

/// Decompresses as many bytes as there is room for, and returns their number.
pub(super) fn zstd(packed: &[u8], to: &mut [u8]) -> Result<usize, String> {
    zstd_safe::decompress(to, packed).map_err(|code| zstd_safe::get_error_name(code).into())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_reversed() {
        let mut numbers: Vec<u8> = [5i32, -7, 2_000_000_000, 2_000_000_000].iter().flat_map(|n| n.to_le_bytes()).collect();
        sum(4, &mut numbers);
        let found: Vec<i32> = numbers.chunks_exact(4).map(|n| i32::from_le_bytes(n.try_into().unwrap())).collect();
        assert_eq!(found, [5, -2, 1_999_999_998, -294_967_298]);
        for size in 1..=16 {
            // A number and a byte are too few for vectors, and 100 are not.
            for len in [size, 3 * size + 1, 100 * size + size / 2] {
                let numbers: Vec<u8> = (0..len).map(|n| (n * 7 % 251) as u8).collect();
                let count = len / size;
                let shuffled: Vec<u8> =
                    (0..len).map(|n| numbers[if n < count * size { n % count * size + n / count } else { n }]).collect();
                let mut found = vec![0; len];
                blosc::unshuffle(size, &shuffled, &mut found);
                assert_eq!(found, numbers, "{size} {len}");
            }
        }
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
