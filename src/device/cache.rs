//! PoCL's cache folder of compiled kernels. Without a writable folder, PoCL has no device or cannot build kernels.

use crate::error::Error;
use std::env;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Environment variable with the path of PoCL's cache folder.
const VARIABLE: &str = "POCL_CACHE_DIR";
/// Free bytes that PoCL needs. The kernels of one picture take 1 to 3 MB, including temporary compiler files.
const NEEDED: usize = 4 << 20;

/// Sets `POCL_CACHE_DIR` to a folder below the system's temporary folder if PoCL cannot write to its default folder. Does nothing
/// if the variable is set. In containers, HOME is often missing or belongs to another user.
///
/// # Safety
/// Changes the environment: no other thread may run.
pub unsafe fn keep_compiled_kernels() {
    match env::var_os(VARIABLE) {
        // PoCL aborts on an empty path.
        // SAFETY: guaranteed by the caller.
        Some(named) if named.is_empty() => unsafe { env::remove_var(VARIABLE) },
        Some(_) => return,
        None => {}
    }
    // On a full disk, the default folder is still usable: kernels compiled earlier are found there.
    if can_hold(&folder(), 0).is_ok() {
        return;
    }
    // Without a temporary folder, PoCL lists no devices; the error of device selection then gives the reason.
    if let Some(folder) = temporary_folder() {
        // SAFETY: guaranteed by the caller.
        unsafe { env::set_var(VARIABLE, folder) };
    }
}

/// Whether a platform is PoCL.
pub(super) fn is_pocl(platform: &str) -> bool {
    platform.contains("Portable Computing Language")
}

/// The error for a PoCL platform that cannot write to its cache folder. Writes a test file there, so call it only after a
/// failure.
pub(crate) fn unusable_cache(platform: &str) -> Option<Error> {
    if !is_pocl(platform) {
        return None;
    }
    let folder = folder();
    can_hold(&folder, NEEDED).err().map(|source| Error::KernelCache { folder, source })
}

/// PoCL's cache folder, by PoCL's own rule.
fn folder() -> PathBuf {
    let set = |name: &str| env::var_os(name);
    let below = |parent: OsString, rest: &str| Path::new(&parent).join(rest);
    match (set(VARIABLE), set("XDG_CACHE_HOME").filter(|name| !name.is_empty()), set("HOME")) {
        (Some(named), ..) => named.into(),
        (None, Some(caches), _) => below(caches, "pocl/kcache"),
        // PoCL treats an empty HOME as the root folder.
        (None, None, Some(home)) => below(if home.is_empty() { "/".into() } else { home }, ".cache/pocl/kcache"),
        (None, None, None) => "/tmp/pocl/kcache".into(),
    }
}

/// Checks that a file of `bytes` bytes can be created in `folder`, or in its nearest existing ancestor.
fn can_hold(folder: &Path, bytes: usize) -> io::Result<()> {
    let existing = folder.ancestors().find(|ancestor| ancestor.exists());
    // An unnamed file, which is removed even after a crash.
    let mut file = tempfile::tempfile_in(existing.unwrap_or(Path::new(".")))?;
    file.write_all(&vec![0; bytes])
}

/// A folder that only this user can write, normally the same one in every run.
///
/// PoCL executes code from this folder, so another user must not control it. A new private folder is renamed to a fixed path. If
/// that path exists but belongs to another user or is writable by others, the new folder is used under its random name.
#[cfg(unix)]
fn temporary_folder() -> Option<PathBuf> {
    use std::fs::Permissions;
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let owner_alone = Permissions::from_mode(0o700);
    let new = tempfile::Builder::new().prefix("layersplat-kernels-").permissions(owner_alone).tempdir().ok()?;
    let user = std::fs::metadata(new.path()).ok()?.uid();
    let own = env::temp_dir().join(format!("layersplat-kernels-of-{user}"));
    if std::fs::rename(new.path(), &own).is_ok() {
        // `new` does not remove the folder: its path has changed.
        return Some(own);
    }
    let there = std::fs::symlink_metadata(&own).ok();
    let trusted = there.is_some_and(|m| m.is_dir() && m.uid() == user && m.mode() & 0o077 == 0);
    Some(if trusted { own } else { new.keep() })
}

#[cfg(not(unix))]
fn temporary_folder() -> Option<PathBuf> {
    None
}
