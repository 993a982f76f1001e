//! Numbers that are no voxels of a device, integers of more than 16 bits and floats of 16 and 64: converted on reading, the smallest one to 0, so that
//! voxels are as fine as the data's own range, wherever that lies.

use super::spool::Spool;
use super::voxels::{Endian, Number, ScalarType, Voxel, is_valid};
use super::{Grid, Rescale, Storage, Volume};
use crate::error::Error;
use crate::memory;
use bytemuck::Zeroable;
use rayon::prelude::*;

/// Numbers that one core looks at together.
const BLOCK: usize = 1 << 16;
/// Numbers that are converted before they are written to a file.
const PIECE: usize = 1 << 22;
/// Numbers of which it is looked at where most of them lie.
const ASKED: usize = 1 << 16;
/// Shares of numbers that are below and above where most of them lie.
const ODD_SHARE: f64 = 0.05;
/// Steps that voxels must have where most of them lie: those of 8 bits.
const STEPS: f64 = 256.0;
/// Whole numbers up to here are floats.
const WHOLE_FLOATS: f64 = 16_777_216.0;

/// Numbers as they lie in a file or in memory.
#[derive(Clone, Copy)]
pub(super) struct Numbers<'a> {
    pub bytes: &'a [u8],
    pub scalar: ScalarType,
    pub endian: Endian,
}

impl Numbers<'_> {
    fn len(self) -> usize {
        self.bytes.len() / self.scalar.bytes()
    }

    /// Number `index`; NaN where it is invalid.
    pub fn get(self, index: usize) -> f64 {
        fn number<T: Number>(numbers: Numbers, index: usize) -> f64 {
            let at = index * size_of::<T>();
            let number = bytemuck::pod_read_unaligned::<T>(&numbers.bytes[at..at + size_of::<T>()]);
            if numbers.endian == Endian::NATIVE { number } else { number.swapped() }.value()
        }
        let number = match self.scalar {
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
        };
        if is_valid(number) { number } else { f64::NAN }
    }

    /// Smallest and largest valid number.
    pub fn range(self) -> Option<(f64, f64)> {
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        let within = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        // `min` and `max` leave NaN out.
        let of = |range, i| within(range, (self.get(i), self.get(i)));
        let range = (0..self.len()).into_par_iter().with_min_len(BLOCK).fold(|| empty, of).reduce(|| empty, within);
        (range.0 <= range.1).then_some(range)
    }

    /// All numbers less `smallest`, as voxels; in a file where they are more than `most` bytes.
    fn less<T: Voxel + Zeroable>(self, name: &str, smallest: f64, most: Option<u64>) -> Result<Storage<'static>, Error> {
        let convert = |first: usize, voxels: &mut [T]| {
            voxels.par_chunks_mut(BLOCK).enumerate().for_each(|(block, voxels)| {
                for (i, voxel) in voxels.iter_mut().enumerate() {
                    *voxel = T::nearest(self.get(first + block * BLOCK + i) - smallest);
                }
            });
        };
        let bytes = (self.len() * size_of::<T>()) as u64;
        if most.is_none_or(|most| bytes <= most) {
            let mut voxels = memory::zeroed::<T>(name, self.len())?;
            convert(0, &mut voxels);
            return Ok(voxels.into());
        }
        let mut spool = Spool::new(name, bytes)?;
        let mut piece = memory::zeroed::<T>(name, PIECE.min(self.len()))?;
        for first in (0..self.len()).step_by(PIECE) {
            let voxels = &mut piece[..PIECE.min(self.len() - first)];
            convert(first, voxels);
            spool.put(bytemuck::cast_slice(voxels))?;
        }
        Ok(Storage::from_bytes(spool.mapped()?, T::TYPE))
    }

    /// Where most numbers lie, judged by some of them.
    fn bulk(self) -> Option<(f64, f64)> {
        let every = self.len().div_ceil(ASKED);
        let mut some: Vec<f64> = (0..self.len()).step_by(every).map(|i| self.get(i)).filter(|n| !n.is_nan()).collect();
        some.sort_by(f64::total_cmp);
        let at = |share: f64| some.get((share * (some.len() as f64 - 1.0)).round() as usize).copied();
        at(ODD_SHARE).zip(at(1.0 - ODD_SHARE))
    }
}

/// A volume of such numbers; `rescale` is what makes them values, `most` how many bytes of memory its voxels may take.
pub(super) fn volume(
    name: String,
    grid: Grid,
    numbers: Numbers,
    rescale: Rescale,
    most: Option<u64>,
) -> Result<Volume<'static>, Error> {
    let range = numbers.range().unwrap_or((0.0, 0.0));
    let storage = storage(&name, numbers, range, most)?;
    let rescale = Rescale::new(rescale.slope(), rescale.value(range.0))?;
    Ok(Volume::new(name, grid, storage)?.with_rescale(rescale))
}

/// Voxels of such numbers, less the smallest of the range of all.
pub(super) fn storage(
    name: &str,
    numbers: Numbers,
    (smallest, largest): (f64, f64),
    most: Option<u64>,
) -> Result<Storage<'static>, Error> {
    let width = largest - smallest;
    let whole = !matches!(numbers.scalar, ScalarType::Float16 | ScalarType::Float64);
    if whole && width <= f64::from(u8::MAX) {
        numbers.less::<u8>(name, smallest, most)
    } else if whole && width <= f64::from(u16::MAX) {
        numbers.less::<u16>(name, smallest, most)
    } else {
        if whole && width > WHOLE_FLOATS {
            let step = (width / WHOLE_FLOATS).log2().ceil().exp2();
            tracing::warn!(
                "{name}: voxels from {smallest} to {largest} become floats: their values are off by up to {}",
                step / 2.0
            );
        }
        warn_if_coarse(name, numbers, smallest);
        numbers.less::<f32>(name, smallest, most)
    }
}

/// Warns where a few numbers far from the rest make the range so wide that floats cannot tell the rest apart.
fn warn_if_coarse(name: &str, numbers: Numbers, smallest: f64) {
    let Some((lo, hi)) = numbers.bulk() else { return };
    let far = (hi - smallest) as f32;
    let steps = (hi - lo) / f64::from(far.next_up() - far);
    if lo < hi && steps < STEPS {
        tracing::warn!(
            "{name}: most voxels lie from {lo} to {hi}, but the smallest is {smallest}: floats that hold both tell only {steps:.0} \
             values apart there; replace what is far from the rest"
        );
    }
}
