//! `layersplat slice`: files, reports and what is refused.

use crate::common::command::*;
use layersplat::image::read_image;
use serde_json::json;

const SMALL: [&str; 4] = ["slice", "builtin:hydrogen@24", "--size", "30x20"];

fn with(more: &str) -> Vec<&str> {
    [&SMALL[..], &more.split(' ').filter(|word| !word.is_empty()).collect::<Vec<_>>()].concat()
}

#[test]
fn slices_are_written_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let report = json(f, &with("-o a.png"));
    let expected = [
        "at",
        "axis",
        "center",
        "convention",
        "device",
        "height",
        "kernel",
        "output",
        "parallel_scale",
        "right",
        "transfer",
        "up",
        "volume",
        "width",
        "window",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!((&report["axis"], &report["at"], &report["kernel"]), (&json!("z"), &json!(11.5), &json!("linear")));
    assert_eq!((&report["transfer"], &report["parallel_scale"]), (&json!(null), &json!(12.0)));
    assert!(report["window"][1].as_f64().unwrap() > 0.0);
    // The same place in three notations, and the middle.
    for (name, at) in [("b.npy", "--at 6"), ("c.npy", "--at 27.0833333333333333333%"), ("d.npy", "--center 11.5,11.5,6")] {
        let report = json(f, &with(&format!("--axis z {at} -o {name}")));
        assert!((report["at"].as_f64().unwrap() - 6.0).abs() < 1e-9, "{report}");
    }
    let [b, c, d] = ["b.npy", "c.npy", "d.npy"].map(|name| read_image(&f.join(name)).unwrap());
    assert!(b.compare(&c).unwrap().max_difference < 1e-4 && b == d);
    assert!(b.compare(&read_image(&f.join("a.png")).unwrap()).unwrap().max_difference > 0.1, "another slice");
    // Beside the volume is the background.
    assert_eq!((b.pixel(0, 0), b.pixel(15, 10)[3]), ([0.0; 4], 1.0));
    json(f, &with("--background white -o white.npy"));
    assert_eq!(read_image(&f.join("white.npy")).unwrap().pixel(0, 0), [1.0; 4]);
}

/// Colours by the transfer function, and by its opacity; a window of colours is opaque.
#[test]
fn colors_are_chosen_by_options() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let mut pictures = Vec::new();
    for (n, more) in [
        "--window 100,50",
        "--window p50,50",
        "--transfer fire",
        "--transfer fire --thickness 2",
        "--transfer fire --window 100,50",
        "--palette tissue",
        "--tent 120,60",
        "--kernel bspline",
        "--kernel gaussian",
    ]
    .into_iter()
    .enumerate()
    {
        let report = json(f, &with(&format!("{more} -o {n}.npy")));
        assert_eq!(report["window"].is_null(), more.contains("--t") || more.contains("--p"), "{more}");
        pictures.push(read_image(&f.join(format!("{n}.npy"))).unwrap());
    }
    for (n, one) in pictures.iter().enumerate() {
        for other in &pictures[..n] {
            assert!(one.compare(other).unwrap().max_difference > 1e-3, "each option changes the picture");
        }
    }
    let opacity = |n: usize| pictures[n].pixel(15, 10)[3];
    assert_eq!((opacity(0), opacity(4)), (1.0, 1.0));
    assert!(opacity(2) == 0.0 || opacity(2) == 1.0);
    assert!(opacity(3) < 1.0);
}

#[test]
fn values_are_the_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let voxels: Vec<u8> = (0..60).map(|n| n * 3 + 1).collect();
    std::fs::write(f.join("v_5x4x3_uint8.raw"), &voxels).unwrap();
    json(f, &["slice", "v_5x4x3_uint8.raw", "--axis", "z", "--at", "1", "--size", "5x4", "--values", "-o", "v.npy"]);
    let slice = layersplat::Volume::open(f.join("v.npy").to_str().unwrap(), &layersplat::OpenOptions::default()).unwrap();
    assert_eq!(slice.grid().dims(), [5, 4, 1]);
    let found: Vec<f32> = (0..20).map(|n| slice.value(n) as f32).collect();
    let expected = (0..4).rev().flat_map(|y| (0..5).map(move |x| f32::from((x + 5 * (y + 4)) as u8 * 3 + 1)));
    assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.01), "{found:?}");
}

/// A patient stored from left to right, from front to back and from head to feet.
#[test]
fn slices_of_patients_are_seen_from_the_usual_side() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 5 5\nencoding: raw\nspace: left-posterior-superior\n\
        space directions: (-1,0,0) (0,1,0) (0,0,-2)\nspace origin: (30,-4,100)\n\n";
    // Bright at the patient's right (the last x) and at the front (the first y).
    let voxel = |n: usize| {
        if n % 5 == 4 {
            200
        } else if (n / 5).is_multiple_of(5) {
            100
        } else {
            10
        }
    };
    let bytes = [header.as_bytes(), &(0..125).map(voxel).collect::<Vec<u8>>()].concat();
    std::fs::write(f.join("patient.nrrd"), bytes).unwrap();
    let slice = |more: &[&str]| {
        json(f, &[&["slice", "patient.nrrd", "--size", "5x5", "--window", "128,256", "-o", "a.npy"], more].concat())
    };
    let report = slice(&[]);
    assert_eq!((&report["axis"], &report["at"]), (&json!("axial"), &json!(96.0)));
    let axial = read_image(&f.join("a.npy")).unwrap();
    let grey = |x: u32, y: u32| (axial.pixel(x, y)[0] * 256.0).round();
    assert_eq!((grey(0, 2), grey(2, 0), grey(2, 4)), (200.0, 100.0, 10.0), "right on the left, the front above");
    let coronal = slice(&["--axis", "coronal", "--at", "0%"]);
    assert_eq!((&coronal["up"], &coronal["right"]), (&json!([0.0, 0.0, 1.0]), &json!([-1.0, 0.0, 0.0])));
    let message = layersplat(f, &["slice", "builtin:hydrogen@8", "--axis", "sagittal"]);
    assert_eq!(message.status.code(), Some(2));
}

#[test]
fn bad_slices_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for (more, code, words) in [
        ("--axis w", 2, "possible values: x, y, z, axial, coronal, sagittal"),
        ("--at 101%", 2, "from 0% to 100%"),
        ("--at 24", 2, "outside the volume|-0.5 to 23.5|--at N"),
        ("--axis axial", 2, "use x, y or z|--axis x"),
        ("--plane 1,2,3", 2, "a point and a normal"),
        ("--plane 1,2,3,0,0,1 --at 4", 2, "cannot be used"),
        ("--plane 1,2,3,0,0,1 --up z", 2, "span no plane|--plane"),
        ("--center 1,2,3 --at 4", 2, "cannot be used"),
        ("--up y", 2, "--plane"),
        ("--window 5,0", 2, "LEVEL,WIDTH"),
        ("--thickness 0", 2, "above 0"),
        ("--values -o a.png", 2, ".npy|--values"),
        ("--background transparent -o a.jpg", 2, "JPEG"),
        ("--bits 16 -o a.webp", 2, "--bits"),
        ("-o a.doc", 2, "picture format"),
        ("--kernel nearest", 2, "catmull-rom"),
        ("-o missing/a.png", 1, "missing"),
    ] {
        refused(f, &with(more), code, &words.split('|').collect::<Vec<_>>());
    }
}

/// A plane through any point, seen from its normal, fills the picture; the command is in the file.
#[test]
fn planes_and_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let report = json(f, &with("--plane 9,10,12,1,1,0.5 -o plane.png"));
    assert!(report["axis"].is_null() && report["at"].is_null(), "{report}");
    let bytes = std::fs::read(f.join("plane.png")).unwrap();
    let text = String::from_utf8_lossy(&bytes).into_owned();
    assert!(text.contains("--plane 9,10,12,1,1,0.5"));
    let placed = json(f, &with("--plane 9,10,12,1,1,0.5 --parallel-scale 3 -o near.png"));
    assert_eq!((&placed["center"], &placed["parallel_scale"]), (&json!([9.0, 10.0, 12.0]), &json!(3.0)));
    let out = layersplat(f, &with("-o -"));
    assert!(out.status.success() && out.stdout.starts_with(b"\x89PNG"));
}

/// Slices of labels have the colours of the nearest ones, or their ids; over a scan they are half transparent.
#[test]
fn labels_keep_their_ids_and_colors() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    // The label 3 in the left half of each slice, and 70 in the right one.
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 6 2\nspace: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n";
    let voxels = |of: &dyn Fn(usize) -> u8| [header.as_bytes(), &(0..72).map(of).collect::<Vec<_>>()].concat();
    std::fs::write(f.join("ids.nrrd"), voxels(&|n| if n % 6 < 3 { 3 } else { 70 })).unwrap();
    std::fs::write(f.join("scan.nrrd"), voxels(&|n| if n > 0 { 200 } else { 0 })).unwrap();
    let common = ["--axis", "z", "--at", "1", "--size", "12x12", "--letters", "off"];
    let slice = |arguments: &[&str]| json(f, &[&["slice"], arguments, &common].concat());
    slice(&["ids.nrrd", "--labels", "--values", "-o", "ids.npy"]);
    let ids = std::fs::read(f.join("ids.npy")).unwrap();
    let ids: Vec<f32> = ids[ids.len() - 4 * 144..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(ids.iter().enumerate().all(|(n, &id)| id == if n % 12 < 6 { 3.0 } else { 70.0 }), "{ids:?}");
    slice(&["ids.nrrd", "--labels", "--label", "3:#ff0000", "--label", "70:hide", "-o", "labels.npy"]);
    let labels = read_image(&f.join("labels.npy")).unwrap();
    assert_eq!((labels.pixel(2, 5), labels.pixel(9, 5)), ([1.0, 0.0, 0.0, 1.0], [0.0; 4]));
    let over = ["scan.nrrd", "--window", "200,400", "--label-colors", "ids.nrrd", "--label", "3:#ff0000", "--label", "70:hide"];
    slice(&[&over[..], &["-o", "over.npy"]].concat());
    let over = read_image(&f.join("over.npy")).unwrap();
    assert_eq!((over.pixel(2, 5), over.pixel(9, 5)), ([0.75, 0.25, 0.25, 1.0], [0.5, 0.5, 0.5, 1.0]));
    for (more, problem) in [
        (["--opacity", "0:1"], "opacity: is for values; labels have the colours and opacities of their table"),
        (["--with", "scan.nrrd"], "--label-colors"),
        (["--label-surfaces", "smooth"], "nearest"),
        (["--mask", "ids.nrrd"], "--label IDS:only"),
        (["--background-value", "3"], "background_value: is for values"),
        (["--thickness", "3"], "thickness: is that of a layer of values"),
    ] {
        refused(f, &[&["slice", "ids.nrrd", "--labels"], &more[..]].concat(), 2, &[problem]);
    }
    refused(
        f,
        &["slice", "scan.nrrd", "--label-colors", "ids.nrrd", "--values", "-o", "v.npy"],
        2,
        &["label_colors: colour pictures"],
    );
}

/// Letters stand at the edges where the file says how the patient lies, and the side of the left is said.
#[test]
fn slices_of_patients_have_letters() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n";
    std::fs::write(f.join("head.nrrd"), [header.as_bytes(), &[0; 63], &[9]].concat()).unwrap();
    let conventions = ["axial", "coronal", "sagittal", "z"]
        .map(|axis| json(f, &["slice", "head.nrrd", "--axis", axis, "--size", "60x60", "-o", "s.png"])["convention"].clone());
    assert_eq!(conventions, [json!("radiological"), json!("radiological"), json!(null), json!("radiological")]);
    let lit = |letters: &[&str]| {
        let arguments = [&["slice", "head.nrrd", "--window", "500,2", "--size", "60x60", "-o", "s.png"], letters].concat();
        assert!(layersplat(f, &arguments).status.success());
        let picture = image::open(f.join("s.png")).unwrap().into_luma8();
        // The middle of each edge.
        [(52..60, 22..38), (0..14, 22..38), (22..38, 0..20), (22..38, 42..60)].map(|(columns, rows)| {
            rows.into_iter().flat_map(|y| columns.clone().map(move |x| (x, y))).any(|(x, y)| picture.get_pixel(x, y).0[0] > 128)
        })
    };
    assert_eq!((lit(&[]), lit(&["--letters", "off"])), ([true; 4], [false; 4]));
    refused(f, &["slice", "builtin:cube@8", "--letters", "on"], 2, &["how the patient lies"]);
}

/// Fields on grids of their own lie over a slice in grey, and are mixed with one in colours.
#[test]
fn slices_show_several_fields() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    // Blocks of one value but for a corner: 100 of 8 voxels, and 50 of 4 voxels twice as large.
    let block = |n: usize, value: u8| (0..n * n * n).map(|i| if i > 0 { value } else { 0 }).collect::<Vec<u8>>();
    std::fs::write(f.join("a_8x8x8_uint8.raw"), block(8, 100)).unwrap();
    std::fs::write(f.join("b_4x4x4_uint8.raw"), block(4, 50)).unwrap();
    let pixel = |arguments: &[&str]| {
        json(f, &[&["slice", "a_8x8x8_uint8.raw", "--axis", "z", "--size", "16x16", "-o", "s.npy"], arguments].concat());
        read_image(&f.join("s.npy")).unwrap().pixel(7, 7).map(|c| (f64::from(c) * 1e4).round() / 1e4)
    };
    let with = ["--with", "b_4x4x4_uint8.raw,spacing=2,2,2,origin=0.5,0.5,0.5,color=#ff0000,opacity=0:0,50:0.5"];
    let grey = pixel(&[&["--window", "100,200"], &with[..]].concat());
    assert_eq!(grey, [0.75, 0.25, 0.25, 1.0]);
    assert_eq!(pixel(&[&["--window", "100,200", "--field", "0,visible=off"], &with[..]].concat()), [0.5, 0.0, 0.0, 0.5]);
    let field = ["--field", "0,color=#0000ff,opacity=0:0,100:0.5"];
    assert_eq!(pixel(&[&field[..], &with].concat()), [0.375, 0.0, 0.375, 0.75]);
    assert_eq!(pixel(&[&field[..], &["--field", "1,visible=off"], &with].concat()), [0.0, 0.0, 0.5, 0.5]);
    // Opacities and a thickness are those of a field in its own colour, too.
    assert_eq!(pixel(&["--field", "0,color=#0000ff", "--opacity", "0:0,100:0.5", "--thickness", "1"]), [0.0, 0.0, 0.5, 0.5]);
    refused(f, &[&["slice", "a_8x8x8_uint8.raw", "--values", "-o", "v.npy"], &with[..]].concat(), 2, &["one field"]);
    refused(f, &["slice", "a_8x8x8_uint8.raw", "--field", "0,iso=5"], 2, &["omit iso"]);
}

/// Slices of colours have the colours that the file states; those of transparent voxels do not bleed.
#[test]
fn slices_of_colors_are_in_colors() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 2\nkinds: RGBA-color domain domain domain\nencoding: raw\n\n";
    // The first columns are red and transparent, the others green and opaque.
    let voxel = |n: usize| if n % 4 < 2 { [255, 0, 0, 0] } else { [0, 51 * (n / 4 % 4) as u8, 102, 255] };
    let bytes: Vec<u8> = (0..32).flat_map(voxel).collect();
    std::fs::write(f.join("c.nrrd"), [header.as_bytes(), &bytes].concat()).unwrap();
    let slice = |more: &[&str]| {
        json(f, &[&["slice", "c.nrrd", "--size", "4x4", "--at", "0", "-o", "c.npy"][..], more].concat());
        let picture = read_image(&f.join("c.npy")).unwrap();
        [(0, 0), (1, 1), (2, 1), (3, 3)].map(|(x, y)| picture.pixel(x, y))
    };
    // Rows of pictures begin at the top, where y is largest.
    assert_eq!(slice(&[]), [[0.0; 4], [0.0; 4], [0.0, 0.4, 0.4, 1.0], [0.0, 0.0, 0.4, 1.0]]);
    json(f, &["slice", "c.nrrd", "--size", "8x8", "--at", "0", "-o", "fine.npy"]);
    let fine = read_image(&f.join("fine.npy")).unwrap();
    assert!((0..64).all(|n| fine.pixel(n % 8, n / 8)[0] == 0.0), "red is transparent");
    assert_eq!(slice(&["--channel", "3", "--window", "0.5,1"])[2], [1.0; 4]);
}
