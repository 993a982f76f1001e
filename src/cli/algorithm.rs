//! The options that choose a renderer.

use super::parse;
use crate::layers::Kernel;
use crate::settings::{Algorithm, LayerAxis, Layered};
use clap::{Args, ValueEnum};

/// Which renderer.
#[derive(Args)]
pub(super) struct AlgorithmOptions {
    /// layered, or one of those that the paper compares with
    #[arg(long, default_value = "layered")]
    algorithm: AlgorithmName,
    /// Distance of view-sheets in voxels: 0.125 to 4 [default: 1]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    sheet_distance: Option<f64>,
    /// Distance of slices (slicing) or samples (raycast) in smallest spacings [default: 1 and 0.5]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    step: Option<f64>,
    /// What reconstructs the field, of layered (not with --classification post, which splats the cubic) and raycast; gaussian of raycast
    /// only [default: by --quality; of raycast linear]
    #[arg(long, visible_alias = "interpolation")]
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

#[derive(Clone, Copy, ValueEnum)]
enum KernelName {
    #[value(alias = "tricubic")]
    Cubic,
    #[value(alias = "trilinear")]
    Linear,
    CatmullRom,
    Bspline,
    Gaussian,
}

impl AlgorithmOptions {
    /// The algorithm that was asked for, or what is contradictory; `layered` and `layer_axis` are what other options say of these.
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
        no_meaning(algorithm, &given)?;
        Ok(algorithm)
    }

    /// The kernel that was asked for.
    pub fn kernel(&self) -> Option<Kernel> {
        self.kernel.map(|name| match name {
            KernelName::Cubic => Kernel::Cubic,
            KernelName::Linear => Kernel::Linear,
            KernelName::CatmullRom => Kernel::CatmullRom,
            KernelName::Bspline => Kernel::BSpline,
            KernelName::Gaussian => Kernel::Gaussian,
        })
    }
}

/// Refuses the first field that was given though an algorithm does not have it.
pub(super) fn no_meaning(algorithm: Algorithm, given: &[(bool, &'static str)]) -> Result<(), crate::Error> {
    match given.iter().find(|(given, _)| *given) {
        Some((_, field)) => {
            let problem = format!("it has no meaning for {}: leave it out", algorithm.name());
            Err(crate::Error::Settings { field, problem })
        }
        None => Ok(()),
    }
}
