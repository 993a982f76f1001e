//! What a volume's values are like.

use super::voxels::Voxels;

/// Bins of a [`Statistics::histogram`].
pub const HISTOGRAM_BINS: usize = 256;

/// Range, mean and histogram of a volume's voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean value.
    pub mean: f64,
    /// Voxels per bin: [`HISTOGRAM_BINS`] equal bins from `min` to `max`; a constant volume fills the first.
    pub histogram: Vec<u64>,
}

impl Statistics {
    pub(super) fn new(voxels: &Voxels, (min, max): (f64, f64)) -> Self {
        let mut histogram = vec![0u64; HISTOGRAM_BINS];
        let mut sum = 0.0;
        let scale = if max > min { HISTOGRAM_BINS as f64 / (max - min) } else { 0.0 };
        voxels.for_each(|v| {
            sum += v;
            histogram[(((v - min) * scale) as usize).min(HISTOGRAM_BINS - 1)] += 1;
        });
        Self { min, max, mean: sum / voxels.len() as f64, histogram }
    }

    /// Smallest value that a share `quantile` (0 … 1) of the voxels does not exceed, to a bin's width.
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

    #[test]
    fn eight_bit_values_have_a_bin_each() {
        let values: Vec<u8> = (0..=255).flat_map(|v| std::iter::repeat_n(v, 1 + usize::from(v) % 3)).collect();
        let statistics = Statistics::new(&Voxels::Uint8(values.clone()), (0.0, 255.0));
        let expected: Vec<u64> = (0..256).map(|v| 1 + v % 3).collect();
        assert_eq!(statistics.histogram, expected);
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        assert!((statistics.mean - mean).abs() < 1e-12);
    }

    #[test]
    fn quantiles() {
        let values: Vec<u16> = (0..1000).collect();
        let statistics = Statistics::new(&Voxels::Uint16(values), (0.0, 999.0));
        assert!((statistics.quantile(0.5) - 500.0).abs() < 8.0);
        assert!((statistics.quantile(1.0) - 999.0).abs() < 1e-9);
    }
}
