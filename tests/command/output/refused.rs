//! Errors of the command; it must never panic.

use crate::common::Random;
use crate::common::command::*;
use std::process::Command;

#[test]
fn bad_command_lines_exit_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (more, words) in [
        ("--size 0x5", "size"),
        ("--size 99999x99999", "16384"),
        ("--size 12x", "WIDTHxHEIGHT"),
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
        ("--parallel-scale 1e300", "scale is 1e300: expected between 1e-30 and 1e30"),
        ("--parallel-scale 1e-300", "scale is 1e-300: expected between 1e-30 and 1e30"),
        ("--up w", "possible values: x, -x, y, -y, z, -z"),
        ("--from beside", "possible values: front, right, back, left, above, below"),
        ("--from left --azimuth 3", "cannot be used"),
        ("--from above --elevation 3", "cannot be used"),
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
        ("--iso 3 --iso-color white --transfer fire", "both colour the surface"),
        ("--iso-color white", "add --iso V"),
        ("--mip --iso 3", "omit --iso"),
        ("--transfer nonsense", "viridis"),
        ("--layer-axis w", "auto"),
        ("--azimuth 0 --layer-axis x", "--layer-axis"),
        ("--background pink", "pink"),
        ("--light 0,0,0", "other than 0"),
        ("--light 1,0", "X,Y,Z"),
        ("--light 1,0,0:-1", "0 to 100"),
        ("--light 1,0,0 --light 0,1,0 --light 0,0,1 --light camera --light 1,1,1", "1 to 4 lights"),
        ("--light 1,0,0 --shading off", "--light X,Y,Z"),
        ("--light 1,0,0:1:46", "0 to 45 degrees"),
        ("--shadows on --shading off", "--shadows on|off"),
        ("--shadows on --blend maximum", "not lit"),
        ("--shadows on --algorithm slicing", "sheets and slices"),
        ("--ambient-occlusion on --algorithm view-sheets", "--ambient-occlusion"),
        ("--shadow-strength 0.5", "enable shadows"),
        ("--shadows on --shadow-strength 1.5", "0 to 1"),
        ("--shadows on --shadow-forgiveness 0.5", "1 to 1000"),
        ("--ambient-occlusion on --ao-reach 0", "inf or a length"),
        ("--ao-reach 5", "enable ambient occlusion"),
        ("--light-grid half", "enable one"),
        ("--exposure 1", "belongs to the studio"),
        ("--look studio --sky red:x", "invalid sky"),
        ("--look studio --scattering 2", "0 to 1"),
        ("--look studio --shadows on", "belongs to the plain look"),
        ("--look studio --blend maximum", "are not lit"),
        ("--look studio --quality paper", "splatted"),
        ("--look studio --extinction linear", "exponential"),
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
        ("folder_4x4x4_uint8.raw", &["folder holds no", "slices"]),
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
        assert_eq!(status.code(), Some(1), "a lost report must not look like success");
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
