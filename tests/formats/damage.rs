//! Truncated files and flipped bits give a volume or an error, and never allocate more memory than the file could hold.

use crate::files::{all, folder};
use layersplat::surface::SurfaceOptions;
use layersplat::volume::{ChannelDescription, LabelTable, Labels, Volume};
use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of truncations and of bit flips per file.
const DAMAGES: usize = 40;
/// Largest allocation for a damaged file of a few thousand bytes: compression ratios are at most 1032.
const MOST: usize = 24 << 20;

/// Records the largest allocation.
struct Watched;

static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all calls are forwarded unchanged.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.fetch_max(size, Ordering::Relaxed);
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static WATCHED: Watched = Watched;

/// Copies a folder with its subfolders.
pub fn copied(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copied(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Files to damage; of several, the first and the last: those of a pattern, or all below a folder.
fn targets(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_str().unwrap().replace("%d", "8").into()];
    }
    let mut found: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()) {
        found.extend(if entry.is_dir() { targets(&entry) } else { vec![entry] });
    }
    found.sort();
    let last = found.pop().unwrap();
    found.truncate(1);
    found.push(last);
    found
}

/// Opens a file in all damaged forms; returns the number of errors.
fn damaged(path: &Path, options: &layersplat::OpenOptions) -> usize {
    targets(path).iter().map(|target| damaged_at(path, target, options)).sum()
}

/// Opens a file as what it is: its metadata of labels and channels may be refused where its voxels are not.
fn opened(path: &Path, options: &layersplat::OpenOptions) -> Result<(), layersplat::Error> {
    if path.extension().is_some_and(|ending| ending == "txt") {
        return LabelTable::open(path).map(|_| ());
    }
    let of = |folder: &str| path.components().any(|part| part.as_os_str() == folder);
    if of("surfaces") {
        return layersplat::surface::open(path, &SurfaceOptions::default()).map(|_| ());
    }
    Volume::open(path, options)?;
    if of("labels") {
        Labels::open(path, options, None)?;
    }
    if of("channels") {
        ChannelDescription::of_file(path, options)?;
    }
    Ok(())
}

/// Opens a path with all kinds of damage to one of its files.
fn damaged_at(path: &Path, target: &Path, options: &layersplat::OpenOptions) -> usize {
    let whole = std::fs::read(target).unwrap();
    let mut refused = 0;
    let mut try_it = |bytes: &[u8], what: &dyn Fn() -> String| {
        std::fs::write(target, bytes).unwrap();
        LARGEST.store(0, Ordering::Relaxed);
        refused += usize::from(opened(path, options).is_err());
        let largest = LARGEST.load(Ordering::Relaxed);
        assert!(largest < MOST, "{} takes {largest} bytes, {}", path.display(), what());
    };
    let step = (whole.len() / DAMAGES).max(1);
    for length in (0..whole.len()).step_by(step) {
        try_it(&whole[..length], &|| format!("cut to {length}"));
    }
    // Pseudo-random bits from a linear congruential generator, for reproducible failures.
    let mut state = 12345u64;
    for _ in 0..DAMAGES {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let bit = (state >> 20) as usize % (whole.len() * 8);
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        try_it(&bytes, &|| format!("with bit {bit} flipped"));
    }
    std::fs::write(target, whole).unwrap();
    refused
}

/// A single test, because it measures allocations of the process.
#[test]
fn damaged_files_are_refused_or_read() {
    let temporary = tempfile::tempdir().unwrap();
    copied(&folder(), temporary.path());
    let table = damaged(&temporary.path().join("labels/atlas.txt"), &layersplat::OpenOptions::default());
    assert!(table > 0, "no damage of a table was detected");
    for file in crate::surfaces::all() {
        let refused = damaged(&temporary.path().join("surfaces").join(&file), &layersplat::OpenOptions::default());
        assert!(refused > 0, "{file}: no damage was detected");
    }
    let mut seen = BTreeSet::new();
    for expected in all() {
        if seen.insert(expected.file.clone()) {
            let refused = damaged(&temporary.path().join(&expected.file), &expected.options);
            assert!(refused > 0, "{}: no damage was detected", expected.file);
        }
    }
}

/// Truncation is detected everywhere except after the voxels.
#[test]
fn files_cut_short_within_their_voxels_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    copied(&folder(), temporary.path());
    for file in ["nrrd/raw.nrrd", "nrrd/int16.nrrd"] {
        let path = temporary.path().join(file);
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() - 1 {
            std::fs::write(&path, &whole[..length]).unwrap();
            for memory in [None, Some(0)] {
                let opened = Volume::open(&path, &layersplat::OpenOptions { memory, ..Default::default() });
                // The checksum after compressed voxels is not verified.
                assert!(opened.is_err(), "{file} at {length} of {}", whole.len());
            }
        }
    }
}
