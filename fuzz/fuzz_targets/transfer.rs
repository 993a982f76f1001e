#![no_main]

use layersplat_fuzz::File;
use std::sync::LazyLock;

/// Formats are detected from the contents.
static FILE: LazyLock<File> = LazyLock::new(|| File::new("input", None));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| FILE.transfer(bytes));
