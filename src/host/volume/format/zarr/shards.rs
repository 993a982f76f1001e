//! Shards: files of several chunks, with an index of where each chunk is.

use super::crc32c::crc32c;
use super::store::{Found, Span};
use serde_json::Value;
use std::ops::Range;

/// Bytes of an index entry: first byte of a chunk, and number of bytes.
const ENTRY: usize = 16;

/// Parses an array of positive sizes.
pub(super) fn sizes(metadata: &Value, name: &str) -> Result<Vec<usize>, String> {
    let size = |n: &Value| n.as_u64().and_then(|n| usize::try_from(n).ok()).filter(|&n| n > 0);
    let found: Option<Vec<usize>> = metadata.as_array().and_then(|sizes| sizes.iter().map(size).collect());
    found.ok_or_else(|| format!("its {name} is {metadata}: expected numbers above 0"))
}

/// How an array is stored in shards.
pub(super) struct Shards {
    /// Shape of a chunk.
    pub chunk: Vec<usize>,
    /// Chunks of a shard along each axis.
    pub counts: Vec<usize>,
    /// Whether a checksum follows the index, which is at the end or at the start.
    is_checked: bool,
    at_end: bool,
    /// Bytes of the index.
    len: u64,
}

impl Shards {
    pub fn new(settings: &Value, shard: &[usize]) -> Result<Self, String> {
        let chunk = sizes(&settings["chunk_shape"], "chunk_shape")?;
        if chunk.len() != shard.len() || shard.iter().zip(&chunk).any(|(whole, part)| whole % part != 0) {
            return Err(format!("its shards of {shard:?} numbers are no multiple of their chunks of {chunk:?}"));
        }
        let counts: Vec<usize> = shard.iter().zip(&chunk).map(|(whole, part)| whole / part).collect();
        let mut is_checked = false;
        for codec in settings["index_codecs"].as_array().into_iter().flatten() {
            match codec["name"].as_str() {
                Some("bytes") if codec["configuration"]["endian"] != "big" => {}
                Some("crc32c") => is_checked = true,
                _ => return Err(format!("the index of its shards has the codec {codec}, which is not supported")),
            }
        }
        let entries = counts.iter().try_fold(ENTRY, |n, &count| n.checked_mul(count)).filter(|&n| n <= isize::MAX as usize / 2);
        let len =
            entries.ok_or_else(|| format!("its shards of {counts:?} chunks are too large"))? + if is_checked { 4 } else { 0 };
        Ok(Self { chunk, counts, is_checked, at_end: settings["index_location"] != "start", len: len as u64 })
    }

    /// Where the index is.
    pub fn index(&self) -> Span {
        if self.at_end { Span::Last(self.len) } else { Span::Part(0..self.len) }
    }

    /// Most bytes of a file whose chunks have at most so many.
    pub fn longest(&self, chunk: u64) -> u64 {
        (self.counts.iter().product::<usize>() as u64).saturating_mul(chunk).saturating_add(self.len)
    }

    /// The shard whose index, or all of it, was found. It may have `most` bytes.
    pub fn shard(&self, found: Found, most: u64) -> Result<Shard, String> {
        let short = "a shard shorter than its index";
        let len = self.len as usize;
        // Servers may answer with the whole file.
        let is_whole = found.first == 0 && found.bytes.len() > len;
        let start = if self.at_end { found.bytes.len().checked_sub(len).ok_or(short)? } else { 0 };
        let mut table = found.bytes.get(start..start + len).ok_or(short)?;
        if self.is_checked {
            let (entries, sum) = table.split_last_chunk::<4>().ok_or(short)?;
            if crc32c(entries) != u32::from_le_bytes(*sum) {
                return Err("a wrong checksum of the index".into());
            }
            table = entries;
        }
        let numbers = table.chunks_exact(8).map(|word| word.first_chunk().map_or(0, |word| u64::from_le_bytes(*word)));
        let table = numbers.collect();
        Ok(Shard { table, version: found.version, whole: is_whole.then_some(found.bytes), most })
    }
}

/// A file of several chunks.
pub(super) struct Shard {
    /// First byte and number of bytes of each chunk.
    table: Vec<u64>,
    pub version: Option<String>,
    /// All bytes, from servers that give no parts.
    pub whole: Option<Vec<u8>>,
    /// Most bytes that it may have.
    pub most: u64,
}

impl Shard {
    /// The bytes of chunk `n`, of which there may be `longest`; `None` if it is not stored.
    pub fn chunk(&self, n: usize, longest: u64) -> Result<Option<Range<u64>>, String> {
        let [first, len] = [self.table[2 * n], self.table[2 * n + 1]];
        if first == u64::MAX && len == u64::MAX {
            return Ok(None);
        }
        let end = first
            .checked_add(len)
            .filter(|&end| len > 0 && len <= longest && end <= self.most)
            .ok_or("an index that leads outside its shard, or to empty parts")?;
        Ok(Some(first..end))
    }
}
