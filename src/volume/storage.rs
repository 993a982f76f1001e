//! Voxels wherever they lie.

use super::voxels::{Endian, Number, Voxel, VoxelType, Voxels, is_valid, with_voxel_type};
use rayon::prelude::*;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

/// Voxels of one type that are owned, borrowed, shared or mapped: x fastest, then y, then z without gaps, unless strides say otherwise.
/// Cheap to clone: clones share the voxels.
///
/// Made from a vector, a slice, an `Arc` of either, [`Voxels`], or by [`Storage::shared`] and [`Storage::from_bytes`] from anything that
/// can show a slice, as a mapped file or a foreign array.
#[derive(Clone)]
pub struct Storage<'a> {
    owner: Arc<dyn AsRef<[u8]> + Send + Sync + 'a>,
    voxel_type: VoxelType,
    endian: Endian,
    /// Byte of the first voxel.
    first: usize,
    /// Bytes from a voxel to its neighbours along x, y, z.
    strides: Option<[isize; 3]>,
}

/// Shows values as bytes.
struct Bytes<T, O>(O, PhantomData<fn() -> T>);

impl<T: Voxel, O: AsRef<[T]>> AsRef<[u8]> for Bytes<T, O> {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(self.0.as_ref())
    }
}

impl<'a> Storage<'a> {
    /// Voxels that something owns and lends.
    pub fn shared<T: Voxel>(owner: impl AsRef<[T]> + Send + Sync + 'a) -> Self {
        Self::from_bytes(Bytes(owner, PhantomData), T::TYPE)
    }

    /// Voxels in bytes, which need not be aligned; in this machine's order.
    pub fn from_bytes(owner: impl AsRef<[u8]> + Send + Sync + 'a, voxel_type: VoxelType) -> Self {
        Self { owner: Arc::new(owner), voxel_type, endian: Endian::NATIVE, first: 0, strides: None }
    }

    /// The same bytes in another order.
    pub fn with_endian(self, endian: Endian) -> Self {
        Self { endian, ..self }
    }

    /// The same bytes with the first voxel at byte `first`, after a header for instance.
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// The same bytes with voxels `strides` bytes apart along x, y, z: of any order, with gaps, backwards (then
    /// [`first`](Self::with_first) is that of voxel (0, 0, 0) all the same).
    pub fn with_strides(self, strides: [isize; 3]) -> Self {
        Self { strides: Some(strides), ..self }
    }

    /// Type of the voxels.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    fn bytes(&self) -> &[u8] {
        (*self.owner).as_ref()
    }

    /// How many voxels there are, as far as storage without strides can tell.
    pub(super) fn count(&self) -> Option<u64> {
        let bytes = self.bytes().len().saturating_sub(self.first);
        self.strides.is_none().then(|| bytes as u64 / self.voxel_type.bytes() as u64)
    }

    /// The voxels of a grid of `dims`; nothing if not all of its places are in the bytes.
    pub(super) fn placed(self, dims: [usize; 3]) -> Option<Placed<'a>> {
        let size = self.voxel_type.bytes();
        let along = |i: usize| dims[..i].iter().try_fold(size as isize, |step, &n| step.checked_mul(isize::try_from(n).ok()?));
        let without_gaps = [along(0)?, along(1)?, along(2)?];
        let strides = self.strides.unwrap_or(without_gaps);
        let steps = || strides.into_iter().zip(dims).map(|(stride, n)| stride as i128 * (n as i128 - 1));
        let least = self.first as i128 + steps().map(|s| s.min(0)).sum::<i128>();
        let most = self.first as i128 + steps().map(|s| s.max(0)).sum::<i128>() + size as i128;
        let fits = least >= 0 && most <= self.bytes().len() as i128;
        let swapped = self.endian != Endian::NATIVE && size > 1;
        fits.then(|| Placed { dense: strides == without_gaps, swapped, storage: self, dims, strides })
    }
}

impl fmt::Debug for Storage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes of {}", self.bytes().len(), self.voxel_type)
    }
}

impl<T: Voxel> From<Vec<T>> for Storage<'static> {
    fn from(values: Vec<T>) -> Self {
        Self::shared::<T>(values)
    }
}

impl<T: Voxel> From<Arc<[T]>> for Storage<'static> {
    fn from(values: Arc<[T]>) -> Self {
        Self::shared::<T>(values)
    }
}

impl<T: Voxel> From<Arc<Vec<T>>> for Storage<'static> {
    fn from(values: Arc<Vec<T>>) -> Self {
        Self::shared::<T>(Owned(values))
    }
}

/// Shows what an `Arc` of a vector holds.
struct Owned<T>(Arc<Vec<T>>);

impl<T> AsRef<[T]> for Owned<T> {
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<'a, T: Voxel> From<&'a [T]> for Storage<'a> {
    fn from(values: &'a [T]) -> Self {
        Self::shared::<T>(values)
    }
}

impl<'a, T: Voxel> From<&'a Vec<T>> for Storage<'a> {
    fn from(values: &'a Vec<T>) -> Self {
        Self::shared::<T>(values.as_slice())
    }
}

impl From<Voxels> for Storage<'static> {
    fn from(voxels: Voxels) -> Self {
        match voxels {
            Voxels::Uint8(values) => values.into(),
            Voxels::Int8(values) => values.into(),
            Voxels::Uint16(values) => values.into(),
            Voxels::Int16(values) => values.into(),
            Voxels::Float32(values) => values.into(),
        }
    }
}

/// Voxels that are looked at together by one core, and copied together.
const BLOCK: usize = 1 << 18;

/// Storage that holds every voxel of a grid. Voxels are counted x fastest, then y, then z, however they lie.
#[derive(Clone, Debug)]
pub(super) struct Placed<'a> {
    storage: Storage<'a>,
    dims: [usize; 3],
    strides: [isize; 3],
    /// Whether voxels follow each other without gaps.
    dense: bool,
    swapped: bool,
}

impl<'a> Placed<'a> {
    /// The voxels of a box.
    pub fn part(&self, first: [usize; 3], dims: [usize; 3]) -> Self {
        let offset: isize = (0..3).map(|i| first[i] as isize * self.strides[i]).sum();
        let storage = Storage { first: self.storage.first.wrapping_add_signed(offset), ..self.storage.clone() };
        let [x, y, _] = dims.map(|n| n as isize);
        let size = self.storage.voxel_type.bytes() as isize;
        Self { dense: self.strides == [size, size * x, size * x * y], dims, storage, ..*self }
    }
}

impl Placed<'_> {
    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// The number in voxel `index`.
    pub fn number(&self, index: usize) -> f64 {
        let at = if self.dense { self.storage.first + index * self.storage.voxel_type.bytes() } else { self.byte(index) };
        with_voxel_type!(self.storage.voxel_type, T => self.read::<T>(self.storage.bytes(), at).into())
    }

    fn byte(&self, index: usize) -> usize {
        let [x, y, _] = self.dims;
        let place = [index % x, index / x % y, index / x / y];
        let offset: isize = (0..3).map(|i| place[i] as isize * self.strides[i]).sum();
        self.storage.first.wrapping_add_signed(offset)
    }

    fn read<T: Number>(&self, bytes: &[u8], at: usize) -> T {
        let number = bytemuck::pod_read_unaligned::<T>(&bytes[at..at + size_of::<T>()]);
        if self.swapped { number.swapped() } else { number }
    }

    /// All voxels as they lie, if they are as a device wants them: without gaps, in this machine's byte order.
    pub fn as_bytes(&self) -> Option<&[u8]> {
        let as_wanted = self.dense && !self.swapped;
        let first = self.storage.first;
        as_wanted.then(|| &self.storage.bytes()[first..first + self.len() * self.storage.voxel_type.bytes()])
    }

    /// All voxels as values of their type, if they lie as such.
    pub fn as_values<T: Voxel>(&self) -> Option<&[T]> {
        self.as_bytes().and_then(|bytes| bytemuck::try_cast_slice(bytes).ok())
    }

    /// Voxels `range` one after the other.
    fn gathered<T: Voxel>(&self, range: Range<usize>) -> Vec<T> {
        let bytes = self.storage.bytes();
        let mut values = Vec::with_capacity(range.len());
        let mut index = range.start;
        while index < range.end {
            let in_row = (self.dims[0] - index % self.dims[0]).min(range.end - index);
            let start = self.byte(index);
            values.extend((0..in_row).map(|i| self.read::<T>(bytes, start.wrapping_add_signed(i as isize * self.strides[0]))));
            index += in_row;
        }
        values
    }

    /// Calls `visit` with blocks of voxels on all cores; what it returns, in their order.
    pub fn map_blocks<T: Voxel, R: Send>(&self, visit: impl Fn(&[T]) -> R + Sync) -> Vec<R> {
        if let Some(values) = self.as_values::<T>() {
            return values.par_chunks(BLOCK).map(&visit).collect();
        }
        let blocks = (0..self.len().div_ceil(BLOCK)).into_par_iter();
        blocks.map(|n| visit(&self.gathered(n * BLOCK..((n + 1) * BLOCK).min(self.len())))).collect()
    }

    /// Smallest and largest valid number, if there is one, and how many voxels are invalid.
    pub fn valid_range(&self) -> (Option<(f64, f64)>, usize) {
        fn block<T: Voxel>(values: &[T]) -> (Option<(f64, f64)>, usize) {
            let valid = |v: &T| T::TYPE != VoxelType::Float32 || is_valid((*v).into());
            let all = || values.iter().copied().filter(valid);
            let Some(first) = all().next() else { return (None, values.len()) };
            let within = |(lo, hi): (T, T), v: T| (if v < lo { v } else { lo }, if v > hi { v } else { hi });
            let (lo, hi) = all().fold((first, first), within);
            (Some((lo.into(), hi.into())), values.len() - all().count())
        }
        let blocks = with_voxel_type!(self.storage.voxel_type, T => self.map_blocks::<T, _>(block));
        blocks.into_iter().fold((None, 0), |(range, invalid), (more, also)| (union(range, more), invalid + also))
    }

    /// Smallest and largest number in a box, `from` to `to` inclusive, `instead` standing for invalid ones.
    pub fn range_in(&self, from: [usize; 3], to: [usize; 3], instead: f64) -> (f64, f64) {
        let all = (f64::INFINITY, f64::NEG_INFINITY);
        let rows = (from[2]..=to[2]).flat_map(|z| (from[1]..=to[1]).map(move |y| (y, z)));
        let starts = rows.map(|(y, z)| from[0] + self.dims[0] * (y + self.dims[1] * z));
        let count = to[0] - from[0] + 1;
        with_voxel_type!(self.storage.voxel_type, T => {
            let values = self.as_values::<T>();
            starts.fold(all, |range, start| match values {
                Some(values) => range_of(range, &values[start..start + count], instead),
                None => range_of(range, &self.gathered::<T>(start..start + count), instead),
            })
        })
    }

    /// Calls `visit` with all voxels as a device wants them, in pieces and in order, `instead` in place of invalid ones (`None`: there
    /// are none), and the byte at which each piece begins.
    pub fn for_each_piece<E>(&self, instead: Option<f64>, mut visit: impl FnMut(usize, &[u8]) -> Result<(), E>) -> Result<(), E> {
        if let (Some(bytes), None) = (self.as_bytes(), instead) {
            return visit(0, bytes);
        }
        with_voxel_type!(self.storage.voxel_type, T => {
            for start in (0..self.len()).step_by(BLOCK) {
                let mut values = self.gathered::<T>(start..(start + BLOCK).min(self.len()));
                if let Some(instead) = instead {
                    values.iter_mut().filter(|v| !is_valid((**v).into())).for_each(|v| *v = T::nearest(instead));
                }
                visit(start * size_of::<T>(), bytemuck::cast_slice(&values))?;
            }
            Ok(())
        })
    }
}

/// A range with more numbers in it.
fn range_of<T: Voxel>(range: (f64, f64), numbers: &[T], instead: f64) -> (f64, f64) {
    numbers.iter().fold(range, |(lo, hi), &number| {
        let number: f64 = number.into();
        let number = if T::TYPE != VoxelType::Float32 || is_valid(number) { number } else { instead };
        (if number < lo { number } else { lo }, if number > hi { number } else { hi })
    })
}

fn union(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}
