//! Transfer functions of channels that are drawn together, each in its colour.

use super::TransferFunction;
use super::value::percentile;
use crate::volume::Volume;

/// Percentile at which opacity ends: a few voxels of a microscopy channel are far brighter than the rest.
const BRIGHTEST: f64 = 99.9;
/// Most voxels are background, with noise of this width in both directions: from this percentile to the median.
const NOISE_BEGINS: f64 = 16.0;
/// Widths of noise above the median at which opacity begins, and the largest share of the window that this may take.
const NOISE_WIDTHS: f64 = 4.0;
const MOST_NOISE: f64 = 0.25;
/// Opacity of the brightest values: what lies behind two walls still shows.
const OPACITY: f64 = 0.25;

impl TransferFunction {
    /// Name of [`channel`](Self::channel).
    pub const CHANNEL: &str = "channel";

    /// One colour, with an opacity that rises from the end of the background's noise to the 99.9th percentile of the voxels.
    pub fn channel(volume: &Volume, color: [f64; 3]) -> Self {
        let (lo, hi) = channel_window(volume);
        let opacities = vec![(lo, 0.0), (hi, OPACITY)];
        Self::new(Self::CHANNEL, vec![(lo, color)], opacities).expect("two values that ascend")
    }

    /// From black to one colour, over the same values, for pictures of the largest or the mean values.
    pub fn channel_ramp(volume: &Volume, color: [f64; 3]) -> Self {
        let (lo, hi) = channel_window(volume);
        Self::new(Self::CHANNEL, vec![(lo, [0.0; 3]), (hi, color)], vec![(lo, 0.0), (hi, OPACITY)])
            .expect("two values that ascend")
    }
}

fn channel_window(volume: &Volume) -> (f64, f64) {
    let volume = volume.overview();
    let statistics = volume.statistics();
    let [before, median, hi] = [NOISE_BEGINS, 50.0, BRIGHTEST].map(|percent| percentile(volume, &statistics, percent));
    let lo = median + (NOISE_WIDTHS * (median - before)).min(MOST_NOISE * (hi - median));
    if lo < hi { (lo, hi) } else { whole_window(volume.range()) }
}

/// The whole range; of a constant volume, the values up to one more.
fn whole_window((lo, hi): (f64, f64)) -> (f64, f64) {
    if lo < hi { (lo, hi) } else { (lo, lo + 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn opacity_rises_from_the_noise_to_the_brightest_voxels() {
        // 900 voxels of noise from 0 to 9, and 100 from 100 to 199.
        let voxels: Vec<u8> = (0..1000u32).map(|n| if n < 900 { n % 10 } else { n - 800 } as u8).collect();
        let volume = Volume::new("ramp", Grid::new([10; 3], DVec3::ONE).unwrap(), voxels).unwrap();
        let transfer = TransferFunction::channel(&volume, [1.0, 0.0, 1.0]);
        let (lo, hi) = transfer.range();
        assert!((12.0..25.0).contains(&lo) && (hi - 199.0).abs() <= 1.0, "{lo} to {hi}");
        assert_eq!((transfer.opacity(lo), transfer.opacity(hi)), (0.0, OPACITY));
        assert_eq!(transfer.color(70.0), [1.0, 0.0, 1.0]);
        assert_eq!(TransferFunction::channel_ramp(&volume, [1.0; 3]).color(lo), [0.0; 3]);
    }

    #[test]
    fn a_constant_volume_has_one_too() {
        let volume = Volume::new("constant", Grid::new([2; 3], DVec3::ONE).unwrap(), vec![7u8; 8]).unwrap();
        assert_eq!(TransferFunction::channel(&volume, [1.0; 3]).range(), (7.0, 8.0));
    }
}
