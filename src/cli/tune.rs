//! `layersplat tune`: finds the fastest tuning values of a device, to port layersplat to a new one.

use super::check;
use super::options::DeviceOptions;
use super::progress;
use crate::camera::{Camera, Orbit};
use crate::device::{Device, LatticeSchedule, Tuning};
use crate::error::Error;
use crate::image::Background;
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::settings::{Algorithm, Evaluation, Layered, Quality, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{OpenOptions, Volume};
use serde::Serialize;
use std::process::ExitCode;
use std::time::Instant;

/// A value replaces the current one if its time is below this fraction; smaller gains are noise.
const MAX_RATIO: f64 = 0.97;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    device: DeviceOptions,
    /// Volume to measure on
    #[arg(long, default_value = "builtin:hydrogen@128")]
    volume: String,
    /// Frames per value, each from another direction; values alternate
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000), value_name = "N")]
    frames: u32,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

/// A tuning parameter.
struct Knob {
    name: &'static str,
    /// Candidate values with their names.
    values: fn(Tuning) -> Vec<(String, Tuning)>,
    /// Settings whose frame time depends on the parameter.
    frames: fn() -> Settings,
}

impl Knob {
    /// All candidates, including the current tuning.
    fn candidates(&self, tuning: Tuning) -> Vec<(String, Tuning)> {
        let mut values = (self.values)(tuning);
        if values.iter().all(|(_, with)| *with != tuning) {
            values.push(("current".into(), tuning));
        }
        values
    }
}

/// A named tuning for each number.
fn each<const N: usize>(numbers: [u32; N], with: impl Fn(u32) -> Tuning) -> Vec<(String, Tuning)> {
    numbers.map(|n| (n.to_string(), with(n))).into()
}

fn blocks(tuning: Tuning) -> Vec<(String, Tuning)> {
    [[1, 1], [16, 8], [32, 8], [32, 16]].map(|block| (format!("{}x{}", block[0], block[1]), Tuning { block, ..tuning })).into()
}

fn schedules(tuning: Tuning) -> Vec<(String, Tuning)> {
    let named = [("tiles", LatticeSchedule::Tiles), ("samples", LatticeSchedule::Samples)];
    named.map(|(name, lattice_schedule)| (name.to_string(), Tuning { lattice_schedule, ..tuning })).into()
}

fn sample_tiles(tuning: Tuning) -> Vec<(String, Tuning)> {
    [[8, 4], [8, 8], [16, 8], [16, 16]]
        .map(|tile| (format!("{}x{}", tile[0], tile[1]), Tuning { sample_tile: tile, ..tuning }))
        .into()
}

fn layers() -> Settings {
    Settings::default()
}

fn splats() -> Settings {
    Quality::Paper.settings()
}

fn per_pixel() -> Settings {
    let layered = Layered { evaluation: Evaluation::Direct, ..Quality::Standard.layered() };
    Settings { algorithm: layered.into(), ..Settings::default() }
}

fn rays() -> Settings {
    Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }.into()
}

fn sheets() -> Settings {
    Algorithm::ViewSheets { sheet_distance: 1.0 }.into()
}

/// The parameters in the order of tuning: those that others depend on come first.
const KNOBS: [Knob; 11] = [
    Knob { name: "vector_width", values: |t| each([16, 8, 4, 1], |n| Tuning { vector_width: n, ..t }), frames: layers },
    Knob { name: "tile_group", values: |t| each([1, 8, 32, 64], |n| Tuning { tile_group: n as usize, ..t }), frames: layers },
    Knob { name: "point_tile_rows", values: |t| each([2, 4, 8, 16, 24], |n| Tuning { point_tile_rows: n, ..t }), frames: layers },
    Knob { name: "tile_run", values: |t| each([1, 4, 8], |n| Tuning { tile_run: n, ..t }), frames: layers },
    Knob { name: "lattice_schedule", values: schedules, frames: layers },
    Knob { name: "sample_tile", values: sample_tiles, frames: layers },
    Knob { name: "block", values: blocks, frames: layers },
    Knob { name: "tile_rows", values: |t| each([2, 4, 8, 16], |n| Tuning { tile_rows: n, ..t }), frames: splats },
    Knob { name: "screen_tile_rows", values: |t| each([4, 8, 16, 24], |n| Tuning { screen_tile_rows: n, ..t }), frames: rays },
    Knob {
        name: "pixel_group",
        values: |t| each([16, 64, 128, 256], |n| Tuning { pixel_group: n as usize, ..t }),
        frames: per_pixel,
    },
    Knob { name: "splat_chunks", values: |t| each([8, 32, 128], |n| Tuning { splat_chunks: n as usize, ..t }), frames: sheets },
];

#[derive(Serialize)]
struct Report {
    device: String,
    volume: String,
    before: Tuning,
    after: Tuning,
    measured: Vec<Measured>,
}

/// A measured candidate.
#[derive(Serialize)]
struct Measured {
    knob: &'static str,
    value: String,
    /// Median frame time. `None` if the device does not support the value.
    milliseconds: Option<f64>,
    taken: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let device = Device::open(&arguments.device.choice())?;
    check::require(&device, &crate::check::Family::ALL.into_iter().collect(), &arguments.device)?;
    let volume = Volume::open(&arguments.volume, &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&volume);
    let before = *device.tuning();
    let (mut tuning, mut measured) = (before, Vec::new());
    let bar = progress::steps(KNOBS.len() as u32, "measuring");
    for knob in &KNOBS {
        tuning = settle(knob, tuning, &device, &volume, &transfer, arguments.frames, &mut measured)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let device = device.info().name.clone();
    let report = Report { device, volume: arguments.volume.clone(), before, after: tuning, measured };
    super::report(arguments.json, &report, || text(&report))?;
    Ok(ExitCode::SUCCESS)
}

/// Measures the candidates of a knob and returns the fastest one if it is faster by more than noise.
fn settle(
    knob: &Knob,
    tuning: Tuning,
    device: &Device,
    volume: &Volume,
    transfer: &TransferFunction,
    frames: u32,
    measured: &mut Vec<Measured>,
) -> Result<Tuning, Error> {
    let viewport = Viewport::new(512, 512)?;
    let settings = (knob.frames)();
    let camera = |n: u32| {
        let orbit = Orbit { azimuth: 360.0 * f64::from(n) / f64::from(frames), elevation: 15.0, roll: 0.0 };
        Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit)
    };
    let draw = |renderer: &mut Renderer, n| renderer.render_rgba8(&camera(n), viewport, &settings, Background::BLACK);
    let mut tried = Vec::new();
    for (value, with) in knob.candidates(tuning) {
        let built = device.with_tuning(with).and_then(|device| {
            let mut renderer = Renderer::new(&device, volume, transfer)?;
            // Warm-up: builds kernels and the layouts of all axes.
            (0..frames).try_for_each(|n| draw(&mut renderer, n).map(drop))?;
            Ok(renderer)
        });
        if let Err(error) = &built {
            tracing::warn!("{} {value}: {error}", knob.name);
        }
        tried.push((value, with, built.ok(), Vec::new()));
    }
    for n in 0..frames {
        for (_, _, renderer, times) in &mut tried {
            let Some(renderer) = renderer else { continue };
            let started = Instant::now();
            draw(renderer, n)?;
            times.push(started.elapsed().as_secs_f64() * 1e3);
        }
    }
    let medians: Vec<_> = tried.iter().map(|(.., times)| median(times.clone())).collect();
    let current = tried.iter().position(|(_, with, ..)| *with == tuning).and_then(|n| medians[n]).unwrap_or(f64::INFINITY);
    let fastest =
        (0..tried.len()).filter(|&n| medians[n].is_some()).min_by(|&a, &b| medians[a].partial_cmp(&medians[b]).expect("times"));
    let best = fastest.filter(|&n| medians[n].is_some_and(|ms| ms < current * MAX_RATIO)).map_or(tuning, |n| tried[n].1);
    for ((value, with, ..), milliseconds) in tried.into_iter().zip(medians) {
        measured.push(Measured { knob: knob.name, value, milliseconds, taken: with == best });
    }
    Ok(best)
}

fn median(mut times: Vec<f64>) -> Option<f64> {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

fn text(report: &Report) -> String {
    let mut lines = vec![format!("{}, {}:", report.device, report.volume)];
    for m in &report.measured {
        let time = m.milliseconds.map_or("unsupported".into(), |ms| format!("{ms:.2} ms"));
        lines.push(format!("  {:<17} {:>6} {time:>12}{}", m.knob, m.value, if m.taken { "  selected" } else { "" }));
    }
    if report.after == report.before {
        lines.push("The values in use are the fastest.".into());
    } else {
        lines.push("Values for Tuning::new in src/device/tuning.rs, or Device::with_tuning:".into());
        lines.push(format!("{:#?}", report.after));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceKind;

    /// Otherwise its time would count as infinite, and any other value would win.
    #[test]
    fn the_current_tuning_is_a_candidate() {
        for own in [DeviceKind::Cpu, DeviceKind::Gpu].map(|kind| Tuning::new(kind, "", 16, 2)) {
            let odd = Tuning { block: [48, 5], tile_rows: 3, ..own };
            for (tuning, knob) in [own, odd].iter().flat_map(|tuning| KNOBS.iter().map(move |knob| (tuning, knob))) {
                let tried = knob.candidates(*tuning);
                assert_eq!(tried.iter().filter(|(_, with)| with == tuning).count(), 1, "{}, {tuning:?}", knob.name);
            }
        }
    }
}
