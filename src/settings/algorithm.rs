//! Rendering algorithms.

use super::{LayerAxis, Layered};
use crate::error::Error;
use crate::layers::Kernel;

/// Rendering algorithm. Layered splatting casts rays by itself where no lattice applies. Ray casting approaches the converged integral. Sheets
/// and slicing are the systems that the paper compares with.
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
    /// Layered volume splatting (the paper).
    Layered(Layered),
    /// Axis-aligned sheet-buffer splatting (Westover 1990): voxels are classified and shaded, then splatted with a Gaussian of radius 2 into
    /// one sheet per slice.
    AxisSheets {
        /// Axis perpendicular to the sheets. A forced axis is an error if the view deviates from it by more than three voxels per layer.
        layer_axis: LayerAxis,
    },
    /// Image-aligned sheet-buffer splatting (Mueller & Crawfis 1998; Neophytou & Mueller 2005). Voxels are sorted along the view in every
    /// frame and splatted with slabs of a Gaussian of radius 2. Sheets are classified and shaded per pixel.
    ViewSheets {
        /// Distance between sheets, in voxels along the view ([`Algorithm::SHEET_DISTANCES`]).
        sheet_distance: f64,
    },
    /// Pre-integrated slicing (Engel et al. 2001): trilinear samples on planes perpendicular to the view, and a table over the front and
    /// back values of each slab.
    Slicing {
        /// Distance between slices, in smallest spacings ([`Algorithm::STEPS`]).
        step: f64,
    },
    /// Front-to-back ray casting with classification after interpolation.
    Raycast {
        /// Reconstruction kernel.
        kernel: Kernel,
        /// Distance between samples, in smallest spacings ([`Algorithm::STEPS`]).
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
    /// Default distance between sheets, in voxels.
    pub const SHEET_DISTANCE: f64 = 1.0;
    /// Default distance between slices, in smallest spacings.
    pub const SLICE_DISTANCE: f64 = 1.0;
    /// Range of sheet distances in voxels: each splat contributes to 4 / distance + 1 sheets.
    pub const SHEET_DISTANCES: (f64, f64) = (0.125, 4.0);
    /// Range of steps, in smallest spacings.
    pub const STEPS: (f64, f64) = (1e-3, 64.0);

    /// Sets the layer axis; has no effect on algorithms without one.
    pub fn along(self, layer_axis: LayerAxis) -> Self {
        match self {
            Algorithm::Layered(layered) => Layered { layer_axis, ..layered }.into(),
            Algorithm::AxisSheets { .. } => Algorithm::AxisSheets { layer_axis },
            other => other,
        }
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Algorithm::Layered(_) => "layered",
            Algorithm::AxisSheets { .. } => "axis-sheets",
            Algorithm::ViewSheets { .. } => "view-sheets",
            Algorithm::Slicing { .. } => "slicing",
            Algorithm::Raycast { .. } => "raycast",
        }
    }

    /// Checks parameter ranges.
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
