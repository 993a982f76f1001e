#![no_main]

use layersplat_fuzz::Store;
use libfuzzer_sys::Corpus;
use std::sync::LazyLock;

static STORE: LazyLock<Store> = LazyLock::new(Store::new);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> Corpus { if STORE.volume(bytes) { Corpus::Keep } else { Corpus::Reject } });
