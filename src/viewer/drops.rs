//! Files that were dropped onto a page.

use crate::files::Scratch;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tokio::sync::Semaphore;

/// Ends of the names of headers that have their voxels in a file beside them. Other files that come together are slices of one volume.
const HEADERS: [&str; 4] = [".hdr", ".mhd", ".nhdr", ".bov"];

/// What was dropped at once: a file, or several in a folder of their own. Removed with its temporary folder when this is dropped.
pub(super) struct Dropped {
    number: u32,
    pub folder: Scratch,
    /// Name of the folder in the temporary folder that has the files, if they are several.
    pub of_several: Option<String>,
    pub files: Vec<String>,
    pub bytes: u64,
}

impl Dropped {
    /// The folder that has the files.
    pub fn place(&self) -> PathBuf {
        self.of_several.as_ref().map_or_else(|| self.folder.path().into(), |name| self.folder.path().join(name))
    }

    /// What is opened: the file, a header among several, or their folder.
    pub fn path(&self) -> PathBuf {
        let is_header = |name: &&String| HEADERS.iter().any(|end| name.to_lowercase().ends_with(end));
        match self.files.as_slice() {
            [file] => self.place().join(file),
            files => files.iter().find(is_header).map_or_else(|| self.place(), |header| self.place().join(header)),
        }
    }

    /// What messages leave out: the temporary folder and a separator.
    pub fn hidden(&self) -> String {
        format!("{}{}", Path::new(self.folder.path()).display(), std::path::MAIN_SEPARATOR)
    }
}

/// Dropped files: one may arrive at a time, and the last drop waits to be opened.
pub(super) struct Drops {
    last: Mutex<(u32, Option<Dropped>)>,
    pub arriving: Semaphore,
}

impl Default for Drops {
    fn default() -> Self {
        Self { last: Mutex::default(), arriving: Semaphore::new(1) }
    }
}

impl Drops {
    /// An empty drop, which is kept when its first file is there.
    pub fn begin(&self, folder: Scratch, of_several: Option<String>) -> Dropped {
        let number = self.last.lock().unwrap_or_else(PoisonError::into_inner).0.wrapping_add(1);
        Dropped { number, folder, of_several, files: Vec::new(), bytes: 0 }
    }

    /// Keeps a drop in place of the last one; returns its number.
    pub fn keep(&self, dropped: Dropped) -> u32 {
        let number = dropped.number;
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = (number, Some(dropped));
        number
    }

    pub fn take(&self, number: u32) -> Option<Dropped> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.1.take_if(|dropped| dropped.number == number)
    }
}
