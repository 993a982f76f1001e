//! Blend modes.

use crate::choice::choices;
use crate::error::Error;

/// Blend mode: combination of the values along a ray to a pixel.
///
/// Maximum, minimum and average consider the voxel region \[0, n − 1\] of each axis only, without background. They are displayed in the
/// colours of the transfer function, opaque; its opacities are ignored.
///
/// ```
/// use layersplat::settings::{Blend, Settings};
///
/// let surface = Settings { blend: Blend::Iso(90.0), ..Settings::default() };
/// assert_eq!(surface.blend.name(), "iso");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Blend {
    /// Front-to-back compositing of emission and absorption.
    #[default]
    Composite,
    /// Maximum intensity projection.
    Maximum,
    /// Minimum intensity projection.
    Minimum,
    /// Mean over the length of the ray.
    Average,
    /// First iso-surface of the field at this value, shaded and opaque, in the transfer function's colour.
    ///
    /// The surface is found where a segment between two samples crosses the value. With several samples per layer, as in `high`, it is
    /// refined on the field. Ray casting, which replaces lattices that cannot cover a view, uses steps of at most a quarter of a spacing
    /// without refinement.
    Iso(f64),
}

choices! { Blend, "blend"; Composite = "composite", Maximum = "maximum", Minimum = "minimum", Average = "average", Iso(0.0) = "iso" }

impl Blend {
    /// The mode with this iso-value, if it has one.
    pub fn at(self, iso: f64) -> Self {
        if let Blend::Iso(_) = self { Blend::Iso(iso) } else { self }
    }

    /// Whether the mode reduces values along rays, excluding background.
    pub fn gathers_values(self) -> bool {
        matches!(self, Blend::Maximum | Blend::Minimum | Blend::Average)
    }

    /// The corresponding mode for stored numbers that decrease with increasing value.
    #[doc(hidden)]
    pub fn reversed(self) -> Self {
        match self {
            Blend::Maximum => Blend::Minimum,
            Blend::Minimum => Blend::Maximum,
            other => other,
        }
    }

    /// Checks the iso-value.
    #[doc(hidden)]
    pub fn check(self) -> Result<(), Error> {
        match self {
            Blend::Iso(value) if !value.is_finite() => {
                Err(Error::OutOfRange { name: "blend", value: value.to_string(), expected: "a finite iso-value" })
            }
            _ => Ok(()),
        }
    }
}
