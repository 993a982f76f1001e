//! Sets `real_volumes` if real volumes are available, so that tests that need them are ignored elsewhere.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(real_volumes)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LAYERSPLAT_VOLUMES");
    let folder = std::env::var("LAYERSPLAT_VOLUMES").unwrap_or_else(|_| "../shared/volumes".into());
    if std::path::Path::new(&folder).is_dir() {
        println!("cargo::rerun-if-changed={folder}");
        println!("cargo::rustc-cfg=real_volumes");
    }
}
