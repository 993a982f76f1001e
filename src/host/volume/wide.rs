//! Conversion of number types without device support: 32- and 64-bit integers, 16- and 64-bit floats.
//!
//! The smallest number becomes 0. The precision of the voxels is therefore relative to the range of the data, not to their magnitude.

use super::extent::Scaling;
use super::missing_data::MissingData;
use super::spool::Spool;
use super::voxels::{Endian, Number, ScalarType, Voxel, is_valid};
use super::{Grid, Rescale, Storage, Volume};
use crate::error::Error;
use crate::memory;
use crate::numbers::shortened;
use bytemuck::Zeroable;
use rayon::prelude::*;

/// Numbers per unit of parallel work.
const BLOCK: usize = 1 << 16;
/// Numbers converted at a time before they are written to a temporary file.
const PIECE: usize = 1 << 22;
/// Number of samples used to estimate the bulk of the distribution.
const ASKED: usize = 1 << 16;
/// Fraction of the numbers excluded from the bulk at either end.
const ODD_SHARE: f64 = 0.05;
/// Least number of distinguishable values in the bulk that needs no warning: 8 bits.
const STEPS: f64 = 256.0;
/// Largest integer up to which float32 represents all integers.
const WHOLE_FLOATS: f64 = 16_777_216.0;

/// Numbers in a file or in memory.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'a> {
    pub bytes: &'a [u8],
    pub scalar: ScalarType,
    pub endian: Endian,
    /// Which of them stand for missing voxels, if there are such.
    pub(super) missing: Option<&'a MissingData>,
}

impl<'a> Numbers<'a> {
    /// Numbers of which none is missing.
    pub fn new(bytes: &'a [u8], scalar: ScalarType, endian: Endian) -> Self {
        Self { bytes, scalar, endian, missing: None }
    }
}

impl Numbers<'_> {
    /// How many there are.
    pub fn count(self) -> usize {
        self.bytes.len() / self.scalar.bytes()
    }

    /// Number `index`; NaN if it is invalid or missing.
    pub fn get(self, index: usize) -> f64 {
        let number = self.stored(index);
        if is_valid(number) && self.missing.is_none_or(|missing| !missing.has(number)) { number } else { f64::NAN }
    }

    /// Whether number `index` stands for a missing voxel.
    pub fn is_missing(self, index: usize) -> bool {
        self.missing.is_some_and(|missing| missing.has(self.stored(index)))
    }

    /// Whether some voxels are missing.
    pub fn has_missing(self) -> bool {
        self.missing.is_some() && (0..self.count()).into_par_iter().with_min_len(BLOCK).any(|index| self.is_missing(index))
    }

    /// Number `index`, valid or not.
    pub fn stored(self, index: usize) -> f64 {
        fn number<T: Number>(numbers: Numbers, index: usize) -> f64 {
            let at = index * size_of::<T>();
            let number = bytemuck::pod_read_unaligned::<T>(&numbers.bytes[at..at + size_of::<T>()]);
            if numbers.endian == Endian::NATIVE { number } else { number.swapped() }.value()
        }
        match self.scalar {
            ScalarType::Uint8 => number::<u8>(self, index),
            ScalarType::Int8 => number::<i8>(self, index),
            ScalarType::Uint16 => number::<u16>(self, index),
            ScalarType::Int16 => number::<i16>(self, index),
            ScalarType::Uint32 => number::<u32>(self, index),
            ScalarType::Int32 => number::<i32>(self, index),
            ScalarType::Uint64 => number::<u64>(self, index),
            ScalarType::Int64 => number::<i64>(self, index),
            ScalarType::Float16 => number::<half::f16>(self, index),
            ScalarType::Float32 => number::<f32>(self, index),
            ScalarType::Float64 => number::<f64>(self, index),
        }
    }

    /// Smallest and largest valid number.
    pub fn range(self) -> Option<(f64, f64)> {
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        let within = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        // `min` and `max` ignore NaN.
        let of = |range, i| within(range, (self.get(i), self.get(i)));
        let range = (0..self.count()).into_par_iter().with_min_len(BLOCK).fold(|| empty, of).reduce(|| empty, within);
        (range.0 <= range.1).then_some(range)
    }

    /// Voxels of all numbers minus `smallest`, in a temporary file if they exceed `most` bytes.
    fn less<T: Voxel + Zeroable>(self, name: &str, smallest: f64, most: Option<u64>) -> Result<Storage<'static>, Error> {
        converted(name, self.count(), most, |i| T::nearest(self.get(i) - smallest))
    }

    /// Range of the bulk of the numbers, estimated from a sample.
    fn bulk(self) -> Option<(f64, f64)> {
        let every = self.count().div_ceil(ASKED);
        let mut some: Vec<f64> = (0..self.count()).step_by(every).map(|i| self.get(i)).filter(|n| !n.is_nan()).collect();
        some.sort_by(f64::total_cmp);
        let at = |share: f64| some.get((share * (some.len() as f64 - 1.0)).round() as usize).copied();
        at(ODD_SHARE).zip(at(1.0 - ODD_SHARE))
    }
}

/// `count` voxels, in a temporary file if they exceed `most` bytes.
fn converted<T: Voxel + Zeroable>(
    name: &str,
    count: usize,
    most: Option<u64>,
    voxel: impl Fn(usize) -> T + Sync,
) -> Result<Storage<'static>, Error> {
    let convert = |first: usize, voxels: &mut [T]| {
        voxels.par_chunks_mut(BLOCK).enumerate().for_each(|(block, voxels)| {
            voxels.iter_mut().enumerate().for_each(|(i, to)| *to = voxel(first + block * BLOCK + i));
        });
    };
    let bytes = (count * size_of::<T>()) as u64;
    if most.is_none_or(|most| bytes <= most) {
        let mut voxels = memory::zeroed::<T>(name, count)?;
        convert(0, &mut voxels);
        return Ok(voxels.into());
    }
    let mut spool = Spool::new(name, bytes)?;
    let mut piece = memory::zeroed::<T>(name, PIECE.min(count))?;
    for first in (0..count).step_by(PIECE) {
        let voxels = &mut piece[..PIECE.min(count - first)];
        convert(first, voxels);
        spool.put(bytemuck::cast_slice(voxels))?;
    }
    Ok(Storage::from_bytes(spool.mapped()?, T::TYPE))
}

/// The volume of floats that devices cannot hold as they are; `None` if they can. Other arguments as for [`volume`].
pub(super) fn scaled(
    name: &str,
    grid: &Grid,
    number: impl Fn(usize) -> f64 + Sync,
    rescale: Rescale,
    most: Option<u64>,
) -> Result<Option<Volume<'static>>, Error> {
    let count = grid.voxel_count();
    let Some(scaling) = Scaling::of(count, &number) else { return Ok(None) };
    let storage = converted(name, count, most, |i| scaling.stored(number(i)))?;
    let rescale = Rescale::new(rescale.slope() * scaling.unit, rescale.value(scaling.lowest))?;
    Ok(Some(Volume::new(name, grid.clone(), storage)?.with_rescale(rescale)))
}

/// Converts numbers to a volume. `rescale` maps the numbers to values; `most` is the memory limit of the voxels in bytes.
pub(super) fn volume(
    name: String,
    grid: Grid,
    numbers: Numbers,
    rescale: Rescale,
    most: Option<u64>,
) -> Result<Volume<'static>, Error> {
    let number = |i: usize| if numbers.is_missing(i) { f64::NAN } else { numbers.stored(i) };
    if matches!(numbers.scalar, ScalarType::Float32 | ScalarType::Float64)
        && let Some(volume) = scaled(&name, &grid, number, rescale, most)?
    {
        return Ok(volume);
    }
    let range = numbers.range().unwrap_or((0.0, 0.0));
    let (storage, offset) = storage(&name, numbers, range, most)?;
    let rescale = Rescale::new(rescale.slope(), rescale.value(offset))?;
    Ok(Volume::new(name, grid, storage)?.with_rescale(rescale))
}

/// Converts numbers to voxels: the number minus an offset, which is returned. It is the smallest of the range, or 0 if floats hold all numbers
/// of the type. Missing voxels are NaN, so that voxels are floats if the numbers declare such.
pub(super) fn storage(
    name: &str,
    numbers: Numbers,
    (smallest, largest): (f64, f64),
    most: Option<u64>,
) -> Result<(Storage<'static>, f64), Error> {
    if numbers.scalar.voxel_type().is_some() {
        return Ok((numbers.less::<f32>(name, 0.0, most)?, 0.0));
    }
    let width = largest - smallest;
    let whole = !matches!(numbers.scalar, ScalarType::Float16 | ScalarType::Float64);
    let narrow = whole && numbers.missing.is_none();
    let storage = if narrow && width <= f64::from(u8::MAX) {
        numbers.less::<u8>(name, smallest, most)
    } else if narrow && width <= f64::from(u16::MAX) {
        numbers.less::<u16>(name, smallest, most)
    } else {
        if whole && width > WHOLE_FLOATS {
            let step = (width / WHOLE_FLOATS).log2().ceil().exp2();
            tracing::warn!(
                "{name}: converting voxels from {} to {} to floats, with rounding errors of up to {}",
                shortened(smallest),
                shortened(largest),
                shortened(step / 2.0)
            );
        }
        warn_if_coarse(name, numbers, smallest);
        numbers.less::<f32>(name, smallest, most)
    };
    Ok((storage?, smallest))
}

/// Warns if outliers widen the range so much that float32 cannot distinguish the other values.
fn warn_if_coarse(name: &str, numbers: Numbers, smallest: f64) {
    let Some((lo, hi)) = numbers.bulk() else { return };
    let far = (hi - smallest) as f32;
    let steps = (hi - lo) / f64::from(far.next_up() - far);
    if lo < hi && steps < STEPS {
        tracing::warn!(
            "{name}: most voxels lie between {} and {}, but the smallest is {}: floats distinguish only {steps:.0} values in that \
             range; replace the outliers",
            shortened(lo),
            shortened(hi),
            shortened(smallest)
        );
    }
}
