//! Voxels of an array, read some layers of chunks at a time.

use super::array::Array;
use super::codec::Codec;
use super::shards::Shard;
use super::store::{Found, Span, changed};
use crate::error::Error;
use crate::memory;
use crate::panics::caught;
use crate::progress;
use crate::volume::VoxelBox;
use crate::volume::format::parts::Parts;
use crate::volume::format::strided;
use std::collections::HashMap;
use std::fmt::Display;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Chunks that are read together, per chunk that is read at once: while the last of them are read, none are waiting.
const CHUNKS_PER_READER: usize = 4;
/// Bytes that may be read together where a layer of chunks has fewer chunks than that.
const MOST_TOGETHER: usize = 64 << 20;

/// Bytes of the chunks that are decoded at once, if there are several.
const MOST_AT_ONCE: usize = 512 << 20;
/// Neighbours in a file are read together if so few bytes are between them, up to so many bytes.
const MOST_BETWEEN: u64 = 32 << 10;
const MOST_IN_ONE: u64 = 1 << 20;

/// One volume of an array, x fastest.
pub(super) struct Pieces {
    array: Array,
    /// Array axes of x, y and z, if they exist, and the position of the volume along the other axes.
    space: [Option<usize>; 3],
    place: Vec<usize>,
    /// First voxel and number of voxels: those of a part, and the layers before it in the same chunks.
    first: [usize; 3],
    dims: [usize; 3],
    /// Whether chunks that a server refuses count as not stored.
    fills_refused: bool,
    /// Files of several chunks, or that they are not stored.
    known: HashMap<PathBuf, Option<Arc<Shard>>>,
    /// Number of chunks that are stored, and of those that were refused.
    stored: AtomicUsize,
    refused: AtomicUsize,
}

impl Pieces {
    pub fn new(array: Array, space: [Option<usize>; 3], place: Vec<usize>) -> Self {
        let dims = space.map(|axis| axis.map_or(1, |axis| array.shape[axis]));
        let (known, stored, refused) = Default::default();
        Self { array, space, place, first: [0; 3], dims, fills_refused: false, known, stored, refused }
    }

    /// The voxels of a part, and the number of those before it.
    pub fn of_part(mut self, part: VoxelBox) -> (Self, u64) {
        (self.first, self.dims) = (part.first, part.dims);
        let before = part.first[2] % self.chunk(2);
        self.first[2] -= before;
        self.dims[2] += before;
        let voxels = before as u64 * self.dims[0] as u64 * self.dims[1] as u64;
        (self, voxels)
    }

    /// Takes chunks that a server refuses as not stored, if `fills`.
    pub fn filling_refused(self, fills: bool) -> Self {
        Self { fills_refused: fills, ..self }
    }

    /// Chunk size along an axis of the volume.
    fn chunk(&self, axis: usize) -> usize {
        self.space[axis].map_or(1, |axis| self.array.chunks[axis])
    }

    /// Chunks that are read at once.
    fn at_once(&self) -> usize {
        self.array.store.at_once().min(MOST_AT_ONCE / self.array.chunk_bytes()).max(1)
    }

    /// Numbers of chunks along x, y and z.
    fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|i| (self.first[i] + self.dims[i]).div_ceil(self.chunk(i)) - self.first[i] / self.chunk(i))
    }

    /// Layers of chunks that are read together.
    fn layers_together(&self) -> usize {
        let [x, y, z] = self.counts();
        let readers = self.at_once();
        let wanted = (CHUNKS_PER_READER * readers).div_ceil(x.saturating_mul(y));
        let bytes = self.layer().saturating_mul(self.chunk(2)).max(1);
        if readers == 1 { 1 } else { wanted.min(MOST_TOGETHER / bytes).clamp(1, z) }
    }

    /// Number of layers of voxels read together.
    fn deep(&self) -> usize {
        self.chunk(2).saturating_mul(self.layers_together()).min(self.dims[2])
    }

    fn layer(&self) -> usize {
        self.dims[0] * self.dims[1] * self.array.scalar.bytes()
    }

    /// The file of a chunk, which is counted from the first, and the chunk's number in it.
    fn file(&self, at: [usize; 3]) -> (PathBuf, usize) {
        let array = &self.array;
        let mut place: Vec<usize> = self.place.iter().zip(&array.chunks).map(|(place, chunk)| place / chunk).collect();
        for (i, axis) in self.space.iter().enumerate() {
            axis.iter().for_each(|&axis| place[axis] = self.first[i] / self.chunk(i) + at[i]);
        }
        array.file(&place)
    }

    /// Bytes of a file; `None` if it is not stored, or refused where that counts as not stored. Its `chunks` are counted.
    fn found(&self, file: &Path, span: &Span, version: Option<&str>, most: u64, chunks: usize) -> io::Result<Option<Found>> {
        match self.array.store.get(file, span, version, most) {
            Err(e) if e.kind() == io::ErrorKind::PermissionDenied && self.fills_refused => {
                self.refused.fetch_add(chunks, Ordering::Relaxed);
                Ok(None)
            }
            // It was there before.
            Ok(None) if version.is_some() => Err(changed()),
            found => found,
        }
        .map_err(|e| named(file, e.kind(), e))
    }

    /// Reads the indexes of the files that hold these chunks, as far as they are not known. Others are forgotten.
    fn learn(&mut self, chunks: &[[usize; 3]], name: &Path) -> io::Result<()> {
        let Some(shards) = &self.array.shards else { return Ok(()) };
        let mut counts = HashMap::<PathBuf, usize>::new();
        chunks.iter().for_each(|&at| *counts.entry(self.file(at).0).or_default() += 1);
        let mut known = std::mem::take(&mut self.known);
        known.retain(|file, _| counts.contains_key(file));
        counts.retain(|file, _| !known.contains_key(file));
        let (counts, known) = (Vec::from_iter(counts), Mutex::new(known));
        let most = shards.longest(Codec::longest(self.array.chunk_bytes()));
        each(counts.len(), self.at_once(), name, |n| {
            let (file, count) = &counts[n];
            let found = self.found(file, &shards.index(), None, most, *count)?;
            let shard = found.map(|found| shards.shard(found, most)).transpose();
            let shard = shard.map_err(|problem| named(file, io::ErrorKind::InvalidData, problem))?;
            lock(&known).insert(file.clone(), shard.map(Arc::new));
            Ok(())
        })?;
        self.known = known.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(())
    }

    /// What to read for these chunks, which are counted from the first.
    fn reads(&self, chunks: &[[usize; 3]]) -> io::Result<Vec<Read>> {
        let longest = Codec::longest(self.array.chunk_bytes());
        let mut reads = Vec::new();
        for &at in chunks {
            let (file, number) = self.file(at);
            let (span, shard) = match self.known.get(&file) {
                None => (0..u64::MAX, None),
                Some(None) => continue,
                Some(Some(shard)) => {
                    let span = shard.chunk(number, longest);
                    let Some(span) = span.map_err(|problem| named(&file, io::ErrorKind::InvalidData, problem))? else { continue };
                    (span, Some(shard.clone()))
                }
            };
            reads.push(Read { file, shard, span: span.clone(), chunks: vec![(at, span)] });
        }
        // Neighbours in a file are read together, where a request takes longer than their bytes.
        reads.sort_by(|a, b| (&a.file, a.span.start).cmp(&(&b.file, b.span.start)));
        let mut together: Vec<Read> = Vec::new();
        for read in reads {
            match together.last_mut() {
                Some(last) if last.may_grow_by(&read) => {
                    last.span.end = last.span.end.max(read.span.end);
                    last.chunks.extend(read.chunks);
                }
                _ => together.push(read),
            }
        }
        Ok(together)
    }

    /// Reads and decodes chunks, and hands on their numbers.
    fn read(&self, read: &Read, put: impl Fn(&[u8], [usize; 3])) -> io::Result<()> {
        let Read { file, shard, span, chunks } = read;
        let len = self.array.chunk_bytes();
        let version = shard.as_ref().and_then(|shard| shard.version.as_deref());
        let found;
        let (bytes, first) = match shard.as_ref().and_then(|shard| shard.whole.as_deref()) {
            Some(whole) => (whole, 0),
            None => {
                let (part, most) = match shard {
                    Some(shard) => (Span::Part(span.clone()), shard.most),
                    None => (Span::All, Codec::longest(len)),
                };
                let Some(some) = self.found(file, &part, version, most, chunks.len())? else { return Ok(()) };
                found = some;
                (&found.bytes[..], found.first)
            }
        };
        for (at, span) in chunks {
            let packed = match shard {
                None => Some(bytes),
                Some(_) => {
                    let inside = |at: u64| at.checked_sub(first).and_then(|at| usize::try_from(at).ok());
                    inside(span.start).zip(inside(span.end)).and_then(|(start, end)| bytes.get(start..end))
                }
            };
            let wrong = |problem: String| named(file, io::ErrorKind::InvalidData, problem);
            let packed = packed.ok_or_else(|| wrong("a chunk outside its shard".into()))?;
            self.stored.fetch_add(1, Ordering::Relaxed);
            put(&self.array.codec.unpack(packed, len).map_err(wrong)?, *at);
        }
        Ok(())
    }

    /// Warns of chunks that are not there. For the last part.
    fn warn_of_holes(&self) {
        let name = self.array.folder();
        let (name, all) = (name.display(), self.counts().iter().product::<usize>());
        match (self.refused.load(Ordering::Relaxed), self.stored.load(Ordering::Relaxed)) {
            (0, 0) => tracing::warn!("{name}: none of its {all} chunks is stored: all voxels have the fill value"),
            (0, _) => {}
            (refused, _) => {
                tracing::warn!("{name}: the server refused {refused} of {all} chunks: their voxels have the fill value")
            }
        }
    }

    /// Copies what the volume has of a chunk, which is counted from the first.
    fn put(&self, numbers: &[u8], at: [usize; 3], slab: &mut [u8]) {
        let (array, size) = (&self.array, self.array.scalar.bytes());
        let strides = array.codec.strides(&array.chunks, size);
        let within = self.place.iter().zip(&array.chunks).zip(&strides);
        let skipped: usize = within
            .enumerate()
            .filter(|(axis, _)| !self.space.contains(&Some(*axis)))
            .map(|(_, ((place, chunk), stride))| place % chunk * stride)
            .sum();
        let from = [2, 1, 0].map(|i| self.space[i].map_or(0, |axis| strides[axis]));
        let to = [self.layer(), self.dims[0] * size, size];
        // Within the chunk and the volume.
        let inside = |i: usize| {
            let begin = (self.first[i] / self.chunk(i) + at[i]) * self.chunk(i);
            let (from, to) = (begin.max(self.first[i]), (begin + self.chunk(i)).min(self.first[i] + self.dims[i]));
            (from - begin, from - self.first[i], to - from)
        };
        let [(skipped_x, x, wide), (skipped_y, y, high)] = [inside(0), inside(1)];
        let skipped = skipped + skipped_x * from[2] + skipped_y * from[1];
        // The slab begins at a multiple of the layers read together.
        let layer = at[2] % self.layers_together() * self.chunk(2);
        let deep = self.chunk(2).min(slab.len() / self.layer() - layer);
        let start = layer * self.layer() + (y * self.dims[0] + x) * size;
        strided::copy(&numbers[skipped..], &from, &mut slab[start..], &to, &[deep, high, wide], size);
    }
}

impl Parts for Pieces {
    /// The declared size: chunks that are not stored are filled with the fill value.
    fn most(&self) -> u64 {
        self.whole()
    }

    fn whole(&self) -> u64 {
        self.dims.iter().fold(self.array.scalar.bytes() as u64, |n, &size| n.saturating_mul(size as u64))
    }

    fn each(&self) -> u64 {
        (self.layer() * self.deep()) as u64
    }

    /// Layers of voxels of some layers of chunks.
    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let (first, [x, y, z]) = (index * self.layers_together(), self.counts());
        let deep = self.deep().min(self.dims[2] - index * self.deep());
        let name = self.array.folder().to_owned();
        let mut slab = memory::zeroed(&name.display().to_string(), self.layer() * deep).map_err(other)?;
        fill(&mut slab, &self.array.fill);
        let count = x * y * self.layers_together().min(z - first);
        let chunks: Vec<[usize; 3]> = (0..count).map(|n| [n % x, n / x % y, first + n / x / y]).collect();
        self.learn(&chunks, &name)?;
        let reads = self.reads(&chunks)?;
        let slab = Mutex::new(slab);
        each(reads.len(), self.at_once(), &name, |n| {
            self.read(&reads[n], |numbers, at| self.put(numbers, at, &mut lock(&slab)))
        })?;
        if first + self.layers_together() >= z {
            self.warn_of_holes();
        }
        Ok(slab.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Fills zeros with copies of a number.
fn fill(zeros: &mut [u8], number: &[u8]) {
    if number.iter().all(|&byte| byte == 0) || zeros.is_empty() {
        return;
    }
    zeros[..number.len()].copy_from_slice(number);
    let mut filled = number.len();
    while filled < zeros.len() {
        let more = filled.min(zeros.len() - filled);
        zeros.copy_within(..more, filled);
        filled += more;
    }
}

/// Bytes of a file that hold chunks, which are counted from the first, each with its bytes.
struct Read {
    file: PathBuf,
    shard: Option<Arc<Shard>>,
    span: Range<u64>,
    chunks: Vec<([usize; 3], Range<u64>)>,
}

impl Read {
    /// Whether another read, of bytes behind, is better done with this one.
    fn may_grow_by(&self, next: &Self) -> bool {
        let end = self.span.end.max(next.span.end);
        self.shard.is_some()
            && self.file == next.file
            && next.span.start.saturating_sub(self.span.end) <= MOST_BETWEEN
            && end - self.span.start <= MOST_IN_ONE
    }
}

/// Does `count` things, so many at once, until one fails.
fn each(count: usize, at_once: usize, name: &Path, work: impl Fn(usize) -> io::Result<()> + Sync) -> io::Result<()> {
    let (next, failed, observer) = (AtomicUsize::new(0), Mutex::new(None::<io::Error>), progress::observer());
    let worker = || {
        loop {
            let n = next.fetch_add(1, Ordering::Relaxed);
            if n >= count {
                return;
            }
            // A panic of a decoder would otherwise be reported, and end the process that reads.
            if let Err(e) = progress::check().and_then(|()| caught(name, || Ok(work(n))).map_err(other)?) {
                lock(&failed).get_or_insert(e);
                // Others begin nothing more.
                next.store(count, Ordering::Relaxed);
            }
        }
    };
    let observed = || match observer.clone() {
        Some(observer) => progress::observed(observer, worker),
        None => worker(),
    };
    match count.min(at_once) {
        0 | 1 => worker(),
        workers => std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(observed)))),
    }
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn other(e: Error) -> io::Error {
    io::Error::other(e.to_string())
}

/// A problem of a file.
fn named(file: &Path, kind: io::ErrorKind, problem: impl Display) -> io::Error {
    io::Error::new(kind, format!("{}: {problem}", file.display()))
}
