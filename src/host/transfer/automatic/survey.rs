//! A sampled pass over a volume: a joint histogram of values and gradient magnitudes, and a histogram of the volume's faces.

use crate::transfer::value::percentile;
use crate::volume::{ReadsValues, Statistics, Volume, VoxelType};
use rayon::prelude::*;

/// Largest number of value bins. Integers of a smaller range have a bin each.
const BINS: usize = 256;
/// Number of gradient bins. They are equal in the root of the magnitude, so that weak gradients are told apart.
const GRADIENTS: usize = 64;
/// Gradient magnitude at the end of the last bin, in value ranges per unit distance: an edge within one voxel along all axes.
const STEEPEST: f64 = 0.87;
/// Approximate number of voxels that are sampled, and of samples per face.
const SAMPLES: usize = 2_000_000;
const FACE_SAMPLES: usize = 10_000;
/// Samples that a thread takes at a time.
const RUN: usize = 1 << 14;
/// Percentiles that bound the examined range where outliers would take most of the bins, and the share of the range that they leave.
const OUTLIERS: [f64; 2] = [0.02, 99.98];
const CROWDED: f64 = 0.5;

/// Histograms of sampled voxels. Bins are equal from `lo` to `hi`; values beyond count in the first and the last bin.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    pub lo: f64,
    pub hi: f64,
    /// Number of sampled voxels per value bin.
    pub counts: Vec<f64>,
    /// Median and mean gradient magnitude per value bin, in value ranges per smallest spacing.
    pub median_gradients: Vec<f64>,
    pub mean_gradients: Vec<f64>,
    /// Number of sampled voxels of weak gradient per value bin.
    pub flat: Vec<f64>,
    /// Number of sampled voxels on the faces of the volume per value bin.
    pub faces: Vec<f64>,
}

impl Survey {
    /// Surveys a volume with at least two values. Results do not depend on the number of processes that share it.
    pub fn new(statistics: &Statistics, volume: &Volume) -> Self {
        let (lo, hi, bins) = range(statistics, volume);
        let sampler = Sampler { volume, lo, per_value: bins as f64 / (hi - lo), per_range: 1.0 / (hi - lo), bins };
        let (mut joint, mut faces) = volume.read_by(&sampler);
        volume.count_all(&mut joint);
        volume.count_all(&mut faces);
        let rows: Vec<&[u64]> = joint.chunks_exact(GRADIENTS).collect();
        let limit = flat_limit(&rows);
        let mean = |row: &[u64]| row.iter().enumerate().map(|(g, &n)| gradient(g) * n as f64).sum::<f64>() / total(row).max(1.0);
        Self {
            lo,
            hi,
            counts: rows.iter().map(|row| total(row)).collect(),
            median_gradients: rows.iter().map(|row| median(row)).collect(),
            mean_gradients: rows.iter().map(|row| mean(row)).collect(),
            flat: rows.iter().map(|row| total(&row[..limit])).collect(),
            faces: faces.into_iter().map(|n| n as f64).collect(),
        }
    }

    /// Number of value bins.
    pub fn bins(&self) -> usize {
        self.counts.len()
    }

    /// Value at a position among the bins; bin `b` reaches from `b` to `b + 1`.
    pub fn value(&self, position: f64) -> f64 {
        self.lo + (self.hi - self.lo) * position / self.bins() as f64
    }

    /// The survey of the negated values.
    pub fn mirrored(&self) -> Self {
        let reversed = |numbers: &[f64]| numbers.iter().rev().copied().collect();
        Self {
            lo: -self.hi,
            hi: -self.lo,
            counts: reversed(&self.counts),
            median_gradients: reversed(&self.median_gradients),
            mean_gradients: reversed(&self.mean_gradients),
            flat: reversed(&self.flat),
            faces: reversed(&self.faces),
        }
    }
}

/// Examined range of values, without rare outliers, and the number of its bins.
fn range(statistics: &Statistics, volume: &Volume) -> (f64, f64, usize) {
    let (min, max) = (statistics.min, statistics.max);
    let [low, high] = OUTLIERS.map(|percent| percentile(volume, statistics, percent));
    let (lo, hi) = if low < high && high - low < CROWDED * (max - min) { (low, high) } else { (min, max) };
    let step = volume.description().rescale().slope().abs();
    let steps = (hi - lo) / step;
    if volume.voxel_type() != VoxelType::Float32 && steps < BINS as f64 {
        return (lo - step / 2.0, hi + step / 2.0, steps.round() as usize + 1);
    }
    (lo, hi, BINS)
}

/// Reads samples of a volume.
struct Sampler<'a> {
    volume: &'a Volume<'a>,
    lo: f64,
    per_value: f64,
    per_range: f64,
    bins: usize,
}

impl ReadsValues for &Sampler<'_> {
    type Read = (Vec<u64>, Vec<u64>);

    fn read(self, value: impl Fn(usize) -> f64 + Sync) -> Self::Read {
        (self.joint(&value), self.faces(&value))
    }
}

impl Sampler<'_> {
    fn bin(&self, value: f64) -> usize {
        (((value - self.lo) * self.per_value).max(0.0) as usize).min(self.bins - 1)
    }

    /// Counts of value and gradient bins, gradient fastest.
    fn joint(&self, value: &(impl Fn(usize) -> f64 + Sync)) -> Vec<u64> {
        let count = self.volume.grid().voxel_count();
        let every = count.div_ceil(SAMPLES);
        let runs = count.div_ceil(every).div_ceil(RUN);
        let add = |mut sums: Vec<u64>, run: usize| {
            for sample in run * RUN..(run + 1) * RUN {
                // Spread within each interval, so that samples do not keep to a few columns of the grid.
                let index = sample * every + scattered(sample) % every;
                if index < count
                    && let Some(bin) = self.joint_bin(index, value)
                {
                    sums[bin] += 1;
                }
            }
            sums
        };
        let none = || vec![0; self.bins * GRADIENTS];
        (0..runs).into_par_iter().fold(none, add).reduce(none, |mut a, b| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        })
    }

    /// The bin of a voxel; `None` if another process owns it, or if it lies on a face across which the volume is thicker than 2 voxels.
    fn joint_bin(&self, index: usize, value: &impl Fn(usize) -> f64) -> Option<usize> {
        let grid = self.volume.grid();
        let (dims, place) = (grid.dims(), grid.place(index));
        if !self.volume.own_box().has(place) {
            return None;
        }
        let strides = [1, dims[0], dims[0] * dims[1]];
        // Parts have a layer of their neighbours' voxels, so this leaves out faces of the volume alone.
        let held = self.volume.held_box();
        let finest = grid.spacing().min_element();
        let mut squares = 0.0;
        for axis in (0..3).filter(|&axis| dims[axis] > 2) {
            if place[axis] == held.first[axis] || place[axis] + 1 == held.end(axis) {
                return None;
            }
            let difference = (value(index + strides[axis]) - value(index - strides[axis])) * self.per_range;
            squares += (difference / 2.0 * finest / grid.spacing()[axis]).powi(2);
        }
        let gradient = ((squares.sqrt() / STEEPEST).sqrt() * GRADIENTS as f64) as usize;
        Some(self.bin(value(index)) * GRADIENTS + gradient.min(GRADIENTS - 1))
    }

    /// Counts of value bins on the six faces.
    fn faces(&self, value: &impl Fn(usize) -> f64) -> Vec<u64> {
        let dims = self.volume.grid().dims();
        let own = self.volume.own_box();
        let mut sums = vec![0; self.bins];
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let count = dims[u] * dims[v];
            let every = count.div_ceil(FACE_SAMPLES);
            for sample in 0..count.div_ceil(every) {
                let index = sample * every + scattered(sample) % every;
                for end in [0, dims[axis] - 1] {
                    let mut place = [0; 3];
                    (place[axis], place[u], place[v]) = (end, index % dims[u], index / dims[u]);
                    if index < count && own.has(place) {
                        sums[self.bin(value(place[0] + dims[0] * (place[1] + dims[1] * place[2])))] += 1;
                    }
                }
            }
        }
        sums
    }
}

/// A fixed pseudo-random number (SplitMix64's finaliser).
fn scattered(n: usize) -> usize {
    let mut z = (n as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    // On 32-bit machines the lower half suffices.
    (z ^ (z >> 31)) as usize
}

/// Magnitude in the middle of a gradient bin.
fn gradient(bin: usize) -> f64 {
    STEEPEST * ((bin as f64 + 0.5) / GRADIENTS as f64).powi(2)
}

fn total(row: &[u64]) -> f64 {
    row.iter().sum::<u64>() as f64
}

fn median(row: &[u64]) -> f64 {
    let half = total(row) / 2.0;
    let mut below = 0.0;
    let bin = row.iter().position(|&n| {
        below += n as f64;
        below >= half && below > 0.0
    });
    bin.map_or(0.0, gradient)
}

/// Share of the typical edge's gradient below which a voxel is flat.
const FLAT: f64 = 0.4;

/// Number of gradient bins that count as flat. The typical edge is the mean gradient, weighted by the gradient.
fn flat_limit(rows: &[&[u64]]) -> usize {
    let (mut weight, mut moment) = (0.0, 0.0);
    for (g, &n) in rows.iter().flat_map(|row| row.iter().enumerate()) {
        weight += gradient(g) * n as f64;
        moment += gradient(g).powi(2) * n as f64;
    }
    let limit = FLAT * moment / weight.max(f64::MIN_POSITIVE);
    (0..GRADIENTS).position(|g| gradient(g) > limit).unwrap_or(GRADIENTS).max(1)
}
