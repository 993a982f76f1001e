//! `layersplat info` of a URL: what its metadata state. No voxels are read.

use super::info::{Arguments, ChannelReport, several};
use super::numbers::bytes_in_words;
use super::option_names;
use super::surfaces::{bounds_of, position};
use crate::error::Error;
use crate::viewport::Viewport;
use crate::volume::{ChannelDescription, Contents, Grid, Level, OpenOptions, Stated};
use serde::Serialize;
use std::process::ExitCode;
use tracing::subscriber::{NoSubscriber, with_default};

/// Size of the pictures of `render` by default.
const PICTURE: u32 = 768;

#[derive(Serialize)]
struct Info {
    url: String,
    dims: [usize; 3],
    #[serde(rename = "type")]
    voxel_type: String,
    channels: usize,
    channel_descriptions: Vec<ChannelReport>,
    frames: usize,
    /// Finest first.
    levels: Vec<LevelReport>,
    /// The level that this and what follows describe.
    level: usize,
    spacing: [f64; 3],
    length_unit: Option<String>,
    origin: [f64; 3],
    bounds: [[f64; 3]; 2],
    /// The level that a picture of the default size shows.
    picture_level: Option<usize>,
}

/// A resolution, of one frame and channel.
#[derive(Serialize)]
struct LevelReport {
    dims: [usize; 3],
    chunk: Option<[usize; 3]>,
    chunks: Option<usize>,
    /// Of its voxels, unpacked.
    bytes: u64,
}

pub(super) fn run(Arguments { volume, json, surfaces, .. }: &Arguments) -> Result<ExitCode, Error> {
    if surfaces.are_given() {
        let problem = "lies beside a volume that is read, and of a URL only metadata are: omit it".into();
        return Err(Error::Settings { field: "surface", problem });
    }
    let options = volume.opening(None)?;
    // Chosen, so that nothing warns of a default, or of many bytes.
    let (frame, channel) = (options.frame.or(Some(0)), options.channel.or(options.channel_name.is_none().then_some(0)));
    // Larger levels have no grid.
    let level = options.level.or(Some(Level::Bytes(Grid::MAX_VOXELS as u64)));
    let of_any = OpenOptions { frame, channel, level, download: Some(u64::MAX), ..options.clone() };
    let quietly = || Stated::of_file(&volume.volume, &of_any);
    let Stated { grid, scalar, contents } = with_default(NoSubscriber::default(), quietly)?;
    let descriptions = if contents.channels > 1 { ChannelDescription::of_file(&volume.volume, &of_any)? } else { Vec::new() };
    let picture = volume.opening(Some(Viewport { width: PICTURE, height: PICTURE }))?;
    let size = scalar.bytes() as u64;
    // What is too much for a picture may still be described.
    let picture = Stated::of_file(&volume.volume, &OpenOptions { frame, channel, ..picture })
        .map(|picture| (picture.contents.level, picture.grid.voxel_count() as u64 * size));
    let dims = if contents.levels.is_empty() { vec![grid.dims()] } else { contents.levels.clone() };
    let level = |(n, dims): (usize, &[usize; 3])| {
        let chunk = contents.chunks.get(n).copied();
        let count = |chunk: [usize; 3]| (0..3).map(|i| dims[i].div_ceil(chunk[i])).product();
        let bytes = dims.iter().fold(size, |bytes, &n| bytes.saturating_mul(n as u64));
        LevelReport { dims: *dims, chunk, chunks: chunk.map(count), bytes }
    };
    let info = Info {
        url: volume.volume.display().to_string(),
        dims: dims[0],
        voxel_type: scalar.to_string(),
        channels: contents.channels,
        channel_descriptions: ChannelReport::all(&descriptions),
        frames: contents.frames,
        levels: dims.iter().enumerate().map(level).collect(),
        spacing: grid.spacing().to_array(),
        level: contents.level,
        length_unit: contents.length_unit.clone(),
        origin: grid.origin().to_array(),
        bounds: bounds_of(&grid).corners(),
        picture_level: picture.as_ref().ok().map(|(level, _)| *level),
    };
    super::report(*json, &info, || text(&info, &contents, &picture))?;
    Ok(ExitCode::SUCCESS)
}

fn text(info: &Info, contents: &Contents, picture: &Result<(usize, u64), Error>) -> String {
    let unit = info.length_unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
    let [lowest, highest] = info.bounds.map(position);
    let by = |[x, y, z]: [usize; 3]| format!("{x}x{y}x{z}");
    let mut lines = vec![info.url.clone(), format!("dims      {}", by(info.dims)), format!("type      {}", info.voxel_type)];
    let mut contents = contents.clone();
    // These have lines of their own.
    contents.levels.clear();
    lines.extend(several(&contents));
    lines.extend(info.channel_descriptions.iter().map(ChannelReport::line));
    for (n, level) in info.levels.iter().enumerate() {
        let chunks = level.chunk.zip(level.chunks).map(|(chunk, count)| format!(" in {count} chunks of {}", by(chunk)));
        let bytes = bytes_in_words(level.bytes);
        lines.push(format!("level {n}   {}{}, {bytes}", by(level.dims), chunks.unwrap_or_default()));
    }
    let picture = match picture {
        Ok((level, bytes)) => format!("level {level}, {} unpacked", bytes_in_words(*bytes)),
        Err(error) => option_names::with_options(error),
    };
    let of_level = if info.level > 0 { format!(" (level {})", info.level) } else { String::new() };
    lines.extend([
        format!("spacing   {}{unit}{of_level}", position(info.spacing)),
        format!("origin    {}", position(info.origin)),
        format!("bounds    {lowest} to {highest}"),
        format!("picture   of {PICTURE}x{PICTURE} pixels: {picture}"),
    ]);
    lines.join("\n")
}
