#![no_main]

use layersplat_fuzz::{File, raw_options};
use std::sync::LazyLock;

/// The file name has the voxel type and the dimensions, which options override.
static FILES: LazyLock<[File; 2]> =
    LazyLock::new(|| ["input_4x3x2_uint8.raw", "input_4x3x2_uint8.raw.gz"].map(|name| File::new(name, None)));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some((choice, rest)) = bytes.split_first_chunk::<8>() {
        FILES[usize::from(choice[0] & 1)].volume_with(rest, &raw_options(choice));
    }
});
