//! Ids of voxels: which there are, and their conversion to indices.

use crate::error::Error;
use crate::memory;
use crate::progress::Task;
use crate::volume::spool::Spool;
use crate::volume::voxels::Voxel;
use crate::volume::wide::Numbers;
use crate::volume::{Rescale, Storage};
use bytemuck::Zeroable;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Largest number of different ids besides the background: indices have 16 bits.
pub(super) const MOST_IDS: usize = u16::MAX as usize;
/// Largest number of different negative ids, which count as the background.
const MOST_NEGATIVE: usize = 8;
/// Voxels per unit of parallel work.
const BLOCK: usize = 1 << 18;
/// Voxels converted at a time before they are written to a temporary file.
const PIECE: usize = 1 << 22;

/// The ids of the voxels of a file.
pub(super) struct Ids<'a> {
    pub path: &'a Path,
    pub dims: [usize; 3],
    pub numbers: Numbers<'a>,
    pub rescale: Rescale,
}

/// A voxel without an id.
struct Bad {
    index: usize,
    value: f64,
}

/// The number of voxels of each id of some voxels.
type Counted = Result<HashMap<i64, u64>, Refused>;

/// Why ids cannot be counted.
enum Refused {
    Bad(Bad),
    TooMany,
    TooManyNegative,
}

impl Ids<'_> {
    /// The id of a voxel, if its value is a whole number of up to 32 bits. Missing voxels are background.
    fn get(&self, index: usize) -> Result<i64, Bad> {
        if self.numbers.is_missing(index) {
            return Ok(0);
        }
        let value = self.rescale.value(self.numbers.get(index));
        let id = value as i64;
        if id as f64 == value && id <= i64::from(u32::MAX) { Ok(id) } else { Err(Bad { index, value }) }
    }

    /// The id of a voxel, or the background's if it has none or a negative one.
    pub fn id(&self, index: usize) -> u32 {
        self.get(index).ok().and_then(|id| u32::try_from(id).ok()).unwrap_or(0)
    }

    /// The number of voxels of each id, in one pass. Memory is bounded by the number of ids. A few negative ids, which programs give to voxels
    /// outside all labels, count as the background.
    ///
    /// # Errors
    /// [`Error::Volume`] if a value is no id, or there are more ids than [`MOST_IDS`].
    pub fn counts(&self) -> Result<BTreeMap<u32, u64>, Error> {
        let count = self.numbers.count();
        let task = Task::new(format!("looking at {}", self.path.display()), count as u64);
        let block = |n: usize| -> Counted {
            let (mut counts, mut run) = (HashMap::new(), (0, 0));
            let voxels = n * BLOCK..((n + 1) * BLOCK).min(count);
            if task.check().is_err() {
                return Ok(counts);
            }
            task.add(voxels.len() as u64);
            for index in voxels {
                let id = self.get(index).map_err(Refused::Bad)?;
                if id != run.0 {
                    add(&mut counts, run)?;
                    run = (id, 0);
                }
                run.1 += 1;
            }
            add(&mut counts, run)?;
            Ok(counts)
        };
        let merged = |a: Counted, b: Counted| match (a, b) {
            (Ok(mut a), Ok(b)) => b.into_iter().try_for_each(|run| add(&mut a, run)).map(|()| a),
            // The first voxel of all threads, so that messages are the same from run to run.
            (Err(Refused::Bad(a)), Err(Refused::Bad(b))) => Err(Refused::Bad(if a.index < b.index { a } else { b })),
            (Err(Refused::Bad(bad)), _) | (_, Err(Refused::Bad(bad))) => Err(Refused::Bad(bad)),
            (Err(e), _) | (_, Err(e)) => Err(e),
        };
        let counts = (0..count.div_ceil(BLOCK)).into_par_iter().map(block).reduce(|| Ok(HashMap::new()), merged);
        task.check().map_err(|e| Error::read(self.path, e))?;
        counts.map(|counts| self.without_negative(counts)).map_err(|refused| match refused {
            Refused::Bad(bad) => self.no_id(&bad),
            Refused::TooManyNegative => {
                let problem = format!(
                    "its voxels have more than {MOST_NEGATIVE} different negative numbers: ids of labels are whole numbers from 0 to {}; \
                     open it as a volume of values, or renumber its labels",
                    u32::MAX
                );
                Error::volume(self.path, problem)
            }
            Refused::TooMany => {
                let problem = format!("its voxels have more than {MOST_IDS} different ids: crop it, or merge labels");
                Error::volume(self.path, problem)
            }
        })
    }

    /// Adds negative ids to the background, with a warning.
    fn without_negative(&self, counts: HashMap<i64, u64>) -> BTreeMap<u32, u64> {
        let (mut all, mut negative) = (BTreeMap::new(), BTreeMap::new());
        for (id, voxels) in counts {
            match u32::try_from(id) {
                Ok(id) => *all.entry(id).or_default() += voxels,
                Err(_) => *negative.entry(id).or_default() += voxels,
            }
        }
        if !negative.is_empty() {
            let (path, voxels) = (self.path.display(), negative.values().sum::<u64>());
            let ids = negative.into_keys().map(|id| id.to_string()).collect::<Vec<_>>().join(", ");
            tracing::warn!(
                "{path}: {voxels} voxels have negative ids ({ids}): they count as the background; renumber labels to draw them"
            );
            *all.entry(0).or_default() += voxels;
        }
        all
    }

    fn no_id(&self, bad: &Bad) -> Error {
        let [x, y, _] = self.dims;
        let place = [bad.index % x, bad.index / x % y, bad.index / x / y];
        let [i, j, k] = place;
        let value = if bad.value.is_nan() { "not a number".into() } else { bad.value.to_string() };
        let remedy = if bad.value > f64::from(u32::MAX) {
            "renumber its labels"
        } else {
            "open it as a volume of values, or save the labels themselves, not interpolated ones"
        };
        let problem =
            format!("its voxel {i},{j},{k} is {value}: ids of labels are whole numbers from 0 to {}; {remedy}", u32::MAX);
        Error::volume(self.path, problem)
    }

    /// Voxels with the position of their id in `ids`, which are ascending and hold all. In a temporary file if they exceed `most` bytes.
    pub fn indices(&self, ids: &[u32], most: Option<u64>) -> Result<Storage<'static>, Error> {
        if ids.len() <= usize::from(u8::MAX) + 1 { self.placed::<u8>(ids, most) } else { self.placed::<u16>(ids, most) }
    }

    fn placed<T: Voxel + Zeroable>(&self, ids: &[u32], most: Option<u64>) -> Result<Storage<'static>, Error> {
        let (name, count) = (self.path.display().to_string(), self.numbers.count());
        let task = Task::new(format!("looking at {name}"), count as u64);
        let convert = |first: usize, voxels: &mut [T]| {
            voxels.par_chunks_mut(BLOCK).enumerate().for_each(|(block, voxels)| {
                if task.check().is_err() {
                    return;
                }
                task.add(voxels.len() as u64);
                // Neighbours mostly have one id.
                let mut last = (0, T::zeroed());
                for (i, voxel) in voxels.iter_mut().enumerate() {
                    let id = self.id(first + block * BLOCK + i);
                    if id != last.0 {
                        last = (id, T::nearest(ids.binary_search(&id).unwrap_or(0) as f64));
                    }
                    *voxel = last.1;
                }
            });
            task.check().map_err(|e| Error::read(self.path, e))
        };
        let bytes = (count * size_of::<T>()) as u64;
        if most.is_none_or(|most| bytes <= most) {
            let mut voxels = memory::zeroed::<T>(&name, count)?;
            convert(0, &mut voxels)?;
            return Ok(voxels.into());
        }
        let mut spool = Spool::new(&name, bytes)?;
        let mut piece = memory::zeroed::<T>(&name, PIECE.min(count))?;
        for first in (0..count).step_by(PIECE) {
            let voxels = &mut piece[..PIECE.min(count - first)];
            convert(first, voxels)?;
            spool.put(bytemuck::cast_slice(voxels))?;
        }
        Ok(Storage::from_bytes(spool.mapped()?, T::TYPE))
    }
}

/// Adds a run of voxels of one id.
fn add(counts: &mut HashMap<i64, u64>, (id, voxels): (i64, u64)) -> Result<(), Refused> {
    if voxels == 0 {
        return Ok(());
    }
    let before = counts.len();
    *counts.entry(id).or_default() += voxels;
    if counts.len() == before {
        return Ok(());
    }
    let negative = || counts.keys().filter(|id| **id < 0).count();
    if id < 0 && negative() > MOST_NEGATIVE {
        return Err(Refused::TooManyNegative);
    }
    // The background is no label.
    let labels = || counts.keys().filter(|id| **id > 0).count();
    if counts.len() > MOST_IDS && labels() > MOST_IDS { Err(Refused::TooMany) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::cancelled;
    use crate::volume::{Endian, Grid, ScalarType, Volume};
    use glam::DVec3;

    fn ids<'a>(numbers: &'a [f64], dims: [usize; 3]) -> Ids<'a> {
        let numbers =
            Numbers { bytes: bytemuck::cast_slice(numbers), scalar: ScalarType::Float64, endian: Endian::NATIVE, missing: None };
        Ids { path: Path::new("t.nrrd"), dims, numbers, rescale: Rescale::default() }
    }

    #[test]
    fn counting_and_converting_end_when_they_are_cancelled() {
        let of = ids(&[1.0, 2.0], [2, 1, 1]);
        assert!(of.counts().is_ok() && of.indices(&[0, 1, 2], None).is_ok());
        cancelled(|| assert!(of.counts().is_err() && of.indices(&[0, 1, 2], None).is_err()));
    }

    #[test]
    fn ids_of_32_bits_stay_exact() {
        // Neither 32-bit floats nor differences of these can tell the last two.
        // Negative numbers are background.
        let numbers = [0.0, 614_454_277.0, 614_454_277.0, 4_294_967_294.0, 4_294_967_295.0, -3.0];
        let of = ids(&numbers, [6, 1, 1]);
        let counts = of.counts().unwrap();
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), [(0, 2), (614_454_277, 2), (4_294_967_294, 1), (4_294_967_295, 1)]);
        for most in [None, Some(0)] {
            let storage = of.indices(&[0, 614_454_277, 4_294_967_294, 4_294_967_295], most).unwrap();
            let volume = Volume::new("t", Grid::new([6, 1, 1], DVec3::ONE).unwrap(), storage).unwrap();
            assert_eq!([0, 1, 2, 3, 4, 5].map(|i| volume.value(i)), [0.0, 1.0, 1.0, 2.0, 3.0, 0.0]);
        }
    }

    #[test]
    fn many_ids_have_indices_of_16_bits_and_more_are_refused() {
        let numbers: Vec<f64> = (0..=65_535).rev().map(|n| f64::from(n) * 1000.0).collect();
        let of = ids(&numbers, [65_536, 1, 1]);
        let sorted: Vec<u32> = of.counts().unwrap().into_keys().collect();
        let storage = of.indices(&sorted, None).unwrap();
        let volume = Volume::new("t", Grid::new([65_536, 1, 1], DVec3::ONE).unwrap(), storage).unwrap();
        assert_eq!((volume.voxel_type().bytes(), volume.value(0), volume.value(65_535)), (2, 65_535.0, 0.0));
        let more: Vec<f64> = (0..=65_536).map(f64::from).collect();
        let message = ids(&more, [65_537, 1, 1]).counts().unwrap_err().to_string();
        assert!(message.contains("more than 65535 different ids"), "{message}");
        assert!(ids(&more[1..], [65_536, 1, 1]).counts().is_err() && ids(&more[..65_536], [65_536, 1, 1]).counts().is_ok());
    }

    #[test]
    fn values_that_are_no_ids_are_named_with_their_place() {
        for (bad, expected) in [
            (0.5, "its voxel 1,1,1 is 0.5: ids of labels are whole numbers from 0 to 4294967295; open it as a volume of values"),
            (-0.5, "is -0.5: ids of labels are whole numbers"),
            (4_294_967_296.0, "is 4294967296: ids of labels are whole numbers from 0 to 4294967295; renumber its labels"),
            (f64::NAN, "is not a number: "),
        ] {
            // The first one counts, whatever thread finds it.
            let mut numbers = vec![3.0; 8 * BLOCK];
            numbers[4 * BLOCK - 1] = 7.5;
            let dims = [2, 2, 2 * BLOCK];
            numbers[7] = bad;
            let message = ids(&numbers, dims).counts().unwrap_err().to_string();
            assert!(message.starts_with("t.nrrd: ") && message.contains(expected), "{message}");
        }
    }
}
