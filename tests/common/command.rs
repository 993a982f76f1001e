//! Running the command.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

pub fn layersplat(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    command.current_dir(folder).args(arguments).output().unwrap()
}

pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = layersplat(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.trim_end().lines().count(), 1, "one line of JSON: {text}");
    serde_json::from_str(&text).unwrap()
}

pub fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Runs a command that must fail: with this exit code, a message that contains every word, empty standard output, no panic and no new
/// files.
#[track_caller]
pub fn refused(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    refused_of(|| layersplat(folder, arguments), folder, arguments, code, words);
}

/// As [`refused`], with limited address space.
#[cfg(unix)]
#[track_caller]
pub fn refused_within(bytes: u64, folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let limited = || {
        let script = format!("ulimit -v {} && exec \"$0\" \"$@\"", bytes / 1024);
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_layersplat")]).args(arguments).current_dir(folder).output().unwrap()
    };
    refused_of(limited, folder, arguments, code, words);
}

#[track_caller]
fn refused_of(run: impl FnOnce() -> Output, folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let before = names(folder);
    let output = run();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(!message.contains("panicked") && output.stdout.is_empty(), "{arguments:?}: {message}");
    for word in words {
        assert!(message.contains(word), "{arguments:?} does not say '{word}': {message}");
    }
    assert_eq!(names(folder), before, "{arguments:?} must not leave files behind");
}
