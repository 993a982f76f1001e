//! What the OpenCL loader could not load, and why: it keeps that to itself, and says only that there is no platform.

use dlopen2::raw::Library;
use std::env;
use std::path::{Path, PathBuf};

/// The loader itself, as it is asked for.
const LOADER: &str = if cfg!(windows) {
    "OpenCL.dll"
} else if cfg!(target_os = "macos") {
    "/System/Library/Frameworks/OpenCL.framework/OpenCL"
} else {
    "libOpenCL.so.1"
};

/// Why the loader was not loaded.
pub(super) fn why_no_loader() -> String {
    why_not(LOADER).unwrap_or_else(|| format!("{LOADER} lacks functions of OpenCL 1.2"))
}

/// Of each implementation that is installed and cannot be loaded, its file and why: a library that it needs itself, most often. One that
/// can be loaded was loaded already.
pub(super) fn failures() -> Vec<String> {
    let said = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).ok()?;
        let library = text.lines().next().unwrap_or_default().trim();
        Some(format!("{}: {}", file.display(), why_not(library)?))
    };
    vendor_files(&vendors()).into_iter().filter_map(said).collect()
}

/// What the system says of a library that it cannot load.
fn why_not(library: &str) -> Option<String> {
    let said = Library::open(library).err()?.to_string();
    // PyPI's package of Intel's runtime does not ask for the other one that it needs.
    let lacks_intels = ["libintlc.so", "libimf.so", "libsvml.so", "libirng.so"].iter().any(|name| said.contains(name));
    Some(if lacks_intels { format!("{said} (pip install intel-cmplr-lib-rt)") } else { said })
}

/// Where implementations are registered, by the loaders' own rule.
fn vendors() -> PathBuf {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty());
    set("OCL_ICD_VENDORS").or(set("OPENCL_VENDOR_PATH")).map_or("/etc/OpenCL/vendors".into(), PathBuf::from)
}

/// The files that register implementations: those of a folder, or a single one.
fn vendor_files(vendors: &Path) -> Vec<PathBuf> {
    let Ok(folder) = std::fs::read_dir(vendors) else { return vec![vendors.to_owned()] };
    let mut files: Vec<_> =
        folder.flatten().map(|entry| entry.path()).filter(|f| f.extension().is_some_and(|e| e == "icd")).collect();
    files.sort();
    files
}
