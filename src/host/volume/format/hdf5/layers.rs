//! Voxels of an HDF5 dataset, read several layers at a time.

use super::numbers::Raw;
use crate::memory;
use crate::volume::format::parts::Parts;
use crate::volume::format::strided;
use hdf5_reader::{Dataset, SliceInfo, SliceInfoElem};
use std::io;

/// Bytes read at a time from datasets without chunks.
const TOGETHER: usize = 1 << 24;

/// One volume of a dataset.
pub(super) struct Layers {
    dataset: Dataset,
    /// Bytes per number.
    size: usize,
    /// Axes of the dataset along which its numbers are read, the slowest of the result first.
    order: Vec<usize>,
    /// Position along the other axes.
    place: Vec<usize>,
    /// Numbers along each of `order`.
    shape: Vec<usize>,
    /// Positions along the first axis that are read together.
    deep: usize,
}

impl Layers {
    /// The numbers along `order`, at `place` along the other axes.
    pub fn new(dataset: Dataset, size: usize, order: Vec<usize>, place: Vec<usize>) -> Self {
        let shape: Vec<usize> = order.iter().map(|&axis| dataset.shape()[axis] as usize).collect();
        let mut layers = Self { dataset, size, order, place, shape, deep: 1 };
        let read: usize = (0..layers.place.len())
            .filter(|&axis| layers.is_read(axis))
            .map(|axis| layers.len(axis))
            .fold(size, usize::saturating_mul);
        let chunk = layers.dataset.chunks().filter(|_| layers.order.len() >= 3).map(|chunks| chunks[layers.order[0]] as usize);
        layers.deep = chunk.unwrap_or(TOGETHER / (read / layers.shape[0]).max(1)).clamp(1, layers.shape[0]);
        layers
    }

    fn len(&self, axis: usize) -> usize {
        self.dataset.shape()[axis] as usize
    }

    /// Whether all along an axis is read. Along axes that are faster than those of the volume, reading all and leaving out most is faster than
    /// reading number by number.
    fn is_read(&self, axis: usize) -> bool {
        let is_behind = self.order.iter().all(|&other| other < axis);
        let is_together = self.dataset.chunks().is_none_or(|chunks| chunks[axis] > 1);
        self.order.contains(&axis) || is_behind && is_together
    }

    /// Bytes of one layer.
    fn layer(&self) -> usize {
        self.shape[1..].iter().fold(self.size, |n, &size| n.saturating_mul(size))
    }

    fn numbers<const N: usize>(&self, index: usize) -> io::Result<Vec<u8>> {
        let failed = |e: String| io::Error::new(io::ErrorKind::InvalidData, e);
        let start = index * self.deep;
        let end = (start + self.deep).min(self.shape[0]);
        // The axes that are read, with their first position and their number of positions.
        let (mut selections, mut read) = (Vec::new(), Vec::new());
        for axis in 0..self.place.len() {
            let [from, to] = if axis == self.order[0] { [start, end] } else { [0, self.len(axis)] };
            if self.is_read(axis) {
                selections.push(SliceInfoElem::Slice { start: from as u64, end: to as u64, step: 1 });
                read.push((axis, to - from));
            } else {
                selections.push(SliceInfoElem::Index(self.place[axis] as u64));
            }
        }
        let found = self.dataset.read_slice::<Raw<N>>(&SliceInfo { selections }).map_err(|e| failed(e.to_string()))?;
        let bytes: Vec<u8> = found.iter().flat_map(|number| number.0).collect();
        if read.iter().map(|(axis, _)| axis).eq(&self.order) {
            return Ok(bytes);
        }
        let sizes: Vec<usize> = read.iter().map(|(_, size)| *size).collect();
        let strides = strided::strides(&sizes, N);
        let along = |axis: usize| read.iter().position(|(read, _)| *read == axis);
        let fixed = read.iter().zip(&strides).filter(|((axis, _), _)| !self.order.contains(axis));
        let skipped: usize = fixed.map(|((axis, _), stride)| self.place[*axis] * stride).sum();
        let from: Vec<usize> = self.order.iter().filter_map(|&axis| along(axis).map(|n| strides[n])).collect();
        let shape: Vec<usize> = std::iter::once(end - start).chain(self.shape[1..].iter().copied()).collect();
        let mut turned = memory::zeroed(self.dataset.name(), self.layer() * (end - start)).map_err(|e| failed(e.to_string()))?;
        strided::copy(bytes.get(skipped..).unwrap_or_default(), &from, &mut turned, &strided::strides(&shape, N), &shape, N);
        Ok(turned)
    }
}

impl Parts for Layers {
    /// The declared size: numbers that are not stored have the fill value.
    fn most(&self) -> u64 {
        self.whole()
    }

    fn whole(&self) -> u64 {
        (self.layer() as u64).saturating_mul(self.shape[0] as u64)
    }

    fn each(&self) -> u64 {
        self.layer() as u64 * self.deep as u64
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        match self.size {
            1 => self.numbers::<1>(index),
            2 => self.numbers::<2>(index),
            4 => self.numbers::<4>(index),
            _ => self.numbers::<8>(index),
        }
    }
}
