//! Rendering algorithms.

use super::number::Number;
use super::{LayerAxis, Layered, Quality};
use crate::choice::choices;
use crate::error::Error;
use crate::layers::Kernel;

/// Rendering algorithm. Layered splatting casts rays by itself where no lattice applies. Ray casting approaches the converged integral. Sheets
/// and slicing are the systems that the paper compares with; they need the feature `paper`.
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
        /// Distance between sheets, in voxels along the view ([`Algorithm::SHEET_DISTANCE`]).
        sheet_distance: f64,
    },
    /// Pre-integrated slicing (Engel et al. 2001): trilinear samples on planes perpendicular to the view, and a table over the front and
    /// back values of each slab.
    Slicing {
        /// Distance between slices, in smallest spacings ([`Algorithm::STEP`]).
        step: f64,
    },
    /// Front-to-back ray casting with classification after interpolation.
    Raycast {
        /// Reconstruction kernel.
        kernel: Kernel,
        /// Distance between samples, in smallest spacings ([`Algorithm::STEP`]).
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

/// Options that only some algorithms have, as a client gives them.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlgorithmOptions {
    /// Kernel of pre-integrated layers and of ray casting.
    pub kernel: Option<Kernel>,
    /// Step of slicing and ray casting.
    pub step: Option<f64>,
    /// Sheet distance of view-sheets.
    pub sheet_distance: Option<f64>,
    /// Layer axis of layers and axis-sheets.
    pub layer_axis: Option<LayerAxis>,
}

choices! {
    Algorithm, "algorithm";
    Layered(Quality::Standard.layered()) = "layered",
    AxisSheets { layer_axis: LayerAxis::Auto } = "axis-sheets",
    ViewSheets { sheet_distance: 1.0 } = "view-sheets",
    Slicing { step: 1.0 } = "slicing",
    Raycast { kernel: Kernel::Linear, step: 0.5 } = "raycast",
}

impl Algorithm {
    /// Range of sheet distances in voxels: each splat contributes to 4 / distance + 1 sheets.
    pub const SHEET_DISTANCE: Number = Number::new("sheet_distance", 0.125, 4.0, "0.125 to 4 voxels");
    /// Range of steps, in smallest spacings.
    pub const STEP: Number = Number::new("step", 1e-3, 64.0, "0.001 to 64 times the smallest spacing");

    /// The algorithm with the given options.
    ///
    /// # Errors
    /// [`Error::Settings`] for options that it does not have.
    pub fn with(self, options: AlgorithmOptions) -> Result<Self, Error> {
        let AlgorithmOptions { kernel, step, sheet_distance, layer_axis } = options;
        let (mut used, has_step) = (self, matches!(self, Algorithm::Slicing { .. } | Algorithm::Raycast { .. }));
        match &mut used {
            Algorithm::Layered(own) => {
                let classification = kernel.map_or(own.classification, |kernel| own.classification.with_kernel(kernel));
                *own = Layered { classification, layer_axis: layer_axis.unwrap_or(own.layer_axis), ..*own };
            }
            Algorithm::AxisSheets { layer_axis: own } => *own = layer_axis.unwrap_or(*own),
            Algorithm::ViewSheets { sheet_distance: own } => *own = sheet_distance.unwrap_or(*own),
            Algorithm::Slicing { step: own } => *own = step.unwrap_or(*own),
            Algorithm::Raycast { kernel: own, step: own_step } => {
                (*own, *own_step) = (kernel.unwrap_or(*own), step.unwrap_or(*own_step));
            }
        }
        self.reject(&[
            ("kernel", kernel.is_some() && !matches!(self, Algorithm::Layered(_) | Algorithm::Raycast { .. })),
            ("step", step.is_some() && !has_step),
            ("sheet_distance", sheet_distance.is_some() && !matches!(self, Algorithm::ViewSheets { .. })),
            ("layer_axis", layer_axis.is_some() && !matches!(self, Algorithm::Layered(_) | Algorithm::AxisSheets { .. })),
        ])?;
        Ok(used)
    }

    /// Fails for the first field that is given although the algorithm does not have it.
    ///
    /// # Errors
    /// [`Error::Settings`].
    pub fn reject(self, given: &[(&'static str, bool)]) -> Result<(), Error> {
        match given.iter().find(|(_, given)| *given) {
            Some((field, _)) => {
                Err(Error::Settings { field, problem: format!("it has no meaning for {}: omit it", self.name()) })
            }
            None => Ok(()),
        }
    }

    /// Sets the layer axis; has no effect on algorithms without one.
    pub fn along(self, layer_axis: LayerAxis) -> Self {
        match self {
            Algorithm::Layered(layered) => Layered { layer_axis, ..layered }.into(),
            Algorithm::AxisSheets { .. } => Algorithm::AxisSheets { layer_axis },
            other => other,
        }
    }

    /// Checks parameter ranges.
    pub(super) fn check(self) -> Result<(), Error> {
        match self {
            Algorithm::Layered(layered) => layered.check(),
            Algorithm::AxisSheets { .. } => Ok(()),
            Algorithm::ViewSheets { sheet_distance } => Self::SHEET_DISTANCE.check(sheet_distance),
            Algorithm::Slicing { step } | Algorithm::Raycast { step, .. } => Self::STEP.check(step),
        }
    }
}
