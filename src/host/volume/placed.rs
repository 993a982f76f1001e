//! Storage of all voxels of a grid.

use super::storage::Storage;
use super::voxels::{Number, Voxel, VoxelType, is_valid, with_voxel_type};
use crate::progress::Task;
use rayon::prelude::*;
use std::ops::Range;

/// Voxels per block, the unit of parallel work and of copies.
const BLOCK: usize = 1 << 18;
/// Blocks per core that are gathered before they are passed on.
const PER_THREAD: usize = 4;

/// Storage that contains every voxel of a grid. Indices count x fastest, then y, then z, regardless of the layout.
#[derive(Clone, Debug)]
pub(super) struct Placed<'a> {
    storage: Storage<'a>,
    dims: [usize; 3],
    strides: [isize; 3],
    /// Whether voxels are consecutive, without gaps.
    dense: bool,
    swapped: bool,
}

impl<'a> Placed<'a> {
    /// Voxels with strides in bytes, all inside `storage`. `swapped`: whether the byte order is not native.
    pub fn new(storage: Storage<'a>, dims: [usize; 3], strides: [isize; 3], swapped: bool) -> Self {
        let [x, y, _] = dims.map(|n| n as isize);
        let size = storage.voxel_type().bytes() as isize;
        Self { dense: strides == [size, size * x, size * x * y], storage, dims, strides, swapped }
    }

    /// The voxels of a box.
    pub fn part(&self, first: [usize; 3], dims: [usize; 3]) -> Self {
        let offset: isize = (0..3).map(|i| first[i] as isize * self.strides[i]).sum();
        Self::new(self.storage.moved(offset), dims, self.strides, self.swapped)
    }
}

impl Placed<'_> {
    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    #[cfg(feature = "mpi")]
    pub fn voxel_type(&self) -> VoxelType {
        self.storage.voxel_type()
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// The stored number of voxel `index`.
    pub fn number(&self, index: usize) -> f64 {
        let at = if self.dense { self.storage.first() + index * self.storage.voxel_type().bytes() } else { self.byte(index) };
        with_voxel_type!(self.storage.voxel_type(), T => self.read::<T>(at).into())
    }

    fn byte(&self, index: usize) -> usize {
        let [x, y, _] = self.dims;
        let place = [index % x, index / x % y, index / x / y];
        let offset: isize = (0..3).map(|i| place[i] as isize * self.strides[i]).sum();
        self.storage.first().wrapping_add_signed(offset)
    }

    fn read<T: Number>(&self, at: usize) -> T {
        let mut number = T::zeroed();
        self.storage.copy(at, bytemuck::bytes_of_mut(&mut number));
        if self.swapped { number.swapped() } else { number }
    }

    /// All voxels as bytes, if they are stored in device layout: without gaps, in native byte order.
    pub fn as_bytes(&self) -> Option<&[u8]> {
        let as_wanted = self.dense && !self.swapped;
        let first = self.storage.first();
        let bytes = self.storage.bytes().filter(|_| as_wanted)?;
        Some(&bytes[first..first + self.len() * self.storage.voxel_type().bytes()])
    }

    /// All voxels as values, if they are stored in device layout and aligned.
    pub fn as_values<T: Voxel>(&self) -> Option<&[T]> {
        self.as_bytes().and_then(|bytes| bytemuck::try_cast_slice(bytes).ok())
    }

    /// Copies voxels `range`. Consecutive voxels of a row are copied at once.
    fn gathered<T: Voxel>(&self, range: Range<usize>) -> Vec<T> {
        let mut values = vec![T::zeroed(); range.len()];
        let side_by_side = self.strides[0] == size_of::<T>() as isize;
        let mut index = range.start;
        while index < range.end {
            let in_row = (self.dims[0] - index % self.dims[0]).min(range.end - index);
            let start = self.byte(index);
            let row = &mut values[index - range.start..][..in_row];
            if side_by_side {
                self.storage.copy(start, bytemuck::cast_slice_mut(row));
            } else {
                for (i, value) in row.iter_mut().enumerate() {
                    let at = start.wrapping_add_signed(i as isize * self.strides[0]);
                    self.storage.copy(at, bytemuck::bytes_of_mut(value));
                }
            }
            index += in_row;
        }
        if self.swapped {
            values.iter_mut().for_each(|value| *value = value.swapped());
        }
        values
    }

    /// Maps blocks of voxels in parallel. Returns the results in order. The task counts bytes.
    pub fn map_blocks<T: Voxel, R: Send + Default>(&self, task: &Task, visit: impl Fn(&[T]) -> R + Sync) -> Vec<R> {
        let visit = |values: &[T]| task.work(size_of_val(values) as u64, || visit(values));
        if let Some(values) = self.as_values::<T>() {
            return values.par_chunks(BLOCK).map(&visit).collect();
        }
        let blocks = (0..self.len().div_ceil(BLOCK)).into_par_iter();
        blocks.map(|n| visit(&self.gathered(n * BLOCK..((n + 1) * BLOCK).min(self.len())))).collect()
    }

    /// Range of the valid voxels, if any, and number of invalid ones. The task counts bytes.
    pub fn valid_range(&self, task: &Task) -> (Option<(f64, f64)>, usize) {
        fn block<T: Voxel>(values: &[T]) -> (Option<(f64, f64)>, usize) {
            let valid = |v: &T| T::TYPE != VoxelType::Float32 || is_valid(v.value());
            let all = || values.iter().copied().filter(valid);
            let Some(first) = all().next() else { return (None, values.len()) };
            let within = |(lo, hi): (T, T), v: T| (if v < lo { v } else { lo }, if v > hi { v } else { hi });
            let (lo, hi) = all().fold((first, first), within);
            (Some((lo.value(), hi.value())), values.len() - all().count())
        }
        let blocks = with_voxel_type!(self.storage.voxel_type(), T => self.map_blocks::<T, _>(task, block));
        blocks.into_iter().fold((None, 0), |(range, invalid), (more, also)| (union(range, more), invalid + also))
    }

    /// Smallest and largest number at each x of the rows `from` to `to` (y, z), inclusive. `instead` replaces invalid numbers.
    pub fn column_ranges(&self, from: [usize; 2], to: [usize; 2], instead: f64) -> Vec<(f64, f64)> {
        fn widen<T: Voxel>(ranges: &mut [(T, T)], row: &[T], instead: T) {
            for ((lo, hi), &number) in ranges.iter_mut().zip(row) {
                let valid = T::TYPE != VoxelType::Float32 || is_valid(number.value());
                let number = if valid { number } else { instead };
                (*lo, *hi) = (if number < *lo { number } else { *lo }, if number > *hi { number } else { *hi });
            }
        }
        let [x, y, _] = self.dims;
        let rows = (from[1]..=to[1]).flat_map(|z| (from[0]..=to[0]).map(move |j| x * (j + y * z)));
        with_voxel_type!(self.storage.voxel_type(), T => {
            let (values, instead) = (self.as_values::<T>(), T::nearest(instead));
            let mut ranges = Vec::new();
            for start in rows {
                let gathered: Vec<T>;
                let row = match values {
                    Some(values) => &values[start..start + x],
                    None => {
                        gathered = self.gathered(start..start + x);
                        &gathered
                    }
                };
                if ranges.is_empty() {
                    let valid = |v: T| T::TYPE != VoxelType::Float32 || is_valid(v.into());
                    ranges = row.iter().map(|&v| if valid(v) { (v, v) } else { (instead, instead) }).collect();
                }
                widen(&mut ranges, row, instead);
            }
            ranges.into_iter().map(|(lo, hi)| (lo.into(), hi.into())).collect()
        })
    }

    /// Calls `visit` with consecutive pieces of all voxels in device layout, and the byte offset of each piece. `instead` replaces invalid
    /// voxels; `None` keeps them.
    pub fn for_each_piece<E>(&self, instead: Option<f64>, mut visit: impl FnMut(usize, &[u8]) -> Result<(), E>) -> Result<(), E> {
        if let (Some(bytes), None) = (self.as_bytes(), instead) {
            return visit(0, bytes);
        }
        let blocks = self.len().div_ceil(BLOCK);
        let at_once = PER_THREAD * rayon::current_num_threads();
        with_voxel_type!(self.storage.voxel_type(), T => {
            let gathered = |block: usize| {
                let mut values = self.gathered::<T>(block * BLOCK..((block + 1) * BLOCK).min(self.len()));
                if let Some(instead) = instead {
                    values.iter_mut().filter(|v| !is_valid((**v).into())).for_each(|v| *v = T::nearest(instead));
                }
                values
            };
            for first in (0..blocks).step_by(at_once) {
                let pieces: Vec<Vec<T>> = (first..(first + at_once).min(blocks)).into_par_iter().map(gathered).collect();
                for (block, values) in (first..).zip(pieces) {
                    visit(block * BLOCK * size_of::<T>(), bytemuck::cast_slice(&values))?;
                }
            }
            Ok(())
        })
    }
}

fn union(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}
