#![no_main]

use layersplat_fuzz::File;
use std::sync::LazyLock;

static FILES: LazyLock<[File; 7]> =
    LazyLock::new(|| ["stl", "ply", "vtk", "vtp", "obj", "gii", "pial"].map(|ending| File::new(&format!("input.{ending}"), None)));

// The first byte chooses the format.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| if let [format, bytes @ ..] = bytes {
    FILES[usize::from(*format) % FILES.len()].surface(bytes);
});
