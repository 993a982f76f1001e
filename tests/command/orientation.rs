//! The command's views: which way is up, where it looks from, and what it says about that.

use crate::common::command::*;
use crate::common::random_bytes;
use layersplat::glam::{DMat3, DVec3};
use layersplat::image::read_image;
use layersplat::volume::{Grid, Volume};
use layersplat::{Frame, OpenOptions};
use std::path::Path;

const NAME: &str = "plain_14x12x10_uint8.raw";
/// Rounding of a view direction that is expressed by angles, and of the picture along it.
const ROUNDING: f64 = 1e-4;
/// Least difference of pictures from different views.
const TELLING: f64 = 0.05;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(NAME), random_bytes([14, 12, 10], 7)).unwrap();
    folder
}

/// The picture of `render FILE` with these arguments, and its report.
fn picture(folder: &Path, file: &str, arguments: &str) -> (Frame, serde_json::Value) {
    let fixed = ["render", file, "--size", "30x26", "-o", "a.npy"];
    let transfer: &[&str] = if arguments.contains("--transfer") { &[] } else { &["--transfer", "fire"] };
    let report = json(folder, &[&fixed[..], transfer, &arguments.split_whitespace().collect::<Vec<_>>()].concat());
    (read_image(&folder.join("a.npy")).unwrap(), report)
}

fn apart(a: &Frame, b: &Frame) -> f64 {
    a.compare(b).unwrap().max_difference
}

/// Only a view without any angle is seen from the side and from above.
#[test]
fn angles_that_are_not_given() {
    let folder = folder();
    let f = folder.path();
    let of = |arguments: &str| picture(f, NAME, arguments).0;
    assert!(of("") == of("--azimuth 30 --elevation 20 --roll 0"));
    for (given, all) in [
        ("--azimuth 40", "--azimuth 40 --elevation 0 --roll 0"),
        ("--elevation 40", "--azimuth 0 --elevation 40 --roll 0"),
        ("--roll 40", "--azimuth 0 --elevation 0 --roll 40"),
        ("--azimuth 0", "--azimuth 0 --elevation 0 --roll 0"),
        ("--from right", "--azimuth 90 --elevation 0"),
        ("--from back --roll 5", "--azimuth 180 --elevation 0 --roll 5"),
        ("--from below", "--azimuth 0 --elevation -90"),
    ] {
        let found = of(given);
        assert!(found == of(all), "{given}");
        assert!(apart(&found, &of("")) > TELLING, "{given}");
    }
}

/// The sky is above the volume, unless the caller says where up is.
#[test]
fn skies_are_above_the_volume() {
    let folder = folder();
    let of = |arguments: &str| picture(folder.path(), NAME, &format!("--look studio --sky white,black {arguments}")).0;
    for (up, direction, other) in [("y", "0,1,0", "0,0,1"), ("-x", "-1,0,0", "0,0,1"), ("z", "0,0,1", "0,1,0")] {
        let found = of(&format!("--up={up}"));
        assert!(found == of(&format!("--up={up} --sky-up={direction}")), "{up}");
        assert!(apart(&found, &of(&format!("--up={up} --sky-up={other}"))) > TELLING, "{up}");
    }
}

/// Lines of `--cameras`, and keys of a film: each for itself, completed by the command line.
#[test]
fn angles_of_lines_and_keys() {
    let folder = folder();
    let f = folder.path();
    let lines = r#"{"output": "0.npy"}
        {"output": "1.npy", "azimuth": 50}
        {"output": "2.npy", "roll": 0}"#;
    std::fs::write(f.join("views"), lines).unwrap();
    for (given, expected) in [
        ("", ["--azimuth 30 --elevation 20", "--azimuth 50 --elevation 0", "--azimuth 0 --elevation 0"]),
        ("--elevation 15", ["--azimuth 0 --elevation 15", "--azimuth 50 --elevation 15", "--azimuth 0 --elevation 15"]),
        ("--from left", ["--azimuth 270 --elevation 0", "--azimuth 50 --elevation 0", "--azimuth 270 --elevation 0"]),
    ] {
        let all = ["render", NAME, "--size", "30x26", "--transfer", "fire", "--cameras", "views"];
        let done = layersplat(f, &[&all[..], &given.split_whitespace().collect::<Vec<_>>()].concat());
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        for (n, expected) in expected.into_iter().enumerate() {
            let found = read_image(&f.join(format!("{n}.npy"))).unwrap();
            assert!(found == picture(f, NAME, expected).0, "{given}: line {n} is not {expected}");
        }
    }
    // A film of two frames is its keys.
    let film = |keys: &str, given: &str| {
        std::fs::write(f.join("keys"), keys).unwrap();
        let all = ["rotate", NAME, "--size", "30x26", "--transfer", "fire", "--keys", "keys", "--frames", "2", "-o", "film"];
        json(f, &[&all[..], &given.split_whitespace().collect::<Vec<_>>()].concat());
        [0, 1].map(|n| std::fs::read(f.join(format!("film/frame_000{n}.png"))).unwrap())
    };
    let fixed = r#""parallel_scale": 9, "center": [6, 5, 4]"#;
    let keys = |first: &str, last: &str| format!(r#"[{{"time": 0, {first} {fixed}}}, {{"time": 1, {last} {fixed}}}]"#);
    for (given, short, full) in [
        ("", keys("", r#""azimuth": 50,"#), keys(r#""elevation": 20,"#, r#""azimuth": 50, "elevation": 0, "roll": 0,"#)),
        ("--roll 7", keys("", r#""azimuth": 50,"#), keys(r#""elevation": 0,"#, r#""azimuth": 50, "elevation": 0, "roll": 7,"#)),
    ] {
        let [start, end] = film(&short, given);
        assert!([&start, &end] == film(&full, given).each_ref() && start != end, "{given}");
    }
}

/// A voxel of a patient: bright, on the left, in front and above; stored along the axes of `direction`.
fn patient(direction: DMat3) -> Volume<'static> {
    const DIMS: [usize; 3] = [18, 20, 22];
    const PLACE: DVec3 = DVec3::new(-4.0, 5.0, 6.0);
    let half = DVec3::from_array(DIMS.map(|n| (n as f64 - 1.0) / 2.0));
    let grid = Grid::oriented(DIMS, DVec3::ONE, -(direction * half), direction).unwrap().with_anatomy();
    let bright = grid.world_to_voxel(PLACE);
    let voxels = (0..DIMS.iter().product()).map(|n| {
        let place = [n % DIMS[0], n / DIMS[0] % DIMS[1], n / DIMS[0] / DIMS[1]].map(|i| i as f64);
        if DVec3::from_array(place).distance(bright) < 2.0 { 255u8 } else { 0 }
    });
    Volume::new("patient", grid, voxels.collect::<Vec<u8>>()).unwrap()
}

/// Where the light of a picture is: rightwards and upwards from its centre, in pixels.
fn light(frame: &Frame) -> [f64; 2] {
    let (width, height) = (frame.width(), frame.height());
    let mut sums = [0.0; 3];
    for (n, pixel) in frame.pixels().iter().enumerate() {
        let (x, y) = (n as u32 % width, n as u32 / width);
        let weight = f64::from(pixel[3]);
        sums[0] += weight * (f64::from(x) + 0.5 - f64::from(width) / 2.0);
        sums[1] += weight * (f64::from(height) / 2.0 - f64::from(y) - 0.5);
        sums[2] += weight;
    }
    assert!(sums[2] > 1.0, "an empty picture");
    [sums[0] / sums[2], sums[1] / sums[2]]
}

/// Whatever the order of the voxels, and in both formats: the head is up, and the patient looks at the viewer. The expected places follow from
/// RAS alone: the voxel is at left 4, front 5, head 6, and a pixel is a unit.
#[test]
fn patients_stand_upright_and_face_the_viewer() {
    /// Extent of a pixel.
    const PIXEL: f64 = 1.0;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let orders = [
        DMat3::IDENTITY,
        DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z),
        DMat3::from_cols(DVec3::Y, DVec3::NEG_Z, DVec3::NEG_X),
    ];
    let view = "--transfer grey --center 0,0,0 --parallel-scale 13";
    for (n, (direction, ending)) in orders.into_iter().zip(["nii", "nrrd", "nii"]).enumerate() {
        let name = format!("p{n}.{ending}");
        patient(direction).save(f.join(&name)).unwrap();
        for (options, expected) in [
            ("--from front", [4.0, 6.0]),
            ("--azimuth 0", [4.0, 6.0]),
            ("--from back", [-4.0, 6.0]),
            ("--from left", [-5.0, 6.0]),
            ("--azimuth 90", [-5.0, 6.0]),
            ("--from right", [5.0, 6.0]),
            ("--from above", [4.0, -5.0]),
            ("--from below", [4.0, 5.0]),
            ("--up -z --azimuth 0", [-4.0, -6.0]),
            ("--up x --azimuth 0", [6.0, -4.0]),
            ("--up y --azimuth 0", [-4.0, 5.0]),
            ("--up -y --azimuth 0", [4.0, -5.0]),
        ] {
            let (frame, report) = picture(f, &name, &format!("{view} {options}"));
            let found = light(&frame);
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < PIXEL, "{name} {options}: at {found:?}, not {expected:?}");
            let chosen = if options.contains("--up") { "given" } else { "patient" };
            assert_eq!(report["up_reason"], chosen, "{name} {options}");
        }
        // A little from the side: nothing that is given, nothing that is straight.
        let oblique = picture(f, &name, view).0;
        assert!(oblique == picture(f, &name, &format!("{view} --azimuth 30 --elevation 20")).0, "{name}");
    }
}

/// `--up y` shows a patient as if nothing were known of it, to the bit, and as the library does.
#[test]
fn y_up_is_the_librarys_view() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let path = patient(DMat3::IDENTITY).save(f.join("known.nrrd")).unwrap();
    let known = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
    assert!(known.contains("space: right-anterior-superior"));
    let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
    let unknown = Grid::oriented(volume.grid().dims(), DVec3::ONE, volume.grid().origin(), volume.grid().direction()).unwrap();
    let values = (0..unknown.voxel_count()).map(|n| volume.value(n) as u8).collect::<Vec<u8>>();
    Volume::new("unknown", unknown, values).unwrap().save(f.join("unknown.nrrd")).unwrap();
    for view in ["", "--azimuth 70 --perspective 40", "--from right --fit volume", "--box --roll 20"] {
        let view = format!("--transfer grey {view}");
        let (found, report) = picture(f, "known.nrrd", &format!("{view} --up y"));
        let (expected, plain) = picture(f, "unknown.nrrd", &view);
        assert!(found == expected, "{view}");
        assert_eq!([&report["up"], &report["up_reason"]], ["y", "given"]);
        assert_eq!([&plain["up"], &plain["up_reason"]], ["y", "default"]);
        assert!(apart(&found, &picture(f, "known.nrrd", &view).0) > TELLING, "{view}");
    }
}

/// Slices farther apart than their pixels stand upright, in turns, too. The reason is told.
#[test]
fn slices_stand_upright() {
    let folder = folder();
    let f = folder.path();
    let thick = "--spacing 1,1,2 --center 6,5,9 --parallel-scale 12";
    let (upright, report) = picture(f, NAME, thick);
    assert_eq!([&report["up"], &report["up_reason"]], ["z", "slices"]);
    // The same view without orbits: from +y, 30° towards −x, 20° above.
    let ([sin_a, cos_a], [sin_e, cos_e]) = [30f64, 20.0].map(|angle| angle.to_radians().sin_cos().into()).into();
    let eye = DVec3::new(6.0, 5.0, 9.0) + 40.0 * DVec3::new(-cos_e * sin_a, cos_e * cos_a, sin_e);
    let line = serde_json::json!({
        "output": "placed.npy", "position": eye.to_array(), "focal_point": [6, 5, 9], "view_up": [0, 0, 1], "parallel_scale": 12
    });
    // The default view-up is the volume's.
    let mut without_up = line.clone();
    without_up.as_object_mut().unwrap().remove("view_up");
    without_up["output"] = "default.npy".into();
    std::fs::write(f.join("views"), format!("{line}\n{without_up}\n")).unwrap();
    let all = ["render", NAME, "--size", "30x26", "--transfer", "fire", "--spacing", "1,1,2", "--cameras", "views"];
    let done = layersplat(f, &all);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(told.contains("up: z, because slices along z are 2 apart and their pixels 1 by 1"), "{told}");
    let [placed, default] = ["placed.npy", "default.npy"].map(|name| read_image(&f.join(name)).unwrap());
    assert!(apart(&upright, &placed) < ROUNDING && placed == default, "{}", apart(&upright, &placed));
    // A quarter of a turn about z.
    let turn = format!("rotate {NAME} --size 30x26 --transfer fire --frames 4 -o turn {thick}");
    let report = json(f, &turn.split_whitespace().collect::<Vec<_>>());
    assert_eq!([&report["up"], &report["up_reason"]], ["z", "slices"]);
    let still = format!("{thick} --azimuth 90 --elevation 20 --background black");
    picture(f, NAME, &still);
    assert!(layersplat(f, &["compare", "a.npy", "turn/frame_0001.png", "--max-difference", "0.01"]).status.success());
    // Nothing is said where the user said it; benches measure the same view of all volumes.
    let says_up = |arguments: &str| {
        let done = layersplat(f, &arguments.split_whitespace().collect::<Vec<_>>());
        assert!(done.status.success(), "{arguments}");
        String::from_utf8_lossy(&done.stderr).contains("up: ")
    };
    assert!(says_up(&format!("render {NAME} --size 9x9 -o b.png")));
    assert!(!says_up(&format!("render {NAME} --size 9x9 -o b.png --up y")));
    assert!(!says_up(&format!("bench {NAME} --size 9x9 --frames 1 --spacing 1,1,2")));
}

/// Real files: what each says, and that the brain's view is the one from the front.
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
#[test]
fn real_volumes() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let volumes = crate::common::real_volumes();
    let skull = volumes.join("cranium_ct_256x256x108_uint8.raw.gz");
    for (path, options, expected) in [
        (volumes.join("../formats/ch2bet.nii.gz"), "", ["z", "patient"]),
        (volumes.join("../formats/seed.nrrd"), "", ["z", "patient"]),
        (skull.clone(), "--spacing 0.957,0.957,1.5", ["z", "slices"]),
        (skull.clone(), "--spacing 0.957,0.957,1.5 --up -y", ["-y", "given"]),
        (skull, "", ["y", "default"]),
    ] {
        let (_, report) = picture(f, path.to_str().unwrap(), options);
        assert_eq!([&report["up"], &report["up_reason"]], expected, "{}", path.display());
    }
}
