//! The crate as a whole: dependencies of library users, and acyclic module dependencies.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Dependencies of the command only.
const OF_THE_COMMAND: [&str; 6] = ["clap", "cpu-time", "indicatif", "plotters", "signal-hook", "tracing-subscriber"];

/// All crates that are built with these features.
fn dependencies(features: &[&str]) -> BTreeSet<String> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["tree", "--offline", "--locked", "--edges", "normal", "--prefix", "none"]).args(features);
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    lines.lines().filter_map(|line| line.split(' ').next()).filter(|name| !name.is_empty()).map(String::from).collect()
}

#[test]
fn the_library_alone_pays_for_nothing_of_the_command() {
    let (library, command) = (dependencies(&["--no-default-features"]), dependencies(&[]));
    assert!(library.contains("opencl3") && library.is_subset(&command), "{library:?}");
    for name in OF_THE_COMMAND {
        assert!(command.contains(name) && !library.contains(name), "{name}");
    }
}

/// Settings and cameras can be constructed with this crate's public items only.
#[test]
fn what_users_need_is_at_hand() {
    use layersplat::glam::DVec3;
    use layersplat::settings::{Classification, Evaluation, LayerAxis, Layered};
    use layersplat::{Axis, Camera, Correction, Density, Orbit, Projection, Settings};
    let camera = Camera::orbit(DVec3::ZERO, 2.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
    let settings = Settings {
        algorithm: Layered {
            layer_axis: LayerAxis::Forced(Axis::Z),
            evaluation: Evaluation::Lattice(Density::Fixed(2)),
            classification: Classification::Post(Correction::SubLayers(2)),
            ..Layered::default()
        }
        .into(),
        ..Settings::default()
    };
    assert!(camera.position.z == 2.0 && settings.layered().is_some_and(|l| l.layer_axis == LayerAxis::Forced(Axis::Z)));
}

/// Top-level modules (files and folders of src) and the modules that each depends on.
fn rooms() -> BTreeMap<String, BTreeSet<String>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut rooms = BTreeMap::new();
    for entry in std::fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        let room = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if room != "lib" && room != "main" {
            // A module may be a file beside a folder.
            let known = named_rooms(&code_of(&path)).into_iter().filter(|name| *name != room);
            rooms.entry(room.clone()).or_insert_with(BTreeSet::new).extend(known);
        }
    }
    rooms
}

/// Code of a file, or of all files of a folder, without tests.
fn code_of(path: &Path) -> String {
    if path.is_dir() {
        return std::fs::read_dir(path).unwrap().map(|entry| code_of(&entry.unwrap().path())).collect();
    }
    if path.extension().is_none_or(|ending| ending != "rs") {
        return String::new();
    }
    let text = std::fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod tests").next().unwrap().to_owned()
}

/// Whether a string in a line of code contains an option of the command, after `--`.
fn options(line: &str) -> bool {
    let is_letter = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_lowercase);
    line.match_indices("--").any(|(at, _)| is_letter(line.as_bytes().get(at + 2)))
}

/// Library messages name fields. Only src/cli/fields.rs maps them to options of the command.
#[test]
fn only_the_command_knows_its_options() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        if !path.ends_with("cli") {
            let code = code_of(&path);
            let found: Vec<&str> = code.lines().filter(|l| options(l) && !l.trim_start().starts_with("//")).collect();
            assert_eq!(found, [""; 0], "{}", path.display());
        }
    }
    assert!(options("correct --dims or") && !options("a - b, c--, -- d"));
}

/// Names after `crate::` outside comments.
fn named_rooms(code: &str) -> BTreeSet<String> {
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let mentions = lines.flat_map(|line| line.split("crate::").skip(1));
    let names = mentions.map(|rest| rest.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect());
    names.filter(|name: &String| !name.is_empty()).collect()
}

/// Modules in dependency cycles: those that remain after repeatedly removing modules without remaining dependencies.
fn circular(mut rooms: BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    while let Some(free) = rooms.iter().find(|(_, known)| !known.iter().any(|k| rooms.contains_key(k))).map(|(r, _)| r.clone()) {
        rooms.remove(&free);
    }
    rooms.into_keys().collect()
}

#[test]
fn rooms_know_each_other_in_one_direction() {
    let mut rooms = rooms();
    assert!(rooms.len() >= 10 && rooms["renderer"].contains("device") && rooms["layers"].contains("viewport"), "{rooms:?}");
    assert_eq!(circular(rooms.clone()), [""; 0]);
    // The check detects a cycle.
    rooms.get_mut("error").unwrap().insert("volume".into());
    assert!(circular(rooms).contains(&"volume".into()));
}
