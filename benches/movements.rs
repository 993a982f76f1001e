//! What a change costs beside the frame that it leads to: upload, layer axis, transfer function, quality, size. `cargo bench --bench movements`
//!
//! `cargo bench --bench movements -- SIDE…` for volumes of other sides than 256 and 512 voxels. A new renderer makes all changes in turn,
//! several times. Prints Markdown: medians of wall time, and of CPU time in brackets, of the first frame after each change and of the
//! next one. `cargo bench --bench movements -- process` prints instead what a process spends that draws one picture of a raw file.

use cpu_time::ProcessTime;
use layersplat::volume::Volume;
use layersplat::{
    Background, Camera, Device, DeviceChoice, OpenOptions, Orbit, Quality, Renderer, Settings, TransferFunction, Viewport,
};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const SIDES: [usize; 2] = [256, 512];
/// A built-in volume with opacities by value.
struct Scene {
    name: &'static str,
    density: &'static str,
    opacities: &'static [(f64, f64)],
}

const SCENES: [Scene; 3] = [
    Scene { name: "gyroid", density: "dense", opacities: &[(18.0, 0.0), (118.0, 0.12)] },
    Scene { name: "hydrogen", density: "sparse", opacities: &[(200.0, 0.0), (230.0, 0.3)] },
    Scene {
        name: "torus-knot",
        density: "dense",
        opacities: &[(30.0, 0.0), (41.0, 0.12), (51.0, 0.0), (222.0, 0.0), (242.0, 0.4)],
    },
];
/// Times that all changes are made, after once for the kernels.
const ROUNDS: usize = 5;
/// Frames after the first one of a change.
const NEXT_FRAMES: usize = 3;

/// Wall and CPU time in milliseconds.
#[derive(Clone, Copy)]
struct Times {
    wall: f64,
    cpu: f64,
}

fn measured<T>(what: impl FnOnce() -> T) -> (T, Times) {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    let made = what();
    (made, Times { wall: wall.elapsed().as_secs_f64() * 1e3, cpu: cpu.elapsed().as_secs_f64() * 1e3 })
}

fn median(all: &[Times]) -> Times {
    let of = |part: fn(&Times) -> f64| {
        let mut values: Vec<f64> = all.iter().map(part).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Times { wall: of(|times| times.wall), cpu: of(|times| times.cpu) }
}

/// A frame of the view that a change leads to.
#[derive(Clone, Copy)]
struct View {
    camera: Camera,
    viewport: Viewport,
    settings: Settings,
}

impl View {
    fn draw(&self, renderer: &mut Renderer) {
        renderer.render_rgba8(&self.camera, self.viewport, &self.settings, Background::BLACK).expect("a frame");
    }
}

/// The first and the next frame of each change, in every round.
struct Change {
    name: &'static str,
    first: Vec<Times>,
    next: Vec<Times>,
}

/// Adds a round to the change of a name.
fn add(changes: &mut Vec<Change>, name: &'static str, first: Times, next: Times) {
    let at = changes.iter().position(|change| change.name == name).unwrap_or_else(|| {
        changes.push(Change { name, first: vec![], next: vec![] });
        changes.len() - 1
    });
    changes[at].first.push(first);
    changes[at].next.push(next);
}

/// All changes, once.
fn round(device: &Device, volume: &Volume, bytes: &[u8], transfer: &TransferFunction, changes: &mut Vec<Change>) {
    let view = |azimuth, elevation, side| {
        let (grid, viewport) = (volume.grid(), Viewport::new(side, side).expect("a valid size"));
        let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport, Orbit { azimuth, elevation, roll: 0.0 });
        View { camera, viewport, settings: Settings::default() }
    };
    let base = view(30.0, 20.0, 512);
    // The transfer functions take turns: setting an equal one has no effect.
    let (lo, hi) = transfer.range();
    let other = transfer.stretched(lo, hi + (hi - lo) * 1e-9).expect("a range");

    let (_, copied) = measured(|| std::hint::black_box(bytes.to_vec()));
    let (mut renderer, uploaded) = measured(|| Renderer::new(device, volume, transfer).expect("a renderer"));
    add(changes, "upload : copy to new memory", uploaded, copied);
    let mut change = |name, transfer: &TransferFunction, view: View| {
        let first = measured(|| {
            renderer.set_transfer_function(transfer);
            view.draw(&mut renderer);
        });
        let next: Vec<Times> = (0..NEXT_FRAMES).map(|_| measured(|| view.draw(&mut renderer)).1).collect();
        add(changes, name, first.1, median(&next));
    };
    let of_quality = |quality: Quality| View { settings: quality.settings(), ..base };
    change("first frame (layer axis z)", transfer, base);
    change("layer axis x", transfer, view(80.0, 20.0, 512));
    change("layer axis y", transfer, view(30.0, 70.0, 512));
    change("back to z", transfer, base);
    change("transfer function", &other, base);
    change("`draft`", &other, of_quality(Quality::Draft));
    change("`high`", &other, of_quality(Quality::High));
    change("`standard`", &other, base);
    change("size 700 × 700", &other, view(30.0, 20.0, 700));
    change("size 512 × 512", &other, base);
    change("size 300 × 300", &other, view(30.0, 20.0, 300));
}

fn table(device: &Device, Scene { name, density, opacities }: &Scene, side: usize) {
    let made = Volume::open(format!("builtin:{name}@{side}"), &OpenOptions::default()).expect("a built-in volume");
    // Voxels of a built-in volume are computed when they are read, and those of a file are in the page cache.
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = std::fs::read(made.save(folder.path().join("voxels.raw")).expect("a file")).expect("its bytes");
    let volume = Volume::new(*name, made.grid().clone(), &bytes[..]).expect("a volume");
    let transfer = TransferFunction::grey_ramp(&volume).with_opacities(opacities.to_vec()).expect("opacities");
    round(device, &volume, &bytes, &transfer, &mut vec![]);
    let mut changes = vec![];
    (0..ROUNDS).for_each(|_| round(device, &volume, &bytes, &transfer, &mut changes));
    println!("\n| {name} {side}³ {density} | first, ms | next, ms | ratio |\n|---|---|---|---|");
    for Change { name, first, next } in &changes {
        let (first, next) = (median(first), median(next));
        let Times { wall, cpu } = first;
        println!(
            "| {name} | {wall:.1} ({cpu:.1}) | {:.1} ({:.1}) | {:.1} ({:.1}) |",
            next.wall,
            next.cpu,
            wall / next.wall,
            cpu / next.cpu
        );
    }
}

/// What a process does in turn that draws one picture of a file, and the times of each, on standard output.
fn draw_once(file: &Path) {
    let report = |name: &str, Times { wall, cpu }: Times| println!("{name}\t{wall}\t{cpu}");
    let (device, times) = measured(|| Device::open(&DeviceChoice::Default).expect("a device"));
    report("OpenCL start", times);
    let (volume, times) = measured(|| Volume::open(file, &OpenOptions::default()).expect("the volume"));
    report("range pass", times);
    let (transfer, times) = measured(|| TransferFunction::automatic(&volume));
    report("automatic transfer function", times);
    let (mut renderer, times) = measured(|| Renderer::new(&device, &volume, &transfer).expect("a renderer"));
    report("upload", times);
    let viewport = Viewport::new(512, 512).expect("a valid size");
    let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, Orbit::default());
    let mut draw = || measured(|| renderer.render(&camera, viewport, &Settings::default()).expect("a frame").0);
    let (frame, first) = draw();
    let (_, next) = draw();
    report("program load, min-max blocks, visibility", Times { wall: first.wall - next.wall, cpu: first.cpu - next.cpu });
    report("frame", next);
    let (_, times) = measured(|| frame.save(file.with_extension("png"), Some(Background::BLACK)).expect("a picture"));
    report("PNG", times);
}

/// Medians of what processes spend on one picture.
fn process_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = Volume::open("builtin:gyroid@256", &OpenOptions::default()).expect("a built-in volume");
    let file = made.save(folder.path().join("gyroid_256x256x256_uint8.raw")).expect("a file");
    let mut stages: Vec<(String, Vec<Times>)> = vec![];
    for _ in 0..=2 * ROUNDS {
        let mut process = Command::new(std::env::current_exe().expect("this program"));
        let output = process.arg("draw").arg(&file).output().expect("a process");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for line in String::from_utf8(output.stdout).expect("UTF-8").lines() {
            let fields: Vec<&str> = line.split('\t').collect();
            let [name, wall, cpu] = fields[..] else { panic!("{line}") };
            let times = Times { wall: wall.parse().expect("ms"), cpu: cpu.parse().expect("ms") };
            match stages.iter_mut().find(|stage| stage.0 == name) {
                // The first process builds the kernels.
                Some(stage) => stage.1.push(times),
                None => stages.push((name.to_owned(), vec![])),
            }
        }
    }
    println!("| part | wall, ms | CPU, ms |\n|---|---|---|");
    for (name, times) in &stages {
        let Times { wall, cpu } = median(times);
        println!("| {name} | {wall:.0} | {cpu:.0} |");
    }
}

fn main() {
    // `cargo bench` adds --bench.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match &arguments[..] {
        [what, file] if what == "draw" => return draw_once(Path::new(file)),
        [what] if what == "process" => return process_table(),
        _ => (),
    }
    let device = Device::open(&DeviceChoice::Default).expect("the benches need an OpenCL device: scripts/test installs PoCL");
    let sides: Vec<usize> = arguments.iter().map(|side| side.parse().expect("a side")).collect();
    for &side in if sides.is_empty() { &SIDES[..] } else { &sides } {
        SCENES.iter().for_each(|scene| table(&device, scene, side));
    }
}
