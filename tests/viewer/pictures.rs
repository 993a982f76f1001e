//! What pages get.

use crate::client::{Message, Page, Viewer};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

const HYDROGEN: [&str; 1] = ["builtin:hydrogen@32"];

#[test]
fn moving_pictures_are_jpegs_and_a_picture_at_rest_is_refined() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    page.send(&page.view(7, 0.0, true));
    let moving = page.picture();
    page.shown();
    assert_eq!((moving.step, moving.is_png, moving.id), (0, false, 7));
    assert!(moving.bytes.starts_with(&[0xff, 0xd8]) && moving.pixels().pixels().any(|p| p.0[0] > 60));
    page.send(&page.view(8, 0.0, false));
    let mut steps = Vec::new();
    while steps.last() != Some(&4) {
        let picture = page.picture();
        page.shown();
        assert!(picture.is_png && picture.id == 8 && (picture.width, picture.height) == (96, 64));
        steps.push(picture.step);
    }
    assert_eq!(steps, [1, 2, 3, 4]);
    // A refined page gets nothing more: the answer to a question comes first.
    page.send(&json!({ "type": "named", "kind": "map", "name": "turbo" }));
    match page.receive() {
        Message::Text(text) => assert_eq!((&text["type"], &text["name"]), (&json!("transfer"), &json!("turbo"))),
        other => panic!("{other:?}"),
    }
}

/// Turning, a look and a transfer function change the picture; going back restores it to the bit.
#[test]
fn pictures_follow_camera_look_and_curve() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let mut look = page.hello["look"].clone();
    look["quality"] = json!("standard");
    page.send(&json!({ "type": "look", "look": look }));
    let draw = |page: &mut Page, turned: f64| {
        page.send(&page.view(1, turned, false));
        page.refined().pixels()
    };
    let first = draw(&mut page, 0.0);
    assert_ne!(draw(&mut page, 40.0), first);
    look["background"] = json!("#204060");
    page.send(&json!({ "type": "look", "look": look }));
    assert_eq!(draw(&mut page, 0.0).get_pixel(0, 0).0, [0x20, 0x40, 0x60, 255]);
    look["background"] = json!("transparent");
    page.send(&json!({ "type": "look", "look": look }));
    assert_eq!(draw(&mut page, 0.0).get_pixel(0, 0).0, [0; 4]);
    look["background"] = json!("#000000");
    page.send(&json!({ "type": "look", "look": look }));
    let red = json!([[0, [1, 0, 0]]]);
    page.send(&json!({ "type": "transfer", "colors": red, "opacities": page.hello["transfer"]["opacities"] }));
    let drawn = draw(&mut page, 0.0);
    assert!(drawn.pixels().any(|p| p.0[0] > 60) && drawn.pixels().all(|p| p.0[0] >= p.0[1]));
    let own = &page.hello["transfer"];
    page.send(&json!({ "type": "transfer", "colors": own["colors"], "opacities": own["opacities"] }));
    assert_eq!(draw(&mut page, 0.0), first);
}

/// Runs a command that a page showed, beside its files in a folder, and returns the bytes of its picture.
pub fn run(folder: &Path, command: &Value) -> Vec<u8> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    std::fs::write(folder.join(text(&command["transfer_name"])), text(&command["transfer_text"])).unwrap();
    for file in command["more"].as_array().unwrap() {
        std::fs::write(folder.join(text(&file["name"])), text(&file["text"])).unwrap();
    }
    let line = text(&command["line"]);
    let (bin, words) = (env!("CARGO_BIN_EXE_layersplat"), line.strip_prefix("layersplat ").unwrap());
    let output = Command::new("sh").args(["-c", &format!("'{bin}' {words}")]).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(folder.join(line.rsplit(' ').next().unwrap())).unwrap()
}

/// The bits of all numbers of an EXR file.
fn numbers(bytes: &[u8]) -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    std::fs::write(&path, bytes).unwrap();
    layersplat::image::read_image(&path).unwrap().pixels().iter().flatten().map(|number| number.to_bits()).collect()
}

/// The bytes of the file, in several looks and both projections.
#[cfg(unix)]
#[test]
fn saved_pictures_are_those_of_the_command() {
    let viewer = Viewer::start(&[
        "builtin:hydrogen@32",
        "--up",
        "z",
        "--gradient",
        "central",
        "--shadow-forgiveness",
        "3",
        "--shadows",
        "on",
    ]);
    let mut page = viewer.page();
    let first = page.hello["look"].clone();
    let camera = page.hello["camera"].clone();
    let mut turned = camera.clone();
    (turned["azimuth"], turned["elevation"], turned["roll"]) = (json!(-123.45678901234567), json!(77.7), json!(1e-7));
    let mut eye = camera.clone();
    eye["projection"] = json!({ "perspective": [35.5, 90.25] });
    let changed = |changes: &[(&str, Value)]| {
        let mut look = first.clone();
        changes.iter().for_each(|(name, value)| look[*name] = value.clone());
        look
    };
    let light = json!([{ "direction": [0.5, 0.25, 0.3333333333333333], "strength": 0.8, "angle": 0.0 }]);
    let studio = changed(&[
        ("studio", json!({ "sky_up": [0.25, 1.0, -0.3333333333333333], "scattering": 0.5, "exposure": 0.75 })),
        ("lights", page.hello["studio"]["lights"].clone()),
        ("lights_follow", json!(false)),
        ("quality", json!("standard")),
    ]);
    let mut labelled = studio.clone();
    (labelled["legend"], labelled["lights_follow"], labelled["lights"]) = (json!(true), json!(true), json!([]));
    for (look, camera, samples, format) in [
        (first.clone(), &turned, 1, "png"),
        (changed(&[("quality", json!("standard")), ("shadows", json!(false)), ("background", json!("#a0b0c0"))]), &eye, 2, "exr"),
        (
            changed(&[("blend", json!("iso")), ("iso", json!(61.3)), ("kernel", json!("catmull-rom")), ("lights", light)]),
            &camera,
            1,
            "png",
        ),
        (
            changed(&[
                ("legend", json!(true)),
                ("bounding_box", json!(true)),
                ("axes", json!(true)),
                ("gradient", json!("sobel")),
            ]),
            &turned,
            2,
            "png",
        ),
        (changed(&[("bounding_box", json!(true)), ("quality", json!("draft"))]), &eye, 1, "exr"),
        // The given shadows do not go with the studio.
        (studio.clone(), &turned, 1, "png"),
        (labelled.clone(), &eye, 2, "png"),
        (labelled, &eye, 1, "exr"),
        (
            changed(&[
                ("blend", json!("maximum")),
                ("crop", json!([[3, 4, 5], [20.5, 30, 31]])),
                ("background", json!("transparent")),
            ]),
            &turned,
            1,
            "exr",
        ),
    ] {
        page.send(&json!({ "type": "look", "look": look }));
        page.send(&json!({ "type": "save", "camera": camera, "width": 90, "height": 70, "samples": samples, "format": format }));
        let command = page.text("command");
        let saved = page.picture();
        assert_eq!((saved.step, saved.width, saved.height), (5, 90, 70));
        let line = command["line"].as_str().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let drawn = run(folder.path(), &command);
        match format {
            // Blocks of an EXR file are written as they are compressed, in any order.
            "exr" => assert!(numbers(&drawn) == numbers(&saved.bytes), "{line}"),
            _ => assert!(drawn == saved.bytes, "{line}"),
        }
    }
}

#[test]
fn curves_are_read_and_written_and_named() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    page.send(&json!({ "type": "read", "name": "my.csv", "text": "0,0,0,0,0\n9,1,0.5,0.25,0.75\n" }));
    let read = page.text("transfer");
    assert_eq!((&read["name"], &read["opacities"]), (&json!("my.csv"), &json!([[0.0, 0.0], [9.0, 0.75]])));
    page.send(&json!({ "type": "transfer", "colors": read["colors"], "opacities": read["opacities"] }));
    for (name, word) in
        [("a.csv", "9,1,0.5,0.25,0.75"), ("a.json", "RGBPoints"), ("a.vp", "0.75"), ("a.vp.json", "volumeProperties")]
    {
        page.send(&json!({ "type": "write", "name": name }));
        let written = page.text("written");
        assert!(written["text"].as_str().unwrap().contains(word), "{name}: {written}");
    }
    for (kind, name) in [("automatic", "vivid"), ("preset", "ct-bone"), ("map", "viridis"), ("initial", "")] {
        page.send(&json!({ "type": "named", "kind": kind, "name": name }));
        assert!(!page.text("transfer")["opacities"].as_array().unwrap().is_empty(), "{kind}");
    }
    for (request, word) in [
        (json!({ "type": "read", "name": "my.csv", "text": "what is this" }), "format"),
        (json!({ "type": "write", "name": "a.doc" }), ".csv"),
        (json!({ "type": "named", "kind": "preset", "name": "pink" }), "ct-bone"),
        (json!({ "type": "transfer", "colors": [[0, [2, 0, 0]]], "opacities": [[0, 0.5]] }), "from 0 to 1"),
    ] {
        page.send(&request);
        let problem = page.text("problem");
        assert!(problem["sentence"].as_str().unwrap().contains(word), "{problem}");
    }
}

#[test]
fn cameras_are_fitted_to_the_page() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let mut scale = |width: u32, height: u32, camera: &Value| {
        page.send(&json!({ "type": "fit", "camera": camera, "width": width, "height": height }));
        page.text("fitted")["camera"]["projection"].clone()
    };
    let camera = viewer.page().hello["camera"].clone();
    let [square, narrow] = [scale(400, 400, &camera), scale(200, 400, &camera)].map(|p| p["parallel_scale"].as_f64().unwrap());
    assert!(narrow > 1.5 * square);
    let mut eye = camera.clone();
    eye["projection"] = json!({ "perspective": [30.0, 1.0] });
    assert!(scale(400, 400, &eye)["perspective"][1].as_f64().unwrap() > 10.0);
}

#[test]
fn two_pages_have_their_own_views_of_one_volume() {
    let viewer = Viewer::start(&HYDROGEN);
    let (mut first, mut second) = (viewer.page(), viewer.page());
    let mut look = first.hello["look"].clone();
    (look["quality"], look["background"]) = (json!("draft"), json!("#ffffff"));
    first.send(&json!({ "type": "look", "look": look }));
    first.send(&first.view(1, 0.0, false));
    look["background"] = json!("#000000");
    second.send(&json!({ "type": "look", "look": look }));
    second.send(&second.view(1, 90.0, false));
    let (a, b) = (first.refined().pixels(), second.refined().pixels());
    assert_eq!((a.get_pixel(0, 0).0[0], b.get_pixel(0, 0).0[0]), (255, 0));
    drop(first);
    second.send(&second.view(2, 90.0, false));
    assert_eq!(second.refined().pixels(), b);
}
