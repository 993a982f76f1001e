//! Grey ramps for projections of values: maximum, minimum and average.

use super::visible_range::visible_range;
use super::{TransferFunction, Value};
use crate::volume::Volume;

/// Percentiles of the voxels at the ends of a ramp. A few extreme voxels (metal, hot pixels) must not darken all others.
const ENDS: [Value; 2] = [Value::Percentile(0.5), Value::Percentile(99.9)];

impl TransferFunction {
    /// Name of transfer functions made by [`TransferFunction::grey_ramp`].
    pub const GREY_RAMP: &str = "grey ramp";
    /// Name of transfer functions made by [`TransferFunction::inverted_grey_ramp`].
    pub const INVERTED_GREY_RAMP: &str = "inverted grey ramp";

    /// A ramp from black to white, and of opacity from 0 to 1, for maximum and average intensity projections. It spans the percentiles
    /// 0.5 to 99.9 of the volume's voxels, or the range of the data if these two are equal, as in sparse volumes.
    ///
    /// ```
    /// use layersplat::volume::{Grid, Voxels};
    /// use layersplat::{TransferFunction, Volume, glam::DVec3};
    ///
    /// let bytes = Voxels::Uint8((0..=255).collect());
    /// let volume = Volume::new("ramp", Grid::new([16, 16, 1], DVec3::ONE)?, bytes)?;
    /// let (ramp, inverted) = (TransferFunction::grey_ramp(&volume), TransferFunction::inverted_grey_ramp(&volume));
    /// assert_eq!((ramp.color(0.0), ramp.color(255.0)), ([0.0; 3], [1.0; 3]));
    /// assert_eq!((inverted.color(0.0), inverted.color(255.0)), ([1.0; 3], [0.0; 3]));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn grey_ramp(volume: &Volume) -> Self {
        ramp(Self::GREY_RAMP, volume, [0.0, 1.0])
    }

    /// As [`TransferFunction::grey_ramp`], from white to black, for minimum intensity projections: the smallest values are the brightest.
    pub fn inverted_grey_ramp(volume: &Volume) -> Self {
        ramp(Self::INVERTED_GREY_RAMP, volume, [1.0, 0.0])
    }
}

/// A ramp between two grey levels, which are also its opacities.
fn ramp(name: &str, volume: &Volume, levels: [f64; 2]) -> TransferFunction {
    let find = Value::finder(volume);
    let [lo, hi] = ENDS.map(find);
    let (lo, hi) = if lo < hi { (lo, hi) } else { visible_range(volume) };
    let [first, last] = levels;
    TransferFunction::new(name, vec![(lo, [first; 3]), (hi, [last; 3])], vec![(lo, first), (hi, last)]).expect("ascending")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Grid, Voxels};
    use glam::DVec3;

    /// Percentiles are bin edges: 1/256 of the range, at most.
    const BIN: f64 = 1.0 / 256.0;

    fn volume(values: Vec<f32>) -> Volume<'static> {
        Volume::new("t", Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap(), Voxels::Float32(values)).unwrap()
    }

    #[test]
    fn ends_are_percentiles_and_outliers_do_not_count() {
        // 10,000 values from 0 to 1, and one voxel of metal.
        let mut values: Vec<f32> = (0..10_000).map(|i| i as f32 / 9_999.0).collect();
        let plain = TransferFunction::grey_ramp(&volume(values.clone())).range();
        assert!((plain.0 - 0.005).abs() <= BIN && (plain.1 - 0.999).abs() <= BIN, "{plain:?}");
        values[5_000] = 3000.0;
        let with_metal = TransferFunction::grey_ramp(&volume(values.clone()));
        assert!((with_metal.range().1 - 0.999).abs() <= BIN, "{:?}", with_metal.range());
        assert!((with_metal.color(0.5)[1] - 0.5).abs() < 0.01 && with_metal.color(3000.0) == [1.0; 3]);
        let inverted = TransferFunction::inverted_grey_ramp(&volume(values));
        assert_eq!((inverted.range(), inverted.color(-1.0), inverted.color(2.0)), (with_metal.range(), [1.0; 3], [0.0; 3]));
    }

    /// Where both percentiles are one value, the ramp spans the data; constant volumes get one as well.
    #[test]
    fn sparse_and_constant_volumes_have_ramps() {
        let mut sparse = vec![0.0; 10_000];
        (sparse[77], sparse[78]) = (40.0, 20.0);
        let ramp = TransferFunction::grey_ramp(&volume(sparse));
        assert_eq!((ramp.range(), ramp.color(20.0)), ((0.0, 40.0), [0.5; 3]));
        for value in [0.0, 7.0, -7.0, 9e29] {
            let (lo, hi) = TransferFunction::grey_ramp(&volume(vec![value; 8])).range();
            assert!(lo < hi && (lo..=hi).contains(&f64::from(value)), "{value}: {lo} to {hi}");
        }
        let mask = TransferFunction::grey_ramp(&volume((0..1000).map(|i| f32::from(i % 3 == 0)).collect()));
        assert_eq!((mask.color(0.0), mask.color(1.0)), ([0.0; 3], [1.0; 3]));
    }
}
