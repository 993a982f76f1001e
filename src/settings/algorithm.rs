//! Which renderer makes a picture.

use super::{LayerAxis, Layered};
use crate::error::Error;
use crate::layers::Kernel;

/// Which renderer makes the picture. All but the first are what the paper compares with, in the same house.
///
/// ```
/// use layersplat::Kernel;
/// use layersplat::settings::{Algorithm, Settings};
///
/// let reference = Settings::from(Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.25 });
/// assert_eq!(reference.algorithm.name(), "raycast");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Algorithm {
    /// Layered volume splatting.
    Layered(Layered),
    /// Axis-aligned sheet-buffer splatting (Westover 1990): voxels are classified and shaded, then splatted with a Gaussian
    /// of radius 2 into one sheet per slice.
    AxisSheets {
        /// Which axis sheets are along. An error where the view is more than three voxels per layer away from a forced one.
        layer_axis: LayerAxis,
    },
    /// Image-aligned sheet-buffer splatting (Mueller & Crawfis 1998; Neophytou & Mueller 2005): voxels are sorted along the
    /// view in every frame and splatted with slabs of a Gaussian of radius 2; sheets are classified and shaded per pixel.
    ViewSheets {
        /// Distance of sheets, in voxels along the view ([`Algorithm::SHEET_DISTANCES`]).
        sheet_distance: f64,
    },
    /// Pre-integrated slicing (Engel et al. 2001): trilinear samples on planes at right angles to the view, a table over the
    /// values in front of and behind each slab.
    Slicing {
        /// Distance of slices, in smallest spacings ([`Algorithm::STEPS`]).
        step: f64,
    },
    /// Ray casting, front to back, each sample classified after interpolation.
    Raycast {
        /// The kernel that reconstructs the field.
        kernel: Kernel,
        /// Distance of samples, in smallest spacings ([`Algorithm::STEPS`]).
        step: f64,
    },
}

impl Default for Algorithm {
    fn default() -> Self {
        Algorithm::Layered(Layered::default())
    }
}

impl From<Layered> for Algorithm {
    fn from(layered: Layered) -> Self {
        Algorithm::Layered(layered)
    }
}

impl Algorithm {
    /// The default distance of sheets.
    pub const SHEET_DISTANCE: f64 = 1.0;
    /// The default distance of slices.
    pub const SLICE_DISTANCE: f64 = 1.0;
    /// Distances of sheets that are accepted: each splat writes 4 / distance + 1 sheets.
    pub const SHEET_DISTANCES: (f64, f64) = (0.125, 4.0);
    /// Steps that are accepted.
    pub const STEPS: (f64, f64) = (1e-3, 64.0);

    /// The same along a layer axis; what has none stays as it is.
    pub fn along(self, layer_axis: LayerAxis) -> Self {
        match self {
            Algorithm::Layered(layered) => Layered { layer_axis, ..layered }.into(),
            Algorithm::AxisSheets { .. } => Algorithm::AxisSheets { layer_axis },
            other => other,
        }
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Algorithm::Layered(_) => "layered",
            Algorithm::AxisSheets { .. } => "axis-sheets",
            Algorithm::ViewSheets { .. } => "view-sheets",
            Algorithm::Slicing { .. } => "slicing",
            Algorithm::Raycast { .. } => "raycast",
        }
    }

    /// Checks its number.
    pub(super) fn check(self) -> Result<(), Error> {
        let (name, value, (from, to), expected) = match self {
            Algorithm::Layered(layered) => return layered.check(),
            Algorithm::AxisSheets { .. } => return Ok(()),
            Algorithm::ViewSheets { sheet_distance } => {
                ("sheet_distance", sheet_distance, Self::SHEET_DISTANCES, "0.125 to 4 voxels")
            }
            Algorithm::Slicing { step } | Algorithm::Raycast { step, .. } => {
                ("step", step, Self::STEPS, "0.001 to 64 times the smallest spacing")
            }
        };
        if (from..=to).contains(&value) {
            return Ok(());
        }
        Err(Error::OutOfRange { name, value: value.to_string(), expected })
    }
}
