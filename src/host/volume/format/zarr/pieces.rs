//! Voxels of an array, read some layers of chunks at a time.

use super::array::Array;
use crate::memory;
use crate::panics::caught;
use crate::progress;
use crate::volume::VoxelBox;
use crate::volume::format::parts::Parts;
use crate::volume::format::strided;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Chunks that are read together, per chunk that is read at once: while the last of them are read, none are waiting.
const CHUNKS_PER_READER: usize = 4;
/// Bytes that may be read together where a layer of chunks has fewer chunks than that.
const MOST_TOGETHER: usize = 64 << 20;

/// Bytes of the chunks that are decoded at once, if there are several: shards are chunks, too.
const MOST_AT_ONCE: usize = 512 << 20;

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
    /// Number of chunks that are stored, and of those that were refused.
    stored: AtomicUsize,
    refused: AtomicUsize,
}

impl Pieces {
    pub fn new(array: Array, space: [Option<usize>; 3], place: Vec<usize>) -> Self {
        let dims = space.map(|axis| axis.map_or(1, |axis| array.shape[axis]));
        let (stored, refused) = Default::default();
        Self { array, space, place, first: [0; 3], dims, fills_refused: false, stored, refused }
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
        let bytes = self.array.chunks.iter().fold(self.array.scalar.bytes(), |n, &size| n.saturating_mul(size));
        self.array.store.at_once().min(MOST_AT_ONCE / bytes.max(1)).max(1)
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

    /// Decodes a chunk, counted from the first; `None` if it is not stored.
    fn piece(&self, at: [usize; 3]) -> io::Result<Option<Vec<u8>>> {
        let array = &self.array;
        let mut place: Vec<usize> = self.place.iter().zip(&array.chunks).map(|(place, chunk)| place / chunk).collect();
        for (i, axis) in self.space.iter().enumerate() {
            axis.iter().for_each(|&axis| place[axis] = self.first[i] / self.chunk(i) + at[i]);
        }
        let (path, size) = (array.file(&place), array.scalar.bytes());
        let named = |kind: io::ErrorKind, problem: String| io::Error::new(kind, format!("{}: {problem}", path.display()));
        let most = array.codec.longest(array.chunks.iter().product::<usize>() * size);
        let packed = match array.store.get(&path, most) {
            Err(e) if e.kind() == io::ErrorKind::PermissionDenied && self.fills_refused => {
                self.refused.fetch_add(1, Ordering::Relaxed);
                None
            }
            Err(e) => return Err(named(e.kind(), e.to_string())),
            Ok(packed) => packed,
        };
        let Some(packed) = packed else { return Ok(None) };
        self.stored.fetch_add(1, Ordering::Relaxed);
        let unpacked = array.codec.unpack(packed, &array.chunks, size, &array.fill);
        unpacked.map(Some).map_err(|problem| named(io::ErrorKind::InvalidData, problem))
    }

    /// Warns of chunks that are not there. For the last part.
    fn warn_of_holes(&self) {
        let name = self.array.file(&[]);
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
        let other = |e: crate::error::Error| io::Error::other(e.to_string());
        let (size, first, [x, y, z]) = (self.array.scalar.bytes(), index * self.layers_together(), self.counts());
        let deep = self.deep().min(self.dims[2] - index * self.deep());
        let name = self.array.file(&[]);
        let mut slab = memory::zeroed(&name.display().to_string(), self.layer() * deep).map_err(other)?;
        slab.chunks_exact_mut(size).for_each(|number| number.copy_from_slice(&self.array.fill));
        let count = x * y * self.layers_together().min(z - first);
        let (next, slab, failed) = (AtomicUsize::new(0), Mutex::new(slab), Mutex::new(None::<io::Error>));
        let (this, observer) = (&*self, progress::observer());
        let fail = |e| {
            failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(e);
            // Others begin no further chunk.
            next.store(count, Ordering::Relaxed);
        };
        let read = || {
            loop {
                let n = next.fetch_add(1, Ordering::Relaxed);
                if n >= count {
                    return;
                }
                let at = [n % x, n / x % y, first + n / x / y];
                // A panic of a decoder would otherwise be reported, and end the process that reads.
                let piece = progress::check().and_then(|()| caught(&name, || Ok(this.piece(at))).map_err(other)?);
                match piece {
                    Ok(Some(numbers)) => this.put(&numbers, at, &mut slab.lock().unwrap_or_else(PoisonError::into_inner)),
                    Ok(None) => {}
                    Err(e) => fail(e),
                }
            }
        };
        let observed = || match observer.clone() {
            Some(observer) => progress::observed(observer, read),
            None => read(),
        };
        match count.min(this.at_once()) {
            0 | 1 => read(),
            readers => std::thread::scope(|scope| (0..readers).for_each(|_| drop(scope.spawn(observed)))),
        }
        if let Some(e) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(e);
        }
        if first + self.layers_together() >= z {
            self.warn_of_holes();
        }
        Ok(slab.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}
