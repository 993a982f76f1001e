//! Where the nodes of a hierarchy are: in folders, or on web servers.

#[cfg(feature = "http")]
use super::http;
use crate::memory;
use crate::url;
use crate::volume::format::{CHANGED, bytes};
use serde_json::Value;
use std::fs::File;
use std::io::{self, Seek, SeekFrom};
use std::num::NonZero;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which bytes of a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Span {
    All,
    Part(Range<u64>),
    /// So many at the end.
    Last(u64),
}

/// Bytes of a file.
#[derive(Debug)]
pub(super) struct Found {
    pub bytes: Vec<u8>,
    /// Which byte of the file is the first: stores may give more than the bytes that were asked for, or fewer at the end of the file.
    pub first: u64,
    /// Differs from that of the file before it was changed, if the store knows that.
    pub version: Option<String>,
}

/// The error of a file that is no longer of the version that was read before.
pub(super) fn changed() -> io::Error {
    io::Error::new(CHANGED, "it changed while it was read: read it again when it is complete")
}

/// Files by their paths, which are those of folders or addresses.
pub(super) trait Store: Send + Sync {
    /// Bytes of a file, `None` if there is no such file.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] if there are more than `most`, [`CHANGED`] if it is known not to be of this `version`.
    fn get(&self, file: &Path, span: &Span, version: Option<&str>, most: u64) -> io::Result<Option<Found>>;

    /// As [`get`](Self::get), for metadata, which several readers ask for: stores that take long keep them.
    fn metadata(&self, file: &Path, most: u64) -> io::Result<Option<Arc<[u8]>>> {
        Ok(self.get(file, &Span::All, None, most)?.map(|found| found.bytes.into()))
    }

    /// Takes metadata of a file that another one has, too. Stores that take long need not read them then.
    fn keep(&self, _file: PathBuf, _metadata: &Value) {}

    /// Names of the folders in a folder; `None` if the store has no lists.
    fn folders(&self, folder: &Path) -> io::Result<Option<Vec<String>>>;

    /// Number of files to read at once.
    fn at_once(&self) -> usize;
}

/// The store of a path.
pub(super) fn of(path: &Path) -> Arc<dyn Store> {
    #[cfg(feature = "http")]
    if url::is_url(path) {
        return http::shared();
    }
    debug_assert!(!url::is_url(path), "without the feature `http`, addresses are refused");
    Arc::new(Folders)
}

/// Folders of this machine.
struct Folders;

impl Store for Folders {
    fn get(&self, file: &Path, span: &Span, version: Option<&str>, most: u64) -> io::Result<Option<Found>> {
        let mut opened = match File::open(file) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        let metadata = opened.metadata()?;
        // A folder of that name is no file.
        if metadata.is_dir() {
            return Ok(None);
        }
        let len = metadata.len();
        let current = metadata.modified().ok().map(|time| format!("{len} {time:?}"));
        if version.is_some() && current.as_deref() != version {
            return Err(changed());
        }
        let Range { start, end } = match *span {
            Span::All => 0..len,
            Span::Part(ref part) => part.start.min(len)..part.end.min(len),
            Span::Last(last) => len.saturating_sub(last)..len,
        };
        if start > 0 {
            opened.seek(SeekFrom::Start(start))?;
        }
        let mut bytes = room(file, end.saturating_sub(start), most)?;
        let found = bytes::fill(&mut opened, &mut bytes)?;
        bytes.truncate(found);
        Ok(Some(Found { bytes, first: start, version: current }))
    }

    fn folders(&self, folder: &Path) -> io::Result<Option<Vec<String>>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                names.extend(path.file_name().and_then(|name| name.to_str()).map(String::from));
            }
        }
        Ok(Some(names))
    }

    fn at_once(&self) -> usize {
        std::thread::available_parallelism().map_or(1, NonZero::get)
    }
}

/// Memory for the `len` bytes of a file that may have `most`.
pub(super) fn room(file: &Path, len: u64, most: u64) -> io::Result<Vec<u8>> {
    if len > most {
        return Err(io::Error::new(io::ErrorKind::InvalidData, format!("it has {len} bytes, and may have at most {most}")));
    }
    memory::zeroed(&file.display().to_string(), len as usize).map_err(|e| io::Error::other(e.to_string()))
}
