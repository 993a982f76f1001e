//! Shared by the fuzz targets. Readers take paths, so every input is written to a file in memory.

use layersplat::surface::{PointData, SurfaceFile, SurfaceOptions};
use layersplat::transfer::FileFormat;
use layersplat::volume::{Endian, OpenOptions, ScalarType, Volume};
use layersplat::{TransferFunction, glam::DVec3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};

mod store;

pub use store::Store;

/// Limit of a single allocation, bytes. An input of 64 KiB expands to at most 128 MiB of voxels (2048 per byte, the ratio of TIFF), and
/// to twice as many where the voxel type is widened. libFuzzer itself detects only memory that was written.
const MOST: usize = 300 << 20;

/// An allocator that aborts on allocations larger than any input requires.
struct Watched;

// SAFETY: all calls are forwarded unchanged to `System`.
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
        eprintln!("allocation of {size} bytes, more than {MOST}");
        std::process::abort();
    }
}

/// A file for the inputs, in a separate temporary folder.
pub struct File {
    path: PathBuf,
}

impl File {
    /// Copies the fixtures of `format` into the same folder, because headers may name them.
    pub fn new(name: &str, format: Option<&str>) -> Self {
        // Not deleted: libFuzzer exits without running destructors.
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

    /// Opens it as a surface, once more with the values of its first array.
    pub fn surface(&self, bytes: &[u8]) {
        std::fs::write(&self.path, bytes).expect("a file in memory");
        let _ = PointData::read(&self.path);
        let Ok(file) = SurfaceFile::read(&self.path) else { return };
        let values = file.arrays.first().map(|array| array.name.clone());
        let bounds = file.bounds();
        assert!(bounds[0].is_finite() && bounds[1].is_finite());
        for options in [SurfaceOptions::default(), SurfaceOptions { values, ..SurfaceOptions::default() }] {
            let surfaces = file.clone().into_surfaces(&options).expect("a surface");
            assert!(!surfaces.is_empty() && surfaces.iter().all(|surface| surface.bounds().is_some()));
        }
    }

    /// Reads it as a transfer function, then writes and reads that in every format.
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

/// Opens a file with options, and then its second frame and its second channel.
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

/// Derives the options of a raw file from eight bytes.
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
