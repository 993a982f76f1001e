//! `layersplat bench`: the paper's protocol, a full turn about y.

use super::rotate::{ELEVATION, progress, turn};
use super::scene::{Scene, SceneOptions, camera};
use crate::device::StageTimes;
use crate::error::Error;
use crate::image::Background;
use crate::renderer::{LatticeReport, Quality};
use cpu_time::ProcessTime;
use serde::Serialize;
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    /// Pictures of the turn
    #[arg(long, default_value_t = 125, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Bench<'a> {
    volume: &'a str,
    algorithm: &'static str,
    quality: Quality,
    device: &'a str,
    frames: u32,
    median_ms: f64,
    min_ms: f64,
    max_ms: f64,
    cpu_ms: f64,
    first_ms: f64,
    stages: BTreeMap<&'static str, f64>,
    effective_splats: u64,
    active_samples: u64,
    lattice: Option<LatticeReport>,
    device_bytes: u64,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    let scene = Scene::open(&arguments.scene)?;
    let background = options.background.unwrap_or(Background::BLACK);
    let frames = arguments.frames;
    let view = |n: u32| camera(options, scene.volume.grid(), turn(options.orbit(ELEVATION), n, frames));

    let started = Instant::now();
    let mut renderer = scene.renderer()?;
    renderer.render_rgba8(&view(0), options.size, &scene.settings, background)?;
    let first_ms = milliseconds(started);
    // Layouts, occupancy and kernels of the other layer axes: the medians exclude them.
    for n in 0..frames.min(8) {
        renderer.render_rgba8(&view(n * frames / frames.min(8)), options.size, &scene.settings, background)?;
    }

    let bar = progress(frames, "measuring");
    let mut times = Vec::new();
    let mut stages = StageTimes::new();
    let (mut cpu_ms, mut active_samples, mut lattice) = (0.0, 0, None);
    for n in 0..frames {
        let (started, cpu) = (Instant::now(), ProcessTime::now());
        let (picture, report) = renderer.render_rgba8(&view(n), options.size, &scene.settings, background)?;
        times.push(milliseconds(started));
        cpu_ms += cpu.elapsed().as_secs_f64() * 1e3;
        drop(picture);
        active_samples += report.active_samples;
        lattice = report.lattice;
        stages.extend(report.stages);
        bar.inc(1);
    }
    bar.finish_and_clear();
    times.sort_by(f64::total_cmp);
    let mut per_stage = BTreeMap::new();
    for (stage, ms) in stages {
        *per_stage.entry(stage).or_insert(0.0) += ms / f64::from(frames);
    }
    let bench = Bench {
        volume: scene.volume.name(),
        algorithm: "layered",
        quality: arguments.scene.quality.quality,
        device: &scene.device.info().name,
        frames,
        median_ms: median(&times),
        min_ms: times[0],
        max_ms: times[times.len() - 1],
        cpu_ms: cpu_ms / f64::from(frames),
        first_ms,
        stages: per_stage,
        effective_splats: scene.transfer.effective_splats(&scene.volume),
        active_samples: active_samples / u64::from(frames),
        lattice,
        device_bytes: scene.device.allocated_bytes(),
    };
    super::report(arguments.json, &bench, || text(&bench))?;
    Ok(ExitCode::SUCCESS)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Median of sorted values.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 }
}

fn text(b: &Bench) -> String {
    let quality = format!("{:?}", b.quality).to_lowercase();
    let lattice = b
        .lattice
        .map_or("none: per pixel".into(), |l| format!("{}x{} samples, {:.2}x{:.2} per voxel", l.width, l.height, l.m[0], l.m[1]));
    let mut lines = vec![
        format!("{}, {} {quality}, on {}", b.volume, b.algorithm, b.device),
        format!("median    {:.2} ms of {} frames ({:.1} frames/s)", b.median_ms, b.frames, 1e3 / b.median_ms),
        format!("range     {:.2} to {:.2} ms", b.min_ms, b.max_ms),
        format!("cpu       {:.2} ms per frame", b.cpu_ms),
        format!("first     {:.1} ms", b.first_ms),
        format!("splats    {} effective; {} active samples per frame", b.effective_splats, b.active_samples),
        format!("lattice   {lattice}"),
        format!("memory    {:.1} MiB on the device", b.device_bytes as f64 / (1 << 20) as f64),
    ];
    lines.extend(b.stages.iter().map(|(stage, ms)| format!("  {stage:<12} {ms:.3} ms")));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians() {
        assert_eq!((median(&[3.0]), median(&[1.0, 2.0]), median(&[1.0, 2.0, 9.0])), (3.0, 1.5, 2.0));
    }
}
