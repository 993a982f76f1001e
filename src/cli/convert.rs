//! `layersplat convert`.

use super::options::FileOptions;
use super::standard::{self, Output};
use crate::error::Error;
use crate::volume::convert;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Volume: a file, a folder or NAME%d.EXT of numbered slices, builtin:NAME, or - for standard input
    input: PathBuf,
    /// Output file: .raw (dimensions and type are added to its name), .nrrd, .nii, .nii.gz, .npy or .vti; nrrd:- and so on for
    /// standard output
    output: PathBuf,
    #[command(flatten)]
    file: FileOptions,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let output = Output::new(&arguments.output, None)?;
    let options = arguments.file.raw(None)?;
    let converted = |input: &Path| convert(input, &options, output.path());
    let written = standard::open_input(&arguments.input, converted).map_err(|e| output.with_given_name(e))?;
    // Also for standard output: the name of a raw file states dimensions and type.
    let name = if output.is_standard() { Path::new(written.file_name().unwrap_or_default()) } else { &written };
    eprintln!("{}", name.display());
    output.finish(&written)
}
