//! Verdicts that are remembered: one file per family, in one folder per device, driver and build of the command.

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
    /// What kernels are built and launched with.
    tuning: String,
    layersplat: String,
    /// Hash of the kernel sources.
    kernels: String,
    /// Options that every kernel program is compiled with.
    compiler_options: String,
    /// Hash of the running executable. Empty if it cannot be read; such verdicts are neither kept nor believed.
    executable: String,
}

/// What a file holds.
#[derive(Serialize, Deserialize)]
struct Kept {
    checked: Checked,
    verdict: Verdict,
}

/// The verdicts on a device.
pub(super) struct Verdicts {
    checked: Checked,
    /// Where they are kept, if there is a place.
    folder: Option<PathBuf>,
}

impl Verdicts {
    pub fn of(device: &DeviceInfo) -> Self {
        Self::below(folder(), device)
    }

    fn below(caches: Option<PathBuf>, device: &DeviceInfo) -> Self {
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
                tracing::warn!("cannot read this executable ({e}): the device is checked by every command");
                String::new()
            }),
        };
        let mut hasher = DefaultHasher::new();
        format!("{checked:?}").hash(&mut hasher);
        let name = format!("{:016x}", hasher.finish());
        Self { checked, folder: caches.map(|caches| caches.join("layersplat/checks").join(name)) }
    }

    fn are_keyed(&self) -> bool {
        !self.checked.executable.is_empty()
    }

    fn file(&self, family: Family) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{family}.json")))
    }

    /// What is remembered of a family. What cannot be read, or is for something else, is none.
    pub fn read(&self, family: Family) -> Option<Verdict> {
        let text = std::fs::read_to_string(self.file(family)?).ok()?;
        let kept: Kept = serde_json::from_str(&text).ok()?;
        (self.are_keyed() && kept.checked == self.checked && kept.verdict.family == family).then_some(kept.verdict)
    }

    /// Remembers verdicts; where that is not possible, the next command checks again.
    pub fn keep<'a>(&self, verdicts: impl Iterator<Item = &'a Verdict>) {
        let mut verdicts = verdicts.peekable();
        if !self.are_keyed() || verdicts.peek().is_none() {
            return;
        }
        let Some(folder) = &self.folder else {
            return tracing::warn!("what the device's check found is not kept, so that every command checks: set XDG_CACHE_HOME");
        };
        let kept = std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e));
        let mut kept_all = || verdicts.try_for_each(|verdict| self.write(folder, verdict));
        if let Err(error) = kept.and_then(|()| kept_all()) {
            tracing::warn!(
                "what the device's check found is not kept, so that every command checks ({error}): set XDG_CACHE_HOME"
            );
        }
    }

    fn write(&self, folder: &Path, verdict: &Verdict) -> Result<(), Error> {
        let kept = Kept { checked: self.checked.clone(), verdict: verdict.clone() };
        let text = serde_json::to_vec_pretty(&kept).expect("verdicts are plain data");
        write_whole(&folder.join(format!("{}.json", verdict.family)), |out| out.write_all(&text))
    }
}

/// The user's folder of what can be made again, as the XDG base directories have it.
fn folder() -> Option<PathBuf> {
    let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("XDG_CACHE_HOME").or_else(|| set("HOME").map(|home| home.join(".cache")))
}

/// Hash of the bytes of the running executable: host code, `-D` options and launch geometry in one.
///
/// A build id from `build.rs` would miss compiler flags, features and dependencies, and size and time of the file are equal in
/// reproducible packages. Reading and hashing the release build (12 MB) takes 3 to 8 ms.
fn executable_hash() -> io::Result<u64> {
    // Linux opens the file that runs, also after an update has replaced it.
    let mut file = File::open("/proc/self/exe").or_else(|_| File::open(env::current_exe()?))?;
    let mut hasher = DefaultHasher::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hasher.finish()),
            read => hasher.write(&piece[..read]),
        }
    }
}
