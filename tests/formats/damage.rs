//! Files that are cut short, or of which bits are flipped, give a volume or an error, and take no more memory than their bytes could
//! stand for.

use crate::files::{all, folder};
use layersplat::volume::Volume;
use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Lengths that a file is cut to, and bits of it that are flipped.
const DAMAGES: usize = 40;
/// Bytes that a damaged file of a few thousand may take at once: packed bytes stand for up to 1032.
const MOST: usize = 24 << 20;

/// Remembers the largest piece of memory that was asked for.
struct Watched;

static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all calls are handed on as they are.
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

/// All files of a folder, below another.
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

/// The files that hold what is opened, of several the first and the last: a pattern's own, or all below a folder.
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

/// Opens a file in every damaged form. How many of them were refused.
fn damaged(path: &Path, options: &layersplat::OpenOptions) -> usize {
    targets(path).iter().map(|target| damaged_at(path, target, options)).sum()
}

/// The same with damage to one of its files.
fn damaged_at(path: &Path, target: &Path, options: &layersplat::OpenOptions) -> usize {
    let whole = std::fs::read(target).unwrap();
    let mut refused = 0;
    let mut try_it = |bytes: &[u8], what: &dyn Fn() -> String| {
        std::fs::write(target, bytes).unwrap();
        LARGEST.store(0, Ordering::Relaxed);
        refused += usize::from(Volume::open(path, options).is_err());
        let largest = LARGEST.load(Ordering::Relaxed);
        assert!(largest < MOST, "{} takes {largest} bytes, {}", path.display(), what());
    };
    let step = (whole.len() / DAMAGES).max(1);
    for length in (0..whole.len()).step_by(step) {
        try_it(&whole[..length], &|| format!("cut to {length}"));
    }
    // Bits by a linear congruence, so that a failure comes back.
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

/// One test, for what it measures is the process's.
#[test]
fn damaged_files_are_refused_or_read() {
    let temporary = tempfile::tempdir().unwrap();
    copied(&folder(), temporary.path());
    let mut seen = BTreeSet::new();
    for expected in all() {
        if seen.insert(expected.file.clone()) {
            let refused = damaged(&temporary.path().join(&expected.file), &expected.options);
            assert!(refused > 0, "{}: nothing that is done to it is noticed", expected.file);
        }
    }
}

/// Nothing of a file can be left out but what comes behind its voxels.
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
                // The checksum behind packed voxels is not looked at where these end.
                assert!(opened.is_err(), "{file} at {length} of {}", whole.len());
            }
        }
    }
}
