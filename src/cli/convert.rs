//! `layersplat convert`.

use super::options::FileOptions;
use crate::error::Error;
use crate::volume::convert;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A file of any format that is read, a folder or NAME%d.ENDING of numbered slices, or builtin:NAME
    input: PathBuf,
    /// A name ending in .raw (dimensions and type are put into it), .nrrd, .nii, .nii.gz, .npy or .vti
    output: PathBuf,
    #[command(flatten)]
    file: FileOptions,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let written = convert(&arguments.input, &arguments.file.raw(None)?, &arguments.output)?;
    eprintln!("{}", written.display());
    Ok(ExitCode::SUCCESS)
}
