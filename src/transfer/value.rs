//! Values that are given as numbers, or as percentiles of a volume's voxels.

use crate::error::Error;
use crate::volume::{Statistics, Volume};
use std::cell::OnceCell;
use std::str::FromStr;

/// A data value: a number, or `p0` … `p100`, what so many percent of a volume's voxels do not exceed.
///
/// ```
/// use layersplat::{RawOptions, Volume};
/// use layersplat::transfer::Value;
///
/// let volume = Volume::open("builtin:hydrogen@32", &RawOptions::default())?;
/// let (bright, all): (Value, Value) = ("p99.5".parse()?, "p100".parse()?);
/// let find = Value::finder(&volume);
/// assert!(find(bright) < find(all));
/// assert_eq!(find(Value::Number(7.5)), 7.5);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// The value itself, finite.
    Number(f64),
    /// Percent of the voxels, 0 … 100.
    Percentile(f64),
}

impl Value {
    /// The value among voxels with these statistics. Percentiles are as fine as a bin of the histogram is wide; `p0` is the smallest
    /// value.
    pub fn among(self, statistics: &Statistics) -> f64 {
        match self {
            Value::Number(number) => number,
            Value::Percentile(percent) if percent <= 0.0 => statistics.min,
            Value::Percentile(percent) => statistics.quantile(percent / 100.0),
        }
    }

    /// What finds values among a volume's voxels, with a pass over them for the first percentile.
    pub fn finder<'a>(volume: &'a Volume<'_>) -> impl Fn(Value) -> f64 + 'a {
        let statistics = OnceCell::new();
        move |value| match value {
            Value::Number(number) => number,
            percentile => percentile.among(statistics.get_or_init(|| volume.statistics())),
        }
    }
}

impl FromStr for Value {
    type Err = Error;

    /// A finite number, or `pN` with N from 0 to 100.
    fn from_str(text: &str) -> Result<Self, Error> {
        let text = text.trim();
        let value = match text.strip_prefix(['p', 'P']) {
            Some(percent) => percent.parse().ok().filter(|p| (0.0..=100.0).contains(p)).map(Value::Percentile),
            None => text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Number),
        };
        let expected = "a finite number, or a percentile from p0 to p100";
        value.ok_or_else(|| Error::OutOfRange { name: "value", value: format!("'{text}'"), expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn numbers_and_percentiles() {
        for (text, value) in [
            ("12.5", Value::Number(12.5)),
            (" -1e3 ", Value::Number(-1000.0)),
            ("p99.5", Value::Percentile(99.5)),
            ("P0", Value::Percentile(0.0)),
            ("p100", Value::Percentile(100.0)),
        ] {
            assert_eq!(text.parse::<Value>().unwrap(), value, "{text}");
        }
        for bad in ["", "p", "p101", "p-1", "pNaN", "NaN", "inf", "1e999", "99p", "5%", "p p5"] {
            let message = bad.parse::<Value>().unwrap_err().to_string();
            assert!(message.contains("p100") && message.contains(bad), "{bad}: {message}");
        }
    }

    /// Bytes have a bin each: what is found is what sorting finds, to a bin.
    #[test]
    fn percentiles_are_those_of_the_sorted_voxels() {
        let mut voxels: Vec<u8> = (0..4000u32).map(|i| (i * i / 63_000) as u8).collect();
        voxels[0] = 255;
        let volume = Volume::new("t", Grid::new([4000, 1, 1], DVec3::ONE).unwrap(), voxels.clone()).unwrap();
        let find = Value::finder(&volume);
        voxels.sort_unstable();
        for percent in [0.0, 1.0, 50.0, 90.0, 99.5, 100.0] {
            let rank = (percent / 100.0 * 4000.0f64).ceil().max(1.0) as usize - 1;
            let (found, sorted) = (find(Value::Percentile(percent)), f64::from(voxels[rank]));
            assert!((found - sorted).abs() <= 1.0, "p{percent}: {found} for {sorted}");
        }
        assert_eq!((find(Value::Percentile(0.0)), find(Value::Percentile(100.0))), (0.0, 255.0));
    }
}
