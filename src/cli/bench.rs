//! `layersplat bench`: frame times by the paper's protocol, a full turn around the y axis.

use super::cameras::Cameras;
use super::options::Fit;
use super::processes::Processes;
use super::progress;
use super::rotate::{START, turn};
use super::scene::{OpenedScene, SceneOptions};
use super::scene_renderer::SceneRenderer;
use crate::camera::Orbit;
use crate::device::StageTimes;
use crate::error::Error;
use crate::framing::Orientation;
use crate::image::Background;
use crate::renderer::{LatticeReport, VolumeRenderer};
use crate::settings::Quality;
use cpu_time::ProcessTime;
use serde::Serialize;
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

/// Number of timed changes of the transfer function, and of the layer axis.
const CHANGES: usize = 9;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    /// Number of frames of the turn
    #[arg(long, default_value_t = 125, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Bench<'a> {
    volume: &'a str,
    algorithm: &'static str,
    quality: Option<Quality>,
    device: &'a str,
    frames: u32,
    median_ms: f64,
    min_ms: f64,
    max_ms: f64,
    cpu_ms: f64,
    first_ms: f64,
    transfer_change_ms: f64,
    transfer_change_cpu_ms: f64,
    axis_change_ms: f64,
    stages: BTreeMap<&'static str, f64>,
    effective_splats: u64,
    /// Sum over all processes that render a frame together.
    #[serde(skip_serializing_if = "Option::is_none")]
    active_samples: Option<u64>,
    lattice: Option<LatticeReport>,
    device_bytes: u64,
    peak_bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    processes: Option<TeamReport>,
}

/// Throughput of several processes. Frame times are from all teams; all other values are from the first process.
#[derive(Serialize)]
struct TeamReport {
    processes: usize,
    teams: usize,
    frames_per_s: f64,
    /// Report of the first team on its last measured picture, if the team has several processes.
    #[cfg(feature = "mpi")]
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<crate::distributed::DistributedReport>,
}

pub(super) fn run(arguments: &Arguments, processes: &Processes) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    let (teams, volume) = (&arguments.scene.teams, &arguments.scene.volume);
    processes.make_teams(teams, volume, options.size, arguments.frames as usize)?;
    let mut scene = OpenedScene::open(&arguments.scene, processes)?;
    let background = options.background.unwrap_or(Background::BLACK);
    let frames = arguments.frames;
    // The same views of all volumes, unless --up is given.
    let orientation = Orientation::with_up(options.up.unwrap_or_default(), scene.volume.grid());
    let first = Cameras::new(options, &scene, Fit::Volume, orientation);
    let start = first.angles().or_each_of(START);
    let first = first.still(start);
    scene.fix_lights(&arguments.scene, &first)?;
    let fitting = Cameras::new(options, &scene, Fit::Volume, orientation);
    let orbits = (0..frames).map(|n| turn(start, n, frames));
    let cameras = fitting.sequence(orbits);
    scene.require_checked(&arguments.scene, options.size, &cameras)?;
    let view = |n: u32| cameras[n as usize];

    let started = Instant::now();
    let mut scene_renderer = SceneRenderer::new(&scene)?;
    scene_renderer.announce(&view(0), options.size, &scene.settings)?;
    let streamed = scene_renderer.is_streamed();
    let renderer = scene_renderer.renderer();
    renderer.render_rgba8(&view(0), options.size, &scene.settings, background)?;
    let first_ms = milliseconds(if streamed { scene.opened_at } else { started });
    // Warm-up: builds layouts, min-max blocks and kernels of every layer axis, which the medians exclude.
    for n in 0..frames.min(8) {
        renderer.render_rgba8(&view(n * frames / frames.min(8)), options.size, &scene.settings, background)?;
    }

    let bar = progress::steps(2 * frames, "measuring");
    let mut stages = StageTimes::new();
    let (mut active_samples, mut last) = (None, None);
    renderer.measure(true);
    let own: Vec<u32> = (0..frames).filter(|&n| processes.owns(n as usize)).collect();
    for &n in &own {
        let (_, mut report) = renderer.render_rgba8(&view(n), options.size, &scene.settings, background)?;
        if let Some(measured) = report.measured.take() {
            *active_samples.get_or_insert(0) += measured.active_samples;
            stages.extend(measured.stages);
        }
        last = Some(report);
        bar.inc(1);
    }
    renderer.measure(false);
    let mut times = Vec::new();
    let mut cpu_ms = 0.0;
    processes.wait();
    let all = Instant::now();
    for &n in &own {
        let (started, cpu) = (Instant::now(), ProcessTime::now());
        let (picture, _) = renderer.render_rgba8(&view(n), options.size, &scene.settings, background)?;
        times.push(milliseconds(started));
        cpu_ms += cpu.elapsed().as_secs_f64() * 1e3;
        drop(picture);
        bar.inc(1);
    }
    processes.wait();
    let frames_per_s = f64::from(frames) / all.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let timed = |renderer: &mut dyn VolumeRenderer, azimuth: f64| -> Result<f64, Error> {
        let started = Instant::now();
        let turned = Orbit { azimuth, ..start };
        let camera = fitting.still(turned);
        renderer.render_rgba8(&camera, options.size, &scene.settings, background)?;
        Ok(milliseconds(started))
    };
    let mut transfer_changes = Vec::new();
    let mut transfer_changes_cpu = Vec::new();
    let mut axis_changes = Vec::new();
    // A slightly different function, because setting an equal one has no effect.
    let (lo, hi) = scene.transfer.range();
    let other = scene.transfer.stretched(lo, hi + (hi - lo) * 1e-9).unwrap_or_else(|_| scene.transfer.clone());
    for transfer in [&other, &scene.transfer].into_iter().cycle().take(CHANGES) {
        let (started, cpu) = (Instant::now(), ProcessTime::now());
        renderer.set_transfer_function(transfer);
        timed(renderer, 0.0)?;
        transfer_changes.push(milliseconds(started));
        transfer_changes_cpu.push(cpu.elapsed().as_secs_f64() * 1e3);
    }
    // Warm-up: the first change across 45° builds what the other layer axis needs.
    timed(renderer, 50.0)?;
    for _ in 0..CHANGES {
        timed(renderer, 40.0)?;
        axis_changes.push(timed(renderer, 50.0)?);
    }
    let mut per_stage = BTreeMap::new();
    for (stage, ms) in stages {
        *per_stage.entry(stage).or_insert(0.0) += ms / own.len() as f64;
    }
    let effective_splats = scene.transfer.effective_splats(&scene.volume);
    let times = processes.gather(if processes.leads_team() { times } else { Vec::new() });
    if !processes.leads() {
        return Ok(ExitCode::SUCCESS);
    }
    let bench = Bench {
        volume: scene.volume.name(),
        algorithm: scene.settings.algorithm.name(),
        quality: scene.settings.layered().map(|_| arguments.scene.quality.quality()),
        device: &scene.device.info().name,
        frames,
        min_ms: times.iter().copied().fold(f64::INFINITY, f64::min),
        max_ms: times.iter().copied().fold(0.0, f64::max),
        median_ms: median(times),
        cpu_ms: cpu_ms / own.len() as f64,
        first_ms,
        transfer_change_ms: median(transfer_changes),
        transfer_change_cpu_ms: median(transfer_changes_cpu),
        axis_change_ms: median(axis_changes),
        stages: per_stage,
        effective_splats,
        active_samples: active_samples.map(|all| all / own.len() as u64),
        lattice: last.as_ref().and_then(|report| report.lattice),
        device_bytes: if streamed { scene.device.peak_bytes() } else { scene.device.allocated_bytes() },
        peak_bytes: peak_bytes(),
        processes: processes.counts().map(|(processes, teams)| TeamReport {
            processes,
            teams,
            frames_per_s,
            #[cfg(feature = "mpi")]
            picture: last.and_then(|report| report.processes),
        }),
    };
    super::report(arguments.json, &bench, || text(&bench))?;
    Ok(ExitCode::SUCCESS)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// The median: the middle value, or the mean of the two middle ones.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

/// Peak resident memory of this process in bytes. `None` except on Linux.
pub(super) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

fn text(b: &Bench) -> String {
    let quality = b.quality.map_or(String::new(), |quality| format!(" {quality:?}").to_lowercase());
    let lattice = b.lattice.map_or("none (per pixel)".into(), |l| {
        format!("{}x{} samples, {:.2}x{:.2} per voxel", l.width, l.height, l.samples_per_voxel[0], l.samples_per_voxel[1])
    });
    let mut lines = vec![
        format!("{}, {}{quality}, on {}", b.volume, b.algorithm, b.device),
        format!("median    {:.2} ms of {} frames ({:.1} frames/s)", b.median_ms, b.frames, 1e3 / b.median_ms),
        format!("range     {:.2} to {:.2} ms", b.min_ms, b.max_ms),
        format!("cpu       {:.2} ms per frame", b.cpu_ms),
        format!("first     {:.1} ms", b.first_ms),
        format!(
            "changes   transfer function {:.2} ms, layer axis {:.2} ms, until the frame is finished",
            b.transfer_change_ms, b.axis_change_ms
        ),
        format!(
            "splats    {} effective{}",
            b.effective_splats,
            b.active_samples.map_or(String::new(), |samples| format!("; {samples} active samples per frame"))
        ),
        format!("lattice   {lattice}"),
        format!(
            "memory    {:.1} MiB on the device, process peak {}",
            mib(b.device_bytes),
            b.peak_bytes.map_or("?".into(), |p| format!("{:.1} MiB", mib(p)))
        ),
    ];
    lines.extend(
        b.processes.as_ref().map(|all| {
            format!("total     {:.1} frames/s by {} processes in {} teams", all.frames_per_s, all.processes, all.teams)
        }),
    );
    lines.extend(b.stages.iter().map(|(stage, ms)| format!("  {stage:<12} {ms:.3} ms")));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians() {
        assert_eq!((median(vec![3.0]), median(vec![2.0, 1.0]), median(vec![9.0, 1.0, 2.0])), (3.0, 1.5, 2.0));
    }
}
