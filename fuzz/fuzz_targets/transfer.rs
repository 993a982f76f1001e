#![no_main]

use layersplat_fuzz::File;
use std::sync::LazyLock;

/// All formats are recognised by what is in them.
static FILE: LazyLock<File> = LazyLock::new(|| File::new("input", None));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| FILE.transfer(bytes));
