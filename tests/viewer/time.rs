//! Sequences in time: steps by the look's frame, while time runs, in saved pictures and in films.

use crate::client::{Message, Page, Viewer};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

const SIDE: usize = 12;
const STEPS: usize = 4;

/// A block that moves along x and brightens.
fn voxels(step: usize) -> Vec<u8> {
    let inside =
        |x: usize, y: usize, z: usize| (2 * step..2 * step + 4).contains(&x) && (4..9).contains(&y) && (4..9).contains(&z);
    let value = |n: usize| if inside(n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE) { 60 + 50 * step as u8 } else { 0 };
    (0..SIDE * SIDE * SIDE).map(value).collect()
}

/// A folder with a file of all steps, a raw file of each, a mask of their upper part, and a subfolder for temporary files.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::create_dir(f.join("temporary")).unwrap();
    let mut header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({STEPS}, {SIDE}, {SIDE}, {SIDE}), }}");
    header += &" ".repeat(117 - header.len());
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(header.bytes().chain(*b"\n"));
    for step in 0..STEPS {
        bytes.extend(voxels(step));
        std::fs::write(f.join(raw(step)), voxels(step)).unwrap();
    }
    std::fs::write(f.join("beat.npy"), bytes).unwrap();
    let upper = |n: usize| u8::from(n / SIDE % SIDE >= 6);
    std::fs::write(f.join("mask_12x12x12_uint8.raw"), (0..SIDE.pow(3)).map(upper).collect::<Vec<_>>()).unwrap();
    folder
}

fn raw(step: usize) -> String {
    format!("s{step}_12x12x12_uint8.raw")
}

/// The look of a step, in a fixed quality.
fn look(page: &Page, step: usize) -> Value {
    let mut look = page.hello["look"].clone();
    (look["frame"], look["quality"]) = (step.into(), "standard".into());
    look
}

fn send_step(page: &mut Page, step: usize) {
    let look = look(page, step);
    page.send(&json!({ "type": "look", "look": look }));
}

/// Runs a command that a page showed, beside the volumes.
fn run(folder: &Path, command: &Value) -> Vec<u8> {
    for file in ["keys", "transfer"] {
        if let Some(name) = command[format!("{file}_name")].as_str() {
            std::fs::write(folder.join(name), command[format!("{file}_text")].as_str().unwrap()).unwrap();
        }
    }
    let line = command["line"].as_str().unwrap();
    let script = format!("'{}' {}", env!("CARGO_BIN_EXE_layersplat"), line.strip_prefix("layersplat ").unwrap());
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(folder.join(line.rsplit(' ').next().unwrap())).unwrap()
}

/// Frames of a file, several files, and the files of a pattern; whole and streamed. Pictures of a step are those of the command that is shown.
#[test]
fn steps_are_those_of_the_command() {
    let folder = folder();
    let f = folder.path();
    let files: Vec<String> = (0..STEPS).map(raw).collect();
    let several: Vec<&str> = files.iter().map(String::as_str).collect();
    for (arguments, names) in [
        (vec!["beat.npy"], "beat.npy --frame 2 "),
        (vec!["s%d_12x12x12_uint8.raw"], "s%d_12x12x12_uint8.raw --frame 2 "),
        (several, "s2_12x12x12_uint8.raw --transfer"),
        (vec!["beat.npy", "--memory", "4M"], "beat.npy --frame 2 "),
        (vec!["beat.npy", "--mask", "mask_12x12x12_uint8.raw"], "beat.npy --mask mask_12x12x12_uint8.raw --frame 2 "),
    ] {
        let viewer = Viewer::start_in(Some(f), &arguments);
        let mut page = viewer.page();
        assert_eq!(page.hello["steps"], STEPS);
        // The histogram is that of all steps.
        assert_eq!(page.hello["histogram"]["highest"].as_f64(), Some(210.0));
        let mut pictures = Vec::new();
        for step in [0, 2, 3, 2] {
            send_step(&mut page, step);
            page.send(&page.view(step as u32, 0.0, false));
            pictures.push(page.refined().pixels());
        }
        assert!(pictures[1] == pictures[3] && pictures[0] != pictures[1] && pictures[1] != pictures[2], "{names}");
        let camera = page.hello["camera"].clone();
        page.send(&json!({ "type": "save", "camera": camera, "width": 40, "height": 30, "samples": 1, "format": "png" }));
        let command = page.text("command");
        let saved = page.picture();
        assert!(command["line"].as_str().unwrap().contains(names), "{command}");
        assert!(run(f, &command) == saved.bytes, "{command}");
        send_step(&mut page, 1);
        page.send(&json!({ "type": "save", "camera": camera, "width": 40, "height": 30, "samples": 1, "format": "png" }));
        page.text("command");
        assert!(page.picture().bytes != saved.bytes, "another step is another picture");
    }
}

/// The other commands of `view` name one step.
#[test]
fn a_chosen_frame_is_no_sequence() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["beat.npy", "--frame", "3"]);
    let mut page = viewer.page();
    assert_eq!(page.hello["steps"], 1);
    page.send(&json!({ "type": "command", "camera": page.hello["camera"], "width": 9, "height": 9, "samples": 1 }));
    let line = page.text("command")["line"].to_string();
    assert!(line.contains("--frame 3") && line.matches("--frame").count() == 1, "{line}");
    send_step(&mut page, 1);
    page.send(&page.view(1, 0.0, false));
    let problem = page.text("problem")["sentence"].to_string();
    assert!(problem.contains("frame"), "{problem}");
}

/// Time runs while a hand turns; pictures are those of moving hands, and films are made meanwhile.
#[test]
fn time_runs_while_a_hand_turns_and_a_film_is_made() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["beat.npy"]);
    let mut page = viewer.page();
    page.send(&film(&page, 7, [0, 3]));
    let (mut shown, mut is_made, mut id) = (Vec::new(), false, 0);
    while !is_made || id < 3 * STEPS {
        id += 1;
        send_step(&mut page, id % STEPS);
        let mut view = page.view(id as u32, id as f64, id % 2 == 0 && !is_made);
        view["playing"] = true.into();
        page.send(&view);
        loop {
            match page.next(&["film", "problem"]) {
                Message::Picture(picture) if picture.step == 0 => {
                    assert!(!picture.is_png && picture.id == id as u32);
                    shown.push(picture.pixels());
                    break;
                }
                Message::Picture(picture) => assert_eq!((picture.step, picture.id), (7, 7)),
                Message::Text(text) if text["type"] == "film" => is_made |= text["state"] == "complete",
                other => panic!("{other:?}"),
            }
        }
    }
    assert!(shown.windows(2).all(|pair| pair[0] != pair[1]));
    // At rest the last step is refined.
    page.send(&page.view(9999, 0.0, false));
    assert_eq!(page.refined().id, 9999);
}

/// A film of a second, in which the camera and time run.
fn film(page: &Page, id: u32, frames: [usize; 2]) -> Value {
    let key = |n: usize| {
        let mut camera = page.hello["camera"].clone();
        camera["azimuth"] = (camera["azimuth"].as_f64().unwrap() + 30.0 * n as f64).into();
        json!({ "time": n, "camera": camera, "frame": frames[n] })
    };
    let keys = [key(0), key(1)];
    json!({ "type": "film", "id": id, "keys": keys, "width": 40, "height": 30, "samples": 1, "rate": 5, "format": "gif" })
}

#[test]
fn films_play_the_frames_of_their_keys_as_the_command_does() {
    let folder = folder();
    let f = folder.path();
    let files: Vec<String> = (0..STEPS).map(raw).collect();
    let several: Vec<&str> = files.iter().map(String::as_str).collect();
    let mut films = Vec::new();
    for (arguments, frames) in [(vec!["beat.npy"], [3, 0]), (several, [3, 0]), (vec!["beat.npy"], [2, 2])] {
        let viewer = Viewer::start_in(Some(f), &arguments);
        let mut page = viewer.page();
        page.send(&film(&page, 1, frames));
        let (command, mut bytes) = (page.text("film_command"), Vec::new());
        loop {
            match page.next(&["film", "problem"]) {
                Message::Picture(part) => bytes.extend(part.bytes),
                Message::Text(text) if text["state"] == "complete" => break,
                Message::Text(text) => assert_eq!(text["state"], "drawing", "{text}"),
                Message::Closed(code) => panic!("closed with {code}"),
            }
        }
        assert!(run(f, &command) == bytes, "{command}");
        films.push(bytes);
        // A frame that no step has.
        page.send(&film(&page, 2, [0, STEPS]));
        let problem = page.text("problem")["sentence"].to_string();
        assert!(problem.contains("frame"), "{problem}");
    }
    assert!(films[0] == films[1] && films[0] != films[2]);
}

/// The first view and *Fit* show the block in all steps; a value that is read is that of the step.
#[test]
fn fit_and_values_know_the_steps() {
    let folder = folder();
    let viewer =
        Viewer::start_in(Some(folder.path()), &["beat.npy", "--azimuth", "0", "--elevation", "0", "--background-value", "0"]);
    let mut page = viewer.page();
    page.send(&json!({ "type": "transfer", "colors": [[0, [1, 1, 1]]], "opacities": [[20, 0], [21, 0.1]] }));
    page.send(&json!({ "type": "fit", "camera": page.hello["camera"], "width": 200, "height": 200 }));
    let camera = page.text("fitted")["camera"].clone();
    // The block spans 2 … 5 in the first step and 8 … 11 in the last.
    let centre = camera["center"][0].as_f64().unwrap();
    assert!((4.5..6.0).contains(&centre), "{camera}");
    let scale = camera["projection"]["parallel_scale"].as_f64().unwrap();
    assert!(scale > 4.0, "{camera}");
    for (step, value) in [(3, 210.0), (0, 60.0)] {
        send_step(&mut page, step);
        // In the middle of the block.
        let x = (2.0 * step as f64 + 1.5 - centre) / scale;
        page.send(&json!({ "type": "pick", "id": step, "camera": camera, "height": 200, "x": x, "y": 0.0 }));
        let found = page.text("picked")["point"]["value"].as_f64().unwrap();
        assert!((found - value).abs() < 0.4 * value, "step {step}: {found}");
    }
}

/// A page opens a sequence by its name.
#[test]
fn a_sequence_is_opened_from_the_page() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &[]);
    let mut page = viewer.page();
    assert_eq!(page.hello["steps"], 1);
    page.send(&json!({ "type": "open", "volume": { "offered": "beat.npy" } }));
    page.hello = page.text("hello");
    assert_eq!(page.hello["steps"], STEPS);
    send_step(&mut page, 2);
    page.send(&page.view(1, 0.0, false));
    assert_eq!(page.refined().id, 1);
}
