//! Values of options for which the library has no type.

use crate::transfer::Value;
use crate::volume::OpenOptions;
use clap::ValueEnum;

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

/// How components are drawn as colours.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(super) enum Colors {
    Direct,
    Direction,
    None,
}

/// The value of `--level`.
#[derive(Clone, Copy)]
pub(super) enum LevelChoice {
    Auto,
    Number(usize),
}

/// A component of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Component {
    Number(usize),
    Name(String),
}

impl Component {
    /// The options with which a file is opened at the component.
    pub fn chosen(&self, options: OpenOptions) -> OpenOptions {
        match self {
            Self::Number(number) => OpenOptions { channel: Some(*number), channel_name: None, ..options },
            Self::Name(name) => OpenOptions { channel: None, channel_name: Some(name.clone()), ..options },
        }
    }
}

/// The value of `--channel`.
#[derive(Clone)]
pub(super) enum ChannelChoice {
    One(Component),
    Magnitude,
}

/// A place along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Along {
    Coordinate(f64),
    /// Share of the volume's extent, 0 … 1.
    Share(f64),
}
