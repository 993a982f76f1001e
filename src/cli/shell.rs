//! `layersplat completions` and `layersplat man`: what shells and `man` are told of the command, made from its own options.

use super::Cli;
use crate::error::Error;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(super) struct Completions {
    /// The shell whose completions are printed
    shell: Shell,
}

#[derive(Args)]
pub(super) struct ManPages {
    /// Folder for layersplat.1, layersplat-render.1 and so on; made if it is missing
    #[arg(short, long, default_value = "man")]
    output: PathBuf,
}

pub(super) fn completions(arguments: &Completions) -> Result<ExitCode, Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "layersplat", &mut script);
    let mut out = io::stdout();
    match out.write_all(&script).and_then(|()| out.flush()) {
        // A reader that went away (`| head`) is no error of ours.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"), e)),
        _ => Ok(ExitCode::SUCCESS),
    }
}

pub(super) fn man_pages(arguments: &ManPages) -> Result<ExitCode, Error> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(|e| Error::write(folder, e))?;
    super::report(false, &(), || format!("pages in {}", folder.display()))?;
    Ok(ExitCode::SUCCESS)
}
