//! The command: output and written files.

mod refused;
mod verbose;

use crate::common::command::*;

#[test]
fn render_writes_pictures_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let small = ["render", "builtin:hydrogen@24", "--size", "40x30", "--azimuth", "30", "--elevation", "-35"];
    let with = |more: &[&'static str]| [&small[..], more].concat();
    let rendered = json(f, &with(&["-o", "a.npy"]));
    assert_eq!((rendered["width"].as_u64(), rendered["height"].as_u64()), (Some(40), Some(30)));
    json(f, &with(&["-o", "a.png"]));
    json(f, &with(&["-o", "clear.png", "--background", "transparent"]));
    json(f, &with(&["-o", "white.npy", "--background", "white"]));
    assert_eq!(names(f), ["a.npy", "a.png", "clear.png", "white.npy"]);
    let bare = layersplat::image::read_image(&f.join("a.npy")).unwrap();
    let black = layersplat::image::read_image(&f.join("a.png")).unwrap();
    let clear = layersplat::image::read_image(&f.join("clear.png")).unwrap();
    let white = layersplat::image::read_image(&f.join("white.npy")).unwrap();
    assert!(bare.pixels().iter().any(|p| p[3] > 0.1 && p[3] < 0.9) && bare.pixel(0, 0) == [0.0; 4]);
    assert!(black.pixels().iter().all(|p| p[3] == 1.0) && white.pixel(0, 0) == [1.0; 4]);
    assert!(clear.compare(&bare).unwrap().max_difference < 1.01 / 255.0);
    let comparison = json(f, &["compare", "a.npy", "clear.png"]);
    assert_eq!(keys(&comparison), ["max_difference", "psnr", "psnr_rgba", "roughness"]);
    let same = json(f, &["compare", "a.npy", "a.npy"]);
    assert!(same["psnr"].is_null() && same["psnr_rgba"].is_null() && same["max_difference"] == 0.0);
    assert_eq!(layersplat(f, &["compare", "a.npy", "white.npy", "--max-difference", "0.5"]).status.code(), Some(1));
    assert_eq!(layersplat(f, &["compare", "a.npy", "white.npy", "--min-psnr", "20"]).status.code(), Some(1));
    assert_eq!(layersplat(f, &["compare", "a.npy", "clear.png", "--min-psnr", "40"]).status.code(), Some(0));
    assert_eq!(layersplat(f, &["compare", "a.npy", "white.npy", "--tolerance", "0.5", "-o", "d.npy"]).status.code(), Some(1));
    let difference = layersplat::image::read_image(&f.join("d.npy")).unwrap();
    assert_eq!(difference, bare.difference(&white).unwrap());
    assert_eq!(difference.pixel(0, 0), [1.0; 4]);
}

#[test]
fn every_quality_and_switch_renders() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for more in [
        "--quality draft",
        "--quality standard",
        "--quality high",
        "--quality paper",
        "--lattice direct",
        "--lattice 3",
        "--correction none",
        "--correction constant",
        "--classification post",
        "--classification post --sublayers 5",
        "--classification preintegrated --sublayers 3",
        "--quality high --kernel catmull-rom",
        "--algorithm raycast --kernel catmull-rom",
        "--quality paper --kernel cubic",
        "--quality draft --classification post",
        "--quality high --classification post",
        "--quality paper --classification preintegrated --footprints exact",
        "--perspective 30 --classification preintegrated --sublayers 2",
        "--correction sublayers",
        "--extinction linear",
        "--shading off",
        "--early-termination off",
        "--layer-axis z",
        "--lattice direct --footprints set",
        "--quality paper --lattice auto",
        "--perspective 40",
        "--perspective 90 --distance 3",
        "--perspective 30 --quality paper",
        "--parallel-scale 3",
        "--center -1,2,3",
        "--roll -20",
        "--unit-distance 2",
        "--spacing 1,2,5",
        "--transfer fire",
        "--transfer viridis --transfer-range -5,200",
        "--transfer cool-warm --background #204060",
        "--transfer grey",
    ] {
        let base = ["render", "builtin:marschner-lobb@16x12x14", "--size", "24x24", "-o", "a.png", "--elevation", "10"];
        json(f, &[&base[..], &more.split(' ').collect::<Vec<_>>()].concat());
    }
}

#[test]
fn info_rotate_devices_and_bench() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let info = json(f, &["info", "builtin:cube@3x4x5"]);
    let placed = [
        "anatomy",
        "are_colors",
        "bounds",
        "channel",
        "channel_descriptions",
        "channels",
        "dims",
        "direction",
        "effective_splats",
    ];
    let several = [
        "frame",
        "frame_spacing",
        "frame_unit",
        "frames",
        "histogram",
        "labels",
        "length_unit",
        "level",
        "levels",
        "magnitude",
        "max",
        "mean",
        "min",
        "missing",
    ];
    let others = ["origin", "spacing", "spacing_is_assumed", "transfer", "type", "up", "up_reason"];
    assert_eq!(keys(&info), [&placed[..], &several, &others].concat());
    assert_eq!((&info["channels"], &info["frames"], &info["levels"]), (&1.into(), &1.into(), &serde_json::json!([[3, 4, 5]])));
    assert_eq!(
        (&info["dims"], &info["bounds"]),
        (&serde_json::json!([3, 4, 5]), &serde_json::json!([[0.0, 0.0, 0.0], [2.0, 3.0, 4.0]]))
    );
    assert_eq!((&info["spacing_is_assumed"], &info["up"]), (&false.into(), &"y".into()));
    assert!(info["effective_splats"].is_null() && info["type"] == "uint8" && info["mean"] == 255.0);
    assert_eq!(json(f, &["info", "builtin:cube@3x4x5", "--transfer", "grey"])["effective_splats"], 60);
    json(f, &["rotate", "builtin:hydrogen@16", "--frames", "3", "--size", "16x16", "-o", "turn"]);
    assert_eq!(names(&f.join("turn")), ["frame_0000.png", "frame_0001.png", "frame_0002.png"]);
    assert!(!json(f, &["devices"])["devices"].as_array().unwrap().is_empty());
    let bench = json(f, &["bench", "builtin:hydrogen@16", "--frames", "3", "--size", "32x32"]);
    let expected = [
        "active_samples",
        "algorithm",
        "axis_change_ms",
        "cpu_ms",
        "device",
        "device_bytes",
        "effective_splats",
        "first_ms",
        "frames",
        "lattice",
        "max_ms",
        "median_ms",
        "min_ms",
        "peak_bytes",
        "quality",
        "stages",
        "transfer_change_cpu_ms",
        "transfer_change_ms",
        "volume",
    ];
    assert_eq!(keys(&bench), expected);
    assert!(bench["active_samples"].as_u64().unwrap() > 0 && bench["median_ms"].as_f64().unwrap() > 0.0);
    assert!(bench["stages"]["lattice"].as_f64().unwrap() > 0.0);
    assert_eq!(keys(&bench["lattice"]), ["height", "samples_per_voxel", "width"]);
}

/// The default framing fits the visible part, for all picture shapes and both projections. `--fit volume` restores the old framing.
#[test]
fn pictures_fit_what_is_visible() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let covered = |options: &str| {
        let base = ["render", "builtin:hydrogen@64", "--transfer", "fire", "--azimuth", "30", "-o", "a.npy"];
        json(f, &[&base[..], &options.split_whitespace().collect::<Vec<_>>()].concat());
        let frame = layersplat::image::read_image(&f.join("a.npy")).unwrap();
        let visible = |x, y| frame.pixel(x, y)[3] > 0.002;
        let columns = (0..frame.width()).filter(|&x| (0..frame.height()).any(|y| visible(x, y))).count();
        let rows = (0..frame.height()).filter(|&y| (0..frame.width()).any(|x| visible(x, y))).count();
        let edge = |x: u32, y: u32| x == 0 || y == 0 || x + 1 == frame.width() || y + 1 == frame.height();
        let at_edge = (0..frame.width()).any(|x| (0..frame.height()).any(|y| edge(x, y) && visible(x, y)));
        (columns as f64 / f64::from(frame.width()), rows as f64 / f64::from(frame.height()), at_edge)
    };
    for size in ["120x120", "60x200", "200x60"] {
        for projection in ["", "--perspective 30", "--perspective 90"] {
            let (across, down, at_edge) = covered(&format!("--size {size} {projection}"));
            assert!(across.max(down) > 0.5, "{size} {projection}: {across}, {down}");
            assert!(!at_edge, "{size} {projection}: cut off");
            let (of_volume, ..) = covered(&format!("--size {size} {projection} --fit volume"));
            assert!(of_volume < across, "{size} {projection}: {of_volume}, {across}");
        }
    }
}

#[test]
fn pictures_as_different_as_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (name, background) in [("black.npy", "black"), ("white.npy", "white")] {
        let empty = ["render", "builtin:cube@2", "--size", "2x2", "--center", "99,0,0", "--parallel-scale", "1"];
        json(f, &[&empty[..], &["-o", name, "--background", background]].concat());
    }
    let output = layersplat(f, &["compare", "black.npy", "white.npy"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("PSNR RGB        0.00 dB"), "{text}");
    assert!(json(f, &["compare", "black.npy", "white.npy"])["psnr"].as_f64().unwrap().is_sign_positive());
}

#[test]
fn the_first_picture_is_neither_black_nor_solid() {
    let folder = tempfile::tempdir().unwrap();
    for volume in ["builtin:hydrogen@40", "builtin:marschner-lobb@40"] {
        json(folder.path(), &["render", volume, "-o", "a.npy", "--size", "64x64", "--azimuth", "30", "--elevation", "20"]);
        let frame = layersplat::image::read_image(&folder.path().join("a.npy")).unwrap();
        let mean = frame.pixels().iter().map(|p| f64::from(p[3])).sum::<f64>() / 4096.0;
        assert!((0.01..0.6).contains(&mean), "{volume}: mean opacity {mean}");
    }
}

/// Shell completions and manual pages are generated from the options.
#[test]
fn completions_and_manual_pages() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for shell in ["bash", "zsh", "fish"] {
        let script = String::from_utf8(layersplat(f, &["completions", shell]).stdout).unwrap();
        assert!(script.contains("layersplat") && script.contains("azimuth"), "{shell}");
    }
    assert_eq!(layersplat(f, &["completions", "cmd"]).status.code(), Some(2));
    assert!(layersplat(f, &["man", "-o", "pages"]).status.success());
    let pages = names(&f.join("pages"));
    assert!(pages.contains(&"layersplat.1".into()) && pages.contains(&"layersplat-render.1".into()), "{pages:?}");
    let page = std::fs::read_to_string(f.join("pages/layersplat-render.1")).unwrap();
    assert!(page.contains("azimuth") && page.contains("Examples"));
}

/// Every command has examples in its help.
#[test]
fn help_has_examples() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let text = |arguments: &[&str]| String::from_utf8(layersplat(f, arguments).stdout).unwrap();
    let all = text(&["--help"]);
    for command in [
        "render",
        "rotate",
        "views",
        "slice",
        "info",
        "transfer",
        "convert",
        "devices",
        "compare",
        "bench",
        "tune",
        "paper",
        "completions",
        "man",
    ] {
        assert!(all.contains(command), "{command}");
        assert!(text(&[command, "--help"]).contains(&format!("Examples:\n  layersplat {command}")), "{command}");
    }
}

/// The command line is in the picture's metadata unless that is refused.
#[test]
fn pictures_say_which_command_made_them() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let command = ["render", "builtin:hydrogen@16", "--size", "24", "--background", "#204060", "-o", "a b.png"];
    assert!(layersplat(f, &command).status.success());
    let holds = |text: &str| std::fs::read(f.join("a b.png")).unwrap().windows(text.len()).any(|part| part == text.as_bytes());
    assert!(holds("layersplat render builtin:hydrogen@16 --size 24 --background '#204060' -o 'a b.png'"));
    assert!(layersplat(f, &[&command[..], &["--no-metadata"]].concat()).status.success());
    assert!(!holds("layersplat"));
}

/// A picture that cannot be written fails before the volume is read.
#[test]
fn unwritable_pictures_are_found_first() {
    let folder = tempfile::tempdir().unwrap();
    let done = layersplat(folder.path(), &["render", "missing.nrrd", "-o", "nowhere/a.png"]);
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.code() == Some(1) && said.contains("the folder nowhere does not exist"), "{said}");
}

/// Empty and uniform pictures are explained with a remedy; others are not.
#[test]
fn pictures_of_nothing_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let said = |more: &str| {
        let arguments: Vec<&str> = "render builtin:hydrogen@16 --size 24x24".split(' ').chain(more.split_whitespace()).collect();
        let done = layersplat(f, &arguments);
        assert!(done.status.success(), "{more}");
        String::from_utf8(done.stderr).unwrap()
    };
    assert!(!said("").contains("empty") && !said("").contains("one colour"));
    for (more, reason) in [
        ("--transfer-range 5000,6000", "--transfer-range 0,"),
        ("--blend iso --iso 9000", "no surface at 9000"),
        ("--clip 0,0,0,-1,-1,-1", "clipped away"),
        ("--parallel-scale 1 --center 900,900,900", "--fit visible"),
        ("--blend maximum --parallel-scale 1 --center 900,900,900", "--fit volume"),
        ("--blend maximum --parallel-scale 0.01 --transfer grey --transfer-range 5000,6000", "one colour"),
        ("--crop 0:2,0:2,0:2 --iso 200", "clipped away"),
        ("--spacing 1,1,50", "50 times"),
        ("--parallel-scale 1e9", "smaller than a pixel; try --parallel-scale 1.299e1"),
    ] {
        assert!(said(more).contains(reason), "{more}: {}", said(more));
    }
    let empty = ["render", "builtin:hydrogen@16", "--size", "24x24", "--transfer-range", "5000,6000", "--fail-empty"];
    assert_eq!(layersplat(f, &empty).status.code(), Some(1));
    assert_eq!(layersplat(f, &[&empty[..4], &empty[6..]].concat()).status.code(), Some(0));
    // A range of values cannot help where there is one value.
    std::fs::write(f.join("flat_4x4x4_uint8.raw"), [0; 64]).unwrap();
    for (volume, remedy) in [("builtin:hydrogen@1", "builtin:hydrogen@64"), ("flat_4x4x4_uint8.raw", "--opacity 0:0.5")] {
        let render = |more: &[&str]| {
            let done = layersplat(f, &[&["render", volume, "--size", "24x24"], more].concat());
            (done.status.success(), String::from_utf8(done.stderr).unwrap())
        };
        let (_, said) = render(&[]);
        assert!(said.contains("all voxels have the value") && said.contains(remedy), "{volume}: {said}");
        assert!(!said.contains("--transfer-range"), "{volume}: {said}");
        if let Some(opacity) = remedy.strip_prefix("--opacity ") {
            let (drawn, said) = render(&["--opacity", opacity]);
            assert!(drawn && !said.contains("empty"), "{said}");
        }
    }
}

/// Odd volumes give a picture that shows something, or a sentence that says why not. Each is a NumPy array of float32.
#[test]
fn odd_values_are_shown_or_explained() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    const SIDE: usize = 8;
    let ball = |height: f32| {
        move |i: usize| {
            let square = |n: usize| (n as f32 - 3.5).powi(2);
            if square(i % SIDE) + square(i / SIDE % SIDE) + square(i / SIDE / SIDE) < 9.0 { height } else { 0.0 }
        }
    };
    let cube: &[u64] = &[SIDE as u64; 3];
    type Values = Box<dyn Fn(usize) -> f32>;
    let volumes: [(&str, &[u64], Values, Option<&str>); 12] = [
        ("one", &[1, 1, 1], Box::new(|_| 5.0), None),
        ("thin", &[1, 8, 8], Box::new(|i| i as f32), None),
        ("line", &[1, 1, 8], Box::new(|i| i as f32), None),
        ("constant", cube, Box::new(|_| 7.0), None),
        ("huge", cube, Box::new(ball(9e29)), None),
        ("tiny", cube, Box::new(ball(1e-30)), None),
        ("mask", cube, Box::new(ball(1.0)), None),
        ("labels", cube, Box::new(|i| (i % 6) as f32), None),
        ("noise", cube, Box::new(|i| (i * 7919 % 256) as f32), None),
        ("nan", cube, Box::new(|_| f32::NAN), Some("no voxel is a finite number")),
        ("infinite", cube, Box::new(|_| f32::INFINITY), Some("no voxel is a finite number")),
        ("denormal", cube, Box::new(ball(1e-42)), None),
    ];
    for (name, shape, value, sentence) in volumes {
        let count: u64 = shape.iter().product();
        let bytes: Vec<u8> = (0..count as usize).flat_map(|n| value(n).to_le_bytes()).collect();
        let [z, y, x] = *shape else { panic!("three axes") };
        let source = format!("{name}_{x}x{y}x{z}_float32.raw");
        std::fs::write(f.join(&source), bytes).unwrap();
        for blend in ["composite", "maximum"] {
            let view = ["--size", "24x24", "--azimuth", "30", "--elevation", "20", "-o", "a.npy"];
            let done = layersplat(f, &[&["render", &source, "--blend", blend][..], &view].concat());
            let said = String::from_utf8(done.stderr).unwrap();
            let single = (name == "one" && blend == "maximum").then_some("has a single one");
            if let Some(sentence) = sentence.or(single) {
                assert!(said.contains(sentence), "{name}, {blend}: {said}");
                continue;
            }
            assert!(done.status.success(), "{name}, {blend}: {said}");
            let picture = layersplat::image::read_image(&f.join("a.npy")).unwrap();
            let shown = picture.pixels().iter().filter(|p| p[0].max(p[1]).max(p[2]) > 0.05).count();
            assert!(shown > 5 && !said.contains("empty"), "{name}, {blend}: {shown} pixels; {said}");
        }
    }
}
