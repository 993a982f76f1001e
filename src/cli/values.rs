//! Values of options for which the library has no type.

use crate::transfer::Value;

/// Opacities at data values, before percentiles are resolved.
#[derive(Clone)]
pub(super) struct Opacities(pub Vec<(Value, f64)>);

/// A triangular opacity peak, before percentiles are resolved.
#[derive(Clone, Copy)]
pub(super) struct Tent {
    pub value: Value,
    pub width: f64,
    pub opacity: f64,
}

/// A distance, or no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach(pub Option<f64>);

/// The value of `--level`.
#[derive(Clone, Copy)]
pub(super) enum LevelChoice {
    Auto,
    Number(usize),
}

/// The value of `--channel`.
#[derive(Clone, Copy)]
pub(super) enum ChannelChoice {
    Number(usize),
    Magnitude,
}

/// A place along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Along {
    Coordinate(f64),
    /// Share of the volume's extent, 0 … 1.
    Share(f64),
}
