//! Lists the kernel files. Sets `real_volumes` if real volumes are available, so that tests that need them are ignored elsewhere.

use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rustc-check-cfg=cfg(real_volumes)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LAYERSPLAT_VOLUMES");
    let folder = std::env::var("LAYERSPLAT_VOLUMES").unwrap_or_else(|_| "../shared/volumes".into());
    if Path::new(&folder).is_dir() {
        println!("cargo::rerun-if-changed={folder}");
        println!("cargo::rustc-cfg=real_volumes");
    }
    list_kernels();
}

/// Writes an array of the names and texts of all files in kernels/, as Rust code. Those of the paper's systems have a feature.
fn list_kernels() {
    println!("cargo::rerun-if-changed=kernels");
    let root = Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo")).join("kernels");
    let mut entries = Vec::new();
    let has_paper = std::env::var_os("CARGO_FEATURE_PAPER").is_some();
    let folders = sorted(&root).into_iter().filter(|folder| has_paper || !folder.ends_with("paper"));
    for file in folders.flat_map(|folder| sorted(&folder)) {
        let name = file.strip_prefix(&root).expect("a file in it").to_str().expect("names are ASCII").replace('\\', "/");
        entries.push(format!("({name:?}, include_str!({file:?}))"));
    }
    let list = Path::new(&std::env::var("OUT_DIR").expect("set by cargo")).join("kernel_files.rs");
    fs::write(list, format!("&[{}]", entries.join(",\n"))).expect("the build folder can be written");
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("kernels has folders of files");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    paths
}
