//! Every option of `layersplat render`: the command's picture is bit-identical to that of the library with the same settings, and differs
//! from the picture without the option.

mod rows;
mod scene;

use crate::common::command::*;
use crate::common::{compare, device, random_bytes};
use layersplat::image::read_image;
use layersplat::{Background, Device, DeviceChoice, Frame};
use rows::{QUALITIES, Row, SCENES, UNCHANGED};
use scene::Scene;
use std::path::Path;
use std::sync::OnceLock;
use tempfile::TempDir;

/// Least effect of an option on its picture.
const TELLING: f64 = 0.002;
/// Least effect of early termination, at a transmittance of 1/4096.
const TELLING_TERMINATION: f64 = 1e-6;

const VOLUME: &str = "plain_14x12x10_uint8.raw";
const WIDE_VOLUME: &str = "wide_14x12x10_uint16.raw";
/// The same volume without its last slice.
const SLICE_LESS: &str = "less_14x12x9_uint8.raw";
/// Bytes of a slice.
const HEADER: u64 = 14 * 12;
/// First and last colour of a preset, with different channels.
const SECOND: [[f64; 3]; 2] = [[1.0, 0.5, 0.0], [0.25, 0.75, 0.875]];

/// The files that the table names, written once.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let made = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        let bytes = random_bytes([14, 12, 10], 7);
        write(VOLUME, &bytes);
        write(SLICE_LESS, &bytes[..bytes.len() - HEADER as usize]);
        // The lower byte matters in the other byte order.
        let wide: Vec<u8> = bytes.iter().enumerate().flat_map(|(n, &b)| [(n * 37 % 251) as u8, b]).collect();
        write(WIDE_VOLUME, &wide);
        let [[r, g, b], [s, h, c]] = SECOND;
        let presets = format!(
            r#"[{{"Name": "first", "RGBPoints": [0,0.1,0.9,0.5, 255,0.7,0.2,1], "Points": [0,0,0.5,0, 255,0.4,0.5,0]}},
                {{"Name": "second", "RGBPoints": [20,{r},{g},{b}, 200,{s},{h},{c}], "Points": [60,0,0.5,0, 180,0.8,0.5,0]}}]"#
        );
        write("two.json", presets.as_bytes());
        let header =
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
        write("sphere.ply", format!("{header}7 6 4\n").as_bytes());
        folder
    });
    made.path()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split_whitespace()
}

/// Picture of the command.
fn rendered(scene: &Scene, arguments: &str) -> Frame {
    let output = tempfile::Builder::new().suffix(".npy").tempfile_in(folder()).unwrap();
    let mut all = vec!["render"];
    // The default volume need not be named.
    all.extend(Some(scene.source).filter(|&source| source != "builtin:hydrogen"));
    all.extend(["-o", output.path().to_str().unwrap()]);
    for (option, default) in [("--size", "36x28"), ("--transfer", "fire")] {
        // These replace the transfer function.
        let instead =
            option == "--transfer" && words(arguments).any(|word| ["--palette", "--preset", "--iso-color"].contains(&word));
        if !instead && !words(arguments).any(|word| word == option) {
            all.extend([option, default]);
        }
    }
    all.extend(words(arguments));
    let done = layersplat(folder(), &all);
    assert!(done.status.success(), "{arguments}: {}", String::from_utf8_lossy(&done.stderr));
    read_image(output.path()).unwrap()
}

/// Checks rows of the table.
fn check(rows: &[Row]) {
    for Row { option, beside: (others, before), given: (given, change) } in rows {
        let mut scene = Scene::default();
        before(&mut scene);
        let without = scene.frame(folder());
        change(&mut scene);
        let with = scene.frame(folder());
        // A repeated --transfer would be rejected; clip planes, lights and peaks may be repeated.
        let several = ["--clip", "--light", "--tent"].contains(option);
        let others = if words(others).next() == Some(option) && !several { "" } else { others };
        let found = rendered(&scene, &format!("{others} {given}"));
        assert!(found == with, "{others} {given}: not the library's picture");
        if with.width() == without.width() {
            let telling = if *option == "--early-termination" { TELLING_TERMINATION } else { TELLING };
            let difference = compare(&with, &without).max_difference;
            assert!(difference > telling, "{others} {given}: differs by {difference} only from the picture without {option}");
        }
    }
}

#[test]
fn volumes_transfer_functions_and_cameras() {
    check(SCENES);
}

#[test]
fn qualities_and_algorithms() {
    let (half, others) = QUALITIES.split_at(QUALITIES.len() / 2);
    // Two commands at a time, because startup dominates.
    std::thread::scope(|scope| {
        scope.spawn(|| check(half));
        check(others);
    });
}

/// A new option requires a row.
#[test]
fn the_table_has_every_option() {
    let help = String::from_utf8(layersplat(folder(), &["render", "--help"]).stdout).unwrap();
    let listed = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let listed = listed.map(|line| words(line).find_map(|word| word.strip_prefix("--")).expect("a long name"));
    // Dots mark options that may be repeated, and brackets values that may be omitted.
    let plain = |name: &str| name.trim_end_matches('.').split('[').next().unwrap_or(name).to_owned();
    let mut listed: Vec<String> = listed.map(|name| format!("--{}", plain(name))).collect();
    assert!(help.contains("[VOLUME]") && listed.len() > 30, "{help}");
    listed.push("VOLUME".into());
    let mut rows: Vec<&str> = SCENES.iter().chain(QUALITIES).map(|row| row.option).collect();
    rows.extend(UNCHANGED.iter().map(|&(option, _)| option));
    listed.sort();
    rows.sort_unstable();
    rows.dedup();
    assert_eq!(listed, rows);
}

/// Without options: the automatic transfer function, on opaque black, with the default file name.
#[test]
fn the_default_picture() {
    let place = tempfile::tempdir().unwrap();
    let volume = folder().join(VOLUME);
    let done = layersplat(place.path(), &["render", volume.to_str().unwrap()]);
    assert!(done.status.success() && names(place.path()) == ["layersplat.png"]);
    let picture = image::open(place.path().join("layersplat.png")).unwrap().into_rgba8();
    let scene = Scene { transfer: scene::Transfer::Automatic, size: crate::common::viewport(512, 512), ..Scene::default() };
    let expected = scene.frame(folder()).to_rgba8(Background::BLACK);
    assert!(picture.as_raw()[..] == expected[..], "not the library's picture");
}

/// Content of reports. Requesting a report, or naming the default device, does not change the picture.
#[test]
fn reports_and_devices() {
    let scene = Scene::default();
    let plain = scene.frame(folder());
    let own = device().info().index.expect("it is listed").to_string();
    assert!(rendered(&scene, &format!("--device {own}")) == plain && rendered(&scene, "--json") == plain);
    for info in Device::list().unwrap() {
        let report =
            json(folder(), &["render", VOLUME, "--size", "8x8", "-o", "d.npy", "--device", &info.index.unwrap().to_string()]);
        assert_eq!(report["device"].as_str(), Some(info.name.as_str()));
        assert_eq!((&report["output"], &report["width"]), (&"d.npy".into(), &8.into()));
        // Part of a name, in upper case.
        let part = info.name.to_uppercase();
        let named = Device::open(&DeviceChoice::Named(part.clone())).unwrap();
        let report = json(folder(), &["render", VOLUME, "--size", "8x8", "-o", "d.npy", "--device", &part]);
        assert_eq!(report["device"].as_str(), Some(named.info().name.as_str()));
    }
}

/// Volumes beyond the memory limit are streamed, with the same picture; memory use is announced and reported.
#[test]
fn memory() {
    // A separate folder, because other tests write files while this one checks for leftovers.
    let folder = tempfile::tempdir().unwrap();
    const SIGNAL: &str = "builtin:marschner-lobb@100";
    let frame = |name: &str, more: &[&str]| {
        let all = [&["render", SIGNAL, "--size", "36x28", "--transfer", "fire", "-o", name], more].concat();
        let report = json(folder.path(), &all);
        (read_image(&folder.path().join(name)).unwrap(), report, layersplat(folder.path(), &all))
    };
    let (whole, plain, _) = frame("whole.npy", &[]);
    let (streamed, report, told) = frame("streamed.npy", &["--memory", "700KiB"]);
    assert!(streamed == whole && plain["stream"].is_null(), "{plain}");
    // Samples between two parts may count for both.
    let active = [&report, &plain].map(|report| report["active_samples"].as_f64().unwrap());
    assert!((1.0..1.05).contains(&(active[0] / active[1])) && report["lattice"] == plain["lattice"], "{active:?}");
    let stream = &report["stream"];
    let number = |key: &str| stream[key].as_u64().unwrap_or_else(|| panic!("{key}: {stream}"));
    assert!(stream["lattices"][0]["parts"].as_u64() > Some(1) && stream["lattices"][0]["axis"] == "z", "{stream}");
    assert!(number("peak_device_bytes") <= number("device_bytes") && number("device_bytes") <= number("memory"), "{stream}");
    assert_eq!((number("memory"), number("volume_bytes")), (700 << 10, 1_000_000));
    assert!(number("voxel_bytes") > 1_000_000 && stream["first_pass_ms"].as_f64() < report["first_ms"].as_f64(), "{report}");
    let told = String::from_utf8(told.stderr).unwrap();
    for words in ["716800 bytes on the device", "parts of up to", "passes over the volume", "the first pass"] {
        assert!(told.contains(words), "{told} does not say '{words}'");
    }
    refused(folder.path(), &["render", SIGNAL, "--memory", "100K", "-o", "no.npy"], 2, &["at least", "102400", "--memory BYTES"]);
    refused(folder.path(), &["render", SIGNAL, "--memory", "many", "-o", "no.npy"], 2, &["--memory", "512M"]);
    let rays = ["render", SIGNAL, "--memory", "700K", "--algorithm", "raycast", "-o", "no.npy"];
    refused(folder.path(), &rays, 2, &["whole volume", "--memory BYTES"]);
}

/// A render beyond the time limit is aborted without a file. Within the limit it is bit-identical, also when streamed.
#[test]
fn a_time_limit() {
    let plain = Scene::default().frame(folder());
    assert!(rendered(&Scene::default(), "--time-limit 3600") == plain);
    assert!(rendered(&Scene::default(), "--time-limit 1e3 --memory 64M") == plain);
    let empty = tempfile::tempdir().unwrap();
    let late = |limit, more| {
        let all = format!("render builtin:cube@16 --size 8x8 -o late.npy --time-limit {limit} {more}");
        let place = empty.path();
        move |code, said: &[&str]| refused(place, &words(&all).collect::<Vec<_>>(), code, said)
    };
    for more in ["", "--memory 64M"] {
        late("1e-9", more)(1, &["longer than its limit of 1ns", "--time-limit SECONDS"]);
    }
    for wrong in ["0", "-1", "soon", "1e300"] {
        late(wrong, "")(2, &["--time-limit", wrong]);
    }
}
