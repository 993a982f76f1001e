#![no_main]

use layersplat_fuzz::File;
use std::sync::LazyLock;

static FILE: LazyLock<File> = LazyLock::new(|| File::new("input.nc", None));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| FILE.volume(bytes));
