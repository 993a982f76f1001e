//! Lookup table of a transfer function, for the device.

use super::TransferFunction;
use crate::choice::choices;
use crate::color::reflectance;

/// Attenuation over a distance, as a function of opacity.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::transfer::Extinction;
///
/// let settings = Settings { extinction: Extinction::Linear, ..Settings::default() };
/// assert_ne!(settings, Settings::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extinction {
    /// Transmittance e^{−τΔt} with τ = −ln(1−α): exact for a homogeneous segment of any length (paper §3.3).
    Exponential,
    /// Transmittance 1 − min(1, αΔt): the first two terms of its series, equal to α blending (the paper's comparison).
    Linear,
}

choices! { Extinction, "extinction"; Exponential = "exponential", Linear = "linear" }

/// Entries per smallest distance between control points; resolves the steepest segment to 3 %.
const ENTRIES_PER_GAP: f64 = 32.0;
/// At least 4096 entries (64 KiB), sixteen per value of 8-bit data. The error of the nearest entry then stays within the fidelity
/// limits of the tests.
const MIN_ENTRIES: usize = 4096;
const MAX_ENTRIES: usize = 1 << 16;
/// Stands for an infinite extinction: e^{−1e30·Δt} is 0 for any Δt that can occur, and 1e30·Δt never overflows.
const OPAQUE: f64 = 1e30;

/// Evenly spaced samples of a transfer function over the values that can occur. Values outside the table take its first or last
/// entry.
///
/// ```
/// use layersplat::TransferFunction;
/// use layersplat::transfer::{Extinction, TransferTable};
///
/// let transfer = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 0.5)])?;
/// let table = TransferTable::new(&transfer, (0.0, 255.0), Extinction::Exponential);
/// assert_eq!(table.first, 0.0);
/// assert_eq!(table.entries[0][3], 0.0);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTable {
    /// r, g, b, and τ or α per unit distance, according to the kind of [`Extinction`].
    pub entries: Vec<[f32; 4]>,
    /// Value of the first entry.
    pub first: f64,
    /// Entries per unit of value; 0 for a single value.
    pub per_value: f64,
}

impl TransferTable {
    /// Samples `transfer` over the intersection of its control points and `field_range`, the range of interpolated values.
    pub fn new(transfer: &TransferFunction, field_range: (f64, f64), extinction: Extinction) -> Self {
        let (lo, hi) = sampled_range(transfer, field_range);
        let count = Self::entry_count(transfer, field_range);
        // One entry before the first point, so that a step there does not affect lower values.
        let below = usize::from(field_range.0 < lo);
        let step = (hi - lo) / (count - 1 - below) as f64;
        let lo = lo - below as f64 * step;
        // If the range is too narrow for f32, values outside it must still map to the first or last entry.
        let per_value = if step > 0.0 { (1.0 / step).min(f64::from(f32::MAX) / count as f64) } else { 0.0 };
        let entries = (0..count)
            .map(|i| {
                let value = lo + i as f64 * step;
                let [r, g, b] = transfer.color(value);
                let attenuation = match extinction {
                    Extinction::Exponential => transfer.extinction(value).min(OPAQUE),
                    Extinction::Linear => transfer.opacity(value),
                };
                [r, g, b, attenuation].map(|c| c as f32)
            })
            .collect();
        Self { entries, first: lo, per_value }
    }

    /// The table with its extinctions (with [`Extinction::Linear`], its opacities per unit distance) times a factor of at least 0.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.entries.iter_mut().for_each(|entry| entry[3] = (f64::from(entry[3]) * factor).min(OPAQUE) as f32);
        self
    }

    /// The table with reflectances in linear light for colours.
    #[doc(hidden)]
    pub fn in_linear_light(mut self) -> Self {
        let reflectances = |color: &mut [f32]| color.iter_mut().for_each(|c| *c = reflectance(f64::from(*c)) as f32);
        self.entries.iter_mut().for_each(|entry| reflectances(&mut entry[..3]));
        self
    }

    /// Number of entries of the table.
    #[doc(hidden)]
    pub fn entry_count(transfer: &TransferFunction, field_range: (f64, f64)) -> usize {
        let (lo, hi) = sampled_range(transfer, field_range);
        let wanted = transfer.smallest_gap().map_or(0.0, |gap| ENTRIES_PER_GAP * (hi - lo) / gap);
        (wanted.min(MAX_ENTRIES as f64) as usize).next_power_of_two().clamp(MIN_ENTRIES, MAX_ENTRIES)
    }

    /// First and last entry with an opacity above 0; `[1, 0]` if all entries are transparent.
    pub fn visible_entries(&self) -> [i32; 2] {
        let visible = |entry: &[f32; 4]| entry[3] > 0.0;
        let ends = self.entries.iter().position(visible).zip(self.entries.iter().rposition(visible));
        ends.map_or([1, 0], |(first, last)| [first as i32, last as i32])
    }

    /// Prefix sums of visible entries, one more than entries: some entry in a … b is visible if `count[b+1] > count[a]`.
    pub fn visible_before(&self) -> Vec<u32> {
        let mut count = 0;
        let mut before = Vec::with_capacity(self.entries.len() + 1);
        before.push(0);
        before.extend(self.entries.iter().map(|entry| {
            count += u32::from(entry[3] > 0.0);
            count
        }));
        before
    }
}

/// Intersection of the range of the control points and the range of interpolated values.
fn sampled_range(transfer: &TransferFunction, field_range: (f64, f64)) -> (f64, f64) {
    let (from, to) = transfer.range();
    // All points are at one value: a step or a constant.
    let (from, to) = if from < to { (from, to) } else { field_range };
    (from.clamp(field_range.0, field_range.1), to.clamp(field_range.0, field_range.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transfer(opacities: Vec<(f64, f64)>) -> TransferFunction {
        TransferFunction::new("t", vec![(0.0, [1.0, 0.5, 0.0])], opacities).unwrap()
    }

    #[test]
    fn entries_are_samples_where_values_and_points_overlap() {
        let table = TransferTable::new(&transfer(vec![(0.0, 0.0), (100.0, 0.5)]), (20.0, 300.0), Extinction::Linear);
        let n = table.entries.len();
        assert_eq!((table.first, table.entries[0][3]), (20.0, 0.1));
        assert_eq!(table.entries[n - 1][3], 0.5);
        assert!((table.per_value * 80.0 - (n - 1) as f64).abs() < 1e-6);
    }

    #[test]
    fn opaque_is_finite_and_one_value_is_enough() {
        let table = TransferTable::new(&transfer(vec![(0.0, 1.0)]), (5.0, 5.0), Extinction::Exponential);
        assert_eq!((table.entries[0][3], table.per_value), (1e30, 0.0));
    }

    #[test]
    fn a_step_at_the_first_point_leaves_what_is_below_it() {
        for opacities in [vec![(100.0, 0.0), (100.0, 1.0), (200.0, 1.0)], vec![(100.0, 0.0), (100.0, 1.0)]] {
            let step = TransferFunction::new("t", vec![(100.0, [1.0; 3])], opacities).unwrap();
            let table = TransferTable::new(&step, (0.0, 150.0), Extinction::Linear);
            let entry = |v: f64| table.entries[((v - table.first) * table.per_value).round().clamp(0.0, 4095.0) as usize][3];
            assert_eq!((entry(0.0), entry(99.0), entry(101.0), entry(150.0)), (0.0, 0.0, 1.0, 1.0));
        }
    }

    #[test]
    fn fine_functions_get_longer_tables() {
        let fine = transfer(vec![(0.0, 0.0), (30_000.0, 0.0), (30_020.0, 0.5), (65_535.0, 0.5)]);
        assert_eq!(TransferTable::new(&fine, (0.0, 65_535.0), Extinction::Linear).entries.len(), MAX_ENTRIES);
    }

    #[test]
    fn visible_entries_are_counted() {
        let table =
            TransferTable::new(&transfer(vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0)]), (0.0, 2.0), Extinction::Linear);
        let before = table.visible_before();
        let n = table.entries.len();
        assert_eq!((before[n / 2], before[n]), (0, (n / 2) as u32));
        assert_eq!(table.visible_entries(), [(n / 2) as i32, n as i32 - 1]);
    }
}
