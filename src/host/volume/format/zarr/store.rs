//! Where the nodes of a hierarchy are: in folders, or on web servers.

#[cfg(feature = "http")]
use super::http;
use crate::memory;
use crate::url;
use crate::volume::format::bytes;
use std::fs::File;
use std::io;
use std::num::NonZero;
use std::path::Path;
use std::sync::Arc;

/// Files by their paths, which are those of folders or addresses.
pub(super) trait Store: Send + Sync {
    /// All bytes of a file, `None` if there is no such file.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] if there are more than `most`.
    fn get(&self, file: &Path, most: u64) -> io::Result<Option<Vec<u8>>>;

    /// As [`get`](Self::get), for metadata, which several readers ask for: stores that take long keep them.
    fn metadata(&self, file: &Path, most: u64) -> io::Result<Option<Arc<[u8]>>> {
        Ok(self.get(file, most)?.map(Into::into))
    }

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
    fn get(&self, file: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
        let mut opened = match File::open(file) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        let metadata = opened.metadata()?;
        // A folder of that name is no file.
        if metadata.is_dir() {
            return Ok(None);
        }
        let mut all = room(file, metadata.len(), most)?;
        let found = bytes::fill(&mut opened, &mut all)?;
        all.truncate(found);
        Ok(Some(all))
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
