//! `layersplat convert`.

use super::options::VolumeOptions;
use crate::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    volume: VolumeOptions,
    /// A name ending in .raw (dimensions and type are put into it), .nrrd, .nii, .nii.gz, .npy or .vti
    output: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let written = arguments.volume.convert(&arguments.output)?;
    eprintln!("{}", written.display());
    Ok(ExitCode::SUCCESS)
}
