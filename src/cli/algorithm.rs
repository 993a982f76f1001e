//! Options that select the algorithm.

use super::{names, parse};
use crate::layers::Kernel;
use crate::settings::{Algorithm, LayerAxis, Layered};
use clap::{Args, ValueEnum};

/// Selection of the algorithm, with the options that only some algorithms have.
#[derive(Args)]
pub(super) struct AlgorithmOptions {
    /// Rendering algorithm: layered, or one that the paper compares with
    #[arg(long, default_value = "layered", value_name = "NAME", value_parser = names::of_enum::<AlgorithmName>())]
    algorithm: AlgorithmName,
    /// Sheet distance of view-sheets in voxels, 0.125 to 4 [default: 1]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    sheet_distance: Option<f64>,
    /// Step of slicing or raycast, relative to the smallest spacing [default: slicing 1, raycast 0.5]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    step: Option<f64>,
    /// Reconstruction kernel; splats (post) are always cubic, gaussian needs raycast [default: by --quality; raycast: linear]
    #[arg(long, visible_alias = "interpolation", value_name = "NAME", value_parser = names::of_enum::<KernelName>())]
    kernel: Option<KernelName>,
}

#[derive(Clone, Copy, ValueEnum)]
enum AlgorithmName {
    Layered,
    AxisSheets,
    ViewSheets,
    Slicing,
    Raycast,
}

/// A reconstruction kernel by name.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum KernelName {
    #[value(alias = "tricubic")]
    Cubic,
    #[value(alias = "trilinear")]
    Linear,
    CatmullRom,
    Bspline,
    Gaussian,
}

impl AlgorithmOptions {
    /// The selected algorithm. `layered` and `layer_axis` come from the other options.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for options that the algorithm does not have.
    pub fn algorithm(&self, layered: Layered, layer_axis: LayerAxis) -> Result<Algorithm, crate::Error> {
        let algorithm = match self.algorithm {
            AlgorithmName::Layered => Algorithm::Layered(Layered { layer_axis, ..layered }),
            AlgorithmName::AxisSheets => Algorithm::AxisSheets { layer_axis },
            AlgorithmName::ViewSheets => {
                Algorithm::ViewSheets { sheet_distance: self.sheet_distance.unwrap_or(Algorithm::SHEET_DISTANCE) }
            }
            AlgorithmName::Slicing => Algorithm::Slicing { step: self.step.unwrap_or(Algorithm::SLICE_DISTANCE) },
            AlgorithmName::Raycast => {
                Algorithm::Raycast { kernel: self.kernel().unwrap_or(Kernel::Linear), step: self.step.unwrap_or(0.5) }
            }
        };
        let kernels = matches!(algorithm, Algorithm::Layered(_) | Algorithm::Raycast { .. });
        let steps = matches!(algorithm, Algorithm::Slicing { .. } | Algorithm::Raycast { .. });
        let given = [
            (self.sheet_distance.is_some() && !matches!(algorithm, Algorithm::ViewSheets { .. }), "sheet_distance"),
            (self.step.is_some() && !steps, "step"),
            (self.kernel.is_some() && !kernels, "kernel"),
        ];
        reject_unsupported(algorithm, &given)?;
        Ok(algorithm)
    }

    /// The kernel given by `--kernel`.
    pub fn kernel(&self) -> Option<Kernel> {
        self.kernel.map(KernelName::kernel)
    }
}

impl KernelName {
    pub fn kernel(self) -> Kernel {
        match self {
            KernelName::Cubic => Kernel::Cubic,
            KernelName::Linear => Kernel::Linear,
            KernelName::CatmullRom => Kernel::CatmullRom,
            KernelName::Bspline => Kernel::BSpline,
            KernelName::Gaussian => Kernel::Gaussian,
        }
    }
}

/// Fails for the first given field that the algorithm does not support.
pub(super) fn reject_unsupported(algorithm: Algorithm, given: &[(bool, &'static str)]) -> Result<(), crate::Error> {
    match given.iter().find(|(given, _)| *given) {
        Some((_, field)) => {
            let problem = format!("it has no meaning for {}: omit it", algorithm.name());
            Err(crate::Error::Settings { field, problem })
        }
        None => Ok(()),
    }
}
