//! Options that select the algorithm.

use super::{names, parse};
use crate::layers::Kernel;
use crate::settings::{self, Algorithm, LayerAxis, Layered};
use clap::Args;

/// Selection of the algorithm, with the options that only some algorithms have.
#[derive(Args)]
pub(super) struct AlgorithmOptions {
    /// Rendering algorithm: layered, or one that the paper compares with
    #[arg(long, default_value = "layered", value_name = "NAME", value_parser = names::of::<Algorithm>())]
    algorithm: Algorithm,
    /// Sheet distance of view-sheets in voxels, 0.125 to 4 [default: 1]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    sheet_distance: Option<f64>,
    /// Step of slicing or raycast, relative to the smallest spacing [default: slicing 1, raycast 0.5]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    step: Option<f64>,
    /// Reconstruction kernel; splats (post) are always cubic, gaussian needs raycast [default: by --quality; raycast: linear]
    #[arg(long, visible_alias = "interpolation", value_name = "NAME", value_parser = names::of::<Kernel>())]
    pub(super) kernel: Option<Kernel>,
}

impl AlgorithmOptions {
    /// The selected algorithm. `layered` comes from the other options, which apply the kernel to it.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for options that the algorithm does not have.
    pub fn algorithm(&self, layered: Layered, layer_axis: LayerAxis) -> Result<Algorithm, crate::Error> {
        let &Self { kernel, step, sheet_distance, .. } = self;
        let layer_axis = Some(layer_axis).filter(|&axis| axis != LayerAxis::Auto);
        let options = settings::AlgorithmOptions { kernel, step, sheet_distance, layer_axis };
        match self.algorithm {
            Algorithm::Layered(_) => Algorithm::from(layered).with(settings::AlgorithmOptions { kernel: None, ..options }),
            other => other.with(options),
        }
    }
}
