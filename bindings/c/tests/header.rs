//! The header is what the source says.

use std::path::Path;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

fn generated() -> String {
    let mut made = Vec::new();
    cbindgen::generate(FOLDER).expect("cbindgen reads the source").write(&mut made);
    String::from_utf8(made).unwrap()
}

/// `LAYERSPLAT_WRITE_HEADER=1` writes it instead.
#[test]
fn the_header_is_up_to_date() {
    let (path, made) = (Path::new(FOLDER).join("include/layersplat.h"), generated());
    if std::env::var_os("LAYERSPLAT_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(made == there, "{} is not up to date: run bindings/c/header", path.display());
}

/// Every function that is exported is declared, with a comment.
#[test]
fn every_function_is_documented() {
    let header = generated();
    let declared: Vec<&str> = header.split("\n\n").filter(|block| block.trim_end().ends_with(");")).collect();
    for block in &declared {
        assert!(block.trim_start().starts_with("/**"), "without a comment: {block}");
    }
    let files = std::fs::read_dir(Path::new(FOLDER).join("src")).unwrap();
    let exported =
        files.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap().matches("#[unsafe(no_mangle)]").count());
    assert_eq!(declared.len(), exported.sum::<usize>());
}
