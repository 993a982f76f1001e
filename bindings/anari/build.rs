//! Compiles the shim against the backend headers of the crate `anari_sys`.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let headers = headers();
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").file("shim/device.cpp").include(&headers);
    // The header with the version is generated, and included as `frontend/…` and `anari/frontend/…`.
    let generated = PathBuf::from(env::var_os("DEP_ANARI_INCLUDE").expect("anari_sys tells where its headers are"));
    build.include(&generated).include(generated.join("anari"));
    build.compile("layersplat_anari_shim");
    println!("cargo:rerun-if-changed=shim");
    println!("cargo:rerun-if-changed=build.rs");
    // Threads of OpenCL and of the library may outlive anariUnloadLibrary, which would otherwise unmap their code.
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}

/// The folder of the backend headers, which `anari_sys` keeps in its own source and does not tell.
fn headers() -> PathBuf {
    let metadata = |offline: &[&str]| {
        let cargo = env::var_os("CARGO").expect("cargo runs this");
        let target = env::var("TARGET").expect("cargo names the target");
        let mut command = Command::new(cargo);
        command.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", &target]).args(offline);
        command.output().ok().filter(|output| output.status.success())
    };
    let output = metadata(&["--offline"]).or_else(|| metadata(&[])).expect("cargo metadata");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let packages = metadata["packages"].as_array().expect("cargo metadata lists packages");
    let package = packages.iter().find(|package| package["name"] == "anari_sys").expect("anari_sys is a dependency");
    let manifest = Path::new(package["manifest_path"].as_str().expect("a package has a manifest"));
    let headers = manifest.with_file_name("ANARI-SDK").join("src/anari/include");
    assert!(headers.is_dir(), "{} has no headers of ANARI", manifest.display());
    headers
}
