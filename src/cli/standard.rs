//! `-`: volumes from standard input, and output to standard output.
//!
//! Volumes are read repeatedly and concurrently, and output must be complete or absent. Both pass through a temporary file, so
//! memory does not grow with their size.

use crate::error::Error;
use crate::files::{Scratch, temporary_failed};
use crate::progress::Task;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Names in messages.
const INPUT: &str = "standard input";
const OUTPUT: &str = "standard output";
/// Bytes copied at a time.
const CHUNK_BYTES: usize = 1 << 20;
/// Exit code that shells report for a process that SIGPIPE ended: 128 plus the signal number.
const BROKEN_PIPE: u8 = 141;

/// Whether a path means standard input.
pub(super) fn is_input(path: &Path) -> bool {
    path == Path::new("-")
}

/// Calls `open` with `path`, or for `-` with a temporary file that holds all of standard input.
pub(super) fn open_input<T>(path: &Path, open: impl FnOnce(&Path) -> Result<T, Error>) -> Result<T, Error> {
    if !is_input(path) {
        return open(path);
    }
    let input = io::stdin();
    if input.is_terminal() {
        return Err(Error::read(Path::new(INPUT), io::Error::other("it is a terminal: pipe a volume into it")));
    }
    // The file is removed on return; memory maps of it stay valid.
    let scratch = Scratch::new()?;
    let file = spool(BufReader::with_capacity(CHUNK_BYTES, input.lock()), scratch.path())?;
    open(&file).map_err(|e| rename_in_error(e, &file, INPUT))
}

/// Copies all of `input` to a new file in `folder`.
fn spool(mut input: impl BufRead, folder: &Path) -> Result<PathBuf, Error> {
    let unread = |e| Error::read(Path::new(INPUT), e);
    let start = input.fill_buf().map_err(unread)?;
    if start.is_empty() {
        return Err(Error::volume(Path::new(INPUT), "it is empty: expected a volume"));
    }
    // Compressed raw files are recognised by name.
    let name = if start.starts_with(&[0x1f, 0x8b]) { "standard input.raw.gz" } else { INPUT };
    let path = folder.join(name);
    let mut file = File::create(&path).map_err(temporary_failed)?;
    let task = Task::new("reading standard input", 0);
    loop {
        let chunk = match input.fill_buf() {
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            chunk => chunk.map_err(unread)?,
        };
        if chunk.is_empty() {
            return Ok(path);
        }
        file.write_all(chunk).map_err(temporary_failed)?;
        let len = chunk.len();
        input.consume(len);
        task.add(len as u64);
    }
}

/// Replaces the temporary file's name in an error.
fn rename_in_error(error: Error, from: &Path, to: &str) -> Error {
    let path = |path: PathBuf| if path == from { to.into() } else { path };
    let text = |text: String| text.replace(&from.display().to_string(), to);
    match error {
        Error::Read { path: file, source } => Error::Read { path: path(file), source },
        Error::Volume { path: file, problem } => Error::Volume { path: path(file), problem: text(problem) },
        Error::FileSize { path: file, dims, scalar, expected, found } => {
            Error::FileSize { path: path(file), dims, scalar, expected, found }
        }
        Error::Unnamed { path: file, field, problem } => Error::Unnamed { path: path(file), field, problem },
        Error::Settings { field, problem } => Error::Settings { field, problem: text(problem) },
        Error::HostMemory { what, needed, available } => Error::HostMemory { what: text(what), needed, available },
        other => other,
    }
}

/// Destination of a result: a file, or standard output for `-` and `FORMAT:-`.
pub(super) struct Output {
    given: PathBuf,
    /// For standard output: the temporary folder and file. The file is copied to standard output when complete.
    standard: Option<(Scratch, PathBuf)>,
}

impl Output {
    /// Creates an output from a path. `default` is the format of `-`.
    ///
    /// # Errors
    /// [`Error::Settings`] if standard output is a terminal.
    pub fn new(given: &Path, default: Option<&str>) -> Result<Self, Error> {
        let name = given.to_str().unwrap_or_default();
        let format = if name == "-" { default.or(Some("")) } else { name.strip_suffix(":-") };
        let Some(format) = format.filter(|format| !format.contains(['/', '\\'])) else {
            return Ok(Self { given: given.into(), standard: None });
        };
        if io::stdout().is_terminal() {
            let problem = "standard output is a terminal: redirect it to a file or pipe it into a program";
            return Err(Error::Settings { field: "output", problem: problem.into() });
        }
        let scratch = Scratch::new()?;
        let file = scratch.path().join(if format.is_empty() { "-".into() } else { format!("layersplat.{format}") });
        Ok(Self { given: given.into(), standard: Some((scratch, file)) })
    }

    /// Path of the file to write.
    pub fn path(&self) -> &Path {
        self.standard.as_ref().map_or(&self.given, |(_, file)| file)
    }

    pub fn is_standard(&self) -> bool {
        self.standard.is_some()
    }

    /// Fails if report and result would both go to standard output.
    pub fn check_report(&self, json: bool) -> Result<(), Error> {
        if json && self.is_standard() {
            let problem = "standard output receives the result: omit --json, or write to a file";
            return Err(Error::Settings { field: "output", problem: problem.into() });
        }
        Ok(())
    }

    /// Replaces the name of the temporary file in an error by the given one.
    pub fn with_given_name(&self, error: Error) -> Error {
        let given = self.given.display().to_string();
        match error {
            Error::UnknownName { what, known, .. } if self.is_standard() => {
                Error::UnknownName { what, name: given, known: format!("{known}; for standard output as in png:- or nrrd:-") }
            }
            error => rename_in_error(error, self.path(), &given),
        }
    }

    /// Copies the complete file to standard output, if that is the destination. The exit code reports a closed pipe.
    pub fn finish(&self, written: &Path) -> Result<ExitCode, Error> {
        if self.standard.is_none() {
            return Ok(ExitCode::SUCCESS);
        }
        let copied = File::open(written).and_then(|mut file| {
            let mut out = io::stdout().lock();
            io::copy(&mut file, &mut out)?;
            out.flush()
        });
        match copied {
            Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(ExitCode::from(BROKEN_PIPE)),
            Err(e) => Err(Error::write(Path::new(OUTPUT), e)),
            Ok(()) => Ok(ExitCode::SUCCESS),
        }
    }
}
