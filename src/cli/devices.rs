//! `layersplat devices`.

use crate::device::{Device, DeviceInfo};
use crate::error::Error;
use serde::Serialize;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Devices {
    devices: Vec<DeviceInfo>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let devices = Devices { devices: Device::list()? };
    super::report(arguments.json, &devices, || devices.devices.iter().map(text).collect::<Vec<_>>().join("\n"))?;
    Ok(ExitCode::SUCCESS)
}

fn text(d: &DeviceInfo) -> String {
    let mib = |bytes: u64| bytes >> 20;
    let t = &d.tuning;
    format!(
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
    )
}
