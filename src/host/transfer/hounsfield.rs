//! Recognition of CT in Hounsfield units, and tissues at fixed values.

use crate::volume::{Statistics, Volume};

/// Hounsfield units of the smallest and the largest value of CT: padding outside the scanned circle, and metal.
const SMALLEST: std::ops::RangeInclusive<f64> = -4096.0..=-900.0;
const LARGEST: std::ops::RangeInclusive<f64> = 300.0..=40000.0;
/// Range of air, padding included, and of soft tissue, fat included.
const AIR: (f64, f64) = (-4096.0, -850.0);
const TISSUE: (f64, f64) = (-200.0, 200.0);
/// Smallest share of the voxels in each of both.
const LEAST: f64 = 0.02;

/// Whether a volume's values are Hounsfield units: air near −1000, much soft tissue around 0, and something denser.
pub(super) fn is_ct(statistics: &Statistics, volume: &Volume) -> bool {
    let shaped = volume.grid().dims().iter().all(|&n| n > 1);
    let share = |range| share(statistics, range);
    shaped
        && SMALLEST.contains(&statistics.min)
        && LARGEST.contains(&statistics.max)
        && share(AIR) >= LEAST
        && share(TISSUE) >= LEAST
}

/// Share of the voxels in a range. Bins that it cuts count in proportion.
fn share(statistics: &Statistics, (lo, hi): (f64, f64)) -> f64 {
    let bins = statistics.histogram.len() as f64;
    let width = (statistics.max - statistics.min) / bins;
    let inside = |bin: usize| {
        let from = statistics.min + width * bin as f64;
        ((hi.min(from + width) - lo.max(from)) / width).clamp(0.0, 1.0)
    };
    let sum: f64 = statistics.histogram.iter().enumerate().map(|(bin, &count)| inside(bin) * count as f64).sum();
    sum / statistics.histogram.iter().sum::<u64>().max(1) as f64
}
