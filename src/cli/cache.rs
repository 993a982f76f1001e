//! `layersplat cache`.

use super::numbers::bytes_in_words;
use crate::cache::{self, Size};
use crate::error::Error;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Remove all of them
    #[arg(long)]
    clear: bool,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    /// Null if there is no place for it.
    folder: Option<PathBuf>,
    /// Before they were removed.
    files: u64,
    bytes: u64,
    most_bytes: u64,
    cleared: bool,
}

pub(super) fn run(&Arguments { clear, json }: &Arguments) -> Result<ExitCode, Error> {
    let mut report = Report { folder: None, files: 0, bytes: 0, most_bytes: 0, cleared: clear };
    if let Some(cache) = cache::downloads() {
        let size = if clear { cache.clear() } else { cache.size() };
        let Size { files, bytes } = size.map_err(|e| Error::read(cache.folder(), e))?;
        report = Report { folder: Some(cache.folder().into()), files, bytes, most_bytes: cache.most(), ..report };
    }
    super::report(json, &report, || text(&report))?;
    Ok(ExitCode::SUCCESS)
}

fn text(Report { folder, files, bytes, most_bytes, cleared }: &Report) -> String {
    let Some(folder) = folder else { return "files of URLs are not kept: set XDG_CACHE_HOME to a folder for them".into() };
    let (folder, bytes) = (folder.display(), bytes_in_words(*bytes));
    match cleared {
        true => format!("{folder}: removed {files} files, {bytes}"),
        false => format!("{folder}: {files} files, {bytes} of at most {}", bytes_in_words(*most_bytes)),
    }
}
