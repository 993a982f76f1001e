//! `layersplat devices`.

use super::check;
use crate::check::Verdict;
use crate::device::{Device, DeviceInfo};
use crate::error::Error;
use serde::Serialize;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Check every device again: render small pictures with all kernels and compare them with the reference; exit with 1 on
    /// failure
    #[arg(long)]
    check: bool,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Devices {
    devices: Vec<ListedDevice>,
}

#[derive(Serialize)]
struct ListedDevice {
    #[serde(flatten)]
    device: DeviceInfo,
    /// One verdict per kernel family, with `--check`.
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Vec<Verdict>>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let listed = |device: DeviceInfo| ListedDevice { check: arguments.check.then(|| check::check_all(&device)), device };
    let devices = Devices { devices: Device::list()?.into_iter().map(listed).collect() };
    super::report(arguments.json, &devices, || devices.devices.iter().map(text).collect::<Vec<_>>().join("\n"))?;
    let all_passed = devices.devices.iter().filter_map(|listed| listed.check.as_ref()).flatten().all(Verdict::passed);
    Ok(if all_passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(ListedDevice { device: d, check }: &ListedDevice) -> String {
    let mib = |bytes: u64| bytes >> 20;
    let t = &d.tuning;
    let mut lines = vec![format!(
        "{}  {} ({:?}, {} compute units)\n   platform  {}, {}, driver {}\n   memory    {} MiB, largest buffer {} MiB\n   \
         tuning    vector width {}, tiles of {}x{} samples, work-groups of {}, stages timed by {}",
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
        t.vector_width,
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
        (None, largest) => {
            format!("   passed    {:<17} largest difference {:.2}/255", verdict.family, 255.0 * largest.unwrap_or(0.0))
        }
    }
}
