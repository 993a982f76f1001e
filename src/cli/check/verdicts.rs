//! Cache of verdicts: one file per family, in one folder per device, driver and build of the command.

use crate::cache;
use crate::check::{Family, Verdict};
use crate::device::{DeviceInfo, compiler_options, kernel_sources_hash};
use crate::error::Error;
use crate::image::write_whole;
use serde::{Deserialize, Serialize};
use std::env;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The key of a verdict. If any of these changes, the device is checked again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Checked {
    platform: String,
    device: String,
    driver: String,
    opencl: String,
    tuning: String,
    layersplat: String,
    /// Hash of the kernel sources.
    kernels: String,
    /// Options that every kernel program is compiled with.
    compiler_options: String,
    /// Hash of the running executable. Empty if it cannot be read; such verdicts are neither cached nor used.
    executable: String,
}

/// Content of a file.
#[derive(Serialize, Deserialize)]
struct CachedVerdict {
    checked: Checked,
    verdict: Verdict,
}

/// Cached verdicts on a device.
pub(super) struct Verdicts {
    checked: Checked,
    /// Folder of the files. `None` if neither XDG_CACHE_HOME nor HOME is set.
    folder: Option<PathBuf>,
}

impl Verdicts {
    /// Opens the cache in the user's cache folder.
    pub fn new(device: &DeviceInfo) -> Self {
        let caches = cache::user_folder();
        let checked = Checked {
            platform: device.platform.clone(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            opencl: device.version.clone(),
            tuning: format!("{:?}", device.tuning),
            layersplat: env!("CARGO_PKG_VERSION").into(),
            kernels: format!("{:016x}", kernel_sources_hash()),
            compiler_options: compiler_options().into(),
            executable: executable_hash().map(|hash| format!("{hash:016x}")).unwrap_or_else(|e| {
                tracing::warn!("cannot read this executable ({e}): every command checks the device again");
                String::new()
            }),
        };
        let mut hasher = DefaultHasher::new();
        format!("{checked:?}").hash(&mut hasher);
        let name = format!("{:016x}", hasher.finish());
        Self { checked, folder: caches.map(|caches| caches.join("layersplat/checks").join(name)) }
    }

    fn has_key(&self) -> bool {
        !self.checked.executable.is_empty()
    }

    fn file(&self, family: Family) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{family}.json")))
    }

    /// The cached verdict on a family. `None` if there is none, it cannot be read, or its key differs.
    pub fn read(&self, family: Family) -> Option<Verdict> {
        let text = std::fs::read_to_string(self.file(family)?).ok()?;
        let cached: CachedVerdict = serde_json::from_str(&text).ok()?;
        (self.has_key() && cached.checked == self.checked && cached.verdict.family == family).then_some(cached.verdict)
    }

    /// Caches verdicts. On failure, warns; the next command then checks again.
    pub fn write<'a>(&self, verdicts: impl Iterator<Item = &'a Verdict>) {
        let mut verdicts = verdicts.peekable();
        if !self.has_key() || verdicts.peek().is_none() {
            return;
        }
        let Some(folder) = &self.folder else {
            return tracing::warn!("device check results are not kept, so every command checks again: set XDG_CACHE_HOME");
        };
        let created = std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e));
        let mut write_all = || verdicts.try_for_each(|verdict| self.write_file(folder, verdict));
        if let Err(error) = created.and_then(|()| write_all()) {
            tracing::warn!("device check results are not kept, so every command checks again ({error}): set XDG_CACHE_HOME");
        }
    }

    fn write_file(&self, folder: &Path, verdict: &Verdict) -> Result<(), Error> {
        let cached = CachedVerdict { checked: self.checked.clone(), verdict: verdict.clone() };
        let text = serde_json::to_vec_pretty(&cached).expect("verdicts are plain data");
        write_whole(&folder.join(format!("{}.json", verdict.family)), |out| out.write_all(&text))
    }
}

/// Bytes at the begin of an ELF file that have the note with its build id.
const FIRST_BYTES: u64 = 4096;
/// Begin of that note: length of its name (`GNU`), of the id (20 bytes), and its type.
const BUILD_ID: &[u8] = b"\x04\0\0\0\x14\0\0\0\x03\0\0\0GNU\0";

/// Hash of the running executable, which covers host code, `-D` options and launch geometry.
///
/// A build id from `build.rs` would miss compiler flags, features and dependencies. Size and time of the file are equal in
/// reproducible packages. The linker's build id is a hash of all that it has linked, and is in the first bytes of the
/// file. Without one, the whole file is hashed.
fn executable_hash() -> io::Result<u64> {
    // On Linux, this opens the running file even after an update has replaced it.
    let mut file = File::open("/proc/self/exe").or_else(|_| File::open(env::current_exe()?))?;
    let mut hasher = DefaultHasher::new();
    file.metadata()?.len().hash(&mut hasher);
    let mut bytes = Vec::new();
    file.by_ref().take(FIRST_BYTES).read_to_end(&mut bytes)?;
    if !bytes.windows(BUILD_ID.len()).any(|found| found == BUILD_ID) {
        file.read_to_end(&mut bytes)?;
    }
    hasher.write(&bytes);
    Ok(hasher.finish())
}
