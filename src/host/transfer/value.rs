//! Data values given as numbers or as percentiles of a volume's voxels.

use crate::error::Error;
use crate::volume::{HISTOGRAM_BINS, Statistics, Volume};
use std::cell::OnceCell;
use std::str::FromStr;

/// A data value: a number, or a percentile `p0` … `p100` of a volume's voxels.
///
/// ```
/// use layersplat::{OpenOptions, Volume};
/// use layersplat::transfer::Value;
///
/// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
/// let (bright, all): (Value, Value) = ("p99.5".parse()?, "p100".parse()?);
/// let find = Value::finder(&volume);
/// assert!(find(bright) < find(all));
/// assert_eq!(find(Value::Number(7.5)), 7.5);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A finite value.
    Number(f64),
    /// Percentile of the voxel values, 0 … 100. 0 is the smallest value.
    Percentile(f64),
}

impl Value {
    /// Returns a function that resolves values for `volume`. The first percentile takes a pass over the voxels. Each percentile in a
    /// crowded histogram bin takes up to three more.
    pub fn finder<'a>(volume: &'a Volume<'_>) -> impl Fn(Value) -> f64 + 'a {
        let (volume, statistics) = (volume.overview(), OnceCell::new());
        move |value| match value {
            Value::Number(number) => number,
            Value::Percentile(percent) => percentile(volume, statistics.get_or_init(|| volume.statistics()), percent),
        }
    }
}

/// Largest share of the voxels in a bin that needs no refinement.
const FEW: f64 = 0.005;
/// Maximum number of refinements, each with 256 times finer bins. Data with a few outliers a million times as large need all three.
const PASSES: usize = 3;

pub(super) fn percentile(volume: &Volume, statistics: &Statistics, percent: f64) -> f64 {
    if percent <= 0.0 {
        return statistics.min;
    }
    let count = statistics.histogram.iter().sum::<u64>() as f64;
    let wanted = percent / 100.0 * count;
    let (mut lo, mut hi) = (statistics.min, statistics.max);
    let mut counts = Counts { below: 0, bins: statistics.histogram.clone() };
    for pass in 0..=PASSES {
        let mut sum = counts.below as f64;
        let reached = counts.bins.iter().position(|&voxels| {
            sum += voxels as f64;
            sum >= wanted
        });
        let (bin, width) = (reached.unwrap_or(HISTOGRAM_BINS - 1), (hi - lo) / HISTOGRAM_BINS as f64);
        let few = counts.bins[bin] as f64 <= FEW * count;
        (lo, hi) = (lo + width * bin as f64, if bin + 1 == HISTOGRAM_BINS { hi } else { lo + width * (bin + 1) as f64 });
        // Each 8-bit value has its own bin in the first histogram.
        if few || pass == PASSES || volume.voxel_type().bytes() == 1 || lo + (hi - lo) / 2.0 >= hi {
            break;
        }
        counts = counted(volume, lo, hi);
    }
    hi
}

/// Number of voxels below a range, and in each of its bins.
struct Counts {
    below: u64,
    bins: Vec<u64>,
}

impl Default for Counts {
    fn default() -> Self {
        Self { below: 0, bins: vec![0; HISTOGRAM_BINS] }
    }
}

fn counted(volume: &Volume, lo: f64, hi: f64) -> Counts {
    let scale = HISTOGRAM_BINS as f64 / (hi - lo);
    let blocks = volume.sum_blocks(|counts: &mut Counts, value: Option<f64>, count| match value {
        Some(value) if value < lo => counts.below += count,
        Some(value) if value <= hi => counts.bins[(((value - lo) * scale) as usize).min(HISTOGRAM_BINS - 1)] += count,
        _ => {}
    });
    let mut total = Counts::default();
    for block in blocks {
        total.below += block.below;
        total.bins.iter_mut().zip(block.bins).for_each(|(bin, more)| *bin += more);
    }
    volume.count_all(std::slice::from_mut(&mut total.below));
    volume.count_all(&mut total.bins);
    total
}

impl FromStr for Value {
    type Err = Error;

    /// Parses a finite number, or `pN` with N in 0 … 100.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for any other text.
    fn from_str(text: &str) -> Result<Self, Error> {
        let text = text.trim();
        let value = match text.strip_prefix(['p', 'P']) {
            Some(percent) => percent.parse().ok().filter(|p| (0.0..=100.0).contains(p)).map(Value::Percentile),
            None => text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Number),
        };
        let expected = "a finite number, or a percentile from p0 to p100";
        value.ok_or_else(|| Error::OutOfRange { name: "value", value: format!("'{text}'"), expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn numbers_and_percentiles() {
        for (text, value) in [
            ("12.5", Value::Number(12.5)),
            (" -1e3 ", Value::Number(-1000.0)),
            ("p99.5", Value::Percentile(99.5)),
            ("P0", Value::Percentile(0.0)),
            ("p100", Value::Percentile(100.0)),
        ] {
            assert_eq!(text.parse::<Value>().unwrap(), value, "{text}");
        }
        for bad in ["", "p", "p101", "p-1", "pNaN", "NaN", "inf", "1e999", "99p", "5%", "p p5"] {
            let message = bad.parse::<Value>().unwrap_err().to_string();
            assert!(message.contains("p100") && message.contains(bad), "{bad}: {message}");
        }
    }

    /// Each 8-bit value has its own bin, so the result equals that of sorting, up to a bin.
    #[test]
    fn percentiles_are_those_of_the_sorted_voxels() {
        let mut voxels: Vec<u8> = (0..4000u32).map(|i| (i * i / 63_000) as u8).collect();
        voxels[0] = 255;
        let volume = Volume::new("t", Grid::new([4000, 1, 1], DVec3::ONE).unwrap(), voxels.clone()).unwrap();
        let find = Value::finder(&volume);
        voxels.sort_unstable();
        for percent in [0.0, 1.0, 50.0, 90.0, 99.5, 100.0] {
            let rank = (percent / 100.0 * 4000.0f64).ceil().max(1.0) as usize - 1;
            let (found, sorted) = (find(Value::Percentile(percent)), f64::from(voxels[rank]));
            assert!((found - sorted).abs() <= 1.0, "p{percent}: {found} for {sorted}");
        }
        assert_eq!((find(Value::Percentile(0.0)), find(Value::Percentile(100.0))), (0.0, 255.0));
    }

    /// One voxel a million times as large as the others, and a volume of mostly equal voxels.
    #[test]
    fn percentiles_do_not_mind_what_is_far_away() {
        let grid = || Grid::new([100, 100, 1], DVec3::ONE).unwrap();
        let mut spread: Vec<f32> = (0..10_000).map(|i| i as f32 / 10_000.0).collect();
        spread[77] = 1e6;
        let volume = Volume::new("t", grid(), spread).unwrap();
        let find = Value::finder(&volume);
        for percent in [1.0, 50.0, 99.0] {
            let found = find(Value::Percentile(percent));
            assert!((found - percent / 100.0).abs() < 0.001, "p{percent}: {found}");
        }
        assert_eq!((find(Value::Percentile(0.0)), find(Value::Percentile(100.0))), (0.0, 1e6));
        let air: Vec<i16> = (0..10_000).map(|i| if i < 9000 { -1000 } else { i - 9000 }).collect();
        let volume = Volume::new("t", grid(), air).unwrap();
        let find = Value::finder(&volume);
        for (percent, expected) in [(50.0, -1000.0), (90.0, -1000.0), (95.0, 499.0), (99.0, 899.0)] {
            let found = find(Value::Percentile(percent));
            assert!((found - expected).abs() < 8.0, "p{percent}: {found}");
        }
    }
}
