//! Pages of several fields, colours and labels.

use crate::client::{Page, Viewer};
use crate::files::open_dropped;
use crate::pictures::run;
use serde_json::{Value, json};
use std::path::Path;

/// What the test's file says of its components.
const VECTOR: &[u8] = b"vector";
/// Two fields of two grids, the second in one colour.
const TWO: [&str; 3] = ["builtin:hydrogen@24", "--with", "builtin:gyroid@16,color=#3388ff,opacity=p60:0,p99:0.1"];

/// A file with labels in layers, and one with three components.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let labels = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files/labels/layers.seg.nrrd");
    std::fs::copy(labels, folder.path().join("layers.seg.nrrd")).unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 10 9 8\nkinds: vector domain domain domain\nencoding: raw\n\n";
    let voxel = |n: usize| [n % 10 * 25, n / 10 % 9 * 28, if (n / 90).is_multiple_of(2) { 250 } else { 40 }].map(|c| c as u8);
    let voxels: Vec<u8> = (0..720).flat_map(voxel).collect();
    std::fs::write(folder.path().join("rgb.nrrd"), [header.as_bytes(), &voxels].concat()).unwrap();
    std::fs::create_dir(folder.path().join("temporary")).unwrap();
    folder
}

/// The saved picture of a look, which is that of the command that comes with it.
fn saved(page: &mut Page, folder: &Path, look: &Value) -> Vec<u8> {
    let camera = page.hello["camera"].clone();
    page.send(&json!({ "type": "look", "look": look }));
    page.send(&json!({ "type": "save", "camera": camera, "width": 60, "height": 50, "samples": 1, "format": "png" }));
    let command = page.text("command");
    let saved = page.picture().bytes;
    assert!(run(folder, &command) == saved, "{}", command["line"]);
    // The program in Python says that it has one volume, unless that is all there is.
    let (python, line) = (command["python"].as_str().unwrap(), command["line"].as_str().unwrap());
    let is_one = ["--mask", "--label-colors"].iter().any(|option| line.contains(option));
    assert_eq!(python.contains("see layersplat."), !is_one, "{python}");
    saved
}

fn with(look: &Value, changes: &[(&str, Value)]) -> Value {
    let mut look = look.clone();
    for (path, value) in changes {
        *look.pointer_mut(path).unwrap() = value.clone();
    }
    look
}

/// Each change of the page changes the picture, and the command draws the same bytes.
#[cfg(unix)]
#[test]
fn pictures_of_two_fields_are_those_of_the_command() {
    let (viewer, folder) = (Viewer::start(&TWO), tempfile::tempdir().unwrap());
    let mut page = viewer.page();
    let channels = page.hello["channels"].clone();
    assert_eq!((&channels[0]["name"], &channels[1]["name"]), (&json!("hydrogen@24"), &json!("gyroid@16")));
    let look = with(&page.hello["look"], &[("/quality", json!("standard")), ("/legend", json!(true))]);
    assert_eq!(look["channels"][1], json!({ "visible": true, "factor": 1.0, "color": "#3388ff" }));
    let mut pictures = vec![saved(&mut page, folder.path(), &look)];
    for changes in [
        vec![("/channels/1/visible", json!(false))],
        vec![("/channels/0/visible", json!(false))],
        vec![("/channels/1/factor", json!(7.25)), ("/channels/0/factor", json!(0.3))],
        vec![("/channels/1/color", json!("#00ff00"))],
        vec![("/blend", json!("maximum"))],
    ] {
        pictures.push(saved(&mut page, folder.path(), &with(&look, &changes)));
    }
    page.send(&json!({ "type": "transfer", "field": 1, "colors": [[0, [1, 0, 0]]], "opacities": [[20, 0], [200, 0.3]] }));
    pictures.push(saved(&mut page, folder.path(), &look));
    for (n, picture) in pictures.iter().enumerate() {
        assert!(pictures[..n].iter().all(|other| other != picture), "{n}");
    }
}

/// Pictures at rest are refined, and a change that is taken back gives the first bits.
#[test]
fn a_hidden_channel_comes_back() {
    let viewer = Viewer::start(&TWO);
    let (mut page, mut other) = (viewer.page(), viewer.page());
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    let draw = |page: &mut Page, look: &Value| {
        page.send(&json!({ "type": "look", "look": look }));
        page.send(&page.view(1, 10.0, false));
        page.refined().pixels()
    };
    let first = draw(&mut page, &look);
    assert_ne!(draw(&mut page, &with(&look, &[("/channels/1/visible", json!(false))])), first);
    // Another page has channels of its own.
    assert_eq!(draw(&mut other, &look), first);
    assert_eq!(draw(&mut page, &look), first);
    page.send(&page.view(2, 40.0, true));
    let moving = page.picture();
    assert!(moving.step == 0 && moving.pixels().pixels().any(|p| p.0[2] > 60));
}

#[test]
fn what_several_fields_do_not_have_is_said_with_the_first_message() {
    let viewer = Viewer::start(&TWO);
    let mut page = viewer.page();
    let unavailable = page.hello["unavailable"].clone();
    for name in ["paper", "slices"] {
        assert!(unavailable[name].as_str().is_some_and(|sentence| sentence.contains("one channel")), "{name}: {unavailable}");
    }
    assert!(["shadows", "maximum", "curve"].iter().all(|&name| unavailable[name].is_null()), "{unavailable}");
    // A look with it is refused, and the picture stays.
    page.send(&json!({ "type": "look", "look": with(&page.hello["look"], &[("/quality", json!("paper"))]) }));
    page.send(&page.view(1, 0.0, true));
    page.text("problem");
    assert!(page.picture().pixels().pixels().any(|p| p.0[0] > 60));
    for bad in [json!([]), json!([{ "visible": true, "factor": -1, "color": "#000000" }])] {
        page.send(&json!({ "type": "look", "look": with(&page.hello["look"], &[("/channels", bad)]) }));
        page.send(&page.view(2, 0.0, true));
        page.text("problem");
    }
    page.send(&json!({ "type": "transfer", "field": 2, "colors": [[0, [1, 0, 0]]], "opacities": [[20, 0.5]] }));
    page.text("problem");
    let one = Viewer::start(&["builtin:hydrogen@16"]);
    assert_eq!(one.page().hello["unavailable"], json!({}));
}

#[test]
fn a_pick_has_the_value_of_each_field() {
    let viewer = Viewer::start(&TWO);
    let mut page = viewer.page();
    page.send(&json!({ "type": "pick", "id": 3, "camera": page.hello["camera"], "height": 64, "x": 0.1, "y": 0.0 }));
    let point = page.text("picked")["point"].clone();
    let values: Vec<f64> = point["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
    assert!(values.len() == 2 && point["value"] == point["values"][0], "{point}");
    assert!(values.iter().all(|value| (-30.0..300.0).contains(value)), "{point}");
    // Alone, the second field is seen where it has opacity.
    let look = with(&page.hello["look"], &[("/channels/0/visible", json!(false))]);
    page.send(&json!({ "type": "look", "look": look }));
    page.send(&json!({ "type": "pick", "id": 4, "camera": page.hello["camera"], "height": 64, "x": 0.1, "y": 0.0 }));
    let point = page.text("picked")["point"].clone();
    let least = page.hello["channels"][1]["transfer"]["opacities"][0][0].as_f64().unwrap();
    assert!(point["values"][1].as_f64().unwrap() > least - 1.0, "{point} of {least}");
}

#[cfg(unix)]
#[test]
fn labels_are_hidden_shown_alone_and_coloured_as_by_the_command() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["layers.seg.nrrd"]);
    let mut page = viewer.page();
    let labels = page.hello["labels"].as_array().unwrap().clone();
    assert!(labels.len() > 1 && page.hello["unavailable"]["curve"].is_string(), "{labels:?}");
    let [key, id, name] = ["key", "id", "name"].map(|part| labels[0][part].clone());
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    let mut pictures = vec![saved(&mut page, folder.path(), &look)];
    for labels in [
        json!({ "only": [], "hidden": [key], "colors": [] }),
        json!({ "only": [key], "hidden": [], "colors": [] }),
        json!({ "only": [], "hidden": [], "colors": [[key, "#123456"]] }),
    ] {
        pictures.push(saved(&mut page, folder.path(), &with(&look, &[("/labels", labels)])));
    }
    for (n, picture) in pictures.iter().enumerate() {
        assert!(pictures[..n].iter().all(|other| other != picture), "{n}");
    }
    // Alone, it is what is read wherever anything is seen.
    let alone = with(&look, &[("/labels", json!({ "only": [key], "hidden": [], "colors": [] }))]);
    page.send(&json!({ "type": "look", "look": alone }));
    let mut seen = 0;
    for n in 0..169u32 {
        let [x, y] = [n % 13, n / 13].map(|i| f64::from(i) * 0.1 - 0.6);
        page.send(&json!({ "type": "pick", "id": n, "camera": page.hello["camera"], "height": 64, "x": x, "y": y }));
        let point = page.text("picked")["point"].clone();
        if !point.is_null() {
            seen += 1;
            assert_eq!(point["labels"], json!([{ "id": id, "name": name }]), "{point}");
        }
    }
    assert!(seen > 0);
    page.send(&json!({ "type": "look", "look": with(&look, &[("/labels/hidden", json!(["987654"]))]) }));
    page.send(&page.view(1, 0.0, true));
    assert!(page.text("problem")["sentence"].as_str().unwrap().contains("987654"));
}

/// A scan in the colours of labels: changes of the page, values and ids under the cursor, and steps in time.
#[cfg(unix)]
#[test]
fn labels_color_a_scan() {
    let folder = folder();
    // Label 3 on the left, 7 on the right, and none in the lowest quarter.
    let id = |n: usize| if n / 256 < 4 { 0 } else { [3u8, 7][n % 16 / 8] };
    std::fs::write(folder.path().join("ids_16x16x16_uint8.raw"), (0..4096).map(id).collect::<Vec<_>>()).unwrap();
    let table = r##"{"labels": [{"id": 3, "name": "left", "color": "#ff0000"}, {"id": 7, "color": "#0000ff"}]}"##;
    std::fs::write(folder.path().join("table.json"), table).unwrap();
    let options = ["builtin:hydrogen@16", "--label-colors", "ids_16x16x16_uint8.raw", "--labels=table.json", "--azimuth", "0"];
    let viewer = Viewer::start_in(Some(folder.path()), &options);
    let mut page = viewer.page();
    let known = |label: &Value| ["key", "name", "color", "visible"].map(|part| label[part].clone());
    let labels: Vec<_> = page.hello["labels"].as_array().unwrap().iter().map(known).collect();
    assert_eq!(labels[0], [json!("3"), json!("left"), json!([1.0, 0.0, 0.0]), json!(true)]);
    assert_eq!(labels[1], [json!("7"), json!("label 7"), json!([0.0, 0.0, 1.0]), json!(true)]);
    for name in ["slices", "maximum"] {
        assert!(page.hello["unavailable"][name].is_string(), "{name}: {}", page.hello["unavailable"]);
    }
    assert!(["curve", "iso", "shadows"].iter().all(|&name| page.hello["unavailable"][name].is_null()));

    let look = with(&page.hello["look"], &[("/quality", json!("standard")), ("/legend", json!(true))]);
    let mut pictures = vec![saved(&mut page, folder.path(), &look)];
    for labels in [
        json!({ "only": [], "hidden": ["3"], "colors": [] }),
        json!({ "only": ["3"], "hidden": [], "colors": [] }),
        json!({ "only": [], "hidden": [], "colors": [["7", "#00ff00"]] }),
    ] {
        pictures.push(saved(&mut page, folder.path(), &with(&look, &[("/labels", labels)])));
    }
    page.send(&json!({ "type": "transfer", "colors": [[0, [1, 1, 1]]], "opacities": [[50, 0], [60, 1]] }));
    pictures.push(saved(&mut page, folder.path(), &look));
    for (n, picture) in pictures.iter().enumerate() {
        assert!(pictures[..n].iter().all(|other| other != picture), "{n}");
    }

    // The value stands beside the label; a hidden one is none.
    let pick = |page: &mut Page, x: f64| {
        page.send(&json!({ "type": "pick", "id": 1, "camera": page.hello["camera"], "height": 64, "x": x, "y": 0.0 }));
        page.text("picked")["point"].clone()
    };
    let hidden = with(&look, &[("/labels/hidden", json!(["7"]))]);
    for (x, of_look, expected) in [
        (-0.3, &look, json!([{ "id": 3, "name": "left" }])),
        (0.3, &look, json!([{ "id": 7, "name": "label 7" }])),
        (0.3, &hidden, json!([])),
    ] {
        page.send(&json!({ "type": "look", "look": of_look }));
        let point = pick(&mut page, x);
        assert_eq!(point["labels"], expected, "{point}");
        assert!(point["value"].as_f64().unwrap() > 40.0 && point["values"] == json!([]), "{point}");
    }

    let steps = [&options[..1], &["builtin:gyroid@16"], &options[1..]].concat();
    let viewer = Viewer::start_in(Some(folder.path()), &steps);
    let mut page = viewer.page();
    assert_eq!(page.hello["steps"], 2);
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    let first = saved(&mut page, folder.path(), &look);
    assert!(saved(&mut page, folder.path(), &with(&look, &[("/frame", json!(1))])) != first);
}

#[cfg(unix)]
#[test]
fn colours_of_components_follow_the_curve() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["rgb.nrrd", "--colors", "direct"]);
    let mut page = viewer.page();
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    let first = saved(&mut page, folder.path(), &look);
    page.send(&json!({ "type": "transfer", "colors": [[0, [1, 1, 1]]], "opacities": [[100, 0], [255, 0.9]] }));
    assert!(saved(&mut page, folder.path(), &look) != first);
    page.send(&json!({ "type": "pick", "id": 1, "camera": page.hello["camera"], "height": 64, "x": 0.0, "y": 0.0 }));
    let point = page.text("picked")["point"].clone();
    assert_eq!(point["values"].as_array().unwrap().len(), 3, "{point}");
}

/// Components of a file as channels, and a mask.
#[cfg(unix)]
#[test]
fn channels_of_a_file_and_masks_open() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["rgb.nrrd", "--channels", "0,2", "--field", "1,factor=2"]);
    let mut page = viewer.page();
    assert_eq!(page.hello["look"]["channels"][1]["factor"], json!(2.0));
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    saved(&mut page, folder.path(), &look);
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16", "--mask", "layers.seg.nrrd"]);
    let mut page = viewer.page();
    let look = with(&page.hello["look"], &[("/quality", json!("standard"))]);
    saved(&mut page, folder.path(), &look);
}

/// Other files open as the command would open them: with all channels, and with what a file of vectors or labels holds.
#[cfg(unix)]
#[test]
fn opened_files_have_their_channels_and_labels() {
    let folder = folder();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let viewer = Viewer::start_in(Some(folder.path()), &["rgb.nrrd", "--channels", "0"]);
    let mut page = viewer.page();
    let hello = open_dropped(&viewer, &mut page, "rgb.nrrd", &bytes("rgb.nrrd"));
    assert_eq!(hello["channels"].as_array().unwrap().len(), 3, "{hello}");
    let hello = open_dropped(&viewer, &mut page, "layers.seg.nrrd", &bytes("layers.seg.nrrd"));
    assert!(hello["labels"].as_array().unwrap().len() > 1 && hello["channels"] == json!([]), "{hello}");
    page.send(&page.view(1, 0.0, true));
    assert!(page.picture().pixels().pixels().any(|p| p.0[0] > 20));
    let plain = Viewer::start_in(Some(folder.path()), &["rgb.nrrd"]);
    assert!(plain.page().hello["channels"] == json!([]), "vectors have a magnitude");
    let text = bytes("rgb.nrrd");
    let at = text.windows(VECTOR.len()).position(|words| words == VECTOR).unwrap();
    let list = [&text[..at], b"list", &text[at + VECTOR.len()..]].concat();
    std::fs::write(folder.path().join("list.nrrd"), &list).unwrap();
    let plain = Viewer::start_in(Some(folder.path()), &["list.nrrd"]);
    let mut page = plain.page();
    assert_eq!(page.hello["channels"].as_array().unwrap().len(), 3, "no channel is left out in silence");
    page.send(&json!({ "type": "command", "camera": page.hello["camera"], "width": 8, "height": 8, "samples": 1 }));
    let line = page.text("command")["line"].as_str().unwrap().to_owned();
    assert!(line.contains("--channels all"), "{line}");
    let one = Viewer::start_in(Some(folder.path()), &["list.nrrd", "--channel", "1"]);
    let page = one.page();
    assert_eq!(page.hello["channels"], json!([]));
    assert!(page.hello["notes"][0].as_str().unwrap().contains("channel 1 of 3"), "{}", page.hello["notes"]);
}
