//! Diagnoses OpenCL libraries that cannot be loaded. The loader itself reports only that there is no platform.

use dlopen2::raw::Library;
use std::env;
use std::path::{Path, PathBuf};

/// File name of the OpenCL loader.
const LOADER: &str = if cfg!(windows) {
    "OpenCL.dll"
} else if cfg!(target_os = "macos") {
    "/System/Library/Frameworks/OpenCL.framework/OpenCL"
} else {
    "libOpenCL.so.1"
};

/// Why the loader itself could not be loaded.
pub(super) fn loader_error() -> String {
    load_error(LOADER).unwrap_or_else(|| format!("{LOADER} lacks OpenCL 1.2 functions"))
}

/// File and error of each installed implementation that cannot be loaded, mostly because another library is missing. Loading the
/// others again has no effect: they are loaded already.
pub(super) fn failures() -> Vec<String> {
    let failure = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).ok()?;
        let library = text.lines().next().unwrap_or_default().trim();
        Some(format!("{}: {}", file.display(), load_error(library)?))
    };
    vendor_files(&vendors_path()).into_iter().filter_map(failure).collect()
}

/// The system's error for a library that cannot be loaded.
fn load_error(library: &str) -> Option<String> {
    let error = Library::open(library).err()?.to_string();
    // The PyPI package of Intel's runtime does not declare this dependency.
    let lacks_intel_runtime = ["libintlc.so", "libimf.so", "libsvml.so", "libirng.so"].iter().any(|name| error.contains(name));
    Some(if lacks_intel_runtime { format!("{error} (pip install intel-cmplr-lib-rt)") } else { error })
}

/// Where implementations are registered, by the same rule as the common loaders.
fn vendors_path() -> PathBuf {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty());
    set("OCL_ICD_VENDORS").or(set("OPENCL_VENDOR_PATH")).map_or("/etc/OpenCL/vendors".into(), PathBuf::from)
}

/// The `.icd` files that register implementations: those in a folder, or a single file.
fn vendor_files(vendors: &Path) -> Vec<PathBuf> {
    let Ok(folder) = std::fs::read_dir(vendors) else { return vec![vendors.to_owned()] };
    let mut files: Vec<_> =
        folder.flatten().map(|entry| entry.path()).filter(|f| f.extension().is_some_and(|e| e == "icd")).collect();
    files.sort();
    files
}
