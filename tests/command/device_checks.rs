//! The command rejects devices that render wrongly, and checks each device once.

use crate::common::command::*;
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the command with verdicts in a separate folder and PoCL's kernels in the usual one, so that they are built once.
fn run(caches: &Path, arguments: &[&str]) -> Output {
    run_build(Path::new(env!("CARGO_BIN_EXE_layersplat")), caches, arguments)
}

/// The same with any build of the command.
fn run_build(build: &Path, caches: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(build);
    command.current_dir(caches).args(arguments).env("XDG_CACHE_HOME", caches).env("RUST_LOG", "warn");
    if std::env::var_os("POCL_CACHE_DIR").is_none() {
        let home = PathBuf::from(std::env::var_os("HOME").unwrap_or("/tmp".into()));
        let usual = std::env::var_os("XDG_CACHE_HOME").map_or(home.join(".cache"), PathBuf::from);
        command.env("POCL_CACHE_DIR", usual.join("pocl/kcache"));
    }
    command.output().unwrap()
}

const RENDER: [&str; 6] = ["render", "builtin:hydrogen@12", "--size", "12x12", "-o", "a.npy"];

fn render(caches: &Path, more: &[&str]) -> Output {
    run(caches, &[&RENDER[..], more].concat())
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Verdict files, by family.
fn verdicts(caches: &Path) -> Vec<PathBuf> {
    let Ok(devices) = std::fs::read_dir(caches.join("layersplat/checks")) else { return Vec::new() };
    let mut files: Vec<PathBuf> =
        devices.flat_map(|device| std::fs::read_dir(device.unwrap().path()).unwrap()).map(|file| file.unwrap().path()).collect();
    files.sort();
    files
}

/// Modifies a JSON file.
fn change(file: &Path, change: impl FnOnce(&mut Value)) {
    let mut kept: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    change(&mut kept);
    std::fs::write(file, kept.to_string()).unwrap();
}

fn refused_for(output: &Output, words: &[&str]) {
    let said = message(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for word in words {
        assert!(said.contains(word), "not '{word}': {said}");
    }
}

/// Verdicts are stored per family. They are trusted, pass or fail, until driver, kernels or version change.
#[test]
fn what_a_check_found_is_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let first = render(f, &[]);
    assert!(first.status.success(), "{}", message(&first));
    let [file] = &verdicts(f)[..] else { panic!("{:?}", verdicts(f)) };
    assert!(file.ends_with("point-lattice.json"), "{file:?}");
    // A repeated check would give another result.
    let problem = "black with alpha 1";
    change(file, |kept| kept["verdict"]["problem"] = problem.into());
    std::fs::remove_file(f.join("a.npy")).unwrap();
    refused_for(&render(f, &[]), &["point-lattice", problem, "--device-unchecked", "--device"]);
    assert!(!f.join("a.npy").exists());
    assert!(render(f, &["--device-unchecked"]).status.success() && f.join("a.npy").exists());
    for command in ["rotate", "bench"] {
        refused_for(&run(f, &[command, "builtin:hydrogen@12", "--size", "12x12", "--frames", "2"]), &[problem]);
    }
    // Other families are checked separately.
    let sliced = render(f, &["--algorithm", "slicing"]);
    assert!(sliced.status.success(), "{}", message(&sliced));
    assert_eq!(verdicts(f).len(), 2);
    // Another driver, kernel or version, or an unreadable file, triggers a new check.
    change(file, |kept| kept["checked"]["driver"] = "another".into());
    assert!(render(f, &[]).status.success());
    std::fs::write(file, "{").unwrap();
    assert!(render(f, &[]).status.success());
    let kept: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    assert!(kept["verdict"]["problem"].is_null() && kept["verdict"]["largest_difference"].as_f64().unwrap() < 0.004, "{kept}");
}

/// A verdict holds for one build only: another executable of the same version, or other compiler options, are checked again.
#[test]
fn verdicts_belong_to_one_build() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    assert!(render(f, &[]).status.success());
    let [file] = &verdicts(f)[..] else { panic!("{:?}", verdicts(f)) };
    let problem = "the verdict of the first build";
    change(file, |kept| kept["verdict"]["problem"] = problem.into());
    refused_for(&render(f, &[]), &[problem]);
    // Systems load an executable with bytes behind its end.
    let other = f.join("other-build");
    std::fs::copy(env!("CARGO_BIN_EXE_layersplat"), &other).unwrap();
    let mut end = std::fs::OpenOptions::new().append(true).open(&other).unwrap();
    end.write_all(b"another build").unwrap();
    drop(end);
    let found = run_build(&other, f, &RENDER);
    assert!(found.status.success(), "{}", message(&found));
    refused_for(&render(f, &[]), &[problem]);
    change(file, |kept| kept["checked"]["compiler_options"] = "-cl-fast-relaxed-math".into());
    let found = render(f, &[]);
    assert!(found.status.success(), "{}", message(&found));
}

/// What is not asked for a device is not refused for it.
#[test]
fn only_what_draws_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["devices"][..], &["info", "builtin:cube@4"], &["render", "builtin:cube@4", "--device-unchecked"]] {
        assert!(run(folder.path(), arguments).status.success());
    }
    assert!(verdicts(folder.path()).is_empty());
}

/// An unwritable cache triggers a check and a message each time, but no error.
#[test]
fn a_cache_that_cannot_be_written_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("layersplat"), "in the way").unwrap();
    for _ in 0..2 {
        let output = render(f, &[]);
        assert!(output.status.success(), "{}", message(&output));
        assert!(message(&output).contains("not kept") && message(&output).contains("XDG_CACHE_HOME"), "{}", message(&output));
    }
}

/// `devices --check` reports all families of all devices and replaces stored verdicts.
#[test]
fn devices_are_checked_anew_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    assert!(render(f, &[]).status.success());
    let [file] = &verdicts(f)[..] else { panic!("{:?}", verdicts(f)) };
    change(file, |kept| kept["verdict"]["problem"] = "it was wrong once".into());
    let output = run(f, &["devices", "--check", "--json"]);
    assert!(output.status.success(), "{}", message(&output));
    let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
    for device in listed["devices"].as_array().unwrap() {
        let check = device["check"].as_array().unwrap();
        assert_eq!(check.len(), layersplat::check::Family::ALL.len());
        assert!(check.iter().all(|verdict| verdict["problem"].is_null()), "{check:?}");
    }
    assert!(verdicts(f).len() >= layersplat::check::Family::ALL.len());
    assert!(render(f, &[]).status.success());
    // Without the option there is no check.
    let output = run(f, &["devices", "--json"]);
    let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(listed["devices"][0].get("check").is_none());
}

/// The checking process accepts lists from the command only.
#[test]
fn the_hidden_command_refuses_nonsense() {
    let folder = tempfile::tempdir().unwrap();
    refused(folder.path(), &["check-device", "0", "nonsense"], 2, &["families"]);
    let help = String::from_utf8(layersplat(folder.path(), &["--help"]).stdout).unwrap();
    assert!(help.contains("devices") && !help.contains("check-device"), "{help}");
}
