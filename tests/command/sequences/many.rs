//! Many views of one volume: `--cameras`.

use super::{NAME, done, folder, picture};
use crate::common::command::*;
use layersplat::image::read_image;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Output, Stdio};

fn lines(output: &Output) -> Vec<serde_json::Value> {
    String::from_utf8_lossy(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Each line gives the picture that `render` makes of the same view, with the common options.
#[test]
fn many_views_are_those_that_render_makes() {
    let folder = folder();
    let f = folder.path();
    let views = r##"{"output": "a.npy", "azimuth": 40, "elevation": -10, "roll": 5}

        {"output": "b.npy", "size": [30, 26], "azimuth": 200, "perspective": 40, "distance": 50, "center": [6, 5, 4]}
        {"output": "c.npy", "size": "18x18", "parallel_scale": 4.5}
        {"output": "d.npy", "position": [6.5, 5.5, 100], "focal_point": [6.5, 5.5, 4.5], "view_up": [0, 1, 0], "parallel_scale": 8}
    "##;
    std::fs::write(f.join("views.ndjson"), views).unwrap();
    let common = "--transfer fire --size 24x20 --shading off --samples 2";
    let output = done(f, &format!("render {NAME} {common} --cameras views.ndjson"));
    let found: Vec<_> =
        lines(&output).iter().map(|l| (l["line"].as_u64().unwrap(), l["output"].as_str().unwrap().to_owned())).collect();
    let expected = [(1, "a.npy"), (3, "b.npy"), (4, "c.npy"), (5, "d.npy")].map(|(n, name)| (n, name.to_owned()));
    assert_eq!(found, expected);
    assert_eq!((&lines(&output)[1]["width"], &lines(&output)[1]["height"]), (&30.into(), &26.into()));
    for (name, options) in [
        ("a", "--azimuth 40 --elevation -10 --roll 5"),
        ("b", "--size 30x26 --azimuth 200 --perspective 40 --distance 50 --center 6,5,4"),
        ("c", "--size 18x18 --parallel-scale 4.5"),
        ("d", "--center 6.5,5.5,4.5 --parallel-scale 8 --azimuth 0"),
    ] {
        let common = if options.contains("--size") { common.replace("--size 24x20", "") } else { common.into() };
        let single = picture(f, &format!("{common} {options}"));
        let comparison = read_image(&f.join(format!("{name}.npy"))).unwrap().compare(&single).unwrap();
        assert!(comparison.max_difference < 1e-6, "{name}: {comparison:?}");
    }
}

/// A line's fields of light replace the options of the command; the next line has those of the command again.
#[test]
fn each_line_may_have_its_own_light() {
    let folder = folder();
    let f = folder.path();
    let views = r#"{"output": "a.npy", "shadows": true, "shadow_strength": 0.5, "light": "-1,1,0.5:0.8", "light_space": "camera"}
        {"output": "b.npy"}
        {"output": "c.npy", "ambient_occlusion": false, "light": ["1,0,0", "camera:0.3"]}
        {"output": "d.npy", "shading": "off", "ambient_occlusion": "off"}
    "#;
    std::fs::write(f.join("views.ndjson"), views).unwrap();
    let common = "--transfer fire --size 24x20";
    done(f, &format!("render {NAME} {common} --ambient-occlusion on --ao-reach 3 --cameras views.ndjson"));
    let singles = [
        ("a", "--ambient-occlusion on --ao-reach 3 --shadows on --shadow-strength 0.5 --light=-1,1,0.5:0.8 --light-space camera"),
        ("b", "--ambient-occlusion on --ao-reach 3"),
        ("c", "--light 1,0,0 --light camera:0.3"),
        ("d", "--shading off"),
    ];
    let mut found = Vec::new();
    for (name, options) in singles {
        let single = picture(f, &format!("{common} {options}"));
        found.push(read_image(&f.join(format!("{name}.npy"))).unwrap());
        let comparison = found.last().unwrap().compare(&single).unwrap();
        assert!(comparison.max_difference < 1e-6, "{name}: {comparison:?}");
    }
    for other in &found[1..] {
        assert!(found[0].compare(other).unwrap().max_difference > 0.01, "the lines must differ");
    }
}

/// The whole file is validated before rendering; errors name the line.
#[test]
fn lines_that_are_wrong_are_named() {
    let folder = folder();
    let f = folder.path();
    let good = r#"{"output": "a.png"}"#;
    let long = format!(r#"{{"output": "{}.png"}}"#, "x".repeat(70_000));
    for (line, word) in [
        (r#"{"output": "a.png""#, "not a JSON object"),
        ("[1]", "not a JSON object"),
        (r#"{"azimuth": 3}"#, "names no picture"),
        (r#"{"output": "a.bmp"}"#, ".exr"),
        (r#"{"output": "a.png", "size": [0, 3]}"#, "1 to 16384"),
        (r#"{"output": "a.png", "size": 3}"#, "WxH"),
        (r#"{"output": "a.png", "azimut": 3}"#, "azimut"),
        (r#"{"output": "a.png", "parallel_scale": -3}"#, "above 0"),
        (r#"{"output": "a.png", "shadows": 3}"#, "use on or off"),
        (r#"{"output": "a.png", "shadow_strength": 0.5}"#, "shadows are off"),
        (&long, "longer than 65536 bytes"),
    ] {
        std::fs::write(f.join("views.ndjson"), format!("{good}\n\n{line}\n{good}\n")).unwrap();
        refused(f, &["render", NAME, "--cameras", "views.ndjson"], 1, &["views.ndjson, line 3", word]);
    }
    refused(f, &["render", NAME, "--cameras", "missing.ndjson"], 1, &["missing.ndjson"]);
    refused(f, &["render", NAME, "--cameras", "views.ndjson", "-o", "a.png"], 2, &["--output"]);
    std::fs::write(f.join("views.ndjson"), r#"{"output": "b.png", "perspective": 1e-320}"#).unwrap();
    refused(f, &["render", NAME, "--cameras", "views.ndjson"], 1, &["line 1", "camera"]);
    // Errors that only the whole scene reveals.
    std::fs::write(f.join("views.ndjson"), r#"{"output": "b.png", "position": [1, 2, 3]}"#).unwrap();
    refused(f, &["render", NAME, "--cameras", "views.ndjson"], 1, &["line 1", "parallel_scale or perspective"]);
}

/// Lines from a pipe are answered one by one, before the pipe is closed. A failed write ends the command.
#[test]
fn a_pipe_is_answered_as_it_goes() {
    let folder = folder();
    let f = folder.path();
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    command.current_dir(f).args(["render", NAME, "--transfer", "fire", "--size", "20x20", "--cameras", "-"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (mut input, mut output) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
    for n in 0..3 {
        writeln!(input, r#"{{"output": "{n}.png", "azimuth": {}}}"#, 30 * n).unwrap();
        let mut answer = String::new();
        output.read_line(&mut answer).unwrap();
        let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
        assert_eq!((&answer["line"], &answer["output"]), (&(n + 1).into(), &format!("{n}.png").into()));
        assert!(f.join(format!("{n}.png")).exists());
    }
    // The next line may be read before the failure of this one is known.
    let _ = writeln!(input, r#"{{"output": "missing/a.png"}}"#).and_then(|()| writeln!(input, r#"{{"output": "4.png"}}"#));
    drop(input);
    let ended = child.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(1) && message.contains("missing"), "{message}");
}
