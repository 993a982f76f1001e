#![no_main]

libfuzzer_sys::fuzz_target!(|message: &str| drop(layersplat::viewer::check_message(message)));
