//! `layersplat completions` and `layersplat man`: shell completions and manual pages, generated from the command's options.

use super::command_line;
use crate::error::Error;
use clap::Args;
use clap_complete::Shell;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(super) struct Completions {
    /// Shell to print completions for
    shell: Shell,
}

#[derive(Args)]
pub(super) struct ManPages {
    /// Folder for layersplat.1, layersplat-render.1 and so on; created if missing
    #[arg(short, long, default_value = "man", value_name = "DIR")]
    output: PathBuf,
}

pub(super) fn completions(arguments: &Completions) -> Result<ExitCode, Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command_line::command(), "layersplat", &mut script);
    let mut out = io::stdout();
    match out.write_all(&script).and_then(|()| out.flush()) {
        // A closed pipe (`| head`) is not an error.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"), e)),
        _ => Ok(ExitCode::SUCCESS),
    }
}

pub(super) fn man_pages(arguments: &ManPages) -> Result<ExitCode, Error> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))?;
    clap_mangen::generate_to(command_line::command(), folder).map_err(|e| Error::write(folder, e))?;
    super::report(false, &(), || format!("pages in {}", folder.display()))?;
    Ok(ExitCode::SUCCESS)
}
