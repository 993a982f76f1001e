//! `rotate --time`: pictures are those of `render --frame`, and refused sequences.

use super::*;
use std::fs::write;

const DIMS: [usize; 3] = [14, 12, 10];
const STEPS: usize = 4;
/// Camera that no transfer function and no other view changes.
const CAMERA: &str = "--fit volume --elevation 15 --size 30x24";

/// Voxels of a step: noise from 0 on, brighter with time.
fn voxels(step: usize) -> Vec<u8> {
    let scale = |byte: u8| (usize::from(byte) * (step + 1) / STEPS) as u8;
    let mut voxels: Vec<u8> = random_bytes(DIMS, step as u64 + 1).into_iter().map(scale).collect();
    voxels[0] = 0;
    voxels
}

/// A NIfTI file of int16 with a time axis, its values scaled by 0.5.
fn nifti(path: &Path, steps: usize) {
    let mut header = [0u8; 352];
    header[0..4].copy_from_slice(&348i32.to_le_bytes());
    let sizes = [4, DIMS[0], DIMS[1], DIMS[2], steps, 1, 1, 1];
    for (n, size) in sizes.into_iter().enumerate() {
        header[40 + 2 * n..42 + 2 * n].copy_from_slice(&(size as i16).to_le_bytes());
    }
    header[70..72].copy_from_slice(&4i16.to_le_bytes());
    header[72..74].copy_from_slice(&16i16.to_le_bytes());
    for n in 0..5 {
        header[76 + 4 * n..80 + 4 * n].copy_from_slice(&1f32.to_le_bytes());
    }
    header[108..112].copy_from_slice(&352f32.to_le_bytes());
    header[112..116].copy_from_slice(&0.5f32.to_le_bytes());
    header[344..348].copy_from_slice(b"n+1\0");
    let numbers = (0..steps).flat_map(voxels).flat_map(|n| i16::from(n).to_le_bytes());
    write(path, header.into_iter().chain(numbers).collect::<Vec<u8>>()).unwrap();
}

fn nrrd(path: &Path, [x, y, z]: [usize; 3], voxels: &[u8]) {
    let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {x} {y} {z}\nencoding: raw\n\n");
    write(path, [header.as_bytes(), voxels].concat()).unwrap();
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    nifti(&folder.path().join("beat.nii"), STEPS);
    for step in 0..STEPS {
        nrrd(&folder.path().join(format!("s{step}.nrrd")), DIMS, &voxels(step));
    }
    folder
}

fn film(folder: &Path, arguments: &str) -> Vec<Frame> {
    let output = folder.join("film");
    let _ = std::fs::remove_dir_all(&output);
    done(folder, &format!("rotate {arguments} {CAMERA} --bits 16 -o film"));
    names(&output).iter().map(|name| read_image(&output.join(name)).unwrap()).collect()
}

fn still(folder: &Path, arguments: &str) -> Frame {
    done(folder, &format!("render {arguments} {CAMERA} --bits 16 -o still.png"));
    read_image(&folder.join("still.png")).unwrap()
}

/// Standing and turning, from one file and from several, in the range of values of all steps.
#[test]
fn pictures_of_a_sequence_are_those_of_its_frames() {
    let folder = folder();
    let f = folder.path();
    let largest = |step: usize| f64::from(*voxels(step).iter().max().unwrap());
    let most = largest(STEPS - 1);
    assert!(most > 1.2 * largest(STEPS - 2));
    let files: Vec<String> = (0..STEPS).map(|n| format!("s{n}.nrrd")).collect();
    for turn in [0, 360, 90] {
        let frames = film(f, &format!("beat.nii --time --turn {turn} --azimuth 30 --transfer fire"));
        let from_files = film(f, &format!("{} --time --turn {turn} --azimuth 30 --transfer fire", files.join(" ")));
        assert_eq!((frames.len(), from_files.len()), (STEPS, STEPS));
        let view = |n: usize| {
            let azimuth = 30.0 + f64::from(turn) * n as f64 / if turn == 90 { STEPS - 1 } else { STEPS } as f64;
            format!("--azimuth {azimuth} --transfer fire")
        };
        for n in 0..STEPS {
            let range = |most: f64| format!("--transfer-range 0,{most}");
            assert!(frames[n] == still(f, &format!("beat.nii --frame {n} {} {}", view(n), range(most / 2.0))), "{turn}: {n}");
            assert!(from_files[n] == still(f, &format!("s{n}.nrrd {} {}", view(n), range(most))), "{turn}: {n}");
        }
        // Another step, another view and the range of one step are noticed.
        let range = format!("--transfer-range 0,{}", most / 2.0);
        assert!(frames[1] != still(f, &format!("beat.nii --frame 2 {} {range}", view(1))));
        assert!(frames[1] != still(f, &format!("beat.nii --frame 1 {}", view(1))));
        assert!(turn == 0 || frames[1] != still(f, &format!("beat.nii --frame 1 {} {range}", view(2))));
    }
}

/// Built-in volumes of different ranges; more and fewer pictures than steps; the film of the automatic transfer function.
#[test]
fn steps_repeat_or_are_left_out() {
    let folder = folder();
    let f = folder.path();
    let options = "--turn 0 --transfer fire --transfer-range 0,128";
    let all = film(f, &format!("beat.nii --time {options}"));
    for (frames, steps) in [(6, vec![0, 1, 1, 2, 2, 3]), (2, vec![0, 3]), (1, vec![0])] {
        let found = film(f, &format!("beat.nii --time {options} --frames {frames}"));
        let expected: Vec<&Frame> = steps.iter().map(|&step| &all[step]).collect();
        assert!(found.iter().eq(expected), "{frames}");
    }
    let report =
        json(f, &["rotate", "builtin:cube@8", "builtin:gyroid@8", "--time", "--turn", "0", "--size", "20", "-o", "g.gif"]);
    assert_eq!((&report["frames"], &report["steps"]), (&2.into(), &2.into()));
    let decoder = GifDecoder::new(BufReader::new(std::fs::File::open(f.join("g.gif")).unwrap())).unwrap();
    assert_eq!(decoder.into_frames().count(), 2);
    let said = done(f, "rotate beat.nii --time --mip --size 20x20 -o mip.gif").stderr;
    let one = done(f, "render beat.nii --frame 0 --mip --size 20x20 -o mip.png").stderr;
    let upper = |said: Vec<u8>| {
        let said = String::from_utf8(said).unwrap();
        let line = said.lines().find(|line| line.starts_with("transfer function: grey")).unwrap().to_owned();
        line.split(" to ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(upper(said) > 2.0 * upper(one), "the ramp is that of the sequence");
}

/// Steps that go through the memory of the device in parts have the bits of whole ones.
#[test]
fn sequences_are_streamed() {
    let folder = folder();
    let f = folder.path();
    let options = "beat.nii --time --turn 0 --transfer fire";
    assert!(film(f, &format!("{options} --memory 253000")) == film(f, options));
    let said = done(f, &format!("rotate {options} {CAMERA} --memory 253000 -o parts.gif")).stderr;
    assert!(String::from_utf8_lossy(&said).contains("2 parts"), "{}", String::from_utf8_lossy(&said));
    let arguments = format!("rotate {options} --size 30x24 --memory 1000 -o no.gif");
    refused(f, &arguments.split(' ').collect::<Vec<_>>(), 2, &["--memory", "budget"]);
}

/// The frames of keys: between keys, before the first and after the last; and time over a path whose keys have none.
#[test]
fn keys_choose_frames() {
    let folder = folder();
    let f = folder.path();
    let look = "--transfer fire --transfer-range 0,128 --rate 4";
    let key = |time: f64, azimuth: f64, frame: &str| format!(r#"{{"time": {time}, "azimuth": {azimuth}{frame}}}"#);
    let keys = |frames: [&str; 3]| {
        let [a, b, c] = frames;
        format!("[{}, {}, {}]", key(0.0, 0.0, a), key(1.0, 90.0, b), key(1.5, 90.0, c))
    };
    write(f.join("plain.json"), keys(["", "", ""])).unwrap();
    write(f.join("frames.json"), keys([r#", "frame": 3"#, r#", "frame": 0.4"#, ""])).unwrap();
    let plain: Vec<Vec<Frame>> = (0..STEPS).map(|n| film(f, &format!("beat.nii --frame {n} --keys plain.json {look}"))).collect();
    // 3, 2.35, 1.7, 1.05, 0.4, 0.4, 0.4.
    let found = film(f, &format!("beat.nii --keys frames.json {look}"));
    assert!(found.iter().enumerate().all(|(n, frame)| *frame == plain[[3, 2, 2, 1, 0, 0, 0][n]][n]) && found.len() == 7);
    assert!(found[1] != plain[3][1]);
    // 0, 0.5, 1, 1.5, 2, 2.5, 3.
    let spread = film(f, &format!("beat.nii --keys plain.json --time {look}"));
    assert!(spread.iter().enumerate().all(|(n, frame)| *frame == plain[[0, 1, 1, 2, 2, 3, 3][n]][n]) && spread.len() == 7);
    write(f.join("beyond.json"), keys([r#", "frame": 0"#, r#", "frame": 4"#, ""])).unwrap();
    write(f.join("wrong.json"), keys([r#", "frame": -1"#, "", ""])).unwrap();
    for (arguments, code, words) in [
        ("beat.nii --keys beyond.json", 1, ["key 2", "0 to 3"]),
        ("beat.nii --keys wrong.json", 1, ["key 1", "from 0"]),
        ("beat.nii --time --keys frames.json", 2, ["conflict", "--time"]),
        ("beat.nii --frame 1 --keys frames.json", 2, ["frame", "omit"]),
        ("beat.nii --turn 20 --keys plain.json", 2, ["--turn", "--keys"]),
    ] {
        let arguments: Vec<&str> = ["rotate"].into_iter().chain(arguments.split(' ')).chain(["-o", "no.gif"]).collect();
        refused(f, &arguments, code, &words);
    }
}

/// A mask is that of every step, and labels colour all of them: while time runs, and by the frames of keys.
#[test]
fn masks_and_labels_are_those_of_every_step() {
    let folder = folder();
    let f = folder.path();
    let half: Vec<u8> = (0..DIMS.iter().product()).map(|n| if n % DIMS[0] < 7 { 1 } else { 2 }).collect();
    nrrd(&f.join("halves.nrrd"), DIMS, &half);
    let [key, other] =
        [(0.0, 0), (1.0, STEPS - 1)].map(|(time, n)| format!(r#"{{"time": {time}, "azimuth": 30, "frame": {n}}}"#));
    write(f.join("keys.json"), format!("[{key}, {other}]")).unwrap();
    let look = "--azimuth 30 --transfer fire --transfer-range 0,128";
    let plain = film(f, &format!("beat.nii --time --turn 0 {look}"));
    for option in ["--mask halves.nrrd:2", "--label-colors halves.nrrd --label 1:#00ff00"] {
        let frames = film(f, &format!("beat.nii --time --turn 0 {look} {option}"));
        let of_keys = film(f, &format!("beat.nii --keys keys.json --rate {} {look} {option}", STEPS - 1));
        let of_files = film(f, &format!("s0.nrrd s1.nrrd --time --turn 0 {look} {option}"));
        assert!(frames.len() == STEPS && of_keys.len() == STEPS);
        for n in 0..STEPS {
            assert!(frames[n] == still(f, &format!("beat.nii --frame {n} {look} {option}")), "{option}: {n}");
            assert!(frames[n] == of_keys[n] && frames[n] != plain[n], "{option}: {n}");
        }
        assert!(of_files[1] == still(f, &format!("s1.nrrd {look} {option}")), "{option}");
    }
    // A field beside others has a frame and a mask of its own.
    let second = "--field 0,visible=off --azimuth 30 --with beat.nii,frame=2,transfer=fire";
    let alone = still(f, "beat.nii --frame 2 --azimuth 30 --mask halves.nrrd:2 --transfer fire");
    assert!(still(f, &format!("beat.nii --frame 0 {second},mask=halves.nrrd:2")) == alone);
    assert!(still(f, &format!("beat.nii --frame 0 {second}")) != alone);
    // The values of all steps are those within the mask.
    let bright: Vec<u8> = voxels(1).iter().zip(&half).map(|(&v, &id)| if id == 1 { 255 } else { v / 4 }).collect();
    nrrd(&f.join("bright.nrrd"), DIMS, &bright);
    let of_all = film(f, "bright.nrrd bright.nrrd --time --turn 0 --azimuth 30 --mask halves.nrrd:2 --transfer fire");
    assert!(of_all[1] == still(f, "bright.nrrd --azimuth 30 --mask halves.nrrd:2 --transfer fire"));
}

/// Fields beside the first have a step for each of its steps, or stand still.
#[test]
fn several_fields_play_together() {
    let folder = folder();
    let f = folder.path();
    let look = "--azimuth 30 --transfer fire --transfer-range 0,128";
    let with = "transfer=cool-warm,range=0,60,opacity=0:0,60:0.3";
    let [key, other] =
        [(0.0, 0), (1.0, STEPS - 1)].map(|(time, n)| format!(r#"{{"time": {time}, "azimuth": 30, "frame": {n}}}"#));
    write(f.join("keys.json"), format!("[{key}, {other}]")).unwrap();
    let files: Vec<String> = (0..STEPS).map(|n| format!("s{n}.nrrd")).collect();
    let both = film(f, &format!("beat.nii --keys keys.json --rate {} {look} --with beat.nii,{with}", STEPS - 1));
    let still_beside = film(f, &format!("{} --time --turn 0 {look} --with beat.nii,frame=2,{with}", files.join(" ")));
    assert_eq!((both.len(), still_beside.len()), (STEPS, STEPS));
    for n in 0..STEPS {
        assert!(both[n] == still(f, &format!("beat.nii --frame {n} {look} --with beat.nii,frame={n},{with}")), "{n}");
        assert!(still_beside[n] == still(f, &format!("s{n}.nrrd {look} --with beat.nii,frame=2,{with}")), "{n}");
    }
    // Components of a file: two, and a range of all steps.
    let [x, y, z] = DIMS;
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 5\nsizes: 2 {x} {y} {z} 2\nkinds: vector domain domain domain time\nencoding: raw\n\n"
    );
    let pairs = |step: usize| voxels(step).into_iter().zip(voxels(3 - step)).flat_map(|(one, other)| [one, other]);
    write(f.join("5d.nrrd"), header.bytes().chain(pairs(0)).chain(pairs(1)).collect::<Vec<u8>>()).unwrap();
    let looks = "--field 0,color=#ff0000,range=0,200,opacity=0:0,200:0.5 --field 1,color=#00ff00,range=0,200,opacity=0:0,200:0.5";
    let of_channels = film(f, &format!("5d.nrrd --time --turn 0 --azimuth 30 --channels all {looks}"));
    assert_eq!(of_channels.len(), 2);
    for (n, frame) in of_channels.iter().enumerate() {
        assert!(*frame == still(f, &format!("5d.nrrd --frame {n} --azimuth 30 --channels all {looks}")), "{n}");
    }
    assert!(of_channels[0] != of_channels[1]);
}

/// Labels and colours of each step are those of its frame. The names are those of all steps: a label that is there later has a place in the
/// list from the first picture on, and can be changed.
#[test]
fn labels_and_colors_play() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let [x, y, z] = DIMS;
    let count = x * y * z;
    let ids = |step: usize| (0..count).map(move |n| if n % x < 5 { 3 } else { 7 * u8::from(step > 0 && n % x > 9) });
    let header =
        format!("NRRD0004\ntype: uint8\ndimension: 4\nsizes: {x} {y} {z} 3\nkinds: domain domain domain time\nencoding: raw\n\n");
    write(f.join("ids.nrrd"), header.bytes().chain((0..3).flat_map(ids)).collect::<Vec<u8>>()).unwrap();
    for step in 0..2 {
        nrrd(&f.join(format!("ids{step}.nrrd")), DIMS, &ids(step).collect::<Vec<u8>>());
    }
    let look = "--azimuth 30 --labels --label 7:#00ff00";
    // The first step has no such label.
    refused(f, &format!("render ids.nrrd --frame 0 {look} -o no.png").split(' ').collect::<Vec<_>>(), 2, &["7"]);
    let frames = film(f, &format!("ids.nrrd --time --turn 0 {look}"));
    let of_files = film(f, &format!("ids0.nrrd ids1.nrrd --time --turn 0 {look}"));
    assert!(frames[0] == still(f, "ids.nrrd --frame 0 --azimuth 30 --labels") && frames[0] == of_files[0]);
    for n in [1, 2] {
        assert!(frames[n] == still(f, &format!("ids.nrrd --frame {n} {look}")), "{n}");
    }
    assert!(frames[1] == of_files[1] && frames[1] != frames[0]);
    let listed = film(f, &format!("ids.nrrd --time --turn 0 {look} --legend"));
    let green = |frame: &Frame| (0..30 * 24).filter(|n| frame.pixel(n % 30, n / 30)[1] > 0.9).count();
    assert!(green(&listed[0]) > 0 && green(&frames[0]) == 0, "the list has the label that comes later");

    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 5\nsizes: 3 {x} {y} {z} 2\nkinds: RGB-color domain domain domain time\nencoding: raw\n\n"
    );
    let colors = |step: usize| voxels(step + 2).into_iter().flat_map(move |v| [v, v / 2 * step as u8, 20]);
    write(f.join("rgb.nrrd"), header.bytes().chain(colors(0)).chain(colors(1)).collect::<Vec<u8>>()).unwrap();
    let [key, other] = [(0.0, 0), (1.0, 1)].map(|(time, n)| format!(r#"{{"time": {time}, "azimuth": 30, "frame": {n}}}"#));
    write(f.join("keys.json"), format!("[{key}, {other}]")).unwrap();
    let frames = film(f, "rgb.nrrd --time --turn 0 --azimuth 30");
    let of_keys = film(f, "rgb.nrrd --keys keys.json --rate 1");
    assert_eq!((frames.len(), of_keys.len()), (2, 2));
    for n in 0..2 {
        assert!(frames[n] == still(f, &format!("rgb.nrrd --frame {n} --azimuth 30")) && frames[n] == of_keys[n], "{n}");
    }
    assert!(frames[0] != frames[1]);
}

#[test]
fn sequences_that_cannot_be_played_are_refused() {
    let folder = folder();
    let f = folder.path();
    nrrd(&f.join("small.nrrd"), [14, 12, 9], &voxels(0)[..14 * 12 * 9]);
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain domain domain\nencoding: raw\n\n";
    write(f.join("rgb.nrrd"), [header.as_bytes(), &[9; 24]].concat()).unwrap();
    let bytes = std::fs::read(f.join("beat.nii")).unwrap();
    write(f.join("cut.nii"), &bytes[..bytes.len() - 1]).unwrap();
    for (arguments, code, words) in [
        (
            "s0.nrrd small.nrrd --time",
            1,
            vec!["small.nrrd", "step 1", "14x12x9 voxels of uint8", "s0.nrrd", "14x12x10", "convert"],
        ),
        ("beat.nii s0.nrrd --time", 1, vec!["s0.nrrd", "step 4", "uint8", "int16"]),
        ("cut.nii --time", 1, vec!["cut.nii", "truncated"]),
        ("s0.nrrd --time", 1, vec!["s0.nrrd", "one volume", "time axis"]),
        ("s0.nrrd s1.nrrd", 2, vec!["--time", "add it"]),
        ("s0.nrrd missing.nrrd --time", 1, vec!["missing.nrrd"]),
        ("beat.nii --time --frame 1", 2, vec!["--frame", "omit"]),
        ("- --time", 2, vec!["standard input", "name a file"]),
        ("s0.nrrd s1.nrrd --time --with beat.nii", 2, vec!["--time", "2 steps", "has 4"]),
        ("beat.nii --time --with beat.nii,frame=4", 2, vec!["frame is 4"]),
        ("beat.nii --time --with rgb.nrrd", 1, vec!["rgb.nrrd", "films do not play beside other fields", "channel=N"]),
        ("beat.nii --time --with rgb.nrrd,channel=0,labels=", 1, vec!["rgb.nrrd", "holds labels"]),
        ("beat.nii --time --channels 0,1", 2, vec!["channel", "beat.nii"]),
        ("beat.nii --time --scene scene.json", 2, vec!["--time", "--with"]),
        ("beat.nii --time --labels", 1, vec!["beat.nii", "whole numbers"]),
        ("beat.nii --time --colors direct", 2, vec!["3 or 4 components"]),
        ("beat.nii --time --colors direction", 2, vec!["--time", "directions of vectors", "--frame"]),
        ("s0.nrrd s1.nrrd --time --labels --label 999:hide", 2, vec!["999"]),
        ("beat.nii --time --mask s9.nrrd", 1, vec!["s9.nrrd"]),
        ("beat.nii --time --mask s0.nrrd:999", 2, vec!["no label has the id 999"]),
        ("beat.nii --turn x", 2, vec!["--turn"]),
    ] {
        for output in ["no.gif", "no"] {
            let arguments: Vec<&str> = ["rotate"].into_iter().chain(arguments.split(' ')).chain(["-o", output]).collect();
            refused(f, &arguments, code, &words);
        }
    }
}

/// The files of a `.pvd` in a folder of its own, in the order of time.
#[cfg(feature = "vtk")]
#[test]
fn collections_are_sequences() {
    let folder = folder();
    let f = folder.path();
    std::fs::create_dir(f.join("run")).unwrap();
    for step in 0..STEPS {
        done(f, &format!("convert s{step}.nrrd run/{step}.vti"));
    }
    let collection = |name: &str, entries: &[(&str, &str)]| {
        let entry = |(time, file): &(&str, &str)| format!(r#"<DataSet timestep="{time}" group="" part="0" file="{file}"/>"#);
        let entries: String = entries.iter().map(entry).collect();
        let text = format!(r#"<?xml version="1.0"?><VTKFile type="Collection"><Collection>{entries}</Collection></VTKFile>"#);
        write(f.join(name), text).unwrap();
    };
    collection("run.pvd", &[("10", "run/2.vti"), ("0", "run/0.vti"), ("2.5", "run/1.vti"), ("1e2", "run/3.vti")]);
    let look = "--time --turn 0 --transfer fire";
    let found = film(f, &format!("run.pvd {look}"));
    assert!(found == film(f, &format!("s0.nrrd s1.nrrd s2.nrrd s3.nrrd {look}")));
    assert!(found != film(f, &format!("s0.nrrd s2.nrrd s1.nrrd s3.nrrd {look}")));
    assert!(found == film(f, &format!("run/%d.vti {look}")));
    // Other commands open one step: the first, and say so, or the chosen one.
    for source in ["run.pvd", "run/%d.vti"] {
        for step in 0..STEPS {
            assert!(still(f, &format!("{source} --frame {step}")) == still(f, &format!("run/{step}.vti")), "{source} {step}");
            let info = json(f, &["info", source, "--frame", &step.to_string()]);
            assert_eq!((&info["frames"], &info["frame"]), (&STEPS.into(), &step.into()));
            assert_eq!(info["max"], json(f, &["info", &format!("run/{step}.vti")])["max"]);
        }
        assert!(still(f, source) == still(f, "run/0.vti") && still(f, source) != still(f, "run/1.vti"));
        let said = String::from_utf8(done(f, &format!("render {source} --size 9x9 -o first.png")).stderr).unwrap();
        assert!(said.contains("using frame 0 of 4"), "{said}");
        done(f, &format!("transfer {source} --frame 3 -o 3.json"));
        done(f, "transfer run/3.vti -o alone.json");
        assert_eq!(std::fs::read(f.join("3.json")).unwrap(), std::fs::read(f.join("alone.json")).unwrap());
        refused(f, &["render", source, "--frame", "4", "-o", "no.png"], 2, &["--frame", "0 to 3", source]);
    }
    // A collection is no step of another one.
    // Times that are not evenly spaced are listed.
    assert_eq!(json(f, &["info", "run.pvd"])["frame_times"], serde_json::json!([0.0, 2.5, 10.0, 100.0]));
    collection("even.pvd", &[("1", "run/0.vti"), ("3", "run/1.vti"), ("5", "run/2.vti")]);
    assert_eq!(json(f, &["info", "even.pvd"])["frame_spacing"], serde_json::json!(2.0));
    collection("nested.pvd", &[("0", "run.pvd")]);
    refused(f, &["render", "nested.pvd", "-o", "no.png"], 1, &["run.pvd", "holds Collection"]);
    collection("twice.pvd", &[("1", "run/0.vti"), ("1", "run/1.vti")]);
    collection("none.pvd", &[]);
    collection("when.pvd", &[("soon", "run/0.vti")]);
    collection("lost.pvd", &[("0", "run/0.vti"), ("1", "run/9.vti")]);
    write(f.join("damaged.pvd"), "<VTKFile><Collection></VTKFile>").unwrap();
    let text = std::fs::read_to_string(f.join("run.pvd")).unwrap();
    write(f.join("cut.pvd"), &text[..text.find("<DataSet timestep=\"1e2").unwrap()]).unwrap();
    for (name, words) in [
        ("cut.pvd", ["cut.pvd", "truncated"]),
        ("twice.pvd", ["time 1", "0.vti"]),
        ("none.pvd", ["no files", "DataSet"]),
        ("when.pvd", ["'soon'", "number"]),
        ("lost.pvd", ["9.vti", "cannot read"]),
        ("damaged.pvd", ["damaged.pvd", "damaged"]),
    ] {
        refused(f, &["rotate", name, "--time", "-o", "no.gif"], 1, &words);
    }
}
