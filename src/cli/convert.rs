//! `layersplat convert`.

use super::options::FileOptions;
use super::standard::{self, Output};
use crate::error::Error;
use crate::volume::convert;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A file of any format that is read, a folder or NAME%d.ENDING of numbered slices, builtin:NAME, or - for standard input
    input: PathBuf,
    /// A name ending in .raw (dimensions and type are put into it), .nrrd, .nii, .nii.gz, .npy or .vti; on standard output raw:-, nrrd:- and
    /// so on
    output: PathBuf,
    #[command(flatten)]
    file: FileOptions,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let output = Output::of(&arguments.output, None)?;
    let options = arguments.file.raw(None)?;
    let converted = |input: &Path| convert(input, &options, output.path());
    let written = standard::opened(&arguments.input, converted).map_err(|e| output.renamed(e))?;
    // The name of a raw file says what it holds.
    let told = if output.is_standard() { Path::new(written.file_name().unwrap_or_default()) } else { &written };
    eprintln!("{}", told.display());
    output.finish(&written)
}
