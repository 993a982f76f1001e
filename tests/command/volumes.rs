//! The command and its volumes: formats, warnings and limits.

use crate::common::command::*;
use layersplat::volume::{OpenOptions, Volume};
use std::path::Path;

fn write<const N: usize>(folder: &Path, name: &str, numbers: impl IntoIterator<Item = [u8; N]>) {
    std::fs::write(folder.join(name), numbers.into_iter().flatten().collect::<Vec<u8>>()).unwrap();
}

/// Standard error of `info`.
fn warnings(folder: &Path, volume: &str) -> String {
    let output = layersplat(folder, &["info", volume]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{message}");
    message
}

/// Standard output of `info`.
fn described(folder: &Path, arguments: &str) -> String {
    let output = layersplat(folder, &format!("info {arguments}").split_whitespace().collect::<Vec<_>>());
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Files with several volumes, as other programs write them; those with a stated distance of times are made here.
#[test]
fn info_tells_channels_times_and_resolutions() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 3 4 5\nkinds: domain domain domain time\nspacings: 1 1 2 0.25\n\
                  units: \"mm\" \"mm\" \"mm\" \"s\"\nencoding: raw\n\n";
    std::fs::write(f.join("times.nrrd"), [header.as_bytes(), &[7; 120]].concat()).unwrap();
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files");
    let mut nifti = Vec::new();
    let packed = std::fs::File::open(files.join("nifti/times.nii.gz")).unwrap();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(packed), &mut nifti).unwrap();
    // The spacing of times, and the codes of millimetres and milliseconds.
    nifti[92..96].copy_from_slice(&2.5f32.to_le_bytes());
    nifti[123] = 2 | 16;
    std::fs::write(f.join("times.nii"), nifti).unwrap();
    let of = |name: &str| files.join(name).display().to_string();
    let mut cases = vec![
        ("times.nrrd --frame 3".to_owned(), vec!["frames    5, 0.25 s apart; this is 3 (--frame)"]),
        ("times.nii".into(), vec!["frames    2, 2.5 ms apart; this is 0 (--frame)"]),
        (of("nrrd/rgb.nrrd") + " --channel 2", vec!["channels  3, which are red, green and blue; this is 2 (--channel)"]),
        (of("metaimage/vectors.mha"), vec!["channels  3; this is 0 (--channel)"]),
        (of("metaimage/vectors.mha") + " --channel magnitude", vec!["channels  3; this is their magnitude (--channel)"]),
        (of("numpy/times.npy"), vec!["frames    2; this is 0 (--frame)"]),
        ("builtin:cube@4".into(), vec![]),
    ];
    if cfg!(feature = "zarr") {
        let lines = ["channels  2; this is 1 (--channel)", "frames    2; this is 0 (--frame)"];
        let levels = "levels    2: 5x4x3, 2x2x3; this is 1 (--level)";
        cases.push((of("zarr/ome_04.zarr") + " --channel 1 --level 1", [&lines[..], &[levels]].concat()));
    }
    for (arguments, expected) in &cases {
        let text = described(f, arguments);
        let is_of_several = |line: &&str| ["channels ", "frames ", "levels "].iter().any(|name| line.starts_with(name));
        assert_eq!(text.lines().filter(is_of_several).collect::<Vec<_>>(), *expected, "{arguments}");
    }
    let info = json(f, &["info", "times.nrrd", "--frame", "3"]);
    let several = ["channels", "channel", "frames", "frame", "frame_spacing", "frame_unit", "levels", "level"];
    let found = serde_json::Value::from(several.map(|key| info[key].clone()).to_vec());
    assert_eq!(found, serde_json::json!([1, 0, 5, 3, 0.25, "s", [[2, 3, 4]], 0]));
    // NumPy arrays state no spacing.
    let array = of("numpy/times.npy");
    let is_assumed = |arguments: &[&str]| json(f, &[&["info"], arguments].concat())["spacing_is_assumed"].clone();
    assert_eq!((is_assumed(&["times.nrrd"]), is_assumed(&[&array])), (false.into(), true.into()));
    assert_eq!(is_assumed(&[&array, "--spacing", "1,1,1"]), false);
    // Numbers have no tails.
    let text = described(f, "times.nrrd");
    assert!(text.contains("range     7 to 7, mean 7\n") && text.contains("values from       voxels"), "{text}");
}

#[test]
fn info_describes_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files/surfaces/colors_text_51.vtk");
    let expected = "colors_text_51.vtk\nformat    VTK PolyData, legacy, text\npoints    8\ntriangles 12, closed\nbounds    1,-2,3 to 2.5,0,7\n\
                    normals   of points\ncolours   of points\narray     cell of cells, 0 to 5\narray     values of points, 281 to 702.5\n\
                    array     from the corner of points, 3 components of magnitude 0 to 4.71699\nspace     RAS, of the file\n\
                    header    3D Slicer output. SPACE=RAS\n";
    assert_eq!(described(folder.path(), &file.display().to_string()), expected);
    let info = json(folder.path(), &["info", &file.display().to_string()]);
    assert_eq!((info["triangles"].as_u64(), info["arrays"][1]["range"][1].as_f64()), (Some(12), Some(702.5)));
}

#[test]
#[cfg(all(feature = "tiff", feature = "zarr"))]
fn info_tells_names_colours_and_windows_of_channels() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files/channels");
    let of = |name: &str| files.join(name).display().to_string();
    let text = described(f, &of("imagej.tif"));
    let lines: Vec<&str> = text.lines().skip_while(|line| !line.starts_with("channels")).take(4).collect();
    let expected = [
        "channels  3; this is 0 (--channel)",
        "        0 #0000ff DAPI, window 1 to 200.5",
        "        1 #00ff00 -, window 0 to 255",
        "        2 #ff0066 Texas Red",
    ];
    assert_eq!(lines, expected);
    let found = &json(f, &["info", &of("omero_04.zarr")])["channel_descriptions"];
    let first = serde_json::json!({"channel": 0, "name": "DAPI", "color": [0.0, 0.0, 1.0], "color_is_declared": true,
        "window": [10.0, 90.5], "active": true});
    assert_eq!(found[0], first);
    assert_eq!(
        (&found[1]["name"], &found[1]["color_is_declared"], &found[1]["active"]),
        (&"EGFP".into(), &false.into(), &false.into())
    );
    // A single channel has nothing to be told from.
    assert_eq!(json(f, &["info", "builtin:cube@4"])["channel_descriptions"], serde_json::json!([]));
    // From standard input, too, where the voxels stand in the way of a second look.
    let file = std::fs::File::open(files.join("imagej.tif")).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_layersplat")).args(["info", "-"]).stdin(file).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains(expected[3]), "{text}");
    // Malformed descriptions are said, and the values described all the same.
    let attributes = r#"{"multiscales": [{"axes": ["c", "z", "y", "x"], "datasets": [{"path": "s0"}]}], "omero": {"channels": [{"color": "red"}]}}"#;
    let source = files.join("omero_04.zarr");
    std::process::Command::new("cp").args(["-r", source.to_str().unwrap(), "bad.zarr"]).current_dir(f).status().unwrap();
    std::fs::write(f.join("bad.zarr/.zattrs"), attributes).unwrap();
    assert!(warnings(f, "bad.zarr").contains("color \"red\""));
}

#[test]
fn one_voxel_without_a_value_changes_no_range() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let values = (0..512).map(|i| if i == 100 { f32::NAN } else { 280.0 + (i % 31) as f32 });
    write(f, "warm_8x8x8_float32.raw", values.map(f32::to_le_bytes));
    let info = json(f, &["info", "warm_8x8x8_float32.raw"]);
    assert_eq!((info["min"].as_f64(), info["max"].as_f64()), (Some(280.0), Some(310.0)));
    assert_eq!(info["histogram"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum::<u64>(), 511);
    // Stretched functions end at the range of the data.
    let transfer = &json(f, &["info", "warm_8x8x8_float32.raw", "--transfer", "grey"])["transfer"]["opacities"];
    assert_eq!((transfer[0][0].as_f64(), transfer[3][0].as_f64()), (Some(280.0), Some(310.0)));
    assert!(warnings(f, "warm_8x8x8_float32.raw").contains("1 voxels are NaN"));
}

#[test]
fn a_background_value_surrounds_the_volume() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("positive_8x8x8_uint8.raw"), [200; 512]).unwrap();
    // Opaque from 50 to 150: the voxels are invisible, only values between them and a background below are visible.
    let between =
        r#"{"RGBPoints": [0,1,1,1, 255,1,1,1], "Points": [0,0,0.5,0, 49,0,0.5,0, 50,1,0.5,0, 150,1,0.5,0, 151,0,0.5,0]}"#;
    std::fs::write(f.join("between.json"), between).unwrap();
    let seen = |more: &[&str]| {
        let base = ["render", "positive_8x8x8_uint8.raw", "--transfer", "between.json", "--size", "30x30", "-o", "a.npy"];
        json(f, &[&base[..], more].concat());
        let frame = layersplat::image::read_image(&f.join("a.npy")).unwrap();
        frame.pixels().iter().filter(|p| p[3] > 0.5).count()
    };
    assert_eq!((seen(&[]), seen(&["--background-value", "180"])), (0, 0));
    assert!(seen(&["--background-value", "-10.5"]) > 100 && seen(&["--background-value", "0"]) > 100);
    assert_eq!(json(f, &["info", "positive_8x8x8_uint8.raw", "--background-value", "-10.5"])["min"], 200.0);
}

#[test]
fn doubles_far_from_zero_are_no_solid_block() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    // A ball that rises to 4000 above 1e12, where floats are 65536 apart.
    let value = |i: usize| {
        let p = [i % 24, i / 24 % 24, i / 576].map(|c| c as f64 - 11.5);
        1e12 + 4000.0 * (1.0 - p.iter().map(|c| c * c).sum::<f64>().sqrt() / 12.0).max(0.0)
    };
    write(f, "far_24x24x24_float64.raw", (0..13_824).map(value).map(f64::to_le_bytes));
    let info = json(f, &["info", "far_24x24x24_float64.raw"]);
    let most = 4000.0 * (1.0 - 0.75f64.sqrt() / 12.0);
    assert!((info["min"].as_f64().unwrap() - 1e12).abs() < 1e-3 && (info["max"].as_f64().unwrap() - 1e12 - most).abs() < 1e-3);
    json(f, &["render", "far_24x24x24_float64.raw", "--transfer", "fire", "--size", "40x40", "-o", "a.npy"]);
    let frame = layersplat::image::read_image(&f.join("a.npy")).unwrap();
    let middle = frame.pixel(20, 20)[3];
    let between = frame.pixels().iter().filter(|p| p[3] > 0.05 * middle && p[3] < 0.9 * middle).count();
    assert!(middle > 0.3 && between > 300, "the ball must fade: {middle} in the centre, {between} intermediate pixels");
    assert!(!warnings(f, "far_24x24x24_float64.raw").contains("WARN"));

    // An outlier, such as a missing measurement.
    let missing = |i: usize| if i == 5000 { -9999.0 } else { value(i) };
    write(f, "lost_24x24x24_float64.raw", (0..13_824).map(missing).map(f64::to_le_bytes));
    let warning = warnings(f, "lost_24x24x24_float64.raw");
    assert!(warning.contains("the smallest is -9999") && warning.contains("values in that range"), "{warning}");
    write(f, "wide_2x2x2_int32.raw", (0..8).map(|i| (i * 250_000_001 - 1_000_000_000i32).to_le_bytes()));
    assert!(warnings(f, "wide_2x2x2_int32.raw").contains("errors of up to 64"));
}

#[test]
fn options_that_are_for_files() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write(f, "photo.dat", [[9; 3]].into_iter().chain((0..8).map(|i| [0, i, i])));
    let found = json(f, &["info", "photo.dat", "--dims", "3x2x2", "--type", "uint16", "--endian", "big", "--header-bytes", "3"]);
    assert_eq!((found["min"].as_f64(), found["max"].as_f64()), (Some(0.0), Some(1799.0)));
    refused(f, &["info", "photo.dat", "--dims", "3x2x2", "--type", "uint16"], 1, &["24 bytes", "27", "--header-bytes"]);
    for option in [["--endian", "big"], ["--header-bytes", "3"], ["--dims", "2x2x2"], ["--type", "int32"]] {
        refused(f, &[&["info", "builtin:cube@4"][..], &option].concat(), 2, &["applies to files"]);
    }
    refused(f, &["info", "photo.dat", "--header-bytes", "-3"], 2, &["-3"]);
}

#[test]
fn volumes_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write(f, "a_4x3x2_int32.raw", (0..24).map(|i: i32| ((i - 12) * 100_000_000).to_be_bytes()));
    for (from, to) in [("a_4x3x2_int32.raw", "b.nrrd"), ("b.nrrd", "c.npy"), ("c.npy", "d.raw")] {
        let endian: &[&str] = if from.starts_with('a') { &["--endian", "big"] } else { &[] };
        let output = layersplat(f, &[&["convert", from, to][..], endian].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let expected: Vec<u8> = (0..24).flat_map(|i: i32| ((i - 12) * 100_000_000).to_le_bytes()).collect();
    assert_eq!(std::fs::read(f.join("d_4x3x2_int32.raw")).unwrap(), expected);
    refused(f, &["convert", "b.nrrd", "e.doc"], 2, &["e.doc", ".nii.gz"]);
    refused(f, &["convert", "b.nrrd", "missing/e.nrrd"], 1, &["does not exist"]);
    refused(f, &["convert", "b.nrrd", "e.npy", "--frame", "1"], 2, &["frame", "--frame N"]);
    refused(f, &["convert", "b.nrrd"], 2, &["OUTPUT"]);
}

/// Address space in bytes, enough for everything except the pictures and volumes of the test below.
#[cfg(unix)]
const LITTLE: u64 = 6 << 30;

/// Requests beyond the available memory are rejected before allocation: a sparse file of 100 GB, a compressed file that declares as much,
/// a built-in volume, and pictures, rendered and read.
#[test]
#[cfg(unix)]
fn what_memory_does_not_hold_is_refused() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let file = std::fs::File::create(f.join("large_5000x5000x4000_uint8.raw")).unwrap();
    // Some file systems do not support files of that size.
    if file.set_len(100_000_000_000).is_ok() {
        refused_within(
            LITTLE,
            f,
            &["info", "large_5000x5000x4000_uint8.raw"],
            1,
            &["large_5000", "100000000000 bytes", "smaller"],
        );
    } else {
        eprintln!("the temporary folder takes no file of 100 GB: its part of the test is skipped");
    }
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![0u8; 1 << 20];
    (0..64).for_each(|_| packed.write_all(&zeros).unwrap());
    let member = packed.finish().unwrap();
    std::fs::write(f.join("bomb_4096x4096x512_uint8.raw.gz"), member.repeat(128)).unwrap();
    refused_within(LITTLE, f, &["info", "bomb_4096x4096x512_uint8.raw.gz"], 1, &["bomb_4096", "8589934592 bytes"]);
    for algorithm in ["layered", "raycast"] {
        let arguments = ["render", "builtin:cube@4", "--size", "16384x16384", "--algorithm", algorithm, "-o", "a.png"];
        refused_within(LITTLE, f, &arguments, 1, &["a picture of 16384x16384 needs", "ulimit"]);
    }
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (16384, 16384, 4), }";
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header.bytes());
    std::fs::write(f.join("huge.npy"), npy).unwrap();
    refused_within(3 << 30, f, &["compare", "huge.npy", "huge.npy"], 1, &["huge.npy", "4294967296 bytes"]);
}

/// Files that cannot be mapped are streamed through a temporary file, with the same picture. The temporary file is removed.
#[test]
fn packed_volumes_are_streamed() {
    const SIZE: usize = 100;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let volume = Volume::open(format!("builtin:marschner-lobb@{SIZE}"), &OpenOptions::default()).unwrap();
    let number = |index: usize| volume.value(index).round() as u8;
    let bytes: Vec<u8> = (0..SIZE * SIZE * SIZE).map(number).collect();
    // Numbers that are converted on reading, slice files, and a multi-page file.
    write(f, "wide_100x100x100_float64.raw", bytes.iter().map(|&n| f64::from(n).to_le_bytes()));
    write(f, "plain_100x100x100_uint8.raw", bytes.iter().map(|&n| [n]));
    assert!(layersplat(f, &["convert", "plain_100x100x100_uint8.raw", "packed.nii.gz"]).status.success());
    std::fs::create_dir(f.join("slices")).unwrap();
    for (z, slice) in bytes.chunks(SIZE * SIZE).enumerate() {
        let side = SIZE as u32;
        image::save_buffer(f.join(format!("slices/{z}.png")), slice, side, side, image::ColorType::L8).unwrap();
    }
    let temporary = f.join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let frame = |volume: &str, more: &[&str]| {
        let all = [&["render", volume, "--size", "36x28", "--transfer", "fire", "-o", "a.npy", "-v"], more].concat();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let output = command.current_dir(f).args(&all).env("TMPDIR", &temporary).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{told}");
        (std::fs::read(f.join("a.npy")).unwrap(), told.contains("temporary file"))
    };
    let (whole, _) = frame("plain_100x100x100_uint8.raw", &[]);
    for volume in ["packed.nii.gz", "slices", "wide_100x100x100_float64.raw"] {
        // Files without a spacing use 1.
        let (read, spooled) = frame(volume, &["--spacing", "1,1,1"]);
        assert!(!spooled && (read == whole || volume.starts_with("wide")), "{volume}");
        let (streamed, spooled) =
            frame(volume, &["--spacing", "1,1,1", "--memory", if volume.starts_with("wide") { "3M" } else { "700K" }]);
        assert!(streamed == read && spooled, "{volume}");
        assert_eq!(names(&temporary), [""; 0]);
    }
    let (_, spooled) = frame("plain_100x100x100_uint8.raw", &["--memory", "700K"]);
    assert!(!spooled, "a file that can be mapped must not be copied");
    std::fs::remove_dir(&temporary).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_layersplat"));
    let lost = ["render", "packed.nii.gz", "--memory", "700K", "-o", "b.npy"];
    let output = command.current_dir(f).args(lost).env("TMPDIR", &temporary).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && told.contains("set TMPDIR to another folder"), "{told}");
}

/// Selection of one of several volumes, components and arrays in a file.
#[test]
fn files_of_several_volumes() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let files = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats/files/");
    let range = |file: &str, more: &[&str]| {
        let path = format!("{files}{file}");
        let info = json(f, &[&["info", &path][..], more].concat());
        (info["min"].as_f64().unwrap(), info["max"].as_f64().unwrap())
    };
    // 60 voxels per channel, numbered consecutively.
    for (channel, expected) in [("0", (0.0, 59.0)), ("1", (60.0, 119.0)), ("2", (120.0, 179.0))] {
        assert_eq!(range("nrrd/rgb.nrrd", &["--channel", channel]), expected);
    }
    assert_eq!(range("nrrd/rgb.nrrd", &[]), range("nrrd/rgb.nrrd", &["--channel", "0"]));
    let [first, second] = ["0", "1"].map(|frame| range("nrrd/times.nrrd", &["--frame", frame]));
    assert_ne!(first, second);
    let path = |file: &str| format!("{files}{file}");
    refused(f, &["info", &path("nrrd/rgb.nrrd"), "--channel", "3"], 2, &["--channel", "0 to 2"]);
    refused(f, &["info", &path("nrrd/rgb.nrrd"), "--channel", "length"], 2, &["--channel", "magnitude"]);
    refused(f, &["info", "builtin:cube@4", "--channel", "magnitude"], 2, &["--channel"]);
    refused(f, &["info", &path("vtk/several.vti"), "--array", "zzz"], 2, &["zzz", "--array"]);
    refused(f, &["info", &path("nrrd/rgb.nrrd"), "--series", "2"], 2, &["--series NAME"]);
    #[cfg(feature = "dicom")]
    {
        refused(f, &["info", &path("dicom/several")], 2, &["2 'first'", "4 'dynamic'", "--series NAME"]);
        assert_eq!(range("dicom/several", &["--series", "dynamic", "--frame", "1"]), (1000.0, 1177.0));
    }
    #[cfg(feature = "zarr")]
    {
        let dims = |level: &str| json(f, &["info", &path("zarr/ome_04.zarr"), "--level", level])["dims"].clone();
        assert_eq!((dims("0"), dims("1")), (serde_json::json!([5, 4, 3]), serde_json::json!([2, 2, 3])));
        refused(f, &["info", &path("zarr/ome_04.zarr"), "--level", "2"], 2, &["levels are 0 to 1", "--level"]);
        refused(f, &["info", &path("zarr/ome_04.zarr"), "--level", "auto"], 2, &["use a number", "--level"]);
        refused(f, &["info", &path("zarr/ome_04.zarr"), "--level", "fine"], 2, &["fine", "auto"]);
        // A picture of 3 pixels needs the coarse level.
        let picture = |level: &str, name: &str| {
            let file = path("zarr/ome_04.zarr");
            let given = ["render", &file, "--size", "3x3", "--level", level, "--transfer", "grey", "-o", name];
            assert!(layersplat(f, &given).status.success(), "{level}");
            std::fs::read(f.join(name)).unwrap()
        };
        let [auto, coarse, fine] = [("auto", "a.npy"), ("1", "b.npy"), ("0", "c.npy")].map(|(level, name)| picture(level, name));
        assert!(auto == coarse && auto != fine);
    }
}

/// Ids with their names, voxels and volumes; changed by options, from tables, and refused where the voxels are no ids.
#[test]
fn info_tells_voxels_and_volume_of_labels() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 2 3 1\nspacings: 0.5 1 4\nendian: little\nencoding: raw\n\n";
    let numbers = [0u32, 7, 7, 4_000_000_000, 7, 0].map(u32::to_le_bytes).concat();
    std::fs::write(f.join("ids.nrrd"), [header.as_bytes(), &numbers].concat()).unwrap();
    std::fs::write(f.join("table.txt"), "7 Liver 255 0 51 51\n9 Absent 1 2 3 0\n").unwrap();
    // Nothing says that these are labels.
    assert!(json(f, &["info", "ids.nrrd"])["labels"].is_null());
    let labels = json(f, &["info", "ids.nrrd", "--labels=table.txt", "--label", "4000000000:#ffffff:hide"])["labels"].clone();
    let expected = serde_json::json!([
        {"layer": 0, "id": 7, "name": "Liver", "color": [1.0, 0.0, 0.2], "opacity": 0.8, "visible": true, "voxels": 3, "volume": 6.0},
        {"layer": 0, "id": 4_000_000_000u32, "name": null, "color": [1.0, 1.0, 1.0], "opacity": 1.0, "visible": false, "voxels": 1,
         "volume": 2.0}
    ]);
    assert_eq!(labels, expected);
    let text = described(f, "ids.nrrd --labels=table.txt --label liver:only");
    let lines = [
        "     label       voxels         volume color   opacity name",
        "         7            3              6 #ff0033     0.8 Liver",
        "4000000000            1              2 ",
    ];
    let found: Vec<&str> = text.lines().skip_while(|line| !line.starts_with(lines[0])).take(3).collect();
    assert!(found.iter().zip(lines).all(|(found, line)| found.starts_with(line)) && found[2].ends_with(" - (hidden)"), "{text}");
    let warning = String::from_utf8(layersplat(f, &["info", "ids.nrrd", "--labels=table.txt"]).stderr).unwrap();
    assert!(
        warning.contains("1 of its ids have no entry in the table, and get colours by their number: 4000000000"),
        "{warning}"
    );
    // Files that declare labels need no option.
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files");
    let layers = files.join("labels/layers.seg.nrrd").display().to_string();
    let text = described(f, &layers);
    assert!(
        text.contains("layer      label ") && text.contains("    1          1           30             15 #0000ff"),
        "{text}"
    );
    std::fs::write(f.join("wrong.txt"), "7 Liver 255 0 51 0\n8 Spleen 255 0 512 0\n").unwrap();
    let scaled = files.join("nifti/scaled.nii").display().to_string();
    for (arguments, code, expected) in [
        (vec!["ids.nrrd", "--labels=wrong.txt"], 1, "wrong.txt, line 2: '8 Spleen 255 0 512 0' is no label: expected id, name"),
        (
            vec!["ids.nrrd", "--label", "8:hide"],
            2,
            "no label has the id 8: ids are 7 to 4000000000, with gaps (--label IDS:CHANGES)",
        ),
        (vec!["ids.nrrd", "--label", "7:hid"], 2, "invalid change '7:hid', which changes nothing; use IDS"),
        (vec![&scaled, "--labels"], 1, "its voxel 0,0,0 is -12.5: ids of labels are whole numbers"),
        (vec!["builtin:cube@4", "--labels"], 1, "built-in volumes have values, not labels"),
    ] {
        let output = layersplat(f, &[&["info"], &arguments[..]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(code) && message.contains(expected), "{arguments:?}: {message}");
    }
}
