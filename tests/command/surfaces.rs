//! The command with surfaces: scenes, lines of `--cameras`, and where they lie.

use crate::common::command::*;
use std::path::Path;

/// Draws the volume of all pictures.
const RENDER: [&str; 8] =
    ["render", "builtin:hydrogen@16", "--transfer", "fire", "--size", "48x40", "--device-unchecked", "--fit=volume"];

/// Spheres at these points, as a file of Stanford.
fn write_points(path: &Path, points: &[&str]) {
    let axes = ["x", "y", "z"].map(|axis| format!("property float {axis}\n")).concat();
    let header = format!("ply\nformat ascii 1.0\nelement vertex {}\n{axes}end_header\n", points.len());
    std::fs::write(path, header + &points.join("\n") + "\n").unwrap();
}

fn folder_with_points() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    write_points(&folder.path().join("scenes/one.ply"), &["4 8 8"]);
    write_points(&folder.path().join("scenes/two.ply"), &["12 8 8"]);
    folder
}

fn pixels(path: &Path) -> Vec<u8> {
    image::open(path).unwrap().into_rgb8().into_raw()
}

/// The picture of some arguments.
fn picture(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = layersplat(folder, &[&RENDER[..], arguments, &["-o", "p.png"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    pixels(&folder.join("p.png"))
}

/// What a command says that fails.
fn problem(folder: &Path, arguments: &[&str]) -> String {
    let output = layersplat(folder, arguments);
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn scenes_have_surfaces() {
    let folder = folder_with_points();
    let f = folder.path();
    std::fs::write(f.join("scenes/at.txt"), "1 0 0 0\n0 1 0 2\n0 0 1 0\n0 0 0 1\n").unwrap();
    let (one, two) = ("scenes/one.ply,radius=3,color=#00ff00,opacity=0.5", "scenes/two.ply,radius=2,at=scenes/at.txt,clip=off");
    let expected = picture(f, &["--surface", one, "--surface", two]);
    let keys = r##""surfaces": [{"file": "one.ply", "radius": 3, "color": "#00ff00", "opacity": 0.5},
                                {"file": "two.ply", "radius": 2, "at": "at.txt", "clip": false}]"##;
    for scene in [format!("{{{keys}}}"), format!(r#"{{"fields": [{{}}], {keys}}}"#)] {
        std::fs::write(f.join("scenes/scene.json"), scene).unwrap();
        assert!(picture(f, &["--scene", "scenes/scene.json"]) == expected);
    }
    assert!(picture(f, &[]) != expected);
    let with_fields = r#"{"fields": [{}, {"file": "builtin:gyroid@16"}], "surfaces": [{"file": "one.ply", "radius": 3}]}"#;
    std::fs::write(f.join("scenes/scene.json"), with_fields).unwrap();
    let others = ["--with", "builtin:gyroid@16", "--surface", "scenes/one.ply,radius=3"];
    assert!(picture(f, &["--scene", "scenes/scene.json"]) == picture(f, &others));
    for (scene, words) in [
        (r#"{"surfaces": [{"radius": 3}]}"#, "surface 1: it names no file"),
        (
            r#"{"surfaces": [{"file": "one.ply", "radius": 3}, {"file": "one.ply", "opacity": 2}]}"#,
            "surface 2: opacity: invalid opacity '2'",
        ),
        (r#"{"surfaces": [{"file": "three.ply"}]}"#, "scenes/three.ply"),
    ] {
        std::fs::write(f.join("scenes/scene.json"), scene).unwrap();
        let said = problem(f, &[&RENDER[..], &["--scene", "scenes/scene.json"]].concat());
        assert!(said.contains(words), "{scene}: {said}");
    }
    std::fs::write(f.join("scenes/scene.json"), format!("{{{keys}}}")).unwrap();
    for (command, words) in [("render", "it has surfaces alone: name a volume"), ("view", "it has surfaces alone")] {
        let said = problem(f, &[command, "--scene", "scenes/scene.json"]);
        assert!(said.contains(words), "{command}: {said}");
    }
    for (command, words) in [("slice", "slices do not show"), ("view", "the viewer draws no surfaces")] {
        let said = problem(f, &[command, "builtin:hydrogen@16", "--scene", "scenes/scene.json"]);
        assert!(said.contains(words), "{command}: {said}");
    }
}

#[test]
fn lines_show_and_hide_surfaces() {
    let folder = folder_with_points();
    let f = folder.path();
    let (one, two) = ("scenes/one.ply,radius=3,name=near", "scenes/two.ply,radius=2");
    let shown = |one: &str, two: &str| picture(f, &["--azimuth=0", "--surface", one, "--surface", two]);
    let hidden = |spec: &str| format!("{spec},visible=off");
    let given = ["--surface", one, "--surface", &hidden(two)];
    let expected = [
        ("", shown(one, &hidden(two))),
        (r#", "show": ["two.ply"]"#, shown(one, two)),
        (r#", "show": "two.ply", "hide": ["near"]"#, shown(&hidden(one), two)),
        // A line changes no other.
        ("", shown(one, &hidden(two))),
        (r#", "hide": ["near"]"#, picture(f, &["--azimuth=0"])),
    ];
    assert!((1..5).all(|n| n == 3 || expected[n].1 != expected[0].1));
    let lines = expected.iter().enumerate().map(|(n, (keys, _))| format!(r#"{{"output": "{n}.png", "azimuth": 0{keys}}}"#));
    std::fs::write(f.join("lines"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    let output = layersplat(f, &[&RENDER[..], &given, &["--cameras", "lines"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for (n, (keys, expected)) in expected.iter().enumerate() {
        assert!(pixels(&f.join(format!("{n}.png"))) == *expected, "line {n}: {keys}");
    }
    for (keys, words) in [
        (r#""hide": ["far"]"#, "line 2: there is no surface 'far': use near, two.ply"),
        (r#""show": 3"#, "line 2: show must be a list of names of surfaces"),
    ] {
        let lines = format!("{{\"output\": \"new.png\"}}\n{{\"output\": \"b.png\", {keys}}}");
        std::fs::write(f.join("lines"), lines).unwrap();
        let said = problem(f, &[&RENDER[..], &given, &["--cameras", "lines"]].concat());
        assert!(said.contains(words) && !f.join("new.png").exists(), "{keys}: {said}");
    }
}

#[test]
fn surfaces_outside_the_volume_are_named() {
    let folder = folder_with_points();
    let f = folder.path();
    write_points(&f.join("far.ply"), &["40 8 8", "42 8 8"]);
    let info = ["info", "builtin:hydrogen@16", "--surface", "scenes/one.ply,radius=3", "--surface", "far.ply,radius=1"];
    let said = String::from_utf8(layersplat(f, &info).stdout).unwrap();
    assert!(said.contains("surface   one.ply: 1 spheres of 1 points, meets the volume: 1,5,5 to 7,11,11"), "{said}");
    let outside = "lies outside the volume: 39,7,7 to 43,9,9, and the volume 0,0,0 to 15,15,15; give its axes by space=LPS";
    assert!(said.contains(&format!("surface   far.ply: 2 spheres of 2 points, {outside}")), "{said}");
    let report: serde_json::Value = serde_json::from_slice(&layersplat(f, &[&info[..], &["--json"]].concat()).stdout).unwrap();
    let meets = ["/surfaces/0/meets_volume", "/surfaces/1/meets_volume"].map(|at| report.pointer(at).unwrap().as_bool());
    assert_eq!(meets, [Some(true), Some(false)]);
    for (spec, is_said) in
        [("far.ply", true), ("far.ply,visible=off", false), ("scenes/one.ply", false), ("far.ply,radius=25", false)]
    {
        let output = layersplat(f, &[&RENDER[..], &["--surface", spec, "-o", "p.png"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains("surface far.ply lies outside the volume") == is_said, "{spec}: {said}");
    }
    let said = problem(f, &["info", "far.ply", "--surface", "far.ply"]);
    assert!(said.contains("the file holds surfaces, too"), "{said}");
}

/// A file in place of a volume is drawn as `--surface` says, if that names it, too.
#[test]
fn surfaces_alone_look_as_their_keys_say() {
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files");
    let folder = tempfile::tempdir().unwrap();
    let seen = |surfaces: &[&str]| {
        let given: Vec<_> = surfaces.iter().flat_map(|surface| ["--surface", surface]).collect();
        let view = ["--size", "24x24", "--shading", "off", "--device-unchecked", "-o", "p.png"];
        let box_ = files.join("surfaces/lh.box");
        let output = layersplat(folder.path(), &[&["render", box_.to_str().unwrap()][..], &view, &given].concat());
        assert!(output.status.success(), "{surfaces:?}: {}", String::from_utf8_lossy(&output.stderr));
        let pixels = pixels(&folder.path().join("p.png"));
        let colors: std::collections::BTreeSet<[u8; 3]> = pixels.as_chunks().0.iter().copied().collect();
        colors.into_iter().collect::<Vec<_>>()
    };
    let box_ = files.join("surfaces/lh.box").to_str().unwrap().to_owned();
    let plain = format!("{box_},shading=off,color=#ff8000");
    assert_eq!(seen(&[&plain]), [[0, 0, 0], [255, 128, 0]]);
    let labels = files.join("surface_data/lh.parts.annot");
    let found = seen(&[&format!("{box_},shading=off,data={}", labels.display())]);
    let has_ends = found.contains(&[0, 0, 255]) && found.iter().any(|color| color[0] > 100 && color[2] < 200);
    assert!(has_ends && found.len() > 5, "red, blue and what lies between: {found:?}");
}
