//! `-`: volumes from standard input, and results to standard output.
//!
//! Files are read more than once and from several places at a time, and results appear whole or not at all: both pass through a temporary
//! file, so memory does not grow with them.

use crate::error::Error;
use crate::files::{Scratch, temporary_failed};
use crate::progress::Task;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What messages call it.
const INPUT: &str = "standard input";
const OUTPUT: &str = "standard output";
/// Bytes that are handed on at a time.
const PIECE: usize = 1 << 20;
/// What shells tell of a process that a broken pipe has ended: 128 and SIGPIPE.
const BROKEN_PIPE: u8 = 141;

/// Whether a name stands for standard input.
pub(super) fn is_input(path: &Path) -> bool {
    path == Path::new("-")
}

/// Opens the file of a name; of `-` what standard input holds until it ends.
pub(super) fn opened<T>(path: &Path, open: impl FnOnce(&Path) -> Result<T, Error>) -> Result<T, Error> {
    if !is_input(path) {
        return open(path);
    }
    let input = io::stdin();
    if input.is_terminal() {
        return Err(Error::read(Path::new(INPUT), io::Error::other("it is a terminal: pipe a volume into it")));
    }
    // What is mapped of the file stays there when it is removed.
    let scratch = Scratch::new()?;
    let file = spooled(BufReader::with_capacity(PIECE, input.lock()), scratch.path())?;
    open(&file).map_err(|e| renamed(e, &file, INPUT))
}

/// Writes all that comes to a file in a folder.
fn spooled(mut input: impl BufRead, folder: &Path) -> Result<PathBuf, Error> {
    let unread = |e| Error::read(Path::new(INPUT), e);
    let start = input.fill_buf().map_err(unread)?;
    if start.is_empty() {
        return Err(Error::volume(Path::new(INPUT), "it is empty: expected a volume"));
    }
    // Raw files that are packed are known by their names.
    let name = if start.starts_with(&[0x1f, 0x8b]) { "standard input.raw.gz" } else { INPUT };
    let path = folder.join(name);
    let mut file = File::create(&path).map_err(temporary_failed)?;
    let mut task = Task::new("reading standard input", 0);
    loop {
        let piece = match input.fill_buf() {
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            piece => piece.map_err(unread)?,
        };
        if piece.is_empty() {
            return Ok(path);
        }
        file.write_all(piece).map_err(temporary_failed)?;
        let len = piece.len();
        input.consume(len);
        task.add(len as u64);
    }
}

/// The error with a file's name in the place of that of the temporary one.
fn renamed(error: Error, from: &Path, to: &str) -> Error {
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

/// Where a result goes: a file, or, of the names `-` and `FORMAT:-`, standard output.
pub(super) struct Output {
    given: PathBuf,
    /// The folder, and the file in it, which is handed on once it is whole.
    standard: Option<(Scratch, PathBuf)>,
}

impl Output {
    /// What `-` alone is written as is `default`.
    pub fn of(given: &Path, default: Option<&str>) -> Result<Self, Error> {
        let name = given.to_str().unwrap_or_default();
        let format = if name == "-" { default.or(Some("")) } else { name.strip_suffix(":-") };
        let Some(format) = format.filter(|format| !format.contains(['/', '\\'])) else {
            return Ok(Self { given: given.into(), standard: None });
        };
        if io::stdout().is_terminal() {
            let problem = "standard output is a terminal, which shows no files: pipe it into a program or a file";
            return Err(Error::Settings { field: "output", problem: problem.into() });
        }
        let scratch = Scratch::new()?;
        let file = scratch.path().join(if format.is_empty() { "-".into() } else { format!("layersplat.{format}") });
        Ok(Self { given: given.into(), standard: Some((scratch, file)) })
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        self.standard.as_ref().map_or(&self.given, |(_, file)| file)
    }

    pub fn is_standard(&self) -> bool {
        self.standard.is_some()
    }

    /// Refuses that a report goes where the result goes.
    pub fn refuse_report(&self, json: bool) -> Result<(), Error> {
        if json && self.is_standard() {
            let problem = "standard output is where the result goes: leave --json out, or write to a file";
            return Err(Error::Settings { field: "output", problem: problem.into() });
        }
        Ok(())
    }

    /// The error with the name that was given.
    pub fn renamed(&self, error: Error) -> Error {
        let given = self.given.display().to_string();
        match error {
            Error::UnknownName { what, known, .. } if self.is_standard() => {
                Error::UnknownName { what, name: given, known: format!("{known}; on standard output as in png:- or nrrd:-") }
            }
            error => renamed(error, self.path(), &given),
        }
    }

    /// Hands a finished file on, if it is to go to standard output. If there is nobody who reads that, the exit code says so.
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
