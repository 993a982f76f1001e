//! Messages of --verbose.

use crate::common::command::*;
use std::path::Path;

/// Standard error of a run that must succeed.
#[track_caller]
fn messages(folder: &Path, arguments: &str) -> String {
    let output = layersplat(folder, &arguments.split_whitespace().collect::<Vec<_>>());
    let messages = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {messages}");
    messages
}

#[test]
fn progress_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let info = |more: &str| messages(folder.path(), &format!("info builtin:cube@8 {more}"));
    assert!(!info("").contains("range of its values") && info("-v").contains("range of its values"));
}

/// A buffer that a frame declares.
struct Declared {
    name: String,
    bytes: u64,
    lifetime: String,
}

/// The buffers of the only frame of a picture of hydrogen, whose stated number, sum and maximum must be theirs, and all messages.
#[track_caller]
fn declared(folder: &Path, arguments: &str) -> (Vec<Declared>, String) {
    let all = messages(folder, &format!("render {arguments} --size 40x30 -o a.npy -vv"));
    let lines: Vec<_> = all.lines().filter(|line| line.contains(" buffers of ")).collect();
    let [line] = lines[..] else { panic!("{arguments}: {} frames\n{all}", lines.len()) };
    let (head, list) = line.split_once(": ").unwrap();
    let buffers: Vec<_> = list
        .split(", ")
        .map(|buffer| {
            let (rest, lifetime) = buffer.strip_suffix(')').and_then(|buffer| buffer.rsplit_once(" (")).expect(line);
            let (name, bytes) = rest.rsplit_once(' ').expect(line);
            Declared { name: name.into(), bytes: bytes.parse().expect(line), lifetime: lifetime.into() }
        })
        .collect();
    let (sum, largest) = (sum(&buffers), buffers.iter().map(|buffer| buffer.bytes).max().unwrap());
    assert!(
        head.ends_with(&format!("{} buffers of {sum} bytes, the largest of {largest}", buffers.len())),
        "{arguments}: {line}"
    );
    (buffers, all)
}

fn sum(buffers: &[Declared]) -> u64 {
    buffers.iter().map(|buffer| buffer.bytes).sum()
}

/// The second level lists the buffers that a frame declares.
#[test]
fn the_buffers_of_a_frame_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    assert!(!messages(f, "render builtin:hydrogen@24x20x18 --size 40x30 -o a.npy -v").contains(" buffers of "));
    for (more, expected) in [
        ("", &[("float picture", "frame"), ("sample counts", "frame"), ("table of integrals", "kept")][..]),
        ("--algorithm raycast", &[("samples of the picture", "frame"), ("min-max blocks", "kept")]),
        ("--quality paper", &[("sub-slabs", "host"), ("footprint set", "kept")]),
    ] {
        let (buffers, _) = declared(f, &format!("builtin:hydrogen@24x20x18 {more}"));
        let of = |name: &str, lifetime: &str| {
            let found = buffers.iter().find(|buffer| buffer.name == name && buffer.lifetime == lifetime);
            found.unwrap_or_else(|| panic!("{more}: no {name} ({lifetime})")).bytes
        };
        // One byte per voxel; four floats per pixel, with or without a lattice.
        assert_eq!(of("voxels", "field"), 24 * 20 * 18, "{more}");
        assert_eq!(of(if more.is_empty() { "float picture" } else { "samples of the picture" }, "frame"), 40 * 30 * 16, "{more}");
        assert!(expected.iter().all(|(name, lifetime)| of(name, lifetime) > 0));
    }
}

/// The sum is the memory that the streaming plan announces, of all voxels and of the largest part.
#[test]
fn the_buffers_of_a_streamed_frame_are_those_announced() {
    let folder = tempfile::tempdir().unwrap();
    for (memory, plan) in [("1300k", " parts of up to "), ("8M", "all 96 layers along z at once")] {
        let (buffers, all) = declared(folder.path(), &format!("builtin:hydrogen@96 --memory {memory}"));
        assert!(all.contains(plan), "{all}");
        assert!(all.contains(&format!("at most {} bytes on the device", sum(&buffers))), "{all}");
    }
}
