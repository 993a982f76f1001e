//! Files that are written whole or not at all.

use crate::error::Error;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{PoisonError, RwLock};

/// Held for reading while a file is written.
static WRITING: RwLock<()> = RwLock::new(());

/// Waits until no file is half written, and lets no other begin before `then` returns: a process may end there.
#[cfg(feature = "cli")]
pub(crate) fn between_files<T>(then: impl FnOnce() -> T) -> T {
    let _no_file = WRITING.write().unwrap_or_else(PoisonError::into_inner);
    then()
}

/// Writes a file under a temporary name beside it, then renames it: it appears whole or not at all.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let _writing = WRITING.read().unwrap_or_else(PoisonError::into_inner);
    let failed = |e| Error::write(path, e);
    // What a link leads to is written, not the link.
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
    if target.exists() && !target.is_file() {
        return Err(failed(io::Error::other("it exists and is no regular file")));
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(failed(io::Error::other(format!("there is no folder {}", folder.display()))));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".layersplat-");
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: the umask takes away what it must.
        builder.permissions(std::fs::Permissions::from_mode(0o666))
    };
    let mut file = builder.tempfile_in(folder).map_err(failed)?;
    let mut buffered = io::BufWriter::new(file.as_file_mut());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(failed)?;
    drop(buffered);
    file.persist(&target).map_err(|e| failed(e.error))?;
    Ok(())
}
