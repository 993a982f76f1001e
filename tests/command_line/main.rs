//! The command: what it prints, what it writes, and how it refuses.

mod common;

use common::Random;
use common::command::*;
use std::process::Command;

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
    assert_eq!(keys(&comparison), ["max_difference", "psnr", "psnr_rgba"]);
    let same = json(f, &["compare", "a.npy", "a.npy"]);
    assert!(same["psnr"].is_null() && same["psnr_rgba"].is_null() && same["max_difference"] == 0.0);
    assert_eq!(layersplat(f, &["compare", "a.npy", "white.npy", "--max-difference", "0.5"]).status.code(), Some(1));
    assert_eq!(layersplat(f, &["compare", "a.npy", "white.npy", "--min-psnr", "20"]).status.code(), Some(1));
    assert_eq!(layersplat(f, &["compare", "a.npy", "clear.png", "--min-psnr", "40"]).status.code(), Some(0));
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
    assert_eq!(keys(&info), ["dims", "effective_splats", "histogram", "max", "mean", "min", "spacing", "transfer", "type"]);
    assert_eq!(info["dims"], serde_json::json!([3, 4, 5]));
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
        "transfer_change_ms",
        "volume",
    ];
    assert_eq!(keys(&bench), expected);
    assert!(bench["active_samples"].as_u64().unwrap() > 0 && bench["median_ms"].as_f64().unwrap() > 0.0);
    assert!(bench["stages"]["lattice"].as_f64().unwrap() > 0.0);
    assert_eq!(keys(&bench["lattice"]), ["height", "samples_per_voxel", "width"]);
}

/// What is visible fits by default, in every shape of picture and both projections; the old framing is there.
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
fn bad_command_lines_exit_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (more, words) in [
        ("--size 0x5", "size"),
        ("--size 99999x99999", "16384"),
        ("--size 12", "WxH"),
        ("--azimuth NaN", "NaN"),
        ("--elevation inf", "inf"),
        ("--parallel-scale 0", "above 0"),
        ("--parallel-scale -1", "above 0"),
        ("--perspective 0", "180"),
        ("--perspective 180", "180"),
        ("--perspective NaN", "180"),
        ("--perspective 30 --distance -1", "above 0"),
        ("--distance 4", "--perspective"),
        ("--perspective 30 --parallel-scale 2", "cannot be used"),
        ("--spacing 1,0,1", "spacing"),
        ("--spacing 1,NaN,1", "spacing"),
        ("--spacing -1,1,1", "spacing"),
        ("--center 1,2", "X,Y,Z"),
        ("--lattice 0", "lattice"),
        ("--lattice 99", "lattice"),
        ("--sublayers 0", "1 to 16"),
        ("--sublayers 17", "1 to 16"),
        ("--correction none --sublayers 2", "--correction"),
        ("--classification preintegrated --correction none", "--correction"),
        ("--classification preintegrated --footprints set", "--classification post"),
        ("--sublayers 9", "1 to 8"),
        ("--classification ray", "preintegrated"),
        ("--footprints set", "--lattice direct"),
        ("--kernel gaussian", "do not sum to one"),
        ("--kernel sinc", "catmull-rom"),
        ("--kernel linear --classification post", "the paper's cubic"),
        ("--kernel bspline --quality paper", "the paper's cubic"),
        ("--kernel catmull-rom --quality high --correction constant", "the paper's cubic"),
        ("--kernel linear --algorithm slicing", "no meaning for slicing"),
        ("--kernel cubic --algorithm view-sheets", "no meaning for view-sheets"),
        ("--kernel gaussian --algorithm axis-sheets", "no meaning for axis-sheets"),
        ("--quality best", "draft"),
        ("--device nonsense", "nonsense"),
        ("--unit-distance 0", "above 0"),
        ("--background-value NaN", "NaN"),
        ("--background-value 1e31", "1e30"),
        ("--transfer-range 5,5", "LO"),
        ("--transfer-range p50,p20", "LO"),
        ("--transfer-range p90,0", "--transfer-range LO,HI"),
        ("--opacity 5:2", "from 0 to 1"),
        ("--opacity 9:0.1,5:0.2", "sort"),
        ("--opacity p101:1", "p99.5"),
        ("--window 40,0", "LEVEL,WIDTH"),
        ("--window 40,10 --transfer-range 0,1", "--transfer-range"),
        ("--tent 5", "V,WIDTH"),
        ("--tent 1e300,1", "--tent V,WIDTH"),
        ("--blend iso --iso p200", "p100"),
        ("--transfer nonsense", "viridis"),
        ("--layer-axis w", "auto"),
        ("--layer-axis x", "--layer-axis"),
        ("--background pink", "pink"),
        ("--light 0,0,0", "other than 0"),
        ("--light 1,0", "X,Y,Z"),
        ("--light 1,0,0:-1", "0 to 100"),
        ("--light 1,0,0 --light 0,1,0 --light 0,0,1 --light camera --light 1,1,1", "1 to 4 lights"),
        ("--light 1,0,0 --shading off", "--light X,Y,Z"),
        ("-o a.bmp", ".png"),
        ("-o a", ".png"),
        ("--type int128", "int128"),
        ("--dims 0x1x1", "XxYxZ"),
        ("--endian middle", "little"),
        ("--endian big", "--endian"),
        ("--endian little", "built-in"),
    ] {
        let base = ["render", "builtin:cube@4"];
        refused(f, &[&base[..], &more.split(' ').collect::<Vec<_>>()].concat(), 2, &[words]);
    }
    refused(f, &["render", "builtin:sphere"], 2, &["sphere", "hydrogen"]);
    refused(f, &["render", "builtin:cube@0"], 2, &["0"]);
    refused(f, &["render", "builtin:cube@99999"], 2, &["2^33"]);
    refused(f, &["rotate", "builtin:cube@4", "--frames", "0"], 2, &["frames"]);
    refused(f, &["nonsense"], 2, &["nonsense"]);
}

#[test]
fn bad_files_exit_with_1_and_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let write = |name: &str, bytes: &[u8]| std::fs::write(f.join(name), bytes).unwrap();
    write("short_4x4x4_uint8.raw", &[0; 63]);
    write("long_4x4x4_uint8.raw", &[0; 65]);
    write("empty_4x4x4_uint8.raw", &[]);
    write("nodims.raw", &[0; 64]);
    write("notype_4x4x4.raw", &[0; 64]);
    write("odd_4x4x4_complex64.raw", &[0; 64]);
    write("huge_100000x100000x100_uint8.raw.gz", &[0; 64]);
    write("over_99999999999x99999999999x9_uint8.raw", &[0; 64]);
    write("zero_0x4x4_uint8.raw", &[0; 64]);
    write("plain_4x4x4_uint8.raw.gz", &[7; 64]);
    write("picture.txt", b"hello");
    std::fs::create_dir(f.join("folder_4x4x4_uint8.raw")).unwrap();
    for (volume, words) in [
        ("missing_4x4x4_uint8.raw", &["missing_4x4x4"][..]),
        ("short_4x4x4_uint8.raw", &["64", "63"]),
        ("long_4x4x4_uint8.raw", &["64", "65"]),
        ("empty_4x4x4_uint8.raw", &["64", "0"]),
        ("nodims.raw", &["--dims"]),
        ("notype_4x4x4.raw", &["--type"]),
        ("odd_4x4x4_complex64.raw", &["complex64", "uint8"]),
        ("huge_100000x100000x100_uint8.raw.gz", &["1000000000000"]),
        ("plain_4x4x4_uint8.raw.gz", &["plain_4x4x4"]),
        ("picture.txt", &[".raw"]),
        ("folder_4x4x4_uint8.raw", &["folder without", "slices"]),
        ("/dev/null", &["regular"]),
    ] {
        refused(f, &["render", volume, "-o", "a.png"], 1, words);
        refused(f, &["info", volume], 1, words);
    }
    for volume in ["over_99999999999x99999999999x9_uint8.raw", "zero_0x4x4_uint8.raw"] {
        refused(f, &["info", volume], 1, &["dims", volume]);
    }
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    if let Ok(full) = full {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let status = command.args(["info", "builtin:cube@4", "--json"]).stdout(full).output().unwrap().status;
        assert_eq!(status.code(), Some(1), "a report that is lost must not look like success");
    }
    refused(f, &["render", "builtin:cube@4", "-o", "nowhere/a.png"], 1, &["nowhere/a.png"]);
    refused(f, &["render", "builtin:cube@4", "-o", "folder_4x4x4_uint8.raw/../missing/b.npy"], 1, &["cannot write"]);
    refused(f, &["compare", "picture.txt", "picture.txt"], 2, &["picture.txt"]);
}

#[test]
fn pictures_that_cannot_be_compared_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let npy = |shape: &str, numbers: usize| {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(std::iter::repeat_n(1f32.to_le_bytes(), numbers).flatten());
        bytes
    };
    let write = |name: &str, bytes: &[u8]| std::fs::write(f.join(name), bytes).unwrap();
    write("good.npy", &npy("(2, 2, 4)", 16));
    write("small.npy", &npy("(1, 2, 4)", 8));
    write("empty.npy", &npy("(0, 5, 4)", 0));
    write("wide.npy", &npy("(1, 99999, 4)", 8));
    write("huge.npy", &npy("(99999999, 99999999, 4)", 8));
    write("flat.npy", &npy("(2, 2)", 4));
    write("short.npy", &npy("(2, 2, 4)", 15));
    write("text.npy", b"hello");
    write("text.png", b"hello");
    for (bad, word) in [
        ("small.npy", "2x1"),
        ("empty.npy", "5x0"),
        ("wide.npy", "16384"),
        ("huge.npy", "99999999x99999999 pixels"),
        ("flat.npy", "shape"),
        ("short.npy", "float32"),
        ("text.npy", ""),
        ("text.png", ""),
        ("missing.png", "No such file"),
    ] {
        refused(f, &["compare", "good.npy", bad], 1, &[bad, word]);
        refused(f, &["compare", bad, "good.npy"], 1, &[bad]);
    }
    refused(f, &["compare", "good.npy", "good.txt"], 2, &["good.txt"]);
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
fn gzip_truncated_at_any_length_is_refused() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v_9x9x9_uint8.raw.gz");
    let mut random = Random(1);
    let bytes: Vec<u8> = (0..729).map(|_| random.next() as u8).collect();
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(&bytes).unwrap();
    let whole = encoder.finish().unwrap();
    let open = || layersplat::Volume::open(path.to_str().unwrap(), &layersplat::OpenOptions::default());
    std::fs::write(&path, &whole).unwrap();
    assert!(open().is_ok());
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        let message = open().expect_err("truncated").to_string();
        assert!(message.contains("v_9x9x9"), "{length}: {message}");
    }
}

#[test]
fn bad_transfer_functions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (name, text, word) in [
        ("empty.json", r#"{"RGBPoints": [], "Points": []}"#, "no points"),
        ("unsorted.json", r#"{"RGBPoints": [5,0,0,0, 1,0,0,0], "Points": [0,0,0.5,0]}"#, "sorted"),
        ("ragged.json", r#"{"RGBPoints": [5,0,0], "Points": [0,0,0.5,0]}"#, "multiple of 4"),
        ("curved.json", r#"{"RGBPoints": [5,0,0,0], "Points": [0,0,1.2,0]}"#, "midpoint"),
        ("nothing.json", "", "JSON"),
    ] {
        std::fs::write(f.join(name), text).unwrap();
        refused(f, &["render", "builtin:cube@4", "--transfer", name], 1, &[word, name]);
    }
    refused(f, &["render", "builtin:cube@4", "--transfer", "missing.json"], 1, &["missing.json"]);
}

#[test]
fn odd_volumes_render_without_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let floats = [f32::NAN, 1.0, f32::INFINITY, 0.5, -3.0, 2.0, f32::NEG_INFINITY, 4.0];
    std::fs::write(f.join("nan_2x2x2_float32.raw"), floats.map(f32::to_le_bytes).concat()).unwrap();
    std::fs::write(f.join("allnan_2x2x2_float32.raw"), [f32::NAN.to_le_bytes(); 8].concat()).unwrap();
    let output = layersplat(f, &["render", "nan_2x2x2_float32.raw", "-o", "a.png"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && message.contains("3 voxels"), "{message}");
    assert_eq!(json(f, &["info", "nan_2x2x2_float32.raw"])["min"], -3.0);
    for volume in ["allnan_2x2x2_float32.raw", "builtin:cube@1", "builtin:cube@1x1x9", "builtin:hydrogen@300x2x1"] {
        for view in [
            "--elevation 90",
            "--azimuth 45",
            "--azimuth 90 --perspective 150",
            "--size 1x1",
            "--size 3x700",
            "--parallel-scale 1e-6",
            "--parallel-scale 1e9",
            "--perspective 30 --distance 1e-6",
            "--perspective 0.001",
        ] {
            json(f, &[&["render", volume, "-o", "a.png"][..], &view.split(' ').collect::<Vec<_>>()].concat());
        }
    }
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

/// What shells and `man` are told, made from the options that there are.
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

/// Every command shows how it is used, and --verbose tells what is done.
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
    let said = |more: &[&str]| {
        let arguments = [&["info", "builtin:cube@8"][..], more].concat();
        String::from_utf8(layersplat(f, &arguments).stderr).unwrap()
    };
    assert!(!said(&[]).contains("first pass") && said(&["-v"]).contains("first pass"));
}

/// Who gets a black or a solid picture is told why, and what to try; who gets a good one is not.
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
        ("--clip 0,0,0,-1,-1,-1", "cut away"),
        ("--parallel-scale 1 --center 900,900,900", "--fit visible"),
        ("--blend maximum --parallel-scale 1 --center 900,900,900", "--fit volume"),
        ("--blend maximum --parallel-scale 0.01 --transfer grey --transfer-range 5000,6000", "one colour"),
        ("--spacing 1,1,50", "50 times"),
    ] {
        assert!(said(more).contains(reason), "{more}: {}", said(more));
    }
}
