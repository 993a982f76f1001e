//! The checked-in header matches the source.

use std::path::Path;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

fn generated() -> String {
    let mut header = Vec::new();
    cbindgen::generate(FOLDER).expect("cbindgen reads the source").write(&mut header);
    String::from_utf8(header).unwrap()
}

/// With `LAYERSPLAT_WRITE_HEADER=1` the test writes the header first.
#[test]
fn the_header_is_up_to_date() {
    let (path, header) = (Path::new(FOLDER).join("include/layersplat.h"), generated());
    if std::env::var_os("LAYERSPLAT_WRITE_HEADER").is_some() {
        std::fs::write(&path, &header).unwrap();
    }
    let current = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(header == current, "{} is not up to date: run bindings/c/header", path.display());
}

/// Every exported function is declared with a comment.
#[test]
fn every_function_is_documented() {
    let header = generated();
    let declared: Vec<&str> = header.split("\n\n").filter(|block| block.trim_end().ends_with(");")).collect();
    for block in &declared {
        assert!(block.trim_start().starts_with("/**"), "without a comment: {block}");
    }
    // Only files directly below src export functions.
    let sources = std::fs::read_dir(Path::new(FOLDER).join("src")).unwrap().map(|entry| entry.unwrap().path());
    let texts = sources.filter(|path| path.is_file()).map(|path| std::fs::read_to_string(path).unwrap());
    let exported = texts.map(|text| text.matches("#[unsafe(no_mangle)]").count());
    assert_eq!(declared.len(), exported.sum::<usize>());
}
