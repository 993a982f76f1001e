//! A first transfer function, from the histogram: never black, never solid.

use super::{TransferFunction, visible_range};
use crate::volume::{HISTOGRAM_BINS, Statistics, Volume};

/// Share of the voxels that stay invisible: air, noise, the bulk around what is of interest.
const HIDDEN_SHARE: f64 = 0.88;
/// Where opacity has reached its middle value, as a share of the voxels.
const MIDDLE_SHARE: f64 = 0.99;
/// Optical depth aimed at along a ray through the middle of the volume.
const DEPTH: f64 = 2.0;
const OPACITY_LIMITS: (f64, f64) = (0.005, 0.6);

pub(super) fn from_statistics(statistics: &Statistics, volume: &Volume) -> TransferFunction {
    let (lo, hi) = visible_range(volume);
    // Where many voxels share the largest values (a mask, say) the quantile alone would hide them too.
    let start = if statistics.min < statistics.max { statistics.quantile(HIDDEN_SHARE) } else { lo }.min((lo + hi) / 2.0);
    let middle = statistics.quantile(MIDDLE_SHARE).clamp(start + 0.1 * (hi - start), start + 0.9 * (hi - start));
    let opacity = opacity_for(statistics, start, volume);
    let at = |t: f64| start + (hi - start) * t;
    let colors =
        vec![(start, [0.45, 0.20, 0.12]), (at(0.33), [0.85, 0.52, 0.30]), (at(0.67), [0.96, 0.86, 0.66]), (hi, [1.0, 1.0, 1.0])];
    let opacities = vec![(lo.min(start), 0.0), (start, 0.0), (middle, opacity), (hi, (1.5 * opacity).min(0.9))];
    TransferFunction::new("automatic", colors, opacities).expect("ascending by construction")
}

/// Opacity at which a ray through the middle meets [`DEPTH`], if the visible voxels were spread evenly.
fn opacity_for(statistics: &Statistics, start: f64, volume: &Volume) -> f64 {
    let count = volume.voxels().len() as f64;
    let width = (statistics.max - statistics.min) / HISTOGRAM_BINS as f64;
    let visible: u64 = (0..HISTOGRAM_BINS)
        .filter(|&bin| width == 0.0 || statistics.min + width * (bin + 1) as f64 > start)
        .map(|bin| statistics.histogram[bin])
        .sum();
    let met = (visible as f64 / count * count.cbrt()).max(1e-3);
    // Twice, since opacity rises from zero: its mean is about half.
    (1.0 - (-2.0 * DEPTH / met).exp()).clamp(OPACITY_LIMITS.0, OPACITY_LIMITS.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Grid, Voxels};
    use glam::DVec3;

    fn automatic(values: Vec<f32>) -> TransferFunction {
        let grid = Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap();
        TransferFunction::automatic(&Volume::new("t", grid, Voxels::Float32(values)).unwrap())
    }

    #[test]
    fn something_is_visible_and_not_everything() {
        let ramp = automatic((0..1000).map(|i| i as f32).collect());
        assert!(ramp.opacity(400.0) == 0.0 && ramp.opacity(999.0) > 0.0);
        let mask = automatic((0..1000).map(|i| if i % 2 == 0 { 0.0 } else { 1.0 }).collect());
        assert!(mask.opacity(0.0) == 0.0 && mask.opacity(1.0) > 0.0 && mask.opacity(1.0) < 1.0);
        let outlier = automatic((0..1000).map(|i| if i == 7 { 1e6 } else { 0.0 }).collect());
        assert!(outlier.opacity(0.0) == 0.0 && outlier.opacity(1e6) > 0.0);
        let negative = automatic((0..1000).map(|i| -1000.0 + i as f32).collect());
        assert!(negative.opacity(-1000.0) == 0.0 && negative.opacity(-1.0) > 0.0);
    }

    #[test]
    fn constant_volumes_have_one_too() {
        for value in [0.0, 5.0, -5.0] {
            assert!(automatic(vec![value; 8]).opacity(value.into()).is_finite());
        }
        assert!(automatic(vec![5.0; 8]).opacity(5.0) > 0.0);
    }
}
