//! The command with several fields, colours and labels.

use crate::common::command::*;
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
    let plain = [&first[..], &["--with", "builtin:gyroid@16,opacity=p50:0,p99:0.3"]].concat();
    let changed = |changes: &[&str]| picture(f, &[&plain[..], changes].concat());
    assert!(changed(&["--field", "1,color=#00aaff,factor=2"]) == with);
    assert!(changed(&["--field", "1,color=#00aaff", "--field", "1,factor=2"]) == with);
    // The plain options are for the first field.
    assert!(changed(&["--field", "1,color=#00aaff,factor=2", "--field", "0,color=#ff0000"]) == with);
    assert!(changed(&["--field", "1,color=#00aaff,factor=2", "--field", "0,factor=0.2"]) != with);
    let hidden = picture(f, &[&first[..], &["--with", "builtin:gyroid@16,visible=off"]].concat());
    assert!(hidden == picture(f, &[&first[..], &["--fit", "visible"]].concat()), "a hidden field changes nothing");
    // A field of its own grid, moved.
    std::fs::write(f.join("at.txt"), "0.5 0 0 20\n0 0.5 0 3\n0 0 0.5 2\n0 0 0 1\n").unwrap();
    let moved = picture(f, &[&first[..], &["--with", "builtin:gyroid@16,at=at.txt"]].concat());
    assert!(moved != picture(f, &[&first[..], &["--with", "builtin:gyroid@16"]].concat()));
    // A transform may shear: rows lean by as many columns as they are high.
    std::fs::write(f.join("lean.txt"), "1 1 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n").unwrap();
    let view = [
        "builtin:cube@8",
        "--transfer",
        "grey",
        "--opacity",
        "0:0,1:1",
        "--shading",
        "off",
        "--azimuth",
        "0",
        "--elevation",
        "0",
    ];
    let lean =
        picture(f, &[&view[..], &["--field", "0,visible=off", "--with", "builtin:cube@8,at=lean.txt,opacity=0:0,1:1"]].concat());
    let [width, height] = [48, 40];
    let first_lit = |row: usize| (0..width).find(|x| lean[3 * (row * width + x)] > 60);
    let [upper, lower] = [height / 4, 3 * height / 4].map(first_lit);
    assert!(upper.unwrap() > lower.unwrap() + 4, "{upper:?} {lower:?}");
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
    // The file says that its components are colours.
    assert!(picture(f, &["rgb.nrrd"]) == colors);
    assert!(picture(f, &["rgb.nrrd", "--colors", "none"]) == picture(f, &["rgb.nrrd", "--channel", "0"]));
    assert!(picture(f, &["rgb.nrrd", "--channel", "0"]) != colors);
    let vectors = std::fs::read(f.join("rgb.nrrd")).unwrap();
    let header = String::from_utf8_lossy(&vectors).find("RGB-color").unwrap();
    std::fs::write(f.join("v.nrrd"), [&vectors[..header], b"list     ", &vectors[header + 9..]].concat()).unwrap();
    let said = layersplat(f, &["render", "v.nrrd", "--size", "8x8", "--device-unchecked", "-o", "v.png"]).stderr;
    let said = String::from_utf8_lossy(&said);
    assert!(said.contains("as red, green and blue by --colors direct"), "{said}");
    assert!(picture(f, &["v.nrrd"]) == picture(f, &["rgb.nrrd", "--channel", "0"]));
    assert!(colors != picture(f, &["rgb.nrrd", "--colors", "direct", "--color-opacity", "#0000ff"]));
    assert!(channels != picture(f, &["rgb.nrrd", "--channels", "all", "--classification", "post"]));
    assert!(picture(f, &["rgb.nrrd", "--channels", "red,Blue"]) == picture(f, &["rgb.nrrd", "--channels", "0,2"]));
    assert!(picture(f, &["rgb.nrrd", "--channel", "green"]) == picture(f, &["rgb.nrrd", "--channel", "1"]));
    let named = picture(f, &["rgb.nrrd", "--channels", "all", "--field", "green,factor=3"]);
    assert!(named == picture(f, &["rgb.nrrd", "--channels", "all", "--field", "1,factor=3"]));
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
    assert!(picture(f, &[labels, "--label-surfaces", "smooth", "--legend"]) == all);
    assert!(picture(f, &[labels, "--label-surfaces", "voxels", "--legend"]) != all);
    // Beside a scan, as one of its fields.
    let scan = |keys: &str| picture(f, &["builtin:gyroid@16", "--with", &format!("{labels}{keys}"), "--legend"]);
    assert!(scan("") != picture(f, &["builtin:gyroid@16", "--legend"]));
    assert!(scan("") != scan(&format!(",label={name}:hide")) && scan("") != scan(&format!(",label={name}:#123456:0.2")));
    // Voxels of other files become labels by this option, too.
    refused(f, &["render", "builtin:gyroid@16", "--label-surfaces", "voxels", "-o", "no.png"], 1, &["values, not labels"]);
    refused(f, &["render", labels, "--label-surfaces", "round", "-o", "no.png"], 2, &["round", "smooth", "voxels"]);
}

/// Options for values are refused, with what serves instead, where labels or colours are drawn; no picture leaves one out in silence.
#[test]
fn options_that_cannot_apply_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    components(f);
    std::fs::copy(files().join("labels/layers.seg.nrrd"), f.join("l.seg.nrrd")).unwrap();
    let of_values = [
        (["--transfer", "fire"], "transfer:"),
        (["--preset", "ct-bone"], "preset:"),
        (["--palette", "calm"], "palette:"),
        (["--transfer-range", "0,9"], "transfer_range:"),
        (["--window", "5,2"], "window:"),
        (["--opacity", "0:0,9:1"], "opacity:"),
        (["--tent", "5,2"], "tent:"),
        (["--background-value", "5"], "background_value:"),
        (["--kernel", "bspline"], "kernel:"),
    ];
    let of_labels = [
        (["--field", "0,factor=2"], "field:"),
        (["--channels", "0"], "the file holds labels"),
        (["--mask", "l.seg.nrrd"], "--label IDS:only"),
        (["--label-colors", "l.seg.nrrd"], "label_colors:"),
    ];
    for (option, problem) in of_values.iter().chain(&of_labels) {
        refused(f, &[&["render", "l.seg.nrrd"], &option[..], &["-o", "no.png"]].concat(), 2, &[problem]);
    }
    let colors = ["render", "rgb.nrrd", "--colors", "direct", "-o", "no.png"];
    for (option, problem) in
        of_values.iter().filter(|(_, problem)| ["preset:", "palette:", "background_value:", "kernel:"].contains(problem))
    {
        refused(f, &[&colors[..], option].concat(), 2, &[problem]);
    }
    // What labels beside a scan do not have, and the opacity of colours that are not drawn.
    let beside = |keys: &str| format!("l.seg.nrrd{keys}");
    for (keys, options, code, problem) in [
        (",opacity=3:1", &[][..], 1, "label=liver"),
        (",label=99:hide", &[], 2, "99"),
        (",color=#ff0000", &[], 1, "label=liver"),
        (",label=1-99:hide", &[], 1, "none of its labels"),
        ("", &["--blend", "maximum"], 2, "labels have none"),
    ] {
        let with = beside(keys);
        refused(
            f,
            &[&["render", "builtin:cube@8", "--with", &with, "-o", "no.png"], options].concat(),
            code,
            &["l.seg.nrrd", problem][usize::from(code == 2)..],
        );
    }
    refused(f, &["render", "builtin:cube@8", "--channels", "0", "--color-opacity", "alpha", "-o", "no.png"], 2, &["color"]);
}

/// Colours beside a scan: in any order, by options and by a scene; a hidden field changes nothing, and values are drawn where they are chosen.
#[test]
fn colors_are_drawn_beside_a_scan() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    components(f);
    // On the grid of the file of colours.
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n";
    let bytes: Vec<u8> = (0..512usize).map(|n| (n % 8 * 30) as u8).collect();
    std::fs::write(f.join("scan.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
    let scan = ["scan.nrrd", "--opacity", "0:0,90:0,210:0.2"];
    let with = |keys: &str| picture(f, &[&scan[..], &["--with", &format!("rgb.nrrd{keys}")]].concat());
    let both = with("");
    assert!(both != picture(f, &scan) && both != with(",channel=0") && both != with(",factor=0.2"));
    assert!(both != with(",color-opacity=white") && both == with(",color-opacity=luminance") && both == with(",colors=direct"));
    assert!(with(",visible=off") == picture(f, &[&scan[..], &["--fit", "visible"]].concat()));
    let swapped = picture(f, &["rgb.nrrd", "--with", "scan.nrrd,transfer=grey,opacity=0:0,90:0,210:0.2"]);
    let first = picture(f, &["scan.nrrd", "--transfer", "grey", "--opacity", "0:0,90:0,210:0.2", "--with", "rgb.nrrd"]);
    let apart = swapped.iter().zip(&first).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart <= Some(1), "{apart:?}");
    let scene = r#"{"fields": [{"file": "rgb.nrrd"}, {"file": "scan.nrrd", "transfer": "grey", "opacity": "0:0,90:0,210:0.2"}]}"#;
    std::fs::write(f.join("scene.json"), scene).unwrap();
    assert!(picture(f, &["--scene", "scene.json"]) == swapped);
    for (keys, code, words) in [
        (",color=#ff0000", 1, ["rgb.nrrd", "channel=N"]),
        (",channel=0,colors=direct", 1, ["rgb.nrrd", "omit one of both"]),
        (",colors=some", 2, ["colors", "direction"]),
        (",channel=0,color-opacity=white", 1, ["rgb.nrrd", "colors=direct"]),
        (",color-opacity=alpha", 2, ["color_opacity", "fourth component"]),
    ] {
        let with = format!("rgb.nrrd{keys}");
        refused(f, &["render", "scan.nrrd", "--with", &with, "-o", "no.png"], code, &words);
    }
    refused(f, &["render", "scan.nrrd", "--with", "rgb.nrrd", "--mip", "-o", "no.png"], 2, &["colours and labels have none"]);
    refused(f, &["render", "scan.nrrd", "--with", "rgb.nrrd", "--field", "1,iso=3", "-o", "no.png"], 1, &["rgb.nrrd", "iso"]);
    refused(f, &["slice", "scan.nrrd", "--with", "rgb.nrrd", "-o", "no.png"], 2, &["slices draw alone"]);
}

/// Any number of labels beside a scan, first or after it; each opacity is a field.
#[test]
fn many_labels_are_drawn_beside_a_scan() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n";
    let bytes: Vec<u8> = (0..512usize).map(|n| (n / 5) as u8).collect();
    std::fs::write(f.join("ids.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
    let scan = ["builtin:gyroid@8", "--legend"];
    let with = |keys: &str| picture(f, &[&scan[..], &["--with", &format!("ids.nrrd,labels={keys}")]].concat());
    let all = with("");
    assert!(all != picture(f, &scan) && all != with(",label=50:hide") && all != with(",label=50:#ff0000"));
    let first = picture(f, &["ids.nrrd", "--labels", "--with", "builtin:gyroid@8"]);
    assert!(first != picture(f, &["ids.nrrd", "--labels"]));
    let opacities: String = (1..=8).map(|n| format!(",label={n}:0.{n}")).collect();
    let with = format!("ids.nrrd,labels={opacities}");
    refused(f, &["render", "builtin:gyroid@8", "--with", &with, "-o", "no.png"], 2, &["10 fields", "once for each opacity"]);
}

/// Depths of labels come with the ids that are seen there: of visible ones, and none beside them.
#[test]
fn ids_stand_beside_depths_of_labels() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    // Two halves of a block, and another label before them.
    let id = |n: usize| match [n % 12, n / 12 % 12, n / 144] {
        [.., 9] => 5u32,
        [x, .., 2..9] => {
            if x < 6 {
                3
            } else {
                70_000
            }
        }
        _ => 0,
    };
    let header = "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 12 12 12\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n";
    let ids: Vec<u8> = (0..12 * 12 * 12).flat_map(|n| id(n).to_le_bytes()).collect();
    std::fs::write(f.join("halves.nrrd"), [header.as_bytes(), &ids].concat()).unwrap();
    // Column by column along the middle row: ids, and whether there is a depth.
    let middle = |arguments: &[&str]| {
        let common = ["--size", "40x30", "--depth", "--device-unchecked", "--azimuth", "0", "--elevation", "0", "-o", "d.exr"];
        let output = layersplat(f, &[&["render", "halves.nrrd"], arguments, &common].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let image = exr::prelude::read_first_flat_layer_from_file(f.join("d.exr")).unwrap();
        let channels = image.layer_data.channel_data.list;
        let named = |name: &str| channels.iter().find(|channel| channel.name.eq(name)).map(|channel| channel.sample_data.clone());
        let row = 15 * 40..16 * 40;
        let depths: Vec<f32> = named("Z").unwrap().values_as_f32().collect();
        let ids = named("id").map(|data| match data {
            exr::prelude::FlatSamples::U32(ids) => ids[row.clone()].to_vec(),
            other => panic!("{other:?}"),
        });
        (ids, depths[row].iter().map(|depth| depth.is_finite()).collect::<Vec<_>>())
    };
    for projection in [&[][..], &["--perspective", "40"]] {
        let (ids, seen) = middle(&[&["--labels", "--label", "5:hide"], projection].concat());
        let ids = ids.unwrap();
        assert!(ids.iter().zip(&seen).all(|(&id, &seen)| (id != 0) == seen), "{ids:?}");
        let runs: Vec<u32> = ids.chunk_by(|a, b| a == b).map(|run| run[0]).collect();
        assert_eq!(runs, [0, 3, 70_000, 0]);
        let share = ids.iter().filter(|&&id| id == 3).count() as f64 / ids.iter().filter(|&&id| id != 0).count() as f64;
        assert!((share - 0.5).abs() < 0.1, "{share}");
        let front = middle(&[&["--labels"], projection].concat()).0.unwrap();
        assert!(front.iter().all(|id| [0, 5].contains(id)) && front.contains(&5), "{front:?}");
    }
    // Values have no ids.
    assert!(middle(&[]).0.is_none());
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
    refused(f, &["render", "block_16x16x16_uint8.raw", "--mask", "far.nrrd"], 1, &["lie outside"]);
    refused(f, &["render", "block_16x16x16_uint8.raw", "--mask", "mask.nrrd:5"], 2, &["no label has the id 5"]);
}

/// One scan given twice, each time within other labels, has a transfer function per label: the picture is that of two files in which the
/// other voxels were blanked by hand.
#[test]
fn each_field_has_a_mask_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let write = |name: &str, keep: &dyn Fn(usize) -> bool, value: &dyn Fn(usize) -> u8| {
        let voxels: Vec<u8> = (0..4096).map(|n| if keep(n) { value(n) } else { 0 }).collect();
        std::fs::write(f.join(name), voxels).unwrap();
    };
    let value = |n: usize| (10 * (n % 16) + 3 * (n / 256)) as u8;
    write("scan_16x16x16_uint8.raw", &|n| n > 0, &value);
    write("left_16x16x16_uint8.raw", &|n| n % 16 < 7, &value);
    write("right_16x16x16_uint8.raw", &|n| n % 16 >= 9 && n / 256 > 3, &value);
    // The labels 1 and 2 side by side, and 4 between them and below.
    let id = |n: usize| {
        if n % 16 < 7 {
            1
        } else if n % 16 >= 9 && n / 256 > 3 {
            2
        } else {
            4u8
        }
    };
    std::fs::create_dir(f.join("sub")).unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nspacings: 1 1 1\nencoding: raw\n\n";
    let ids: Vec<u8> = (0..4096).map(id).collect();
    std::fs::write(f.join("sub/ids.nrrd"), [header.as_bytes(), &ids].concat()).unwrap();
    let first = ["--transfer", "fire", "--opacity", "20:0,200:0.4", "--fit", "volume"];
    let second = "transfer=cool-warm,opacity=20:0,90:0.3,range=0,200";
    let draw = |file: &str, mask: Option<&str>, with: &str| {
        let mask: Vec<&str> = mask.into_iter().flat_map(|mask| ["--mask", mask]).collect();
        picture(f, &[&[file], &mask[..], &first, &["--with", with]].concat())
    };
    let by_hand = draw("left_16x16x16_uint8.raw", None, &format!("right_16x16x16_uint8.raw,{second}"));
    let masked =
        draw("scan_16x16x16_uint8.raw", Some("sub/ids.nrrd:1"), &format!("scan_16x16x16_uint8.raw,mask=sub/ids.nrrd:2,{second}"));
    assert!(masked == by_hand);
    assert!(draw("scan_16x16x16_uint8.raw", None, &format!("scan_16x16x16_uint8.raw,mask=sub/ids.nrrd:2,{second}")) != by_hand);
    // A scene masks its first field, too, and names the mask relative to itself.
    let fields = |first: &str| {
        format!(
            r#"[{{{first}"mask": "ids.nrrd:1"}}, {{"file": "../scan_16x16x16_uint8.raw", "mask": "ids.nrrd:2", "transfer": "cool-warm", "opacity": [[20, 0], [90, 0.3]], "range": [0, 200]}}]"#
        )
    };
    for (first_field, volume) in [("", Some("scan_16x16x16_uint8.raw")), (r#""file": "../scan_16x16x16_uint8.raw", "#, None)] {
        std::fs::write(f.join("sub/scene.json"), fields(first_field)).unwrap();
        let volume: Vec<&str> = volume.into_iter().collect();
        assert!(picture(f, &[&volume, &first[..], &["--scene", "sub/scene.json"]].concat()) == by_hand, "{first_field}");
    }
    // Refused masks.
    let far = header.replace(
        "spacings: 1 1 1",
        "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (500,0,0)",
    );
    std::fs::write(f.join("far.nrrd"), [far.as_bytes(), &ids].concat()).unwrap();
    for (mask, code, words) in [
        ("far.nrrd", 1, &["lie outside", "far.nrrd", "placement"][..]),
        ("sub/ids.nrrd:9", 2, &["no label has the id 9", "1 to 4"]),
        ("nothing.nrrd:1", 1, &["nothing.nrrd"]),
    ] {
        let with = format!("scan_16x16x16_uint8.raw,mask={mask}");
        refused(f, &[&["render", "scan_16x16x16_uint8.raw", "--with", &with], &SIZE[..]].concat(), code, words);
    }
}

/// A scan in the colours of labels on another grid: names and colours of a table, changes, ids beside depths, and what is refused.
#[test]
fn labels_color_a_scan() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let voxels: Vec<u8> = (0..4096).map(|n| 100 + (n % 16) as u8).collect();
    std::fs::write(f.join("scan_16x16x16_uint8.raw"), voxels).unwrap();
    let header = |kind: &str, origin: &str| {
        let place = format!("space directions: (-2,0,0) (0,-2,0) (0,0,2)\nspace origin: {origin}");
        format!(
            "NRRD0004\ntype: {kind}\ndimension: 3\nsizes: 8 8 8\nspace: left-posterior-superior\n{place}\nendian: little\nencoding: raw\n\n"
        )
    };
    let ids: Vec<u8> = (0..512).map(|n| if n % 8 < 4 { 3 } else { 7 }).collect();
    std::fs::write(f.join("ids.nrrd"), [header("uint8", "(-0.5,-0.5,0.5)").as_bytes(), &ids].concat()).unwrap();
    let scan = ["scan_16x16x16_uint8.raw", "--transfer", "grey", "--opacity", "0:0,99:0,100:0.9", "--fit", "volume"];
    let draw = |more: &[&str]| picture(f, &[&scan[..], more].concat());
    let plain = draw(&[]);
    // Whether there are red pixels, and blue ones.
    let hues = |pixels: &[u8]| {
        let share = |c: usize| {
            let is_pure = |pixel: &&[u8]| pixel[c] > 60 && pixel.iter().enumerate().all(|(n, &own)| n == c || own < 9);
            pixels.chunks_exact(3).filter(is_pure).count()
        };
        (share(0) > 50, share(2) > 50)
    };
    std::fs::write(
        f.join("table.json"),
        r##"{"labels": [{"id": 3, "name": "left", "color": "#ff0000"}, {"id": 7, "color": "#0000ff"}]}"##,
    )
    .unwrap();
    let table = ["--label-colors", "ids.nrrd", "--labels=table.json"];
    assert_eq!(hues(&draw(&table)), (true, true));
    assert_eq!(hues(&draw(&[&table[..], &["--label", "left:only"]].concat())), (true, false));
    assert_eq!(hues(&plain), (false, false));
    assert!(draw(&["--label-colors", "ids.nrrd"]) != draw(&table));
    assert!(draw(&["--label-colors", "ids.nrrd", "--label", "3,7:hide"]) == plain, "hidden labels keep the scan's colours");
    assert!(draw(&[&table[..], &["--legend"]].concat()) != draw(&table));
    // The ids at the depths of the scan.
    let ids_at_depths = |more: &[&str]| {
        let depths = ["--depth", "--device-unchecked", "--azimuth", "0", "--elevation", "0", "-o", "d.exr"];
        assert!(layersplat(f, &[&["render"], &scan[..], more, &SIZE, &depths].concat()).status.success());
        let image = exr::prelude::read_first_flat_layer_from_file(f.join("d.exr")).unwrap();
        let ids = image.layer_data.channel_data.list.iter().find(|channel| channel.name.eq("id")).unwrap();
        ids.sample_data.values_as_f32().map(|id| id as u32).collect::<std::collections::BTreeSet<u32>>()
    };
    assert_eq!(ids_at_depths(&table), [0, 3, 7].into());
    // Without a placement, labels of the scan's size lie where the scan does.
    std::fs::write(f.join("own_16x16x16_uint8.raw"), vec![3u8; 4096]).unwrap();
    let own = ["--label-colors", "own_16x16x16_uint8.raw", "--labels=table.json"];
    assert_eq!(hues(&draw(&own)), (true, false));
    assert_eq!(ids_at_depths(&[&own[..], &["--spacing", "9,9,9"]].concat()), [0, 3].into());

    std::fs::write(f.join("half_8x8x8_uint8.raw"), &ids).unwrap();
    std::fs::write(f.join("far.nrrd"), [header("uint8", "(500,0,0)").as_bytes(), &ids].concat()).unwrap();
    let nan: Vec<u8> = (0..512).flat_map(|n| if n == 9 { f32::NAN } else { 3.0f32 }.to_le_bytes()).collect();
    std::fs::write(f.join("nan.nrrd"), [header("float", "(0,0,0)").as_bytes(), &nan].concat()).unwrap();
    let cases: [(&str, i32, &[&str]); 12] = [
        ("--label-colors nothing.nrrd", 1, &["nothing.nrrd"]),
        ("--label-colors half_8x8x8_uint8.raw", 1, &["half_8x8x8", "8x8x8", "16x16x16", "spacing and origin"]),
        ("--label-colors far.nrrd", 1, &["far.nrrd", "lie outside", "placement"]),
        ("--label-colors nan.nrrd", 1, &["nan.nrrd", "its voxel 1,1,0 is not a number"]),
        ("--label-colors ids.nrrd --label 9:hide", 2, &["no label has the id 9", "3 to 7"]),
        ("--label-colors ids.nrrd --labels=nothing.txt", 1, &["nothing.txt"]),
        ("--label-colors ids.nrrd --blend maximum", 2, &["blend", "colours of labels"]),
        ("--label-colors ids.nrrd --classification post", 2, &["--label-colors", "splatted layers"]),
        ("--label-colors ids.nrrd --algorithm view-sheets", 2, &["--label-colors", "ray casting"]),
        ("--label-colors ids.nrrd --with builtin:cube@8", 2, &["--label-colors", "one volume"]),
        ("--label-colors ids.nrrd --look studio", 2, &["--look", "labels beside it"]),
        ("--label-colors ids.nrrd --memory 3k", 2, &["--memory", "set at least"]),
    ];
    for (more, code, words) in cases {
        let arguments: Vec<&str> = ["render"].into_iter().chain(scan).chain(more.split(' ')).chain(SIZE).collect();
        refused(f, &arguments, code, words);
        // A page begins with none of them, either.
        #[cfg(feature = "viewer")]
        refused(f, &["view", "--no-browser"].into_iter().chain(arguments[1..].iter().copied()).collect::<Vec<_>>(), code, words);
    }
}

#[test]
fn mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    components(f);
    std::fs::write(f.join("scene.json"), r#"[{"file": "rgb.nrrd"}, {"color": "grey"}]"#).unwrap();
    std::fs::write(f.join("flat.txt"), "1 1 0 0\n0 0 0 0\n0 0 1 0\n").unwrap();
    let cases: [(&str, i32, &[&str]); 20] = [
        ("rgb.nrrd --channels all --classification post --lattice direct", 2, &["layers per pixel", "one channel", "lattice"]),
        ("rgb.nrrd --channels all --classification post --blend iso --iso 9", 2, &["iso", "pre-integrated"]),
        ("rgb.nrrd --channels 0,3", 2, &["channel", "0 to 2"]),
        ("rgb.nrrd --channels 0,0", 2, &["channel 0 occurs twice"]),
        ("rgb.nrrd --channels 0,ultraviolet", 2, &["'ultraviolet' is not in rgb.nrrd, whose channels are red, green, blue"]),
        ("rgb.nrrd --channels red,0", 2, &["channel 0 occurs twice"]),
        ("rgb.nrrd --channels all --field ultraviolet,factor=2", 2, &["no field 'ultraviolet'"]),
        ("rgb.nrrd --with nothing.nrrd", 1, &["nothing.nrrd"]),
        ("rgb.nrrd --with rgb.nrrd,factor=-1", 2, &["factor"]),
        ("rgb.nrrd --with rgb.nrrd,at=flat.txt", 1, &["flat.txt", "plane"]),
        ("rgb.nrrd --scene scene.json", 1, &["scene.json", "field 2", "names no file"]),
        ("rgb.nrrd --channels all --quality paper", 2, &["one channel", "layers on a lattice"]),
        ("rgb.nrrd --channels all --algorithm view-sheets", 2, &["one channel"]),
        ("rgb.nrrd --colors direct --color-opacity alpha", 2, &["fourth component"]),
        ("rgb.nrrd --colors direct --blend maximum", 2, &["blend"]),
        ("rgb.nrrd --mip", 2, &["blend", "choose one channel"]),
        ("rgb.nrrd --preset ct-bone", 2, &["preset", "--channel N"]),
        ("rgb.nrrd --colors none --color-opacity white", 2, &["color_opacity", "--colors direct"]),
        ("rgb.nrrd --channels all --field 3,factor=2", 2, &["no field 3", "--field N|NAME,KEY=VALUE"]),
        ("rgb.nrrd --field 0,file=other.nrrd", 2, &["file: unknown key"]),
    ];
    for (arguments, code, words) in cases {
        let arguments: Vec<&str> = ["render"].into_iter().chain(arguments.split(' ')).chain(SIZE).collect();
        refused(f, &arguments, code, words);
    }
    let nine: Vec<String> = (0..8).flat_map(|_| ["--with".to_owned(), "rgb.nrrd".to_owned()]).collect();
    let arguments: Vec<&str> = ["render", "rgb.nrrd"].into_iter().chain(nine.iter().map(String::as_str)).chain(SIZE).collect();
    refused(f, &arguments, 2, &["9 fields", "at most 8"]);
}
