//! Statistics of a volume's values.

use super::Volume;

/// Number of bins of [`Statistics::histogram`].
pub const HISTOGRAM_BINS: usize = 256;

/// Range, mean and histogram of a volume's valid voxels.
///
/// ```
/// use layersplat::{OpenOptions, Volume};
///
/// let statistics = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?.statistics();
/// assert!(statistics.min <= statistics.quantile(0.5) && statistics.quantile(0.5) <= statistics.max);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean value.
    pub mean: f64,
    /// Number of voxels per bin: [`HISTOGRAM_BINS`] equal bins from `min` to `max`. A constant volume fills the first bin.
    pub histogram: Vec<u64>,
}

/// Sums over a block of voxels.
struct Sums {
    sum: f64,
    histogram: Vec<u64>,
}

impl Default for Sums {
    fn default() -> Self {
        Self { sum: 0.0, histogram: vec![0; HISTOGRAM_BINS] }
    }
}

impl Statistics {
    pub(super) fn new(volume: &Volume) -> Self {
        let (min, max) = volume.range();
        let scale = if max > min { HISTOGRAM_BINS as f64 / (max - min) } else { 0.0 };
        let blocks = volume.sum_blocks(|sums: &mut Sums, value, count| {
            if let Some(v) = value {
                sums.sum += v * count as f64;
                sums.histogram[(((v - min) * scale) as usize).min(HISTOGRAM_BINS - 1)] += count;
            }
        });
        let mut total = Sums::default();
        for block in blocks {
            total.sum += block.sum;
            total.histogram.iter_mut().zip(block.histogram).for_each(|(bin, more)| *bin += more);
        }
        volume.count_all(&mut total.histogram);
        volume.add_all(std::slice::from_mut(&mut total.sum));
        let count = total.histogram.iter().sum::<u64>().max(1);
        Self { min, max, mean: total.sum / count as f64, histogram: total.histogram }
    }

    /// Smallest value that a fraction `quantile` (0 … 1) of the voxels does not exceed, to within a bin's width.
    pub fn quantile(&self, quantile: f64) -> f64 {
        let wanted = quantile * self.histogram.iter().sum::<u64>() as f64;
        let mut below = 0.0;
        let bin = self.histogram.iter().position(|&count| {
            below += count as f64;
            below >= wanted
        });
        self.min + (self.max - self.min) * (bin.unwrap_or(HISTOGRAM_BINS - 1) + 1) as f64 / HISTOGRAM_BINS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::{self, Observer};
    use crate::volume::{Grid, Rescale, Voxel};
    use glam::DVec3;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn volume<T: Voxel>(values: Vec<T>) -> Volume<'static> {
        Volume::new("t", Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap(), values).unwrap()
    }

    #[test]
    fn eight_bit_values_have_a_bin_each() {
        // More voxels than a block has.
        let values: Vec<u8> = (0..=255).flat_map(|v| std::iter::repeat_n(v, 2000 + usize::from(v) % 3)).collect();
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        let expected: Vec<u64> = (0..256).map(|v| 2000 + v % 3).collect();
        let volume = volume(values);
        let statistics = volume.statistics();
        assert_eq!(statistics.histogram, expected);
        assert!((statistics.mean - mean).abs() < 1e-12);
        let turned = volume.with_rescale(Rescale::new(-2.0, 10.0).unwrap()).statistics();
        assert_eq!((turned.min, turned.max), (-500.0, 10.0));
        assert_eq!(turned.histogram, expected.into_iter().rev().collect::<Vec<_>>());
        assert!((turned.mean - (10.0 - 2.0 * mean)).abs() < 1e-9);
    }

    /// Whoever waits for passes over large volumes can end them, and hears how far they are.
    #[test]
    fn a_pass_ends_when_its_observer_does() {
        struct EndsAtOnce(AtomicU64);
        impl Observer for EndsAtOnce {
            fn step(&self, what: &str, done: u64, total: u64) {
                assert!(what == "looking at t" && done < total, "{what}: {done} of {total}");
                self.0.fetch_max(done, Ordering::SeqCst);
            }
            fn is_cancelled(&self) -> bool {
                self.0.load(Ordering::SeqCst) > 0
            }
        }
        let (volume, count) = (volume(vec![7u8; 16 << 20]), 16 << 20);
        let observer = Arc::new(EndsAtOnce(AtomicU64::new(0)));
        let counted = progress::observed(observer, || Statistics::new(&volume)).histogram.iter().sum::<u64>();
        assert!(counted > 0 && counted < count / 2, "{counted} of {count}");
        assert_eq!(volume.statistics().histogram.iter().sum::<u64>(), count);
    }

    #[test]
    fn quantiles() {
        let statistics = volume((0..1000u16).collect()).statistics();
        assert!((statistics.quantile(0.5) - 500.0).abs() < 8.0);
        assert!((statistics.quantile(1.0) - 999.0).abs() < 1e-9);
    }
}
