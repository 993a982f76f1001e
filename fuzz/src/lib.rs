//! What fuzz targets share: readers take paths, so every input becomes a file in memory.

use layersplat::transfer::FileFormat;
use layersplat::volume::{Endian, OpenOptions, ScalarType, Volume};
use layersplat::{TransferFunction, glam::DVec3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};

mod store;

pub use store::Store;

/// Bytes that are never asked for at once: an input of 64 KiB stands for up to 128 MiB of voxels (2048 a byte, which is TIFF's), and
/// these for twice as many where numbers become wider. libFuzzer itself only sees memory that was written.
const MOST: usize = 300 << 20;

/// Ends the process where a piece of memory is asked for that no input may need.
struct Watched;

// SAFETY: all calls are handed on as they are.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        check(size);
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static WATCHED: Watched = Watched;

#[inline(never)]
fn check(size: usize) {
    if size > MOST {
        eprintln!("{size} bytes are asked for at once");
        std::process::abort();
    }
}

/// A file that inputs are written to, in a folder of its own.
pub struct File {
    path: PathBuf,
}

impl File {
    /// Beside it lie the fixtures of a format, which headers may name.
    pub fn new(name: &str, format: Option<&str>) -> Self {
        // Left behind: a fuzzer ends without an end of its own.
        let folder = tempfile::tempdir().expect("a folder").keep();
        if let Some(format) = format {
            let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/formats/files").join(format);
            for entry in std::fs::read_dir(fixtures).expect("the format's fixtures") {
                let path = entry.expect("a name").path();
                if path.is_file() {
                    std::fs::copy(&path, folder.join(path.file_name().expect("a name"))).expect("a copy");
                }
            }
        }
        Self { path: folder.join(name) }
    }

    /// Opens it as a volume.
    pub fn volume(&self, bytes: &[u8]) {
        self.volume_with(bytes, &OpenOptions::default());
    }

    /// Opens it with options.
    pub fn volume_with(&self, bytes: &[u8], options: &OpenOptions) {
        std::fs::write(&self.path, bytes).expect("a file in memory");
        opened(&self.path, options);
    }

    /// Reads it as a transfer function, which is then written and read again in every format.
    pub fn transfer(&self, bytes: &[u8]) {
        std::fs::write(&self.path, bytes).expect("a file in memory");
        let Ok(transfer) = TransferFunction::from_file(&self.path, None) else { return };
        for format in [FileFormat::ParaView, FileFormat::SlicerText, FileFormat::SlicerJson, FileFormat::Csv] {
            std::fs::write(&self.path, transfer.to_text(format)).expect("a file in memory");
            let again = TransferFunction::from_file(&self.path, None);
            assert!(again.is_ok(), "{format:?}: {again:?}");
        }
    }
}

/// Opens what was written with options, and then its second frame and channel.
fn opened(path: &Path, options: &OpenOptions) {
    let Ok(volume) = Volume::open(path, options) else { return };
    let count: usize = volume.grid().dims().iter().product();
    assert!(volume.value(count - 1).is_finite() || volume.invalid() > 0);
    drop(volume);
    for options in [
        OpenOptions { frame: Some(1), ..options.clone() },
        OpenOptions { channel: Some(1), spacing: Some(DVec3::ONE), ..options.clone() },
    ] {
        let _ = Volume::open(path, &options);
    }
}

/// What eight bytes choose of a raw file's options.
pub fn raw_options(choice: &[u8; 8]) -> OpenOptions {
    const TYPES: [ScalarType; 11] = [
        ScalarType::Uint8,
        ScalarType::Int8,
        ScalarType::Uint16,
        ScalarType::Int16,
        ScalarType::Uint32,
        ScalarType::Int32,
        ScalarType::Uint64,
        ScalarType::Int64,
        ScalarType::Float16,
        ScalarType::Float32,
        ScalarType::Float64,
    ];
    let given = |bit: u8| choice[0] >> bit & 1 == 1;
    OpenOptions {
        dims: given(1)
            .then(|| [choice[1], choice[2], choice[3]].map(|n| if n > 250 { usize::MAX >> (n - 251) } else { n.into() })),
        voxel_type: given(2).then(|| TYPES[usize::from(choice[4]) % TYPES.len()]),
        endian: given(3).then_some(Endian::Big),
        header_bytes: given(4).then(|| if choice[6] == 255 { u64::MAX - u64::from(choice[5]) } else { choice[5].into() }),
        spacing: given(5).then(|| DVec3::new(1.0, 2.0, f64::from(choice[7]))),
        ..OpenOptions::default()
    }
}
