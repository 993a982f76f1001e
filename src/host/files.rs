//! Atomic file output, and removal of unfinished files when the process ends.

use crate::error::Error;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard};
use std::time::Duration;
use sysinfo::{Pid, ProcessesToUpdate, System};
use tempfile::{NamedTempFile, TempPath};

/// Locked for reading while a file is written.
static WRITING: RwLock<()> = RwLock::new(());
/// Files whose writing takes long. They are removed on exit, not waited for.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// Folders in which this process has removed files left by killed processes.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Prefix of temporary file names; the process id follows.
const PREFIX: &str = ".layersplat-";
/// Minimum time since the last write to a leftover file. Its process may be invisible to this one, in another container or on
/// another machine; if so, it writes a frame of its animation within that time.
const LEFTOVER_AGE: Duration = Duration::from_secs(24 * 3600);

/// Keeps signals from ending the process while the returned guard exists.
fn begin_write() -> RwLockReadGuard<'static, ()> {
    WRITING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for short writes, removes unfinished files, and blocks new writes while `then` runs. The process may exit in `then`.
pub fn between_files<T>(then: impl FnOnce() -> T) -> T {
    let _no_file = WRITING.write().unwrap_or_else(PoisonError::into_inner);
    for path in std::mem::take(&mut *UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)) {
        // The process is about to exit, so errors cannot be reported.
        let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
    }
    then()
}

/// Creates a temporary file in the folder of `path`, and returns it with its final path. Symbolic links are followed.
fn create_temporary(path: &Path) -> io::Result<(NamedTempFile, PathBuf)> {
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
    if target.exists() && !target.is_file() {
        return Err(io::Error::other("it exists and is not a regular file"));
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(io::Error::other(format!("the folder {} does not exist", folder.display())));
    }
    if SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.into()) {
        sweep(folder, std::fs::Metadata::is_file, |path| std::fs::remove_file(path));
    }
    let prefix = format!("{PREFIX}{}-", std::process::id());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt;
        // Default permissions of a new file; the umask applies.
        builder.permissions(std::fs::Permissions::from_mode(0o666))
    };
    let file = builder.tempfile_in(folder)?;
    Ok((file, target))
}

/// Removes what killed processes left of a kind: the process no longer runs, and it is older than [`LEFTOVER_AGE`].
fn sweep(folder: &Path, is_kind: fn(&std::fs::Metadata) -> bool, remove: fn(&Path) -> io::Result<()>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_old = |entry: &std::fs::DirEntry| {
            let metadata = entry.metadata().ok().filter(is_kind);
            metadata.and_then(|found| found.modified().ok()?.elapsed().ok()).is_some_and(|age| age > LEFTOVER_AGE)
        };
        let process = entry.file_name().to_str().and_then(parse_process);
        // Another process may remove the file at the same time, so errors are ignored.
        if process.is_some_and(|process| is_old(&entry) && !is_running(process)) && remove(&entry.path()).is_ok() {
            tracing::info!("removed the unfinished {} of a killed process", entry.path().display());
        }
    }
}

/// Process id in the name of a temporary file.
fn parse_process(name: &str) -> Option<u32> {
    let (process, _random) = name.strip_prefix(PREFIX)?.split_once('-')?;
    process.parse().ok()
}

fn is_running(process: u32) -> bool {
    let (mut system, process) = (System::new(), Pid::from_u32(process));
    system.refresh_processes(ProcessesToUpdate::Some(&[process]), true);
    system.process(process).is_some()
}

/// Reads a file of UTF-8 text of at most `most` bytes.
///
/// # Errors
/// [`Error::Read`] if it cannot be read, is larger, or is no text.
pub fn read_text(path: &Path, most: u64) -> Result<String, Error> {
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let mut text = String::new();
    file.take(most + 1).read_to_string(&mut text).map_err(|e| Error::read(path, e))?;
    if text.len() as u64 > most {
        return Err(Error::read(path, io::Error::other(format!("it is larger than {most} bytes"))));
    }
    Ok(text)
}

/// Checks that a file can be written in the folder of `path`, before work that takes long.
///
/// # Errors
/// [`Error::Write`], which names `path`.
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let _writing = begin_write();
    create_temporary(path).map(drop).map_err(|e| Error::write(path, e))
}

/// Writes a file atomically: to a temporary file in the same folder, which is then renamed.
///
/// # Errors
/// [`Error::Write`], which names `path`. No file is left behind.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let _writing = begin_write();
    let failed = |e| Error::write(path, e);
    let (mut file, target) = create_temporary(path).map_err(failed)?;
    let mut buffered = io::BufWriter::new(file.as_file_mut());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(failed)?;
    drop(buffered);
    file.persist(&target).map_err(|e| failed(e.error))?;
    Ok(())
}

/// A file that is written incrementally over a long time. It is removed if this is dropped or the process ends before
/// [`finish`](Self::finish).
pub struct Unfinished {
    temporary: Option<TempPath>,
    target: PathBuf,
}

impl Unfinished {
    /// Creates the temporary file and opens it for writing.
    pub fn new(path: &Path) -> io::Result<(Self, File)> {
        let _writing = begin_write();
        let (file, target) = create_temporary(path)?;
        let (file, temporary) = file.into_parts();
        unfinished(|paths| paths.insert(temporary.to_path_buf()));
        Ok((Self { temporary: Some(temporary), target }, file))
    }

    /// Path of the temporary file.
    pub fn path(&self) -> &Path {
        self.temporary.as_deref().expect("present until finished")
    }

    /// Renames the complete file to its final path.
    pub fn finish(mut self) -> io::Result<()> {
        let _writing = begin_write();
        let temporary = self.temporary.take().expect("present until finished");
        unfinished(|paths| paths.remove(&temporary.to_path_buf()));
        temporary.persist(&self.target).map_err(|e| e.error)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(temporary) = self.temporary.take() {
            unfinished(|paths| paths.remove(&temporary.to_path_buf()));
        }
    }
}

/// Error of a failed write to a temporary file, which suggests another folder.
pub fn temporary_failed(e: io::Error) -> Error {
    Error::write(
        &std::env::temp_dir(),
        io::Error::new(e.kind(), format!("{e}; set TMPDIR to another folder for temporary files")),
    )
}

/// A temporary folder that other users cannot read. It is removed with its content when this is dropped or the process ends, and after a kill by the first process that
/// makes one a day later.
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    /// Creates the folder in the system's temporary folder (`TMPDIR`).
    pub fn new() -> Result<Self, Error> {
        let _writing = begin_write();
        static SWEEP: std::sync::Once = std::sync::Once::new();
        SWEEP.call_once(|| sweep(&std::env::temp_dir(), std::fs::Metadata::is_dir, |path| std::fs::remove_dir_all(path)));
        let prefix = format!("{PREFIX}{}-", std::process::id());
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix);
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::PermissionsExt;
            // By default other users can read a temporary folder.
            builder.permissions(std::fs::Permissions::from_mode(0o700))
        };
        let folder = builder.tempdir().map_err(temporary_failed)?;
        unfinished(|paths| paths.insert(folder.path().into()));
        Ok(Self(folder))
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Creates a file in the folder, which other users cannot read, and opens it for writing. Its own folder is created, too.
    pub fn create(&self, name: impl AsRef<Path>) -> io::Result<File> {
        let path = self.path().join(name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut options = File::options();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        options.open(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        unfinished(|paths| paths.remove(self.0.path()));
    }
}

fn unfinished<T>(change: impl FnOnce(&mut BTreeSet<PathBuf>) -> T) -> T {
    change(&mut UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[cfg(unix)]
    #[test]
    fn files_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let mut killed = std::process::Command::new("true").spawn().unwrap();
        killed.wait().unwrap();
        let (dead, own) = (killed.id(), std::process::id());
        let put = |name: &str, hours: u64| {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(hours * 3600)).unwrap();
        };
        let left = format!(".layersplat-{dead}-a1B2c3");
        let kept = [
            (format!(".layersplat-{dead}-recent"), 23),
            (format!(".layersplat-{own}-running"), 1000),
            (".layersplat-Xy12Zw".into(), 1000),
            (format!("layersplat-{dead}-Xy12Zw"), 1000),
            (format!(".layersplat-{dead}"), 1000),
        ];
        put(&left, 25);
        kept.iter().for_each(|(name, hours)| put(name, *hours));
        std::fs::create_dir(folder.path().join(format!(".layersplat-{dead}-folder"))).unwrap();
        assert!(names(folder.path()).contains(&left));
        let (unfinished, _) = Unfinished::new(&folder.path().join("a.bin")).unwrap();
        drop(unfinished);
        let mut expected: Vec<String> = kept.into_iter().map(|(name, _)| name).collect();
        expected.push(format!(".layersplat-{dead}-folder"));
        let mut found = names(folder.path());
        expected.sort();
        found.sort();
        assert_eq!(found, expected);
    }

    #[cfg(unix)]
    #[test]
    fn folders_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let mut killed = std::process::Command::new("true").spawn().unwrap();
        killed.wait().unwrap();
        let put = |process: u32, hours: u64| {
            let left = folder.path().join(format!(".layersplat-{process}-{hours}"));
            std::fs::create_dir(&left).unwrap();
            std::fs::write(left.join("volume.raw"), "voxels").unwrap();
            File::open(&left).unwrap().set_modified(std::time::SystemTime::now() - Duration::from_secs(hours * 3600)).unwrap();
        };
        put(killed.id(), 25);
        put(killed.id(), 23);
        put(std::process::id(), 1000);
        sweep(folder.path(), std::fs::Metadata::is_dir, |path| std::fs::remove_dir_all(path));
        let mut found = names(folder.path());
        found.sort();
        let mut expected = vec![format!(".layersplat-{}-23", killed.id()), format!(".layersplat-{}-1000", std::process::id())];
        expected.sort();
        assert_eq!(found, expected);
    }

    #[cfg(unix)]
    #[test]
    fn others_cannot_read_temporary_files() {
        use std::os::unix::fs::PermissionsExt;
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let scratch = Scratch::new().unwrap();
        scratch.create("scan.nrrd").unwrap();
        assert_eq!((mode(scratch.path()), mode(&scratch.path().join("scan.nrrd"))), (0o700, 0o600));
    }

    #[test]
    fn only_finished_files_exist() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let (unfinished, mut file) = Unfinished::new(&path).unwrap();
        file.write_all(b"half").unwrap();
        assert!(names(folder.path())[0].starts_with(".layersplat-") && !path.exists());
        drop(unfinished);
        assert_eq!(names(folder.path()), [""; 0]);
        let (unfinished, mut file) = Unfinished::new(&path).unwrap();
        file.write_all(b"whole").unwrap();
        unfinished.finish().unwrap();
        assert_eq!((names(folder.path()), std::fs::read(&path).unwrap()), (vec!["a.bin".to_owned()], b"whole".to_vec()));
        assert!(Unfinished::new(&folder.path().join("missing/a.bin")).is_err());
    }
}
