//! Volumes from standard input, results to standard output.
#![cfg(unix)]

use crate::common::command::*;
use layersplat::volume::{OpenOptions, Volume};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const PICTURE: [&str; 5] = ["--size", "40x30", "--azimuth", "30", "--no-metadata"];

/// The command with a separate folder for temporary files.
fn command(temporary: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    command.args(arguments).env("TMPDIR", temporary).current_dir(temporary.parent().unwrap());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs the command with bytes on standard input. It must not leave temporary files behind.
#[track_caller]
fn fed(bytes: &[u8], arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let temporary = folder.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let mut child = command(&temporary, arguments).spawn().unwrap();
    // The command may close standard input early.
    let _ = child.stdin.take().unwrap().write_all(bytes);
    let output = child.wait_with_output().unwrap();
    assert_eq!(names(&temporary), [""; 0], "{arguments:?}");
    output
}

/// Standard output of a run that must succeed.
#[track_caller]
fn made(bytes: &[u8], arguments: &[&str]) -> Vec<u8> {
    let output = fed(bytes, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Asserts an exit code, messages, and an empty standard output.
#[track_caller]
fn refused_with(bytes: &[u8], arguments: &[&str], code: i32, words: &[&str]) {
    let output = fed(bytes, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(code), 0), "{arguments:?}: {message}");
    assert!(!message.contains("panicked") && !message.contains("/temporary/"), "{arguments:?}: {message}");
    for word in words {
        assert!(message.contains(word), "{arguments:?} does not say '{word}': {message}");
    }
}

/// Writes a volume to a file and returns its bytes.
fn volume(folder: &Path, name: &str) -> Vec<u8> {
    let volume = Volume::open("builtin:hydrogen@12x11x10", &OpenOptions::default()).unwrap();
    std::fs::read(volume.save(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn pictures_through_pipes_are_those_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let nrrd = volume(f, "hydrogen.nrrd");
    let render = |volume: &str, output: &str| [&["render", volume, "-o", output], &PICTURE[..]].concat().join(" ");
    let words = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
    let run = |text: String| made(&nrrd, &words(&text).iter().map(String::as_str).collect::<Vec<_>>());
    let file = |name: &str| {
        let path = f.join(name).display().to_string();
        run(render(f.join("hydrogen.nrrd").to_str().unwrap(), &path));
        std::fs::read(path).unwrap()
    };
    let png = file("a.png");
    assert!(png.starts_with(b"\x89PNG"));
    assert!(run(render("-", "-")) == png && run(render("-", "png:-")) == png);
    assert!(run(render("-", "npy:-")) == file("a.npy"));
}

#[test]
fn raw_files_are_told_by_options() {
    let folder = tempfile::tempdir().unwrap();
    let raw = volume(folder.path(), "hydrogen.raw");
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(&raw).unwrap();
    let options = ["--dims", "12x11x10", "--type", "uint8"];
    for bytes in [&raw, &packer.finish().unwrap()] {
        let npy = made(bytes, &[&["convert", "-", "npy:-"], &options[..]].concat());
        assert!(npy.starts_with(b"\x93NUMPY") && npy.ends_with(&raw));
    }
    refused_with(&raw, &["info", "-"], 1, &["standard input: unknown format"]);
    refused_with(&raw[1..], &[&["info", "-"], &options[..]].concat(), 1, &["standard input: 12x11x10", "found 1319", "--dims"]);
}

#[test]
fn volumes_are_converted_in_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let nrrd = volume(folder.path(), "hydrogen.nrrd");
    let raw = volume(folder.path(), "hydrogen.raw");
    let there = made(&nrrd, &["convert", "-", "nii.gz:-"]);
    let back = made(&there, &["convert", "-", "vti:-"]);
    assert!(made(&back, &["convert", "-", "raw:-"]) == raw);
    // The file name, which encodes the layout, is reported.
    let told = fed(&nrrd, &["convert", "-", "raw:-"]).stderr;
    assert!(String::from_utf8(told).unwrap().contains("_12x11x10_uint8.raw"));
    assert!(made(&[], &["transfer", "builtin:cube@4", "-o", "csv:-"]).starts_with(b"value,r,g,b,a\n"));
}

#[test]
fn what_comes_is_checked_as_files_are() {
    let folder = tempfile::tempdir().unwrap();
    let nrrd = volume(folder.path(), "hydrogen.nrrd");
    refused_with(b"", &["info", "-"], 1, &["standard input: it is empty"]);
    refused_with(&nrrd[..nrrd.len() - 1], &["info", "-"], 1, &["standard input: ", "truncated"]);
    let huge = String::from_utf8_lossy(&nrrd[..200]).replace("12 11 10", "9999 9999 9999");
    refused_with(huge.as_bytes(), &["info", "-"], 1, &["standard input: ", "999700029999"]);
    refused_with(&nrrd, &["info", "-", "--channel", "1"], 2, &["1 is not in standard input"]);
    refused_with(&nrrd, &["convert", "-", "-"], 2, &["'-'", "nrrd:-"]);
    refused_with(&nrrd, &["convert", "-", "doc:-"], 2, &["'doc:-'", "nrrd:-"]);
    refused_with(&nrrd, &["render", "-", "-o", "doc:-"], 2, &["'doc:-'", "png:-"]);
    refused_with(&nrrd, &["render", "-", "-o", "-", "--json"], 2, &["--json", "--output"]);
    refused_with(&nrrd, &["render", "-", "--cameras", "-"], 2, &["standard input", "--cameras"]);
}

/// A closed standard output is not an error.
#[test]
fn a_broken_pipe_ends_quietly() {
    let folder = tempfile::tempdir().unwrap();
    let temporary = folder.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    for arguments in [
        &["convert", "builtin:cube@64", "raw:-"][..],
        &["render", "builtin:cube@8", "-o", "-", "--size", "9x9", "--transfer", "fire"],
    ] {
        let mut child = command(&temporary, arguments).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(141), "{arguments:?}: {message}");
        assert!(!message.contains("panicked") && !message.contains("layersplat:"), "{arguments:?}: {message}");
        assert_eq!(names(&temporary), [""; 0]);
    }
}

/// `script` provides a terminal.
#[test]
fn terminals_are_neither_read_nor_filled() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [("convert builtin:cube@4 nrrd:-", "standard output is a terminal"), ("info -", "it is a terminal")]
    {
        let line = format!("{} {arguments}", env!("CARGO_BIN_EXE_layersplat"));
        let mut script = Command::new("script");
        script.args(["-q", "-e", "-c", &line, "/dev/null"]).current_dir(folder.path()).stdin(Stdio::null());
        let output = script.output().unwrap();
        let seen = String::from_utf8_lossy(&output.stdout);
        assert!(!output.status.success() && seen.contains(words), "{arguments}: {seen}");
    }
}

#[test]
fn a_signal_removes_what_has_come() {
    let folder = tempfile::tempdir().unwrap();
    let temporary = folder.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let mut child = command(&temporary, &["info", "-"]).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(&[0; 1 << 16]).unwrap();
    while names(&temporary).is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = Command::new("kill").arg(child.id().to_string()).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(128 + 15));
    assert_eq!(names(&temporary), [""; 0]);
}
