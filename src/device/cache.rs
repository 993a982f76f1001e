//! The folder in which PoCL keeps compiled kernels. Without one it has no device, or builds nothing.

use crate::error::Error;
use std::env;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Names PoCL's folder.
const VARIABLE: &str = "POCL_CACHE_DIR";
/// Bytes that PoCL must be able to write: one picture takes between 1 and 3 MB of kernels, the files of its compiler included.
const NEEDED: usize = 4 << 20;

/// Gives PoCL a folder of its own below the system's temporary one, unless it can write its default or `POCL_CACHE_DIR` names
/// another: in a container, HOME is often missing or another user's.
///
/// # Safety
/// Changes the environment: no other thread may be running.
pub unsafe fn keep_compiled_kernels() {
    match env::var_os(VARIABLE) {
        // PoCL aborts at an empty name.
        // SAFETY: the caller's promise.
        Some(named) if named.is_empty() => unsafe { env::remove_var(VARIABLE) },
        Some(_) => return,
        None => {}
    }
    // A full disk is no reason to move: kernels that are there already are still found.
    if can_hold(&folder(), 0).is_ok() {
        return;
    }
    // Where there is no temporary folder either, PoCL's devices are missing, and the error says why.
    if let Some(folder) = temporary_folder() {
        // SAFETY: the caller's promise.
        unsafe { env::set_var(VARIABLE, folder) };
    }
}

/// Whether a platform is PoCL.
pub(super) fn is_pocl(platform: &str) -> bool {
    platform.contains("Portable Computing Language")
}

/// Why kernels cannot be built on a platform, if it is PoCL and cannot write its folder. This writes there: ask after a failure.
pub(crate) fn unusable_cache(platform: &str) -> Option<Error> {
    if !is_pocl(platform) {
        return None;
    }
    let folder = folder();
    can_hold(&folder, NEEDED).err().map(|source| Error::KernelCache { folder, source })
}

/// Where PoCL keeps kernels, by its own rule.
fn folder() -> PathBuf {
    let set = |name: &str| env::var_os(name);
    let below = |parent: OsString, rest: &str| Path::new(&parent).join(rest);
    match (set(VARIABLE), set("XDG_CACHE_HOME").filter(|name| !name.is_empty()), set("HOME")) {
        (Some(named), ..) => named.into(),
        (None, Some(caches), _) => below(caches, "pocl/kcache"),
        // An empty HOME is the root folder to PoCL.
        (None, None, Some(home)) => below(if home.is_empty() { "/".into() } else { home }, ".cache/pocl/kcache"),
        (None, None, None) => "/tmp/pocl/kcache".into(),
    }
}

/// Whether a file of so many bytes can be made in a folder, or where it would have to be made.
fn can_hold(folder: &Path, bytes: usize) -> io::Result<()> {
    let existing = folder.ancestors().find(|ancestor| ancestor.exists());
    // A file without a name: nothing is left behind, whatever happens.
    let mut file = tempfile::tempfile_in(existing.unwrap_or(Path::new(".")))?;
    file.write_all(&vec![0; bytes])
}

/// A folder that only this user can write, the same one every time.
///
/// PoCL runs what lies there. So a new folder, which is certainly this user's, is moved into place; if one is there already that
/// is not, or that others can write, the new one stays where it is.
#[cfg(unix)]
fn temporary_folder() -> Option<PathBuf> {
    use std::fs::Permissions;
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let owner_alone = Permissions::from_mode(0o700);
    let new = tempfile::Builder::new().prefix("layersplat-kernels-").permissions(owner_alone).tempdir().ok()?;
    let user = std::fs::metadata(new.path()).ok()?.uid();
    let own = env::temp_dir().join(format!("layersplat-kernels-of-{user}"));
    if std::fs::rename(new.path(), &own).is_ok() {
        // It is no longer where `new` would remove it.
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
