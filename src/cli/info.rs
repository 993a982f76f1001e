//! `layersplat info`.

use super::options::{TransferOptions, VolumeOptions};
use super::scene::{describe, open_transfer};
use super::transfer::TransferReport;
use crate::error::Error;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::{Statistics, Volume};
use serde::Serialize;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    volume: VolumeOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Info {
    dims: [usize; 3],
    #[serde(rename = "type")]
    voxel_type: String,
    spacing: [f64; 3],
    min: f64,
    max: f64,
    mean: f64,
    histogram: Vec<u64>,
    effective_splats: Option<u64>,
    transfer: TransferReport,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let volume = arguments.volume.open(None, None)?;
    let transfer = open_transfer(&arguments.transfer, &volume, Blend::Composite)?;
    let effective_splats = arguments.transfer.transfer.is_some().then(|| transfer.effective_splats(&volume));
    let statistics = volume.statistics();
    let info = Info {
        dims: volume.grid().dims(),
        voxel_type: volume.voxel_type().to_string(),
        spacing: volume.grid().spacing().to_array(),
        min: statistics.min,
        max: statistics.max,
        mean: statistics.mean,
        histogram: statistics.histogram.clone(),
        effective_splats,
        transfer: TransferReport::new(&transfer),
    };
    super::report(arguments.json, &info, || text(&info, &transfer, &statistics, &volume))?;
    Ok(ExitCode::SUCCESS)
}

fn text(info: &Info, transfer: &TransferFunction, statistics: &Statistics, volume: &Volume) -> String {
    let [x, y, z] = info.dims;
    let [hx, hy, hz] = info.spacing;
    let mut lines = vec![
        volume.name().to_owned(),
        format!("dims      {x}x{y}x{z}, {} voxels", volume.grid().voxel_count()),
        format!("type      {}", info.voxel_type),
        format!("spacing   {hx},{hy},{hz}"),
        format!("range     {} to {}, mean {:.3}", info.min, info.max, info.mean),
    ];
    if let Some(count) = info.effective_splats {
        let share = 100.0 * count as f64 / volume.grid().voxel_count() as f64;
        lines.push(format!("effective splats {count} ({share:.2} %)"));
    }
    lines.push(format!("transfer  {}", describe(transfer)));
    lines.extend(histogram(statistics));
    lines.join("\n")
}

/// Sixteen rows of bars on a logarithmic scale, so that rare values are visible beside a background of millions.
fn histogram(statistics: &Statistics) -> Vec<String> {
    const ROWS: usize = 16;
    const WIDTH: f64 = 50.0;
    let per_row = statistics.histogram.len() / ROWS;
    let rows: Vec<u64> = statistics.histogram.chunks(per_row).map(|bins| bins.iter().sum()).collect();
    let largest = rows.iter().max().map_or(1.0, |&n| (n as f64).ln_1p()).max(1.0);
    let step = (statistics.max - statistics.min) / ROWS as f64;
    let bar = |n: u64| "#".repeat(((n as f64).ln_1p() / largest * WIDTH).round() as usize);
    rows.iter().enumerate().map(|(i, &n)| format!("{:>12.5} {n:>12} {}", statistics.min + step * i as f64, bar(n))).collect()
}
