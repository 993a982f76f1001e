//! The command with several fields, colours and labels.

mod common;

use common::command::*;
use std::path::{Path, PathBuf};

const SIZE: [&str; 2] = ["--size", "48x40"];

fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files")
}

/// Pixels of a picture that the command renders.
fn picture(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let arguments = [&["render"], arguments, &SIZE, &["--device-unchecked", "-o", "p.png"]].concat();
    let output = layersplat(folder, &arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    image::open(folder.join("p.png")).unwrap().into_rgb8().into_raw()
}

/// A file of three components, as NRRD.
fn components(folder: &Path) {
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 8 8 8\nkinds: RGB-color domain domain domain\nencoding: raw\n\n";
    let voxel = |n: usize| [200u8 * u8::from(n % 8 < 4), 180 * u8::from(n / 64 < 4), 120];
    let bytes: Vec<u8> = (0..512).flat_map(voxel).collect();
    std::fs::write(folder.join("rgb.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
}

#[test]
fn options_and_scenes_draw_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let first = ["builtin:hydrogen@16", "--transfer", "fire"];
    let with = picture(f, &[&first[..], &["--with", "builtin:gyroid@16,color=#00aaff,opacity=p50:0,p99:0.3,factor=2"]].concat());
    let scene = r##"{"fields": [{}, {"file": "builtin:gyroid@16", "color": "#00aaff", "opacity": [["p50", 0], ["p99", 0.3]], "factor": 2}]}"##;
    std::fs::write(f.join("scene.json"), scene).unwrap();
    assert!(picture(f, &[&first[..], &["--scene", "scene.json"]].concat()) == with);
    assert!(picture(f, &first) != with);
    let hidden = picture(f, &[&first[..], &["--with", "builtin:gyroid@16,visible=off"]].concat());
    assert!(hidden == picture(f, &[&first[..], &["--fit", "visible"]].concat()), "a hidden field changes nothing");
    // A field of its own grid, moved.
    std::fs::write(f.join("at.txt"), "0.5 0 0 20\n0 0.5 0 3\n0 0 0.5 2\n0 0 0 1\n").unwrap();
    let moved = picture(f, &[&first[..], &["--with", "builtin:gyroid@16,at=at.txt"]].concat());
    assert!(moved != picture(f, &[&first[..], &["--with", "builtin:gyroid@16"]].concat()));
}

/// Each line of `--cameras` shows all fields, as a command of its own does.
#[test]
fn many_views_show_all_fields() {
    const VIEWS: &str = r#"{"output": "v0.png", "azimuth": 10}
        {"output": "v1.png", "azimuth": 100, "elevation": 30}"#;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let both =
        ["builtin:hydrogen@16", "--with", "builtin:gyroid@16,color=#00aaff,opacity=p50:0,p99:0.3,factor=2", "--fit", "volume"];
    std::fs::write(f.join("views.ndjson"), VIEWS).unwrap();
    let arguments = [&["render"], &both[..], &SIZE, &["--device-unchecked", "--cameras", "views.ndjson"]].concat();
    let output = layersplat(f, &arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let views = [&["--azimuth", "10", "--elevation", "0"][..], &["--azimuth", "100", "--elevation", "30"]];
    for (n, view) in views.into_iter().enumerate() {
        let of_many = image::open(f.join(format!("v{n}.png"))).unwrap().into_rgb8().into_raw();
        assert!(of_many == picture(f, &[&both[..], view].concat()), "view {n}");
        assert!(of_many != picture(f, &[&both[..1], &both[3..], view].concat()), "view {n} shows one field");
    }
}

/// Vectors along x, where the file has any, with one that is not a number.
#[test]
fn directions_of_vectors_are_colors() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: float\ndimension: 4\nsizes: 3 8 8 8\nkinds: vector domain domain domain\nendian: little\nencoding: raw\n\n";
    let vector = |n: usize| [if n == 200 { f32::NAN } else { -2.0 }, 0.0, 0.0];
    let bytes: Vec<u8> = (0..512).flat_map(vector).flat_map(f32::to_le_bytes).collect();
    std::fs::write(f.join("flow.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
    let shown = picture(f, &["flow.nrrd", "--colors", "direction", "--opacity", "0:0,2:0.3", "--shading", "off"]);
    assert!(shown.chunks_exact(3).all(|pixel| pixel[1] == 0 && pixel[2] == 0) && shown.iter().any(|&c| c > 100));
    let thin = picture(f, &["flow.nrrd", "--colors", "direction", "--opacity", "0:0,2:0.03", "--shading", "off"]);
    let sum = |pixels: &[u8]| pixels.iter().map(|&c| u64::from(c)).sum::<u64>();
    assert!(sum(&thin) < sum(&shown) / 2, "opacities are those of the norm");
    picture(f, &["flow.nrrd", "--colors", "direction", "--legend"]);
    components(f);
    refused(f, &["render", "rgb.nrrd", "--colors", "direction", "--color-opacity", "white"], 2, &["color_opacity", "direction"]);
    std::fs::write(f.join("block_4x4x4_uint8.raw"), [7; 64]).unwrap();
    refused(f, &["render", "block_4x4x4_uint8.raw", "--colors", "direction"], 2, &["direction needs 3 components"]);
}

#[test]
fn components_are_channels_or_colors() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    components(f);
    let channels = picture(f, &["rgb.nrrd", "--channels", "all"]);
    assert!(channels != picture(f, &["rgb.nrrd", "--channels", "0,2"]));
    let colors = picture(f, &["rgb.nrrd", "--colors", "direct"]);
    assert!(colors != channels && colors.iter().any(|&c| c > 40));
    assert!(colors != picture(f, &["rgb.nrrd", "--colors", "direct", "--color-opacity", "#0000ff"]));
    assert!(channels != picture(f, &["rgb.nrrd", "--channels", "all", "--classification", "post"]));
    // The first component may be any.
    assert!(picture(f, &["rgb.nrrd", "--channels", "1"]) != picture(f, &["rgb.nrrd", "--channels", "0"]));
}

#[test]
fn labels_of_a_file_are_drawn_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let labels = files().join("labels/layers.seg.nrrd");
    let labels = labels.to_str().unwrap();
    let all = picture(f, &[labels, "--legend"]);
    assert!(all.iter().any(|&c| c > 60));
    let json = json(f, &["info", labels]);
    let name = json["labels"][0]["name"].as_str().unwrap().to_owned();
    assert!(
        picture(f, &[labels, "--label", &format!("{name}:hide"), "--fit", "volume"]) != picture(f, &[labels, "--fit", "volume"])
    );
}

/// Within a ball of labels, on a grid of its own, a cube is a ball.
#[test]
fn masks_leave_what_lies_within() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let at = |n: usize| [n % 8, n / 8 % 8, n / 64].map(|i| i as f64 - 3.5);
    let ids = (0..512).map(|n| if at(n).iter().map(|c| c * c).sum::<f64>() < 9.0 { 3u8 } else { 7 * u8::from(n % 8 == 7) });
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nspace: left-posterior-superior\nspace directions: (-2,0,0) (0,-2,0) (0,0,2)\nspace origin: (-0.5,-0.5,0.5)\nencoding: raw\n\n";
    std::fs::write(f.join("mask.nrrd"), [header.as_bytes(), &ids.collect::<Vec<u8>>()].concat()).unwrap();
    let voxels: Vec<u8> = (0..4096).map(|n| 100 + (n % 16) as u8).collect();
    std::fs::write(f.join("block_16x16x16_uint8.raw"), voxels).unwrap();
    let shown = [
        "--opacity",
        "0:0,99:0,100:1",
        "--transfer",
        "grey",
        "--transfer-range",
        "0,115",
        "--fit",
        "volume",
        "--background-value",
        "0",
    ];
    let draw = |mask: &str| {
        let mask: &[&str] = if mask.is_empty() { &[] } else { &["--mask", mask] };
        picture(f, &[&["block_16x16x16_uint8.raw"], mask, &shown].concat())
    };
    let lit = |pixels: &[u8]| pixels.chunks_exact(3).filter(|pixel| pixel[0] > 20).count();
    let (whole, all, ball) = (lit(&draw("")), lit(&draw("mask.nrrd")), lit(&draw("mask.nrrd:3")));
    assert!(whole > all && all > ball && ball > whole / 6, "{whole}, {all}, {ball}");
    let far = header.replace("(-0.5,-0.5,0.5)", "(500,0,0)");
    std::fs::write(f.join("far.nrrd"), [far.as_bytes(), &[3; 512]].concat()).unwrap();
    refused(f, &["render", "block_16x16x16_uint8.raw", "--mask", "far.nrrd"], 1, &["within a visible label"]);
    refused(f, &["render", "block_16x16x16_uint8.raw", "--mask", "mask.nrrd:5"], 2, &["no label has the id 5"]);
}

#[test]
fn mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    components(f);
    std::fs::write(f.join("scene.json"), r#"[{"file": "rgb.nrrd"}, {"color": "grey"}]"#).unwrap();
    std::fs::write(f.join("sheared.txt"), "1 0.5 0 0\n0 1 0 0\n0 0 1 0\n").unwrap();
    let cases: [(&str, i32, &[&str]); 10] = [
        ("rgb.nrrd --channels 0,3", 2, &["channel", "0 to 2"]),
        ("rgb.nrrd --channels 0,0", 2, &["channel 0 occurs twice"]),
        ("rgb.nrrd --with nothing.nrrd", 1, &["nothing.nrrd"]),
        ("rgb.nrrd --with rgb.nrrd,factor=-1", 2, &["factor"]),
        ("rgb.nrrd --with rgb.nrrd,at=sheared.txt", 1, &["sheared.txt", "angle"]),
        ("rgb.nrrd --scene scene.json", 1, &["scene.json", "field 2", "names no file"]),
        ("rgb.nrrd --channels all --quality paper", 2, &["one channel", "layers on a lattice"]),
        ("rgb.nrrd --channels all --algorithm view-sheets", 2, &["one channel"]),
        ("rgb.nrrd --colors direct --color-opacity alpha", 2, &["fourth component"]),
        ("rgb.nrrd --colors direct --blend maximum", 2, &["blend"]),
    ];
    for (arguments, code, words) in cases {
        let arguments: Vec<&str> = ["render"].into_iter().chain(arguments.split(' ')).chain(SIZE).collect();
        refused(f, &arguments, code, words);
    }
    let nine: Vec<String> = (0..8).flat_map(|_| ["--with".to_owned(), "rgb.nrrd".to_owned()]).collect();
    let arguments: Vec<&str> = ["render", "rgb.nrrd"].into_iter().chain(nine.iter().map(String::as_str)).chain(SIZE).collect();
    refused(f, &arguments, 2, &["9 fields", "at most 8"]);
}
