//! Files that were dropped onto a page.

use crate::files::Scratch;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tokio::runtime::Handle;
use tokio::sync::Semaphore;

/// Ends of the names of headers that have their voxels in files beside them. Other files that come together are slices of one volume.
const HEADERS: [&str; 6] = [".hdr", ".mhd", ".nhdr", ".bov", ".pvd", ".series"];
/// Ends of the names of files that come with volumes, as descriptions do, and are not read.
const UNREAD: [&str; 6] = [".json", ".txt", ".csv", ".md", ".xml", ".vp"];
/// Ends of the names of files that have a whole volume each. Others may be slices of one.
const VOLUMES: [&str; 15] = [
    ".h5", ".hdf5", ".mgh", ".mgz", ".mha", ".nc", ".nii", ".nii.gz", ".npy", ".npz", ".nrrd", ".raw", ".raw.gz", ".vti", ".vtk",
];
/// Most names in a sentence.
const MOST_NAMES: usize = 4;

/// What was dropped at once: a file, or several in a folder of their own. Removed with its temporary folder when this is dropped.
pub(super) struct Dropped {
    number: u32,
    /// `None` only while this is dropped.
    folder: Option<Scratch>,
    /// Name of the folder in the temporary folder that has the files, if they are several.
    pub of_several: Option<String>,
    pub files: Vec<String>,
    pub bytes: u64,
}

impl Dropped {
    /// The temporary folder.
    fn folder(&self) -> &Scratch {
        self.folder.as_ref().expect("there until this is dropped")
    }

    /// The temporary folder, which is kept.
    pub fn into_folder(mut self) -> Scratch {
        self.folder.take().expect("there until this is dropped")
    }

    /// Creates a file of the drop.
    pub fn create(&self, name: &str) -> io::Result<File> {
        self.folder().create(Path::new(self.of_several.as_deref().unwrap_or_default()).join(name))
    }

    /// The folder that has the files.
    pub fn place(&self) -> PathBuf {
        self.folder().path().join(self.of_several.as_deref().unwrap_or_default())
    }

    /// What is opened: the file, the header among several, or their folder.
    ///
    /// # Errors
    /// A sentence, if these are several volumes.
    pub fn path(&self) -> Result<PathBuf, String> {
        let headers = self.files_of(|name| ends_in(name, &HEADERS));
        let read = self.files_of(|name| self.files.len() == 1 || !ends_in(name, &UNREAD));
        match (&headers[..], &read[..]) {
            ([file], _) | ([], [file]) => Ok(self.place().join(file)),
            ([], [_, _, ..]) if read.iter().all(|name| ends_in(name, &VOLUMES)) => Err(format!(
                "These are several volumes: {}. Drop one of them. Steps in time are shown by 'layersplat view A B'.",
                listed(&read)
            )),
            ([], _) => Ok(self.place()),
            (several, _) => Err(format!("These are several volumes: {}. Drop one of them, with its voxels.", listed(several))),
        }
    }

    /// What is said of files that are not read.
    pub fn note(&self) -> Option<String> {
        let unread = self.files_of(|name| self.files.len() > 1 && ends_in(name, &UNREAD));
        (!unread.is_empty()).then(|| format!("Not read: {}", listed(&unread)))
    }

    fn files_of(&self, is_one: impl Fn(&str) -> bool) -> Vec<&str> {
        self.files.iter().map(String::as_str).filter(|name| is_one(name)).collect()
    }

    /// What messages leave out: the temporary folder and a separator.
    pub fn hidden(&self) -> String {
        format!("{}{}", self.folder().path().display(), std::path::MAIN_SEPARATOR)
    }
}

impl Drop for Dropped {
    fn drop(&mut self) {
        // Removing large files takes long, and the thread of connections does not wait for that.
        if let (Some(folder), Ok(runtime)) = (self.folder.take(), Handle::try_current()) {
            runtime.spawn_blocking(move || drop(folder));
        }
    }
}

fn ends_in(name: &str, ends: &[&str]) -> bool {
    ends.iter().any(|end| name.to_lowercase().ends_with(end))
}

/// The first of some names.
fn listed(names: &[&str]) -> String {
    let first = names[..names.len().min(MOST_NAMES)].join(", ");
    if names.len() > MOST_NAMES { format!("{first} and {} more", names.len() - MOST_NAMES) } else { first }
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
        Dropped { number, folder: Some(folder), of_several, files: Vec::new(), bytes: 0 }
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
