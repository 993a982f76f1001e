//! Voxels of an array, read one layer of chunks at a time.

use super::array::Array;
use crate::memory;
use crate::volume::format::bytes;
use crate::volume::format::parts::Parts;
use crate::volume::format::strided;
use std::fs::File;
use std::io;

/// One volume of an array, x fastest.
pub(super) struct Pieces {
    array: Array,
    /// Array axes of x, y and z, if they exist, and the position of the volume along the other axes.
    space: [Option<usize>; 3],
    place: Vec<usize>,
    dims: [usize; 3],
}

impl Pieces {
    pub fn new(array: Array, space: [Option<usize>; 3], place: Vec<usize>) -> Self {
        let dims = space.map(|axis| axis.map_or(1, |axis| array.shape[axis]));
        Self { array, space, place, dims }
    }

    /// Chunk size along an axis of the volume.
    fn chunk(&self, axis: usize) -> usize {
        self.space[axis].map_or(1, |axis| self.array.chunks[axis])
    }

    /// Number of layers read together.
    fn deep(&self) -> usize {
        self.chunk(2).min(self.dims[2])
    }

    fn layer(&self) -> usize {
        self.dims[0] * self.dims[1] * self.array.scalar.bytes()
    }

    /// Decodes a chunk; `None` if it is not stored.
    fn piece(&self, place: &[usize]) -> io::Result<Option<Vec<u8>>> {
        let (path, array) = (self.array.file(place), &self.array);
        let named = |problem: String| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {problem}", path.display()));
        let mut file = match File::open(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        let len = file.metadata()?.len();
        let size = array.scalar.bytes();
        let most = array.codec.longest(array.chunks.iter().product::<usize>() * size);
        if len > most {
            return Err(named(format!("it has {len} bytes, but its chunk needs at most {most}")));
        }
        let name = path.display().to_string();
        let mut packed = memory::zeroed(&name, len as usize).map_err(|e| io::Error::other(e.to_string()))?;
        let found = bytes::fill(&mut file, &mut packed)?;
        packed.truncate(found);
        array.codec.unpack(packed, &array.chunks, size, &array.fill).map(Some).map_err(named)
    }

    /// Copies the part of a chunk that belongs to the volume.
    fn put(&self, numbers: &[u8], at: [usize; 3], slab: &mut [u8], deep: usize) {
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
        let first = [0, 1].map(|i| at[i] * self.chunk(i));
        let [x, y] = [0, 1].map(|i| self.chunk(i).min(self.dims[i] - first[i]));
        let start = (first[1] * self.dims[0] + first[0]) * size;
        strided::copy(&numbers[skipped..], &from, &mut slab[start..], &to, &[deep, y, x], size);
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

    /// All layers of one layer of chunks.
    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let other = |e: crate::error::Error| io::Error::other(e.to_string());
        let (size, first) = (self.array.scalar.bytes(), index * self.chunk(2));
        let deep = self.chunk(2).min(self.dims[2] - first);
        let mut slab = memory::zeroed(&self.array.file(&[]).display().to_string(), self.layer() * deep).map_err(other)?;
        slab.chunks_exact_mut(size).for_each(|number| number.copy_from_slice(&self.array.fill));
        let counts = [0, 1].map(|i| self.dims[i].div_ceil(self.chunk(i)));
        for n in 0..counts[0] * counts[1] {
            let at = [n % counts[0], n / counts[0], index];
            let mut piece: Vec<usize> = self.place.iter().zip(&self.array.chunks).map(|(place, chunk)| place / chunk).collect();
            for (axis, at) in self.space.iter().zip(at) {
                axis.iter().for_each(|&axis| piece[axis] = at);
            }
            if let Some(numbers) = self.piece(&piece)? {
                self.put(&numbers, at, &mut slab, deep);
            }
        }
        Ok(slab)
    }
}
