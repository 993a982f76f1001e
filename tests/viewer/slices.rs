//! Slices beside the picture: those of the command, and their limits.

use crate::client::{Message, Page, Picture, Viewer};
use serde_json::{Value, json};
use std::process::Command;

const HYDROGEN: [&str; 1] = ["builtin:hydrogen@32"];
/// What a picture of slices is.
const SLICES: u8 = 6;
const WIDTH: u32 = 44;
const HEIGHT: u32 = 36;

/// A request for the slices of the volume's axes through a point.
fn request(page: &Page, id: u32, point: [f64; 3]) -> Value {
    let axes = page.hello["slices"]["axes"].as_array().unwrap();
    let planes: Vec<Value> = axes.iter().map(|axis| json!({ "right": axis["right"], "up": axis["up"] })).collect();
    json!({
        "type": "slices", "id": id, "point": point, "planes": planes, "width": WIDTH, "height": HEIGHT, "kernel": "linear",
        "window": [100, 150], "thickness": null, "moving": false,
    })
}

fn with(mut request: Value, name: &str, value: Value) -> Value {
    request[name] = value;
    request
}

/// The answer and its picture.
fn slices(page: &mut Page, request: &Value) -> (Value, Picture) {
    page.send(request);
    let answer = page.text("slices");
    let picture = page.picture();
    page.shown();
    assert_eq!((answer["id"].as_u64(), picture.id, picture.step), (request["id"].as_u64(), picture.id, SLICES));
    assert_eq!((picture.width, picture.height), (WIDTH, 3 * HEIGHT));
    (answer, picture)
}

/// One of three slices, by the command.
fn by_command(options: &[&str]) -> image::RgbaImage {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slice.png");
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    let size = format!("{WIDTH}x{HEIGHT}");
    let output = command.args(["slice", HYDROGEN[0], "--size", &size]).args(options).arg("-o").arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    image::open(path).unwrap().into_rgba8()
}

fn part(picture: &Picture, n: u32) -> image::RgbaImage {
    image::imageops::crop_imm(&picture.pixels(), 0, n * HEIGHT, WIDTH, HEIGHT).to_image()
}

#[test]
fn slices_have_the_bits_of_the_command() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let names: Vec<_> = page.hello["slices"]["axes"].as_array().unwrap().iter().map(|axis| axis["name"].clone()).collect();
    assert_eq!(names, ["z", "y", "x"]);
    let point = [11.25, 15.5, 20.0];
    let plain = request(&page, 1, point);
    let (answer, grey) = slices(&mut page, &plain);
    let (_, smooth) = slices(&mut page, &with(with(plain.clone(), "kernel", json!("bspline")), "id", json!(2)));
    for (n, (axis, at)) in [("z", "20"), ("y", "15.5"), ("x", "11.25")].into_iter().enumerate() {
        let options = ["--axis", axis, "--at", at, "--window", "100,150"];
        assert!(part(&grey, n as u32) == by_command(&options), "{axis}");
        assert!(part(&smooth, n as u32) == by_command(&[&options[..], &["--kernel", "bspline"]].concat()), "{axis}");
    }
    assert!(grey.is_png && grey.pixels() != smooth.pixels());
    // The value is that of the pixel in the middle of a slice with an odd number of pixels around the point.
    let value = answer["value"].as_f64().unwrap();
    let corner: Vec<f64> = answer["placed"][0]["corner"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    assert!(value > 0.0 && (corner[2] - 20.0).abs() < 1e-9, "{answer}");
    // Colours follow the page's transfer function.
    let colors = with(with(plain, "window", Value::Null), "id", json!(3));
    let (_, before) = slices(&mut page, &colors);
    page.send(&json!({ "type": "transfer", "colors": [[0, [1, 0, 0]]], "opacities": [[0, 1]] }));
    page.send(&page.view(4, 0.0, true));
    assert_eq!(page.picture().id, 4);
    page.shown();
    let (_, after) = slices(&mut page, &with(colors, "id", json!(5)));
    assert!(before.pixels() != after.pixels());
    assert_eq!(part(&after, 0).get_pixel(WIDTH / 2, HEIGHT / 2).0, [255, 0, 0, 255]);
}

#[test]
fn points_outside_have_no_value_and_moving_slices_are_jpegs() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let outside = request(&page, 1, [-50.0, 15.0, 15.0]);
    let (answer, _) = slices(&mut page, &outside);
    assert!(answer["value"].is_null(), "{answer}");
    let moving = with(request(&page, 2, [15.0; 3]), "moving", json!(true));
    let (answer, picture) = slices(&mut page, &moving);
    assert!(!picture.is_png && answer["value"].is_number());
}

#[test]
fn bad_slices_are_refused() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let good = request(&page, 1, [15.0; 3]);
    for (name, value, word) in [
        ("width", json!(0), "viewport"),
        ("height", json!(4_000_000), "viewport"),
        ("window", json!([0, 0]), "window"),
        ("thickness", json!(-1), "thickness"),
        // So far away that the volume has no size.
        ("point", json!([1e300, 1e300, 1e300]), "half the height of the slice is 0"),
    ] {
        let bad = with(good.clone(), name, value);
        let bad = if name == "thickness" { with(bad, "window", Value::Null) } else { bad };
        page.send(&bad);
        let problem = page.text("problem");
        assert!(problem["sentence"].as_str().unwrap().contains(word), "{problem}");
    }
    let flat = json!({ "right": [1, 0, 0], "up": [1, 0, 0] });
    page.send(&with(good.clone(), "planes", json!([flat, flat, flat])));
    assert!(page.text("problem")["sentence"].as_str().unwrap().contains("span no plane"));
    // Two planes, or a field that there is not, are of another version.
    for bad in [with(good.clone(), "planes", json!([])), with(good, "path", json!("/etc/passwd"))] {
        let mut page = viewer.page();
        page.send(&bad);
        loop {
            match page.receive() {
                Message::Closed(code) => break assert_eq!(code, 1007),
                Message::Text(_) => {}
                Message::Picture(picture) => panic!("{picture:?}"),
            }
        }
    }
}

#[test]
fn a_page_that_never_acknowledges_gets_two_pictures_of_slices() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    let plain = request(&page, 0, [15.0; 3]);
    page.send(&plain);
    assert_eq!(page.picture().id, 0);
    for id in 1..60 {
        page.send(&with(with(plain.clone(), "id", json!(id)), "point", json!([15.0, 15.0, f64::from(id) / 3.0])));
    }
    assert!(page.picture().id > 0);
    page.gets_no_picture();
    // The newest request wins, and the second picture may have been that of the last one.
    page.send(&with(plain, "id", json!(60)));
    page.shown();
    assert_eq!(page.picture().id, 60);
}
