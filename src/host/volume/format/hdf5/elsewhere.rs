//! Data in other files: external storage, external links and virtual datasets.

use crate::error::Error;
use hdf5_reader::error::{Error as Problem, Result};
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::storage::DynStorage;
use hdf5_reader::{Dataset, ExternalFileResolver, ExternalLinkResolver, FilesystemExternalFileResolver, Hdf5File};
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Finds files in the folder of a file and below, and records those that it does not find.
pub(super) struct Others {
    path: PathBuf,
    files: FilesystemExternalFileResolver,
    missing: Mutex<BTreeSet<String>>,
    used: AtomicBool,
}

impl Others {
    pub fn of(path: &Path) -> Arc<Self> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let files = FilesystemExternalFileResolver::new(folder);
        Arc::new(Self { path: path.into(), files, missing: Mutex::default(), used: AtomicBool::new(false) })
    }

    /// Why something was not found, if it is in a file that is missing.
    pub fn problem(&self) -> Option<String> {
        let missing = self.missing.lock().unwrap_or_else(PoisonError::into_inner);
        let names = missing.iter().cloned().collect::<Vec<_>>().join(", ");
        (!names.is_empty()).then(|| format!("its data are in {names}, which is not in its folder: put it there"))
    }

    /// Whether links to other files were followed.
    pub fn are_used(&self) -> bool {
        self.used.load(Ordering::Relaxed)
    }

    fn open(&self, name: &str) -> Option<DynStorage> {
        let found = self.files.resolve_external_file(name).ok().flatten();
        if found.is_none() {
            self.missing.lock().unwrap_or_else(PoisonError::into_inner).insert(name.into());
        }
        found
    }
}

impl ExternalFileResolver for Others {
    fn resolve_external_file(&self, name: &str) -> Result<Option<DynStorage>> {
        Ok(self.open(name))
    }
}

impl ExternalLinkResolver for Others {
    fn resolve_external_link(&self, name: &str) -> Result<Option<Hdf5File>> {
        self.used.store(true, Ordering::Relaxed);
        let limits = || super::limits(&Self::of(&self.path));
        self.open(name).map(|storage| Hdf5File::from_storage_with_options(storage, limits())).transpose()
    }
}

/// Rejects a dataset whose numbers are in files that are missing.
pub(super) fn check(path: &Path, file: &Hdf5File, dataset: &Dataset, others: &Others) -> std::result::Result<(), Error> {
    let header = file.get_or_parse_header(dataset.address()).ok();
    let is_external = |message: &HdfMessage| matches!(message, HdfMessage::ExternalFiles(_));
    if !header.is_some_and(|header| header.messages.iter().any(is_external)) {
        return Ok(());
    }
    // Reading one number opens all of them.
    let first = vec![hdf5_reader::SliceInfoElem::Index(0); dataset.ndim()];
    let found = dataset.read_slice::<super::numbers::Value>(&hdf5_reader::SliceInfo { selections: first });
    match (found, others.problem()) {
        (Err(_), Some(problem)) => Err(Error::volume(path, problem)),
        _ => Ok(()),
    }
}

/// The number of the layout of virtual datasets.
const VIRTUAL: u8 = 3;
/// Bytes of a file that are searched for the sources of virtual datasets.
const SEARCHED: u64 = 16 << 20;
/// Longest name in bytes.
const LONGEST_NAME: usize = 4096;

/// Whether something cannot be read because a dataset is virtual.
pub(super) fn is_virtual(problem: &Problem) -> bool {
    match problem {
        Problem::UnsupportedLayoutClass(class) => *class == VIRTUAL,
        Problem::Context { source, .. } => is_virtual(source),
        _ => false,
    }
}

/// What is wrong with a file with a virtual dataset.
pub(super) fn virtual_problem(path: &Path) -> String {
    let (present, missing): (Vec<_>, Vec<_>) =
        sources(path).into_iter().partition(|name| path.with_file_name(name).is_file() || PathBuf::from(name).is_file());
    let listed = |names: &[String]| names.join(", ");
    let lies = match (&present[..], &missing[..]) {
        ([], []) => "in other datasets".into(),
        (present, []) => format!("in {}", listed(present)),
        ([], missing) => format!("in {}, which is missing", listed(missing)),
        (present, missing) => format!("in {} and in {}, which is missing", listed(present), listed(missing)),
    };
    format!("it has a virtual dataset, whose numbers are {lies}: give the file of its numbers, or copy them into one dataset")
}

/// Names of the files of virtual datasets. They are in collections of objects, whose layout is: `GCOL`, 12 bytes, and objects of a header
/// of 16 bytes, the last 8 of which are its length, and as many bytes in multiples of 8.
fn sources(path: &Path) -> BTreeSet<String> {
    let mut bytes = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(SEARCHED).read_to_end(&mut bytes));
    let mut names = BTreeSet::new();
    if read.is_err() {
        return names;
    }
    let starts = (0..bytes.len()).step_by(8).filter(|&at| bytes[at..].starts_with(b"GCOL\x01"));
    for start in starts {
        let mut rest = bytes.get(start + 16..).unwrap_or_default();
        while let Some((head, behind)) = rest.split_first_chunk::<16>() {
            let [_, len] = [0, 8].map(|at| head[at..].first_chunk().map_or(0, |word| u64::from_le_bytes(*word)));
            let Some(object) = usize::try_from(len).ok().and_then(|len| behind.get(..len)) else { break };
            if head[..2] == [0, 0] {
                break;
            }
            names.extend(source(object));
            rest = behind.get(object.len().next_multiple_of(8)..).unwrap_or_default();
        }
    }
    names
}

/// The files of a mapping: version 0 or 1, the number of entries in 8 bytes, and for each two names that end with 0, of a file and of a
/// dataset in it, and selections. The first name is where it should be; others are told by their extension.
fn source(object: &[u8]) -> Vec<String> {
    let Some((0..=1, rest)) = object.split_first() else { return Vec::new() };
    let Some((count, rest)) = rest.split_first_chunk::<8>() else { return Vec::new() };
    if !(1..1 << 32).contains(&u64::from_le_bytes(*count)) {
        return Vec::new();
    }
    let is_name = |word: &&[u8]| word.len() <= LONGEST_NAME && !word.iter().any(u8::is_ascii_control);
    let words = rest.split(|&byte| byte == 0).enumerate();
    let names = words.filter(|(n, word)| is_name(word) && (*n == 0 || word.len() > 3 && word.contains(&b'.')));
    // "." is the file itself.
    let names = names.filter_map(|(_, word)| std::str::from_utf8(word).ok()).filter(|name| !["", "."].contains(name));
    names.map(Into::into).collect()
}
