//! Films along key cameras.

use crate::client::{Message, Page, Viewer};
use serde_json::{Value, json};
use std::process::Command;

/// A film of a hydrogen atom whose cameras turn by 40° per second.
fn film(page: &Page, id: u32, format: &str, (width, height, samples, rate): (u32, u32, u32, u32)) -> Value {
    let key = |time: f64| {
        let mut camera = page.hello["camera"].clone();
        camera["azimuth"] = (camera["azimuth"].as_f64().unwrap() + 40.0 * time).into();
        camera["center"][0] = (camera["center"][0].as_f64().unwrap() + time / 3.0).into();
        json!({ "time": time, "camera": camera })
    };
    let keys = [key(0.0), key(0.3), key(0.8)];
    json!({ "type": "film", "id": id, "keys": keys, "width": width, "height": height, "samples": samples, "rate": rate, "format": format })
}

/// What a film ends with: its last state, its bytes, its command and the problems on the way.
#[derive(Default)]
struct Ended {
    state: String,
    bytes: Vec<u8>,
    command: Value,
    problems: Vec<String>,
    /// Pictures of the page that came meanwhile, with the film's progress.
    shown: Vec<(u32, u64)>,
}

fn ended(page: &mut Page, id: u32) -> Ended {
    let (mut ended, mut done) = (Ended::default(), 0);
    while !["complete", "cancelled", "failed"].contains(&ended.state.as_str()) {
        match page.next(&["film", "film_command", "problem"]) {
            Message::Picture(part) if part.step == 7 => {
                assert_eq!(part.id, id);
                ended.bytes.extend(part.bytes);
            }
            Message::Picture(picture) => ended.shown.push((picture.id, done)),
            Message::Text(text) if text["type"] == "problem" => ended.problems.push(text["sentence"].to_string()),
            Message::Text(text) if text["type"] == "film_command" => ended.command = text,
            Message::Text(text) => {
                assert_eq!(text["id"], id);
                done = text["done"].as_u64().unwrap();
                ended.state = text["state"].as_str().unwrap().to_owned();
            }
            Message::Closed(code) => panic!("closed with {code}"),
        }
    }
    ended
}

/// Runs the command of a film beside its files.
fn run(command: &Value) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    for file in ["keys", "transfer"] {
        let name = command[format!("{file}_name")].as_str().unwrap();
        std::fs::write(folder.path().join(name), command[format!("{file}_text")].as_str().unwrap()).unwrap();
    }
    let line = command["line"].as_str().unwrap();
    let script = format!("'{}' {}", env!("CARGO_BIN_EXE_layersplat"), line.strip_prefix("layersplat ").unwrap());
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(folder.path().join(line.rsplit(' ').next().unwrap())).unwrap()
}

#[test]
fn films_are_those_of_the_command_to_the_bit() {
    let viewer = Viewer::start(&["builtin:hydrogen@24"]);
    let mut page = viewer.page();
    let first = page.hello["look"].clone();
    let mut eye = page.hello["camera"].clone();
    eye["projection"] = json!({ "perspective": [30.0, 60.0] });
    let shadowed = {
        let mut look = first.clone();
        (look["shadows"], look["quality"], look["background"]) = (json!(true), json!("standard"), json!("#304050"));
        look
    };
    for (id, format, look, camera) in [(1, "gif", first.clone(), None), (2, "apng", shadowed, Some(eye))] {
        page.send(&json!({ "type": "look", "look": look }));
        if let Some(camera) = camera {
            page.hello["camera"] = camera;
        }
        page.send(&film(&page, id, format, (52, 38, id, 5)));
        let ended = ended(&mut page, id);
        assert_eq!((ended.state.as_str(), ended.problems.len()), ("complete", 0), "{:?}", ended.problems);
        assert!(run(&ended.command) == ended.bytes, "{}", ended.command["line"]);
    }
}

#[test]
fn hands_move_during_a_film_which_goes_on_and_can_be_given_up() {
    let viewer = Viewer::start(&["builtin:hydrogen@64"]);
    let mut page = viewer.page();
    // Hours, if nobody gives it up.
    let mut long = film(&page, 1, "gif", (700, 500, 8, 50));
    long["keys"][2]["time"] = 50.into();
    page.send(&long);
    let drawing = |page: &mut Page| loop {
        if let Message::Text(text) = page.next(&["film"]) {
            assert_eq!(text["state"], "drawing");
            return text["done"].as_u64().unwrap();
        }
    };
    drawing(&mut page);
    for id in 1..20 {
        page.send(&page.view(id, f64::from(id), true));
        while !matches!(page.next(&[]), Message::Picture(picture) if picture.id == id) {}
    }
    page.send(&page.view(20, 0.0, false));
    assert_eq!(page.refined().id, 20);
    let before = drawing(&mut page);
    while drawing(&mut page) <= before {}
    // A second film waits, and is given up there.
    page.send(&film(&page, 2, "gif", (32, 24, 1, 5)));
    page.send(&json!({ "type": "cancel_film", "id": 2 }));
    page.send(&json!({ "type": "cancel_film", "id": 1 }));
    let mut given_up: Vec<u64> = Vec::new();
    while given_up.len() < 2 {
        match page.next(&["film"]) {
            Message::Text(text) if text["state"] == "cancelled" => given_up.push(text["id"].as_u64().unwrap()),
            _ => {}
        }
    }
    // Page and film are whole afterwards.
    page.send(&film(&page, 3, "apng", (32, 24, 1, 5)));
    assert_eq!(ended(&mut page, 3).state, "complete");
}

#[test]
fn films_that_cannot_be_made_say_why() {
    let viewer = Viewer::start(&["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    let good = film(&page, 1, "gif", (32, 24, 1, 5));
    let changed = |field: &str, value: Value| {
        let mut film = good.clone();
        film[field] = value;
        film
    };
    let one_key = json!([good["keys"][0]]);
    for (film, word) in [
        (changed("keys", one_key), "key cameras"),
        (changed("rate", 0.into()), "per second"),
        (changed("rate", 60.into()), "50 frames per second"),
        (changed("width", 60000.into()), "viewport"),
        (changed("samples", 99.into()), "samples"),
    ] {
        page.send(&film);
        let ended = ended(&mut page, 1);
        let problem = ended.problems.join(" ");
        assert!(ended.state == "failed" && problem.contains(word), "{word}: {problem}");
    }
    // Where ffmpeg is missing, the sentence names it, and no path.
    page.send(&changed("format", "mp4".into()));
    let ended = ended(&mut page, 1);
    let problem = ended.problems.join(" ");
    assert!(ended.state == "complete" || problem.contains("ffmpeg"), "{problem}");
    assert!(!problem.contains("/tmp") && !problem.contains(".layersplat"), "{problem}");
}

#[test]
fn a_page_that_leaves_a_film_does_not_disturb_others() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("temporary")).unwrap();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@32"]);
    let mut page = viewer.page();
    page.send(&film(&page, 1, "gif", (800, 600, 4, 50)));
    while !matches!(page.next(&["film"]), Message::Text(_)) {}
    drop(page);
    let mut other = viewer.page();
    other.send(&film(&other, 2, "gif", (32, 24, 1, 5)));
    assert_eq!(ended(&mut other, 2).state, "complete");
    // The files of both are gone.
    let left = || std::fs::read_dir(folder.path().join("temporary")).unwrap().count();
    while left() > 0 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}
