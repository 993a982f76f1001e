//! The extent of floats, and how those are scaled that 32-bit floats of devices cannot hold.

use super::voxels::{LARGEST_MAGNITUDE, is_valid};
use rayon::prelude::*;

/// Numbers per unit of parallel work.
const BLOCK: usize = 1 << 16;
/// Narrower ranges would be flushed to zero on devices without denormals.
pub(super) const SMALLEST_RANGE: f64 = 1e-30;
/// A number that stands for missing ones is farther from 0 than all others, by this factor.
const FAR: f64 = 1e3;

/// What numbers there are; NaN and infinity are none.
#[derive(Clone, Copy)]
struct Extent {
    /// The number of the largest magnitude, and how often it occurs.
    largest: f64,
    times: u64,
    /// Smallest and largest of all others.
    others: (f64, f64),
}

fn within(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

impl Extent {
    const EMPTY: Self = Self { largest: 0.0, times: 0, others: (f64::INFINITY, f64::NEG_INFINITY) };

    fn of(number: f64) -> Self {
        if number.is_finite() { Self { largest: number, times: 1, ..Self::EMPTY } } else { Self::EMPTY }
    }

    fn joined(self, other: Self) -> Self {
        let (more, less) = if self.times == 0 || (other.times > 0 && other.largest.abs() > self.largest.abs()) {
            (other, self)
        } else {
            (self, other)
        };
        let others = within(more.others, less.others);
        match less.times {
            0 => more,
            times if less.largest == more.largest => Self { times: more.times + times, others, ..more },
            _ => Self { others: within(others, (less.largest, less.largest)), ..more },
        }
    }

    /// Smallest and largest number, without one that stands for missing ones, as 1e35 or 9.96921e36: it occurs more than once, and all others
    /// are far smaller.
    fn range(self) -> (f64, f64) {
        let next = self.others.0.abs().max(self.others.1.abs());
        let is_fill_value = !is_valid(self.largest) && self.times > 1 && next.is_finite() && self.largest.abs() > FAR * next;
        if is_fill_value || self.times == 0 { self.others } else { within(self.others, (self.largest, self.largest)) }
    }
}

/// A mapping of numbers to those of a device: number = `lowest` + `unit` · stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scaling {
    pub lowest: f64,
    highest: f64,
    /// A power of two, so that the digits of numbers stay.
    pub unit: f64,
}

impl Scaling {
    /// The scaling that numbers need, if they lie beyond 1e30 or in a range that 32-bit floats flush to zero.
    pub fn of(count: usize, number: impl Fn(usize) -> f64 + Sync) -> Option<Self> {
        let all = (0..count).into_par_iter().with_min_len(BLOCK);
        let extent = all.fold(|| Extent::EMPTY, |extent, i| extent.joined(Extent::of(number(i))));
        let (lowest, highest) = extent.reduce(|| Extent::EMPTY, Extent::joined).range();
        let width = highest - lowest;
        let is_large = lowest.abs().max(highest.abs()) > LARGEST_MAGNITUDE;
        let is_needed = width.is_finite() && width >= 0.0 && (is_large || width > 0.0 && width < SMALLEST_RANGE);
        // The width of a single number is its magnitude, so that it is of the order of 1, too.
        let width = if width > 0.0 { width } else { highest.abs() };
        is_needed.then(|| Self { lowest, highest, unit: power_below(width) })
    }

    /// The stored number of a number; NaN if it stands for a missing one.
    pub fn stored(self, number: f64) -> f32 {
        if (self.lowest..=self.highest).contains(&number) { ((number - self.lowest) / self.unit) as f32 } else { f32::NAN }
    }
}

/// The largest power of two up to a positive number.
fn power_below(number: f64) -> f64 {
    let bits = number.to_bits();
    match bits >> 52 {
        // Subnormal numbers have no exponent of their own.
        0 => f64::from_bits(1 << (63 - bits.leading_zeros())),
        exponent => f64::from_bits(exponent << 52),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(numbers: &[f64]) -> Option<Scaling> {
        Scaling::of(numbers.len(), |i| numbers[i])
    }

    #[test]
    fn powers_of_two_are_units() {
        for (number, expected) in
            [(1.0, 1.0), (1.5e33, 2f64.powi(110)), (1e-60, 2f64.powi(-200)), (5e-324, 5e-324), (1e-310, 2f64.powi(-1030))]
        {
            assert_eq!(power_below(number), expected, "{number}");
        }
    }

    #[test]
    fn numbers_that_floats_cannot_hold_are_scaled() {
        for numbers in
            [[0.0, 3e33, 1e33], [-2e33, 0.0, 2e30], [1e-60, 3e-60, 2e-60], [0.0, 1e-310, 5e-311], [1e300, 2e300, 3e300]]
        {
            let scaling = of(&numbers).unwrap();
            for number in numbers {
                let stored = f64::from(scaling.stored(number));
                let found = scaling.lowest + scaling.unit * stored;
                // Half a step of a float.
                assert!((found - number).abs() <= scaling.unit * 2f64.powi(-24), "{found} for {number}");
                assert!((0.0..2.0).contains(&stored));
            }
        }
        for ordinary in [&[0.0, 1.0][..], &[1e30, -1e30], &[5.0, 5.0], &[], &[f64::NAN], &[0.0, 1e-29], &[f64::MIN, f64::MAX]] {
            assert_eq!(of(ordinary), None, "{ordinary:?}");
        }
        let constant = of(&[4e33; 5]).unwrap();
        assert_eq!((constant.lowest, constant.stored(4e33)), (4e33, 0.0));
    }

    #[test]
    fn numbers_that_stand_for_missing_ones_are_none() {
        assert_eq!(of(&[0.0, 280.0, 1e35, 1e35]), None);
        let tiny = of(&[1e-60, 3e-60, 1e35, 1e35, f64::INFINITY]).unwrap();
        assert!(tiny.stored(1e35).is_nan() && tiny.stored(f64::INFINITY).is_nan() && tiny.stored(3e-60) > 0.0);
        let large = of(&[0.0, 3e31, 1e38, 5e31, 1e38]).unwrap();
        assert!(large.stored(1e38).is_nan() && large.stored(5e31) > large.stored(3e31));
        // One peak, and peaks that other numbers come close to.
        assert!(of(&[0.0, 280.0, 1e35]).is_some() && of(&[0.0, 9e29, 1.5e30, 1.5e30]).is_some());
    }
}
