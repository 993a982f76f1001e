//! Transfer functions: files of other programs compared with VTK, and `layersplat transfer`.

use crate::common::command::*;
use layersplat::image::read_image;
use layersplat::transfer::FileFormat;
use layersplat::{TransferFunction, Volume};
use serde_json::Value;
use std::path::Path;

/// Numbers of VTK, from tests/transfer/truth.py.
const VTK: &str = include_str!("transfer/vtk.json");
/// Documented error of linear pieces, and the rounding of VTK's table to six digits.
const PIECES: f64 = 1e-3 + 1e-6;
/// Steps have no curves: only the rounding remains.
const STEPS: f64 = 1e-6;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
}

fn read(folder: &Path, name: &str, text: &str) -> TransferFunction {
    std::fs::write(folder.join(name), text).unwrap();
    TransferFunction::from_file(&folder.join(name), None).unwrap()
}

/// Each preset of the table, with sample values and VTK's results.
fn cases() -> Vec<(String, String, Vec<f64>, Value)> {
    let cases: Vec<Value> = serde_json::from_str(VTK).unwrap();
    let case = |case: Value| {
        let name = case["preset"]["Name"].as_str().unwrap().to_owned();
        (name, case["preset"].to_string(), numbers(&case["values"]), case)
    };
    cases.into_iter().map(case).collect()
}

#[test]
fn colours_are_those_of_vtk_in_every_space() {
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for (name, preset, values, case) in cases() {
        let Some(colors) = case["colors"].as_array().filter(|_| !name.contains("CIEDE2000")) else { continue };
        let transfer = read(folder.path(), "preset.json", &preset);
        let tolerance = if name.contains("Step") { STEPS } else { PIECES };
        for (&value, expected) in values.iter().zip(colors) {
            let (found, expected) = (transfer.color(value), numbers(expected));
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off <= tolerance, "{name} at {value}: {found:?} for {expected:?}");
            compared += 1;
        }
    }
    assert!(compared > 900, "{compared}");
}

#[test]
fn opacities_are_those_of_vtk_whatever_their_curves() {
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for (name, preset, values, case) in cases() {
        let Some(opacities) = case["opacities"].as_array() else { continue };
        let transfer = read(folder.path(), "preset.json", &preset);
        for (&value, expected) in values.iter().zip(opacities) {
            let (found, expected) = (transfer.opacity(value), expected.as_f64().unwrap());
            assert!((found - expected).abs() <= PIECES, "{name} at {value}: {found} for {expected}");
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

/// Both search shortest paths in a grid of sixteen steps per channel. VTK also moves the end points to the grid, by up to half a step.
const PATHS: f64 = 1.0 / 32.0;

#[test]
fn paths_of_ciede2000_are_near_those_of_vtk() {
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for (name, preset, values, case) in cases().into_iter().filter(|(name, ..)| name.contains("CIEDE2000")) {
        let transfer = read(folder.path(), "preset.json", &preset);
        let off = |(&value, expected): (&f64, &Value)| {
            transfer.color(value).into_iter().zip(numbers(expected)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let most = values.iter().zip(case["colors"].as_array().unwrap()).map(off).fold(0.0, f64::max);
        assert!(most <= PATHS, "{name}: off by {most}");
        compared += values.len();
    }
    assert!(compared > 150, "{compared}");
}

/// At a step, a value has the colour of its own point, as in ParaView.
#[test]
fn labels_have_the_colours_of_their_points() {
    let folder = tempfile::tempdir().unwrap();
    let labels = r#"{"ColorSpace": "Step", "RGBPoints": [0,0,0,0, 1,1,0,0, 2,0,1,0, 3,0,0,1]}"#;
    let transfer = read(folder.path(), "labels.json", labels);
    let colors = [0.0, 1.0, 2.0, 3.0].map(|label| transfer.color(label));
    assert_eq!(colors, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!((transfer.color(0.5), transfer.color(1.001), transfer.color(9.0)), (colors[1], colors[2], colors[3]));
}

/// Conversion from any format to any other and back preserves the function.
#[test]
fn functions_are_converted_by_the_ending() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let convert = |from: &str, to: &str| {
        let done = layersplat(f, &["transfer", "builtin:cube@4", "--transfer", from, "-o", to]);
        assert!(done.status.success(), "{from} {to}: {}", String::from_utf8_lossy(&done.stderr));
        TransferFunction::from_file(&f.join(to), None).unwrap()
    };
    let first = convert("cividis_r", "a.json");
    for [from, to] in [["a.json", "b.vp"], ["b.vp", "c.vp.json"], ["c.vp.json", "d.json"]] {
        let next = convert(from, to);
        assert_eq!((next.colors(), next.opacities()), (first.colors(), first.opacities()), "{to}");
    }
    let lines = convert("d.json", "e.csv");
    assert_eq!(convert("e.csv", "f.csv").colors(), lines.colors());
    for i in 0..=510 {
        let value = f64::from(i) / 2.0;
        assert!(
            (lines.opacity(value) - first.opacity(value)).abs() < 1e-12
                && (lines.color(value)[0] - first.color(value)[0]).abs() < 1e-12
        );
    }
    assert_eq!(names(f), ["a.json", "b.vp", "c.vp.json", "d.json", "e.csv", "f.csv"]);
    let preset: Value = serde_json::from_slice(&std::fs::read(f.join("a.json")).unwrap()).unwrap();
    assert_eq!((&preset[0]["Name"], &preset[0]["ColorSpace"]), (&"cividis_r".into(), &"RGB".into()));
}

/// `layersplat transfer` writes the function that the options define.
#[test]
fn shaped_functions_are_written_as_they_are_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let shaped = ["--transfer", "magma", "--opacity", "p50:0,200:0.25", "--tent", "120,20,0.75"];
    json(f, &[&["transfer", "builtin:marschner-lobb@24"][..], &shaped, &["-o", "a.vp.json"]].concat());
    let volume = Volume::open("builtin:marschner-lobb@24", &Default::default()).unwrap();
    let median = volume.statistics().quantile(0.5);
    let expected = TransferFunction::builtin("magma", &volume).unwrap();
    let expected = expected.with_opacities(vec![(median, 0.0), (200.0, 0.25)]).unwrap().with_tent(120.0, 20.0, 0.75).unwrap();
    let written = TransferFunction::from_file(&f.join("a.vp.json"), None).unwrap();
    assert_eq!((written.colors(), written.opacities()), (expected.colors(), expected.opacities()));
    let picture = |name: &str, more: &[&str]| {
        json(f, &[&["render", "builtin:marschner-lobb@24", "--size", "24x24", "-o", name][..], more].concat());
        read_image(&f.join(name)).unwrap()
    };
    assert!(picture("a.npy", &shaped) == picture("b.npy", &["--transfer", "a.vp.json"]));
}

#[test]
fn names_are_listed_and_functions_told() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let listed = layersplat(f, &["transfer", "--list"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    let (transfers, others) = listed.split_once("--preset\n").unwrap();
    let (presets, palettes) = others.split_once("--palette\n").unwrap();
    let names =
        |lines: &str| lines.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next()).map(String::from).collect();
    let (transfers, presets, palettes): (Vec<String>, Vec<String>, Vec<String>) =
        (names(transfers), names(presets), names(palettes));
    assert!(transfers.iter().map(String::as_str).eq(TransferFunction::names()) && transfers.len() > 30, "{listed}");
    assert!(presets.iter().map(String::as_str).eq(TransferFunction::presets().map(|(name, _)| name)), "{listed}");
    assert!(palettes.iter().map(String::as_str).eq(TransferFunction::palettes()), "{listed}");
    let volume = Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default()).unwrap();
    for (option, expected) in [
        ("--preset mr", TransferFunction::preset("mr", &volume).unwrap()),
        ("--transfer mr", TransferFunction::preset("mr", &volume).unwrap()),
        ("--palette vivid", TransferFunction::automatic_in(&volume, "vivid").unwrap()),
    ] {
        let told = json(f, &format!("transfer builtin:hydrogen@16 {option}").split(' ').collect::<Vec<_>>());
        let opacities: Vec<[f64; 2]> = expected.opacities().iter().map(|&(value, opacity)| [value, opacity]).collect();
        assert_eq!((&told["name"], &told["opacities"]), (&expected.name().into(), &serde_json::json!(opacities)), "{option}");
    }
    let told = json(f, &["transfer", "builtin:cube@4", "--window", "100,50"]);
    assert_eq!(keys(&told), ["colors", "name", "opacities"]);
    assert_eq!((&told["name"], &told["opacities"]), (&"grey".into(), &serde_json::json!([[75.0, 0.0], [125.0, 1.0]])));
    let line = layersplat(f, &["transfer", "builtin:cube@4", "--window", "100,50"]);
    assert!(String::from_utf8(line.stdout).unwrap().contains("0 at 75 to 1 at 125"));
}

/// The picture of a function: a colour bar at the bottom, and the curve of the opacity.
#[test]
fn a_function_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let show = |more: &[&str]| {
        json(f, &[&["transfer", "builtin:marschner-lobb@24", "-o", "a.png"][..], more].concat());
        read_image(&f.join("a.png")).unwrap()
    };
    let shown = show(&["--transfer", "fire"]);
    assert_eq!((shown.width(), shown.height()), (640, 360));
    let volume = Volume::open("builtin:marschner-lobb@24", &Default::default()).unwrap();
    let (fire, (lo, hi)) = (TransferFunction::builtin("fire", &volume).unwrap(), volume.range());
    for column in (60..620).step_by(7) {
        let expected = fire.color(lo + (hi - lo) * (f64::from(column - 56) + 0.5) / 564.0);
        let found = shown.pixel(column, 316);
        assert!((0..3).all(|c| (f64::from(found[c]) - expected[c]).abs() < 0.01), "{column}: {found:?} for {expected:?}");
    }
    // A constant at half the height of an axis that ends at 0.5: white across the picture, and nowhere else.
    let flat = show(&["--transfer", "fire", "--opacity", "0:0.25"]);
    let is_white = |column: u32, row: u32| flat.pixel(column, row)[..3].iter().all(|&c| c > 0.99);
    let rows: Vec<u32> = (34..296).filter(|&row| (100..600).all(|column| is_white(column, row))).collect();
    assert!(!rows.is_empty() && rows.iter().all(|row| (163..=167).contains(row)), "{rows:?}");
    let large = show(&["--transfer", "fire", "--size", "1280x720"]);
    assert_eq!((large.width(), large.height()), (1280, 720));
}

/// Constant data, data far from 0, and data of a wide range.
#[test]
fn odd_volumes_are_shown_too() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (name, values) in [
        ("flat", [7.0; 8]),
        ("far", [1e12, 1e12 + 4000.0, 1e12, 1e12, 1e12 + 1.0, 1e12, 1e12, 1e12]),
        ("farther", [1e25, 1e25 + 4e9, 1e25, 1e25, 1e25, 1e25, 1e25, 1e25]),
        ("wide", [-9e29, 9e29, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
        ("lost", [-1e30; 8]),
        ("narrow", [0.0, 1e-30, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ] {
        let file = format!("{name}_2x2x2_float64.raw");
        std::fs::write(f.join(&file), values.map(f64::to_le_bytes).concat()).unwrap();
        for more in [&[][..], &["--transfer", "magma_r"], &["--window", "p50,1e16"]] {
            json(f, &[&["transfer", &file, "-o", "a.png", "--size", "320x180"], more].concat());
            assert_eq!(read_image(&f.join("a.png")).unwrap().width(), 320);
        }
    }
}

#[test]
fn what_cannot_be_written_or_shown_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("bad.vp"), "1\n1\n0.7\n").unwrap();
    std::fs::write(f.join("bad.csv"), "0,0,0,0,0\n1,2\n").unwrap();
    std::fs::write(f.join("bad.txt"), "nothing of the kind").unwrap();
    for (arguments, code, words) in [
        ("transfer builtin:cube@4 -o a.doc", 2, ["a.doc", ".vp.json"]),
        ("transfer builtin:cube@4 -o missing/a.csv", 1, ["missing", "a.csv"]),
        ("transfer builtin:cube@4 -o a.png --size 100x100", 2, ["100x100", "--size WxH"]),
        ("transfer builtin:cube@4 --transfer pink_r", 2, ["pink_r", "inferno"]),
        ("transfer builtin:cube@4 --transfer bad.vp -o a.json", 1, ["bad.vp", "nine lines"]),
        ("transfer builtin:cube@4 --transfer bad.csv -o a.json", 1, ["bad.csv", "line 2"]),
        ("transfer builtin:cube@4 --transfer bad.txt", 1, ["bad.txt", "ParaView"]),
        ("transfer builtin:cube@4 --transfer bad.csv#x", 1, ["bad.csv", "no preset"]),
        ("transfer builtin:cube@4 --preset ct-brain", 2, ["ct-brain", "ct-lung"]),
        ("transfer builtin:cube@4 --palette pink", 2, ["pink", "vivid"]),
        ("transfer builtin:cube@4 --palette calm --transfer fire", 2, ["--palette", "--transfer"]),
        ("transfer --list -o a.png", 2, ["--list", "--output"]),
    ] {
        refused(f, &arguments.split(' ').collect::<Vec<_>>(), code, &words);
    }
    assert_eq!(FileFormat::from_path(Path::new("x.VP.JSON")).unwrap(), FileFormat::SlicerJson);
}
