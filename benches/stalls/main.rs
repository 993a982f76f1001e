//! How long a live renderer keeps its viewer waiting when something changes: the first frame beside the next. benches/stalls/run
//!
//! Without arguments, runs itself twice, in an empty folder for PoCL's compiled kernels and again in the same one, and prints a table of
//! both. With `once`, draws in this process and prints a line per change. With `minute`, runs a script of what a user does at a viewer after
//! the programs for it were built ahead, likewise twice; with `minute-at-once`, while another process builds them, with
//! `minute-general` likewise and frames drawn by general programs, and with `minute-alone` while this process builds.

#[path = "../scene/mod.rs"]
mod scene;

mod changes;
mod minute;

use changes::Change;
use layersplat::{Background, Renderer};
use minute::Compiles;
use scene::{BUILT_IN, Scene, viewport};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Frames after the first one of a change, of which the fastest counts: what drawing takes.
const NEXT_FRAMES: usize = 3;

/// Engine where it is at hand, else a built-in volume.
fn scene() -> Scene {
    Scene::data_sets().into_iter().find(|scene| scene.name == "engine").unwrap_or_else(|| Scene::built_in(BUILT_IN[0]))
}

fn milliseconds(draw: impl FnOnce()) -> f64 {
    let began = Instant::now();
    draw();
    began.elapsed().as_secs_f64() * 1e3
}

/// First and next frame of a change, in milliseconds.
fn measured(renderer: &mut Renderer, scene: &Scene, change: &Change) -> [f64; 2] {
    renderer.set_transfer_function(change.transfer.as_ref().unwrap_or(&scene.transfer));
    let mut draw = || {
        milliseconds(|| {
            renderer.render_rgba8(&change.camera, viewport(), &change.settings, Background::BLACK).expect("a frame");
        })
    };
    let first = draw();
    let next = (0..NEXT_FRAMES).map(|_| draw()).fold(f64::INFINITY, f64::min);
    [first, next]
}

/// Draws all changes in this process.
fn once() {
    let scene = scene();
    eprintln!("{}, {:?} voxels, {} x {} pixels", scene.name, scene.volume.grid().dims(), viewport().width, viewport().height);
    let began = Instant::now();
    let mut renderer = scene.renderer();
    let uploaded = began.elapsed().as_secs_f64() * 1e3;
    for change in changes::all(&scene) {
        let [mut first, next] = measured(&mut renderer, &scene, &change);
        if change.name == "very first" {
            first += uploaded;
        }
        println!("{}\t{first}\t{next}", change.name);
    }
}

/// This program with another argument, with kernels compiled into a folder.
fn process(argument: &str, kernels: &Path) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.arg(argument).env("POCL_CACHE_DIR", kernels).stderr(Stdio::inherit());
    command
}

/// First and next frames in a process of their own, by change.
fn in_process(kernels: &Path) -> BTreeMap<String, [f64; 2]> {
    let output = process("once", kernels).output().expect("a process");
    assert!(output.status.success(), "it ended with {}", output.status);
    let text = String::from_utf8(output.stdout).expect("text");
    let number = |text: Option<&str>| text.and_then(|number| number.parse().ok()).expect("a number");
    let line = |line: &str| {
        let mut fields = line.split('\t');
        let name = fields.next().unwrap_or_default().to_owned();
        (name, [number(fields.next()), number(fields.next())])
    };
    text.lines().map(line).collect()
}

fn table() {
    let kernels = tempfile::tempdir().expect("a folder");
    let [cold, warm] = [0, 1].map(|_| in_process(kernels.path()));
    println!("| change | first frame, nothing compiled | first frame, compiled before | next frame |");
    println!("|---|---|---|---|");
    for Change { name, .. } in changes::all(&scene()) {
        println!("| {name} | {:.0} ms | {:.0} ms | {:.0} ms |", cold[name][0], warm[name][0], warm[name][1]);
    }
}

/// The script in two processes: with nothing compiled, and with what the first one compiled.
fn minutes(argument: &str) {
    let kernels = tempfile::tempdir().expect("a folder");
    for compiled in ["nothing compiled", "compiled before"] {
        println!("\n{compiled}:\n");
        let status = process(argument, kernels.path()).status().expect("a process");
        assert!(status.success(), "it ended with {status}");
    }
}

fn main() -> ExitCode {
    if let Some(done) = layersplat::device::compile_for_parent() {
        return done;
    }
    // `cargo bench` adds --bench.
    match std::env::args().skip(1).find(|argument| argument != "--bench").as_deref() {
        None => table(),
        Some("once") => once(),
        Some("minute") => minutes("one-minute"),
        Some("minute-at-once") => minutes("one-minute-at-once"),
        Some("minute-general") => minutes("one-minute-general"),
        Some("minute-alone") => minutes("one-minute-alone"),
        Some("one-minute") => minute::minute(&scene(), Compiles::Before),
        Some("one-minute-at-once") => minute::minute(&scene(), Compiles::Beside),
        Some("one-minute-general") => minute::minute(&scene(), Compiles::BesideGeneral),
        Some("one-minute-alone") => minute::minute(&scene(), Compiles::InThisProcess),
        Some(other) => {
            eprintln!("{other}: there are no argument, `once`, `minute`, `minute-at-once`, `minute-general` and `minute-alone`");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
