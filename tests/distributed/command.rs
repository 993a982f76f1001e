//! `layersplat` under mpirun: pictures, and termination if a rank fails.

use crate::launch::mpirun;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const LAYERSPLAT: &str = env!("CARGO_BIN_EXE_layersplat");
/// Seconds after which `timeout` ends a hanging run, with exit code 124.
const HANGING: &str = "120";
/// Time for ranks to end after mpirun. On a busy machine, a signalled process takes seconds to release its memory.
const ENDING: Duration = Duration::from_secs(60);
/// Parts behind an opaque front are not terminated: an error of an 8-bit step.
const A_STEP: f32 = 1.5 / 255.0;

/// Runs `mpirun` in a folder with a time limit.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mpirun = mpirun();
    let mut command = Command::new("timeout");
    command.arg(HANGING).arg(mpirun.get_program()).args(mpirun.get_args()).args(arguments);
    command.envs(mpirun.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let done = command.current_dir(folder).output().expect("timeout, of coreutils");
    assert_ne!(done.status.code(), Some(124), "{arguments:?} hangs: {}", said(&done));
    done
}

fn said(done: &Output) -> String {
    [&done.stdout, &done.stderr].map(|said| String::from_utf8_lossy(said).into_owned()).concat()
}

fn on(ranks: usize, folder: &Path, arguments: &[&str]) -> Output {
    let ranks = ranks.to_string();
    let done = run(folder, &[&["-n", &ranks, LAYERSPLAT], arguments].concat());
    assert!(done.status.success(), "{arguments:?} on {ranks}: {}", said(&done));
    done
}

fn alone(folder: &Path, arguments: &[&str]) {
    let done = Command::new(LAYERSPLAT).args(arguments).current_dir(folder).output().unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", said(&done));
}

fn pixels(path: &Path) -> Vec<[u8; 4]> {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgba8().pixels().map(|p| p.0).collect()
}

fn assert_alike(folder: &Path, a: &str, b: &str) {
    let (a, b) = (pixels(&folder.join(a)), pixels(&folder.join(b)));
    assert!(a.len() == b.len() && a.iter().any(|p| *p != a[0]), "an empty picture is like any other");
    let most = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(f32::from(most) / 255.0 <= A_STEP, "{most} steps");
}

const VIEW: [&str; 8] = ["builtin:gyroid@37x40x43", "--size", "90x70", "--azimuth", "70", "--elevation", "25", "-o"];

#[test]
fn a_picture_by_several_is_that_of_one() {
    let folder = tempfile::tempdir().unwrap();
    alone(folder.path(), &[&["render"], &VIEW[..], &["alone.png"]].concat());
    for ranks in [1, 2, 3, 5] {
        let done = on(ranks, folder.path(), &[&["render"], &VIEW[..], &["shared.png", "--json"]].concat());
        assert_alike(folder.path(), "alone.png", "shared.png");
        let told: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        if ranks == 1 {
            assert_eq!(pixels(&folder.path().join("alone.png")), pixels(&folder.path().join("shared.png")));
        } else {
            assert_eq!(told["processes"]["ranks"].as_array().unwrap().len(), ranks, "{told}");
        }
    }
}

/// A team of one renders all views; the other ranks are idle.
#[test]
fn a_team_of_one_draws_what_processes_cannot_share() {
    let folder = tempfile::tempdir().unwrap();
    let render = ["render", "builtin:gyroid@16", "--size", "40x40", "--ranks-per-picture", "1"];
    let more: [&[&str]; 3] =
        [&["--depth", "-o", "a.exr"], &["--algorithm", "raycast", "-o", "a.png"], &["--memory", "4M", "-o", "b.png"]];
    for more in more {
        let output = folder.path().join(more.last().unwrap());
        on(3, folder.path(), &[&render[..], more].concat());
        let by_three = std::fs::read(&output).unwrap();
        on(1, folder.path(), &[&render[..], more].concat());
        assert!(by_three == std::fs::read(&output).unwrap() && by_three.len() > 1000, "{more:?}");
    }
}

#[test]
fn sequences_are_dealt_out() {
    let folder = tempfile::tempdir().unwrap();
    let film = ["rotate", "builtin:gyroid@31", "--frames", "5", "--size", "60x50", "-o"];
    alone(folder.path(), &[&film[..], &["alone"]].concat());
    let frames = |name: &str| (0..5).map(|n| format!("{name}/frame_{n:04}.png")).collect::<Vec<_>>();
    on(3, folder.path(), &[&film[..], &["dealt"]].concat());
    on(5, folder.path(), &[&film[..], &["teams", "--ranks-per-picture", "2"]].concat());
    for (one, (dealt, teams)) in frames("alone").iter().zip(frames("dealt").iter().zip(&frames("teams"))) {
        assert_eq!(pixels(&folder.path().join(one)), pixels(&folder.path().join(dealt)), "{one}");
        assert_alike(folder.path(), one, teams);
    }
    on(2, folder.path(), &[&film[..], &["film.gif"]].concat());
    alone(folder.path(), &[&film[..], &["alone.gif"]].concat());
    let [dealt, alone] = ["film.gif", "alone.gif"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert!(dealt == alone && dealt.len() > 1000);
    let told = on(2, folder.path(), &["bench", "builtin:gyroid@20", "--frames", "4", "--size", "40x40", "--json"]);
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    assert_eq!((&told["processes"]["processes"], &told["processes"]["teams"]), (&2.into(), &2.into()), "{told}");
}

#[test]
fn files_of_cameras_are_dealt_out() {
    let folder = tempfile::tempdir().unwrap();
    let lines: String = (0..4).map(|n| format!("{{\"output\": \"NAME{n}.png\", \"azimuth\": {}}}\n", n * 40)).collect();
    for (name, ranks, more) in [("alone", 0, &[][..]), ("dealt", 3, &[]), ("shared", 2, &["--ranks-per-picture", "2"])] {
        std::fs::write(folder.path().join("cameras"), lines.replace("NAME", name)).unwrap();
        let arguments = [&["render", "builtin:gyroid@29", "--size", "50x40", "--cameras", "cameras"], more].concat();
        if ranks == 0 {
            alone(folder.path(), &arguments);
        } else {
            let done = on(ranks, folder.path(), &arguments);
            assert_eq!(String::from_utf8_lossy(&done.stdout).matches("render_ms").count(), 4);
        }
    }
    for n in 0..4 {
        let [one, dealt, shared] = ["alone", "dealt", "shared"].map(|name| format!("{name}{n}.png"));
        assert_eq!(pixels(&folder.path().join(&one)), pixels(&folder.path().join(&dealt)));
        assert_alike(folder.path(), &one, &shared);
    }
}

/// Asserts that all ranks end, with the message of the failed rank, and that nothing is written.
fn assert_refused(done: &Output, folder: &Path, words: &[&str]) {
    let said = said(done);
    assert!(!done.status.success(), "{said}");
    words.iter().for_each(|word| assert!(said.contains(word), "no '{word}' in: {said}"));
    assert!(!said.contains("panicked"), "{said}");
    let pictures: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(!pictures.iter().any(|name| name.to_string_lossy().ends_with("png")), "{pictures:?}");
}

#[test]
fn what_one_rank_cannot_do_ends_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let [there, elsewhere] = ["there", "elsewhere"].map(|name| {
        std::fs::create_dir(path.join(name)).unwrap();
        path.join(name).display().to_string()
    });
    alone(path, &["convert", "builtin:gyroid@16", "there/a.nrrd"]);
    let render = ["render", "a.nrrd", "--size", "40x40", "-o", "out.png"];
    // One rank does not find the file.
    let first = [&["-n", "2", "-wdir", &there, LAYERSPLAT], &render[..]].concat();
    let second = [&[":", "-n", "1", "-wdir", &elsewhere, LAYERSPLAT], &render[..]].concat();
    assert_refused(&run(path, &[&first[..], &second].concat()), path, &["rank 2: cannot read a.nrrd"]);
    // One rank has no device.
    let no_device = [&[":", "-n", "1", "-wdir", &there, "env", "OCL_ICD_VENDORS=/nowhere", LAYERSPLAT], &render[..]].concat();
    assert_refused(&run(path, &[&first[..], &no_device].concat()), path, &["rank 2: ", "OpenCL"]);
    // An error on all ranks.
    let packed = ["-n", "3", LAYERSPLAT, "render", "b_2x2x2_uint8.raw.gz", "-o", "out.png"];
    std::fs::write(path.join("b_2x2x2_uint8.raw.gz"), [0x1f, 0x8b]).unwrap();
    assert_refused(&run(path, &packed), path, &["layersplat convert"]);
    let no_lattice = ["-n", "2", LAYERSPLAT, "render", "builtin:gyroid@16", "--algorithm", "raycast", "-o", "out.png"];
    let done = run(path, &no_lattice);
    assert_refused(&done, path, &["only layers on a lattice", "--ranks-per-picture 1"]);
    assert_eq!(done.status.code(), Some(2));
    let depths = ["-n", "2", LAYERSPLAT, "render", "builtin:gyroid@16", "--depth", "-o", "out.exr", "--ranks-per-picture", "2"];
    assert_refused(&run(path, &depths), path, &["processes cannot share this view", "rays", "--ranks-per-picture 1"]);
    assert_refused(&run(path, &["-n", "2", LAYERSPLAT, "render", "-", "-o", "out.png"]), path, &["standard input"]);
    // Rejected before the first picture.
    let mut inside = ["-n", "2", LAYERSPLAT, "rotate", "builtin:gyroid@16", "--frames", "9", "-o", "frames"].to_vec();
    inside.extend(["--ranks-per-picture", "2", "--perspective", "60", "--elevation", "0"]);
    assert_refused(&run(path, &inside), path, &["processes cannot share this view"]);
    assert!(!path.join("frames").exists());
    // The leader cannot write.
    let no_folder = ["-n", "3", LAYERSPLAT, "render", "builtin:gyroid@16", "-o", "nowhere/out.png"];
    assert_refused(&run(path, &no_folder), path, &["nowhere/out.png"]);
    let no_film = ["-n", "3", LAYERSPLAT, "rotate", "builtin:gyroid@16", "--frames", "6", "-o", "a.nrrd/film.gif"];
    assert_refused(&run(path, &no_film), path, &["film.gif"]);
    let bad = ["-n", "3", LAYERSPLAT, "render", "builtin:gyroid@16", "--size", "0x0", "-o", "out.png"];
    assert_refused(&run(path, &bad), path, &["--size"]);
}

/// A rank with too little memory: its part of 406 MB, plus the process itself, exceeds its address space.
#[test]
fn a_rank_without_memory_ends_all() {
    let folder = tempfile::tempdir().unwrap();
    let render = format!("exec {LAYERSPLAT} render builtin:cube@1500x1000x800 --size 40x40 -o out.png");
    let little = format!("ulimit -v 600000; {render}");
    let done = run(folder.path(), &["-n", "2", "sh", "-c", &render, ":", "-n", "1", "sh", "-c", &little]);
    assert_refused(&done, folder.path(), &["rank 2: "]);
}

/// All descendants of a process.
fn descendants(of: u32) -> Vec<(u32, String)> {
    let mut found = Vec::new();
    let mut seek = vec![of];
    while let Some(parent) = seek.pop() {
        for entry in std::fs::read_dir("/proc").unwrap().flatten() {
            let Ok(id) = entry.file_name().to_string_lossy().parse::<u32>() else { continue };
            let Ok(stat) = std::fs::read_to_string(entry.path().join("stat")) else { continue };
            let (name, rest) = stat.rsplit_once(')').unwrap();
            if rest.split_whitespace().nth(1).and_then(|p| p.parse().ok()) == Some(parent) {
                found.push((id, name.split_once('(').unwrap().1.to_owned()));
                seek.push(id);
            }
        }
    }
    found
}

/// Whether a process exists and has not ended.
fn lives(id: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{id}/stat")).is_ok_and(|stat| !stat.contains(") Z"))
}

fn started(folder: &Path, arguments: &[&str]) -> Child {
    let mpirun = mpirun();
    let mut command = Command::new("timeout");
    command.arg(HANGING).arg(mpirun.get_program()).args(mpirun.get_args()).args(arguments);
    command.envs(mpirun.get_envs().filter_map(|(name, value)| Some((name, value?))));
    command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn a_rank_that_is_killed_ends_all() {
    let folder = tempfile::tempdir().unwrap();
    let film =
        ["rotate", "builtin:gyroid@40", "--frames", "100000", "--ranks-per-picture", "3", "--size", "200x200", "-o", "film.gif"];
    let child = started(folder.path(), &[&["-n", "3", LAYERSPLAT], &film[..]].concat());
    let ranks = loop {
        let found: Vec<u32> =
            descendants(child.id()).into_iter().filter(|(_, name)| name == "layersplat").map(|(id, _)| id).collect();
        // The ranks are working once the film has a temporary file.
        let begun = std::fs::read_dir(folder.path()).unwrap().count() > 0;
        if found.len() == 3 && begun {
            break found;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    assert!(Command::new("kill").args(["-KILL", &ranks[1].to_string()]).status().unwrap().success());
    let done = child.wait_with_output().unwrap();
    assert!(!done.status.success() && done.status.code() != Some(124), "{}", said(&done));
    assert!(!folder.path().join("film.gif").exists());
    // No rank continues alone. mpirun may end before the ranks that it has signalled do.
    let deadline = Instant::now() + ENDING;
    while ranks.iter().any(|&id| lives(id)) {
        assert!(
            Instant::now() < deadline,
            "of {ranks:?}, {:?} live on",
            ranks.iter().filter(|&&id| lives(id)).collect::<Vec<_>>()
        );
        std::thread::sleep(Duration::from_millis(50));
    }
}
