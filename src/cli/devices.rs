//! `layersplat devices`.

use super::check;
use crate::check::Verdict;
use crate::device::{Device, DeviceInfo};
use crate::error::Error;
use serde::Serialize;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Check that every device draws what it should, anew, and exit with 1 if one does not. It draws small pictures through every kernel,
    /// which takes half a minute on PoCL where none is built yet, and seconds later on; what fails is refused from then on
    #[arg(long)]
    check: bool,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Devices {
    devices: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    #[serde(flatten)]
    device: DeviceInfo,
    /// One per kernel family, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Vec<Verdict>>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let listed = |device: DeviceInfo| Listed { check: arguments.check.then(|| check::check_all(&device)), device };
    let devices = Devices { devices: Device::list()?.into_iter().map(listed).collect() };
    super::report(arguments.json, &devices, || devices.devices.iter().map(text).collect::<Vec<_>>().join("\n"))?;
    let all_passed = devices.devices.iter().filter_map(|listed| listed.check.as_ref()).flatten().all(Verdict::passed);
    Ok(if all_passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(Listed { device: d, check }: &Listed) -> String {
    let mib = |bytes: u64| bytes >> 20;
    let t = &d.tuning;
    let mut lines = vec![format!(
        "{}  {} ({:?}, {} units)\n   platform  {}, {}, driver {}\n   memory    {} MiB, {} MiB in one buffer\n   \
         tuning    vectors of {}, tiles of {}x{} samples, groups of {}, stages timed by {}",
        d.index.map_or(String::new(), |index| index.to_string()),
        d.name,
        d.kind,
        d.compute_units,
        d.platform,
        d.version,
        d.driver,
        mib(d.memory_bytes),
        mib(d.largest_buffer_bytes),
        t.vector_width,
        t.vector_width * t.tile_vectors,
        t.tile_rows,
        t.tile_group,
        if t.event_times { "events" } else { "the wall clock" },
    )];
    lines.extend(check.iter().flatten().map(verdict_text));
    lines.join("\n")
}

fn verdict_text(verdict: &Verdict) -> String {
    match (&verdict.problem, verdict.largest_difference) {
        (Some(problem), _) => format!("   FAILED    {:<17} {problem}", verdict.family),
        (None, largest) => format!("   right     {:<17} to {:.2} of 255 steps", verdict.family, 255.0 * largest.unwrap_or(0.0)),
    }
}
