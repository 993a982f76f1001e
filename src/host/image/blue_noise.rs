//! A fixed blue-noise dither pattern, by the void-and-cluster method: R. Ulichney, "The void-and-cluster method for dither array
//! generation", Proc. SPIE 1913, 1993.
//!
//! Its thresholds are spread evenly at every level, so that the error of dithering has high frequencies only, which the eye averages.

use std::sync::LazyLock;

/// Pixels along each side of the pattern, which repeats.
pub(super) const SIDE: usize = 64;
const COUNT: usize = SIDE * SIDE;
/// Standard deviation of the Gaussian that measures crowding, in pixels (Ulichney's choice).
const SIGMA: f64 = 1.5;
/// Pixels of the first pattern.
const FIRST: usize = COUNT / 10;

static THRESHOLDS: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let threshold = |rank: usize| ((rank as f64 + 0.5) / COUNT as f64) as f32;
    ranks().into_iter().map(threshold).collect()
});

/// The thresholds of a row of pixels, in 0 … 1 exclusive: element `column % SIDE` is that of a column.
pub(super) fn row(row: usize) -> &'static [f32] {
    &THRESHOLDS[row % SIDE * SIDE..][..SIDE]
}

/// The rank of each pixel, row by row: every number below `COUNT` once.
fn ranks() -> Vec<usize> {
    let mut pattern = Pattern::new();
    pattern.spread();
    let first = pattern.clone();
    let mut ranks = vec![0; COUNT];
    // From the first pattern down, the most crowded pixel has the highest rank.
    for rank in (0..FIRST).rev() {
        let tightest = pattern.tightest();
        pattern.set(tightest, false);
        ranks[tightest] = rank;
    }
    // From the first pattern up, the largest void comes next. Beyond one half, the method removes the tightest cluster of unset pixels. With a
    // Gaussian that is the same pixel: the crowding of unset pixels is a constant less that of set pixels.
    let mut pattern = first;
    for rank in FIRST..COUNT {
        let void = pattern.void();
        pattern.set(void, true);
        ranks[void] = rank;
    }
    ranks
}

/// Set pixels on a torus.
#[derive(Clone)]
struct Pattern {
    set: Vec<bool>,
    /// Sum of the Gaussians around all set pixels.
    crowding: Vec<f64>,
    /// Gaussian by distance along an axis.
    weights: [f64; SIDE],
}

impl Pattern {
    /// Creates a pattern of `FIRST` pseudo-random pixels.
    fn new() -> Self {
        let weights = std::array::from_fn(|n| {
            let distance = n.min(SIDE - n) as f64;
            // Not `f64::exp`, whose last bit depends on the platform.
            libm::exp(-distance * distance / (2.0 * SIGMA * SIGMA))
        });
        let mut pattern = Self { set: vec![false; COUNT], crowding: vec![0.0; COUNT], weights };
        // A linear congruential generator (Knuth's MMIX).
        let mut state = 1_u64;
        let mut missing = FIRST;
        while missing > 0 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let pixel = (state >> 33) as usize % COUNT;
            if !pattern.set[pixel] {
                pattern.set(pixel, true);
                missing -= 1;
            }
        }
        pattern
    }

    fn set(&mut self, pixel: usize, set: bool) {
        self.set[pixel] = set;
        let sign = if set { 1.0 } else { -1.0 };
        let (row, column) = (pixel / SIDE, pixel % SIDE);
        for (y, crowding) in self.crowding.chunks_exact_mut(SIDE).enumerate() {
            let weight = sign * self.weights[(y + SIDE - row) % SIDE];
            for (x, crowding) in crowding.iter_mut().enumerate() {
                *crowding += weight * self.weights[(x + SIDE - column) % SIDE];
            }
        }
    }

    /// The most crowded set pixel.
    fn tightest(&self) -> usize {
        let set = (0..COUNT).filter(|&pixel| self.set[pixel]);
        set.max_by(|&a, &b| self.crowding[a].total_cmp(&self.crowding[b])).expect("pixels are set")
    }

    /// The least crowded unset pixel.
    fn void(&self) -> usize {
        let unset = (0..COUNT).filter(|&pixel| !self.set[pixel]);
        unset.min_by(|&a, &b| self.crowding[a].total_cmp(&self.crowding[b])).expect("pixels are unset")
    }

    /// Moves the most crowded pixel to the largest void until it would return to its place.
    fn spread(&mut self) {
        loop {
            let tightest = self.tightest();
            self.set(tightest, false);
            let void = self.void();
            self.set(void, true);
            if void == tightest {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// FNV-1a of the ranks. The pattern must never change: pictures that were written stay reproducible.
    const CHECKSUM: u64 = 0x96dc_0b24_e1fc_b8e9;

    #[test]
    fn every_rank_occurs_once_and_the_pattern_is_fixed() {
        let ranks = ranks();
        let mut sorted = ranks.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..COUNT));
        let checksum = ranks.iter().fold(0xcbf2_9ce4_8422_2325_u64, |sum, &rank| {
            rank.to_le_bytes().iter().fold(sum, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
        });
        assert_eq!(checksum, CHECKSUM, "{checksum:#x}");
    }

    /// Mean power of a pattern's frequencies of up to `limit` cycles along each axis, relative to white noise.
    fn low_frequencies(pattern: &[f64], limit: i32) -> f64 {
        let mean = pattern.iter().sum::<f64>() / COUNT as f64;
        let variance = pattern.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / COUNT as f64;
        let mut powers = Vec::new();
        for (u, v) in (0..=limit).flat_map(|u| (-limit..=limit).map(move |v| (u, v))).filter(|&f| f != (0, 0)) {
            let phase = |n: usize| TAU * (f64::from(u) * (n % SIDE) as f64 + f64::from(v) * (n / SIDE) as f64) / SIDE as f64;
            let sum = |f: fn(f64) -> f64| (0..COUNT).map(|n| (pattern[n] - mean) * f(phase(n))).sum::<f64>();
            powers.push((sum(f64::cos).powi(2) + sum(f64::sin).powi(2)) / (COUNT as f64 * variance));
        }
        powers.iter().sum::<f64>() / powers.len() as f64
    }

    /// Largest power of low frequencies, where white noise has 1. The pattern has 0.054, 0.025 and 0.020.
    const LOW: f64 = 0.1;

    /// The pattern of each level has next to no low frequencies, where a random order has those of white noise.
    #[test]
    fn low_frequencies_are_missing() {
        let ranks = ranks();
        let level = |ranks: &[usize], level: usize| ranks.iter().map(|&rank| f64::from(rank < level)).collect::<Vec<_>>();
        for share in [10, 4, 2] {
            let found = low_frequencies(&level(&ranks, COUNT / share), 6);
            assert!(found < LOW, "one in {share}: {found}");
        }
        // The same measure notices a pattern of other order.
        let random: Vec<usize> = (0..COUNT).map(|n| (n * n * 7 + n * 1031) / 3 * 2_654_435_761 % COUNT).collect();
        let found = low_frequencies(&level(&random, COUNT / 4), 6);
        assert!(found > 0.3, "{found}");
    }
}
