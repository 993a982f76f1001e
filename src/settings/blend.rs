//! What becomes of the values along a ray.

use crate::error::Error;

/// How the values along a ray make a pixel.
///
/// Maximum, minimum and average are taken among the voxels, on \[0, n − 1\] of each axis, where no background enters, and shown through
/// the transfer function's colours, opaque, without its opacity.
///
/// ```
/// use layersplat::settings::{Blend, Settings};
///
/// let surface = Settings { blend: Blend::Iso(90.0), ..Settings::default() };
/// assert_eq!(surface.blend.name(), "iso");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Blend {
    /// Emission and absorption, front to back.
    #[default]
    Composite,
    /// The largest value.
    Maximum,
    /// The smallest value.
    Minimum,
    /// The mean over the ray's length.
    Average,
    /// The first surface where the field has this value, shaded, opaque, in the transfer function's colour there. Where a segment between
    /// two samples crosses it; with several samples per layer, as in `high`, refined on the field itself. Where no lattice reaches and rays
    /// are cast instead, these go in quarters of a spacing at most and are not refined.
    Iso(f64),
}

impl Blend {
    /// Whether values are gathered along rays, and no background may enter.
    pub fn gathers_values(self) -> bool {
        matches!(self, Blend::Maximum | Blend::Minimum | Blend::Average)
    }

    /// The same of numbers that are the smaller the larger values are.
    pub(crate) fn reversed(self) -> Self {
        match self {
            Blend::Maximum => Blend::Minimum,
            Blend::Minimum => Blend::Maximum,
            other => other,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Blend::Composite => "composite",
            Blend::Maximum => "maximum",
            Blend::Minimum => "minimum",
            Blend::Average => "average",
            Blend::Iso(_) => "iso",
        }
    }

    /// Checks its number.
    pub(super) fn check(self) -> Result<(), Error> {
        match self {
            Blend::Iso(value) if !value.is_finite() => Err(Error::OutOfRange {
                name: "blend",
                value: value.to_string(),
                expected: "an iso-value that is a finite number",
            }),
            _ => Ok(()),
        }
    }
}
