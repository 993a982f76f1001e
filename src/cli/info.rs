//! `layersplat info`.

use super::labels::{self, LabelReport};
use super::numbers::{hex_color, shortened};
use super::options::{Described, LabelOptions, TransferOptions, VolumeOptions};
use super::orientation::{self, UpReport};
use super::remarks::describe;
use super::scene::open_transfer;
use super::surface_info::{self, PlaceReport};
use super::surfaces::{SurfaceArguments, bounds_of, position};
use super::transfer::TransferReport;
use crate::error::Error;
use crate::framing::Orientation;
use crate::settings::Blend;
use crate::surface::SurfaceFile;
use crate::transfer::TransferFunction;
use crate::volume::{ChannelDescription, Contents, FrameSpacing, Statistics, Volume};
use glam::DVec3;
use serde::Serialize;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub volume: VolumeOptions,
    #[command(flatten)]
    labels: LabelOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    #[command(flatten)]
    pub surfaces: SurfaceArguments,
    /// Print the report as one line of JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Info {
    dims: [usize; 3],
    #[serde(rename = "type")]
    voxel_type: String,
    /// Components of each voxel in the file, and which one is described here.
    channels: usize,
    channel: usize,
    /// What the file states about its components, if there are several.
    channel_descriptions: Vec<ChannelReport>,
    /// Whether the magnitude of all components is described.
    magnitude: bool,
    /// Whether the components are colours.
    are_colors: bool,
    /// Volumes of a sequence, usually times, and which one is described here.
    frames: usize,
    frame: usize,
    /// Distance between frames, if the file states one.
    frame_spacing: Option<f64>,
    /// If they are not evenly spaced.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frame_times: Vec<f64>,
    frame_unit: Option<String>,
    /// Dimensions of all resolutions, finest first, and which one is described here.
    levels: Vec<[usize; 3]>,
    level: usize,
    spacing: [f64; 3],
    spacing_is_assumed: bool,
    /// Unit of the spacing and of all positions, if the file states one.
    length_unit: Option<String>,
    /// World position of voxel 0,0,0.
    origin: [f64; 3],
    /// Unit vectors of the voxel axes in the world.
    direction: [[f64; 3]; 3],
    /// Lowest and highest world coordinates of voxel centres.
    bounds: [[f64; 3]; 2],
    /// Towards which sides of the patient x, y and z run, if the file declares a patient.
    anatomy: Option<[&'static str; 3]>,
    #[serde(flatten)]
    up: UpReport,
    min: f64,
    max: f64,
    mean: f64,
    /// Voxels that are missing, NaN or infinite. They count as the background.
    missing: usize,
    histogram: Vec<u64>,
    effective_splats: Option<u64>,
    transfer: TransferReport,
    /// Labels that voxels have, if the voxels are labels.
    labels: Option<Vec<LabelReport>>,
    /// Those of `--surface`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    surfaces: Vec<PlaceReport>,
}

/// A component of the file.
#[derive(Serialize)]
pub(super) struct ChannelReport {
    channel: usize,
    name: Option<String>,
    /// Of its brightest value, in pictures of several: declared by the file, of a fluorophore's name, or another that is free.
    color: [f64; 3],
    /// Whether the file declares the colour.
    color_is_declared: bool,
    /// Data values that are shown black and in full colour.
    window: Option<[f64; 2]>,
    active: bool,
}

impl ChannelReport {
    pub fn all(channels: &[ChannelDescription]) -> Vec<Self> {
        let report = |(channel, (found, color)): (usize, (&ChannelDescription, [f64; 3]))| Self {
            channel,
            name: found.name.clone(),
            color,
            color_is_declared: found.color.is_some(),
            window: found.window.map(|(from, to)| [from, to]),
            active: found.active,
        };
        channels.iter().zip(ChannelDescription::colors(channels)).enumerate().map(report).collect()
    }

    pub fn line(&self) -> String {
        let window = self.window.map_or(String::new(), |[from, to]| format!(", window {} to {}", shortened(from), shortened(to)));
        let hidden = if self.active { "" } else { ", hidden at first" };
        format!("  {:>7} {} {}{window}{hidden}", self.channel, hex_color(self.color), self.name.as_deref().unwrap_or("-"))
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    if SurfaceFile::is_one(&arguments.volume.volume) {
        if arguments.surfaces.are_given() {
            let problem = "says where surfaces lie beside a volume, and the file holds surfaces, too: omit it".into();
            return Err(Error::Settings { field: "surface", problem });
        }
        return surface_info::run(&arguments.volume.volume, arguments.json);
    }
    let Described { volume, labels, channels } = arguments.volume.open_described(&arguments.labels)?;
    // Malformed descriptions keep nobody from the values.
    let channels = channels.unwrap_or_else(|error| {
        eprintln!("layersplat: {error}");
        Vec::new()
    });
    let transfer = open_transfer(&arguments.transfer, &volume, Blend::Composite)?;
    let effective_splats = arguments.transfer.transfer.is_some().then(|| transfer.effective_splats(&volume));
    let statistics = volume.statistics();
    let (grid, contents) = (volume.grid(), volume.contents());
    let direction = grid.direction();
    let surfaces = arguments.surfaces.open(&volume)?;
    let surfaces = surfaces.iter().map(|surface| PlaceReport::new(surface, grid)).collect();
    let info = Info {
        dims: grid.dims(),
        voxel_type: volume.voxel_type().to_string(),
        channels: contents.channels,
        channel: contents.channel,
        channel_descriptions: ChannelReport::all(&channels),
        magnitude: contents.magnitude,
        are_colors: contents.are_colors,
        frames: contents.frames,
        frame: contents.frame,
        frame_spacing: contents.frame_spacing.as_ref().map(|spacing| spacing.distance),
        frame_times: contents.frame_times.clone(),
        frame_unit: contents.frame_spacing.as_ref().and_then(|spacing| spacing.unit.clone()),
        levels: if contents.levels.is_empty() { vec![grid.dims()] } else { contents.levels.clone() },
        level: contents.level,
        spacing: grid.spacing().to_array(),
        spacing_is_assumed: !contents.states_spacing && !arguments.volume.has_spacing(),
        length_unit: contents.length_unit.clone().filter(|_| !arguments.volume.has_spacing()),
        origin: grid.origin().to_array(),
        direction: direction.to_cols_array_2d(),
        bounds: bounds_of(grid).corners(),
        anatomy: grid.has_anatomy().then(|| [direction.x_axis, direction.y_axis, direction.z_axis].map(side_of_patient)),
        up: UpReport::new(&Orientation::of(grid)),
        min: statistics.min,
        max: statistics.max,
        mean: statistics.mean,
        missing: volume.invalid(),
        histogram: statistics.histogram.clone(),
        effective_splats,
        transfer: TransferReport::new(&transfer),
        labels: labels.as_ref().map(LabelReport::all),
        surfaces,
    };
    super::report(arguments.json, &info, || text(&info, &transfer, &statistics, &volume))?;
    Ok(ExitCode::SUCCESS)
}

fn text(info: &Info, transfer: &TransferFunction, statistics: &Statistics, volume: &Volume) -> String {
    let [x, y, z] = info.dims;
    let assumed = if info.spacing_is_assumed { ", assumed: the file states none" } else { "" };
    let unit = info.length_unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
    let [lowest, highest] = info.bounds.map(position);
    let mut lines = vec![
        volume.name().to_owned(),
        format!("dims      {x}x{y}x{z}, {} voxels", volume.grid().voxel_count()),
        format!("type      {}", info.voxel_type),
    ];
    lines.extend(several(volume.contents()));
    lines.extend(info.channel_descriptions.iter().map(ChannelReport::line));
    lines.extend([
        format!("spacing   {}{unit}{assumed}", position(info.spacing)),
        format!("origin    {}", position(info.origin)),
        format!("bounds    {lowest} to {highest}"),
        format!("up        {}", orientation::describe(&Orientation::of(volume.grid()), volume.grid())),
        format!("range     {} to {}, mean {}", shortened(info.min), shortened(info.max), shortened(info.mean)),
    ]);
    if info.missing > 0 {
        let share = 100.0 * info.missing as f64 / volume.grid().voxel_count() as f64;
        lines.push(format!("missing   {} voxels ({share:.2} %), which count as the background", info.missing));
    }
    if let Some([x, y, z]) = info.anatomy {
        lines.push(format!("anatomy   x runs to {x}, y to {y}, z to {z}"));
    }
    if let Some(count) = info.effective_splats {
        let share = 100.0 * count as f64 / volume.grid().voxel_count() as f64;
        lines.push(format!("effective splats {count} ({share:.2} %)"));
    }
    lines.push(format!("transfer  {}", describe(transfer)));
    lines.extend(info.labels.iter().flat_map(|reports| labels::lines(reports)));
    lines.extend(info.surfaces.iter().map(PlaceReport::line));
    lines.extend(histogram(statistics));
    lines.join("\n")
}

/// Times of frames that are listed.
const LISTED_TIMES: usize = 8;

/// Lines about channels, frames and resolutions, where the file has several, with the options that choose others.
pub(super) fn several(contents: &Contents) -> Vec<String> {
    let Contents { channels, channel, magnitude, frames, frame, levels, level, .. } = contents;
    let mut lines = Vec::new();
    if *channels > 1 {
        let this = if *magnitude { "their magnitude".into() } else { channel.to_string() };
        let colors = if contents.are_colors { ", which are red, green and blue" } else { "" };
        lines.push(format!("channels  {channels}{colors}; this is {this} (--channel)"));
    }
    if *frames > 1 {
        let unit = |unit: &Option<String>| unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
        let apart = |spacing: &FrameSpacing| format!(", {}{} apart", shortened(spacing.distance), unit(&spacing.unit));
        let times = match contents.frame_times.as_slice() {
            [] => contents.frame_spacing.as_ref().map_or(String::new(), apart),
            times => {
                let more = if times.len() > LISTED_TIMES { ", …" } else { "" };
                let listed: Vec<String> = times.iter().take(LISTED_TIMES).map(|&time| shortened(time).to_string()).collect();
                format!(" at {}{more}", listed.join(", "))
            }
        };
        lines.push(format!("frames    {frames}{times}; this is {frame} (--frame)"));
    }
    if levels.len() > 1 {
        let sizes: Vec<String> = levels.iter().map(|[x, y, z]| format!("{x}x{y}x{z}")).collect();
        lines.push(format!("levels    {}: {}; this is {level} (--level)", levels.len(), sizes.join(", ")));
    }
    lines
}

/// The side of a patient that a direction in RAS coordinates points to most.
fn side_of_patient(direction: DVec3) -> &'static str {
    let axis = direction.abs().max_position();
    let names = [["left", "right"], ["posterior", "anterior"], ["inferior", "superior"]];
    names[axis][usize::from(direction[axis] > 0.0)]
}

/// A heading and sixteen rows of bars on a logarithmic scale, so that rare values are visible beside a background of millions.
fn histogram(statistics: &Statistics) -> Vec<String> {
    const ROWS: usize = 16;
    const WIDTH: f64 = 50.0;
    let per_row = statistics.histogram.len() / ROWS;
    let rows: Vec<u64> = statistics.histogram.chunks(per_row).map(|bins| bins.iter().sum()).collect();
    let largest = rows.iter().max().map_or(1.0, |&n| (n as f64).ln_1p()).max(1.0);
    let step = (statistics.max - statistics.min) / ROWS as f64;
    let bar = |n: u64| "#".repeat(((n as f64).ln_1p() / largest * WIDTH).round() as usize);
    let row = |(i, &n): (usize, &u64)| format!("{:>12} {n:>12} {}", shortened(statistics.min + step * i as f64), bar(n));
    let heading = format!("{:>12} {:>12} logarithmic", "values from", "voxels");
    [heading].into_iter().chain(rows.iter().enumerate().map(row)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_sides_follow_the_direction() {
        let turned = glam::DMat3::from_cols(DVec3::NEG_X, DVec3::Z, DVec3::Y);
        let grid =
            crate::volume::Grid::oriented([3, 4, 5], DVec3::new(1.0, 2.0, 3.0), DVec3::new(10.0, 0.0, 0.0), turned).unwrap();
        assert_eq!(bounds_of(&grid).corners(), [[8.0, 0.0, 0.0], [10.0, 12.0, 6.0]]);
        assert_eq!([turned.x_axis, turned.y_axis, turned.z_axis].map(side_of_patient), ["left", "superior", "anterior"]);
    }
}
