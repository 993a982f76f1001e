//! The command and picture output: formats, supersampling, annotations, contact sheets, image sequences, and many views of one volume.

mod many;
mod time;

use crate::common::command::*;
use crate::common::random_bytes;
use image::AnimationDecoder;
use image::codecs::{gif::GifDecoder, png::PngDecoder};
use layersplat::annotation::Annotations;
use layersplat::image::read_image;
use layersplat::settings::Blend;
use layersplat::{Background, Frame, OpenOptions, TransferFunction, Viewport, Volume};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const NAME: &str = "plain_14x12x10_uint8.raw";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(NAME), random_bytes([14, 12, 10], 7)).unwrap();
    folder
}

/// Runs a command that must succeed.
#[track_caller]
fn done(folder: &Path, arguments: &str) -> Output {
    let output = layersplat(folder, &arguments.split_whitespace().collect::<Vec<_>>());
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn picture(folder: &Path, arguments: &str) -> Frame {
    let transfer = if arguments.contains("--transfer") { "" } else { "--transfer fire" };
    done(folder, &format!("render {NAME} {transfer} -o out.npy {arguments}"));
    read_image(&folder.join("out.npy")).unwrap()
}

/// Every format shows the same picture; float formats have the same numbers.
#[test]
fn formats_show_the_same_picture() {
    /// PSNR of JPEG at edges as sharp as noise, in dB; other pictures are far below.
    const JPEG_PSNR: f64 = 25.0;
    let folder = folder();
    let f = folder.path();
    let floats = picture(f, "--size 40x30");
    for (name, background) in [("a.exr", ""), ("a.png", ""), ("a.png", "--background #204060"), ("a.jpg", "--background #204060")]
    {
        done(f, &format!("render {NAME} --transfer fire --size 40x30 -o {name} {background}"));
        let read = read_image(&f.join(name)).unwrap();
        let stands_on = background.split(' ').nth(1).map_or(Background::BLACK, |color| color.parse().unwrap());
        let expected = if name == "a.exr" { floats.clone() } else { floats.clone().over(stands_on) };
        let comparison = read.compare(&expected).unwrap();
        match name {
            "a.exr" => assert_eq!(comparison.max_difference, 0.0),
            "a.png" => assert!(comparison.max_difference <= 0.5001 / 255.0, "{comparison:?}"),
            _ => assert!(comparison.psnr.unwrap() > JPEG_PSNR, "{comparison:?}"),
        }
    }
    refused(f, &["render", NAME, "-o", "b.jpg", "--background", "transparent"], 2, &["transparency", "--background"]);
    refused(f, &["render", NAME, "-o", "b.bmp"], 2, &[".exr"]);
}

/// N×N samples per pixel equal the average of a picture N times as large.
#[test]
fn samples_are_averaged() {
    /// Rounding of sums of nine floats.
    const ROUNDING: f64 = 1e-6;
    let folder = folder();
    let f = folder.path();
    let camera = "--azimuth 30 --elevation 20 --parallel-scale 9";
    let (fine, averaged) =
        (picture(f, &format!("{camera} --size 60x45")), picture(f, &format!("{camera} --size 20x15 --samples 3")));
    let mean = |n: usize| {
        let (x, y) = (n as u32 % 20 * 3, n as u32 / 20 * 3);
        let pixels: Vec<[f32; 4]> = (0..9).map(|k| fine.pixel(x + k % 3, y + k / 3)).collect();
        [0, 1, 2, 3].map(|c| (pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / 9.0) as f32)
    };
    let by_hand = Frame::new(layersplat::Viewport::new(20, 15).unwrap(), (0..300).map(mean).collect());
    assert!(averaged.compare(&by_hand).unwrap().max_difference < ROUNDING);
    // A single ray per pixel gives another picture.
    let plain = picture(f, &format!("{camera} --size 20x15"));
    assert!(averaged.compare(&plain).unwrap().max_difference > 0.01);
    // Rotations, too.
    done(f, &format!("rotate {NAME} --transfer fire --frames 1 {camera} --size 20x15 --samples 3 -o turn"));
    let turned = read_image(&f.join("turn/frame_0000.png")).unwrap();
    assert!(turned.compare(&by_hand.over(Background::BLACK)).unwrap().max_difference < 0.6 / 255.0);
    for size in ["9000x100", "100x9000"] {
        refused(f, &["render", NAME, "--samples", "2", "--size", size], 2, &["18000", "16384", "--samples"]);
    }
    refused(f, &["render", NAME, "--samples", "17"], 2, &["1 to 16"]);
}

fn frames(path: &Path) -> Vec<Vec<u8>> {
    let reader = BufReader::new(std::fs::File::open(path).unwrap());
    let frames = match path.extension().unwrap().to_str().unwrap() {
        "gif" => GifDecoder::new(reader).unwrap().into_frames(),
        _ => PngDecoder::new(reader).unwrap().apng().unwrap().into_frames(),
    };
    frames.map(|frame| frame.unwrap().into_buffer().into_raw()).collect()
}

fn bytes(path: &Path) -> Vec<u8> {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgba8().into_raw()
}

/// The frames in an animation are those of the image sequence.
#[test]
fn turns_in_one_file() {
    let folder = folder();
    let f = folder.path();
    let turn = format!("rotate {NAME} --transfer fire --frames 5 --size 24x20");
    done(f, &format!("{turn} -o turn"));
    let expected: Vec<Vec<u8>> = (0..5).map(|n| bytes(&f.join(format!("turn/frame_000{n}.png")))).collect();
    for name in ["a.apng", "b.png"] {
        done(f, &format!("{turn} -o {name}"));
        assert!(frames(&f.join(name)) == expected, "{name}");
    }
    done(f, &format!("{turn} -o a.gif --rate 50"));
    // 256 colours for 480 pixels.
    let found = frames(&f.join("a.gif"));
    let far = found.concat().iter().zip(expected.concat()).map(|(a, b)| f64::from(a.abs_diff(b))).sum::<f64>() / 9600.0;
    assert!(found.len() == 5 && far < 2.0, "{far}");
    refused(f, &["rotate", NAME, "-o", "a.gif", "--rate", "51"], 2, &["1 to 50"]);
    refused(f, &["rotate", NAME, "-o", "b.gif", "--background", "transparent"], 2, &[".apng"]);
    refused(f, &["rotate", NAME, "-o", "b.webm"], 2, &[".mp4"]);
    refused(f, &["rotate", NAME, "-o", NAME], 1, &["not a folder"]);
    refused(f, &["rotate", NAME, "-o", "missing/a.gif"], 1, &["missing"]);
}

/// Camera paths: the first and the last frame are those of the outer keys. The number of frames follows from the duration.
#[test]
fn key_cameras() {
    let folder = folder();
    let f = folder.path();
    let keys = r#"[{"time": 1, "azimuth": 10, "parallel_scale": 8}, {"time": 1.2, "azimuth": 80, "parallel_scale": 8},
        {"time": 1.4, "position": [9, 7, 60], "focal_point": [6, 5, 4], "parallel_scale": 5}]"#;
    std::fs::write(f.join("keys.json"), keys).unwrap();
    let rotated =
        json(f, &["rotate", NAME, "--transfer", "fire", "--size", "24x20", "--keys", "keys.json", "--rate", "20", "-o", "way"]);
    assert_eq!(rotated["frames"], 9);
    std::fs::write(
        f.join("one.json"),
        r#"{"output": "last.png", "position": [9, 7, 60], "focal_point": [6, 5, 4], "parallel_scale": 5}"#,
    )
    .unwrap();
    done(f, &format!("render {NAME} --transfer fire --size 24x20 --cameras one.json"));
    let apart = |a: &str, b: &str| {
        let [a, b] = [a, b].map(|name| read_image(&f.join(name)).unwrap());
        a.compare(&b).unwrap().max_difference
    };
    assert!(apart("last.png", "way/frame_0008.png") < 2.0 / 255.0);
    assert!(apart("way/frame_0000.png", "way/frame_0008.png") > 0.1 && apart("way/frame_0000.png", "way/frame_0001.png") > 0.01);
    for (keys, words) in [
        ("[]", "at least 2"),
        ("{}", "not a JSON list"),
        (r#"[{"time": 0}, {"azimuth": 3}]"#, "key 2: it has no time"),
        (r#"[{"time": 0}, {"time": 0}]"#, "key 2: its time, 0, is not after 0"),
        (r#"[{"time": 0}, {"time": 1, "zoom": 3}]"#, "key 2: unknown field `zoom`"),
        (r#"[{"time": 0}, {"time": 1, "perspective": 30}]"#, "all parallel"),
    ] {
        std::fs::write(f.join("bad.json"), keys).unwrap();
        refused(f, &["rotate", NAME, "--keys", "bad.json", "-o", "bad"], 1, &["bad.json", words]);
    }
    std::fs::write(f.join("long.json"), r#"[{"time": 0}, {"time": 1e9}]"#).unwrap();
    refused(f, &["rotate", NAME, "--keys", "long.json", "-o", "bad"], 2, &["100000"]);
}

/// A replacement for `ffmpeg`: its input, and the handling of its failures.
#[cfg(unix)]
#[test]
fn films_are_made_by_ffmpeg() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let f = folder.path();
    let bin = f.join("bin");
    std::fs::create_dir(&bin).unwrap();
    let with = |script: &str, output: &str| {
        let ffmpeg = bin.join("ffmpeg");
        std::fs::write(&ffmpeg, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&ffmpeg, PermissionsExt::from_mode(0o755)).unwrap();
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let turn = ["rotate", NAME, "--transfer", "fire", "--frames", "3", "--size", "25x20", "-o", output];
        command.current_dir(f).env("PATH", path).args(turn).output().unwrap()
    };
    // The last argument is the file, which receives the pixels.
    let kept = with(r#"echo "$@" > arguments; for file; do :; done; cat > "$file""#, "a.mp4");
    assert!(kept.status.success(), "{}", String::from_utf8_lossy(&kept.stderr));
    done(f, &format!("rotate {NAME} --transfer fire --frames 3 --size 25x20 -o turn"));
    let rgb = |n: usize| image::open(f.join(format!("turn/frame_000{n}.png"))).unwrap().into_rgb8().into_raw();
    assert!(std::fs::read(f.join("a.mp4")).unwrap() == (0..3).flat_map(rgb).collect::<Vec<u8>>());
    let arguments = std::fs::read_to_string(f.join("arguments")).unwrap();
    assert!(arguments.contains("-video_size 25x20 -framerate 25") && arguments.contains("yuv420p"), "{arguments}");
    let before = names(f);
    for script in ["cat > /dev/null; echo the codec is missing >&2; exit 3", "echo the codec is missing >&2; exit 3"] {
        let failed = with(script, "b.mp4");
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert!(
            failed.status.code() == Some(1) && message.contains("b.mp4") && message.contains("the codec is missing"),
            "{message}"
        );
        assert_eq!(names(f), before);
    }
    // Without ffmpeg on the PATH.
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    let missing = command.current_dir(f).env("PATH", f.join("nowhere")).args(["rotate", NAME, "-o", "b.mp4"]).output().unwrap();
    let message = String::from_utf8_lossy(&missing.stderr).into_owned();
    assert!(missing.status.code() == Some(1) && message.contains("install") && message.contains(".apng"), "{message}");
    assert_eq!(names(f), before);
}

/// An interrupted animation leaves no file, and keeps an existing one.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_film_leaves_nothing() {
    let folder = folder();
    let f = folder.path();
    std::fs::write(f.join("a.apng"), "old").unwrap();
    let before = names(f);
    let turn = ["rotate", "builtin:cube@4", "--frames", "20000", "--size", "300x300", "-o"];
    for output in ["a.apng", "a.gif"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let mut child = command.current_dir(f).args(turn).arg(output).stderr(Stdio::null()).spawn().unwrap();
        let size = || {
            let entries = std::fs::read_dir(f).unwrap().flatten();
            let temporary = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(".layersplat-"));
            temporary.filter_map(|entry| Some(entry.metadata().ok()?.len())).max().unwrap_or(0)
        };
        while child.try_wait().unwrap().is_none() && size() < 5000 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(names(f).len() == before.len() + 1);
        // Shells may make background processes ignore SIGINT, but not SIGTERM.
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(128 + 15));
        assert_eq!((names(f), std::fs::read(f.join("a.apng")).unwrap()), (before.clone(), b"old".to_vec()), "{output}");
    }
}

/// The cells of a contact sheet are the pictures of its sides at one scale, plus labels.
#[test]
fn contact_sheets_show_every_side() {
    let folder = folder();
    let f = folder.path();
    let camera = "--transfer fire --size 120x100 --parallel-scale 9 --center 6.5,5.5,4.5";
    let arguments = format!("views {NAME} {camera} -o sheet.npy");
    let told = json(f, &arguments.split(' ').collect::<Vec<_>>());
    assert_eq!((&told["width"], &told["height"]), (&480.into(), &200.into()));
    let sides = [(0, 0), (90, 0), (180, 0), (270, 0), (0, 90), (0, -90)];
    let sheet = read_image(&f.join("sheet.npy")).unwrap();
    for (n, (azimuth, elevation)) in sides.into_iter().enumerate() {
        let single = picture(f, &format!("{camera} --azimuth {azimuth} --elevation {elevation}"));
        let (left, top) = (n as u32 % 4 * 120, n as u32 / 4 * 100);
        let place = |n: u32| (n % 120, n / 120);
        let differing = (0..12_000).map(place).filter(|&(x, y)| sheet.pixel(left + x, top + y) != single.pixel(x, y));
        let differing: Vec<_> = differing.collect();
        // Only the label in the upper left corner differs: margin, capitals, descenders, halo.
        assert!(differing.len() > 100 && differing.iter().all(|&(_, y)| y < 8 + 9 + 4 + 1), "{n}: {}", differing.len());
    }
    refused(f, &["views", NAME, "--size", "5000x100"], 2, &["4096x8192", "--size"]);
    refused(f, &["views", NAME, "--from", "left"], 2, &["all sides", "--from front|right|back|left|above|below"]);
}

/// Annotations do not change the picture underneath.
#[test]
fn annotations_are_added_to_the_picture() {
    let folder = folder();
    let f = folder.path();
    let bare = picture(f, "--size 200x160 --fit visible");
    for options in ["--legend", "--box", "--axes", "--legend --units HU --length-units mm"] {
        let annotated = picture(f, &format!("--size 200x160 --fit visible --legend-place over {options}"));
        let differing = annotated.pixels().iter().zip(bare.pixels()).filter(|(a, b)| a != b).count();
        assert!((50..16_000).contains(&differing), "{options}: {differing}");
    }
    refused(f, &["render", NAME, "--units", "HU"], 2, &["--legend"]);
    // Beside the volume, they leave the smaller picture as it is: the legend a column, the axes a strip below.
    let volume = Volume::open(f.join(NAME), &OpenOptions::default()).unwrap();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let legend = Annotations { legend: true, ..Annotations::default() };
    let inner = legend.inner(Viewport::new(200, 160).unwrap(), &transfer, Blend::Composite);
    let small = picture(f, &format!("--size {}x160 --fit visible", inner.width));
    let beside = picture(f, "--size 200x160 --fit visible --legend");
    let inset = |beside: &Frame, small: &Frame| {
        let rows = beside.pixels().chunks_exact(beside.width() as usize).zip(small.pixels().chunks_exact(small.width() as usize));
        rows.into_iter().all(|(beside, small)| beside[..small.len()] == *small)
    };
    assert!(inset(&beside, &small) && !inset(&picture(f, "--size 200x160 --fit visible --legend --legend-place over"), &small));
    // A bounding box of size 0.
    done(f, "render builtin:cube@1 --box --legend --axes --size 100x80 -o one.png");
    let paths: Vec<PathBuf> = ["a.png", "b.png"].map(|name| f.join(name)).into();
    for path in &paths {
        done(f, &format!("render {NAME} --legend --box --axes --size 200x160 -o {}", path.display()));
    }
    assert!(bytes(&paths[0]) == bytes(&paths[1]));
}
