//! `layersplat rotate`.

use super::film::Film;
use super::keys::Keys;
use super::orientation::UpReport;
use super::parse;
use super::pictures::{PictureOptions, Pictures};
use super::processes::Processes;
use super::progress;
use super::scene::{OpenedScene, SceneOptions};
use super::time::{Moments, TimeOptions, Timed};
use crate::camera::Orbit;
use crate::error::Error;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Default elevation of `rotate` and `bench` in degrees, as in the paper's protocol.
pub(super) const ELEVATION: f64 = 20.0;
/// Default orbit of the first frame of `rotate` and `bench`.
pub(super) const START: Orbit = Orbit { azimuth: 0.0, elevation: ELEVATION, roll: 0.0 };
/// Default number of frames of a turn, as in the paper's protocol.
const TURN_FRAMES: u32 = 125;
/// Degrees.
const FULL_TURN: f64 = 360.0;
const MAX_FRAMES: u32 = 100_000;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    pictures: PictureOptions,
    #[command(flatten)]
    time: TimeOptions,
    /// Number of frames [default: 125; with --time one per step; with --keys, their duration times --rate]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)), value_name = "N")]
    frames: Option<u32>,
    /// Follow a smooth path through the key cameras of a JSON file instead of a turn; see below
    #[arg(long, value_name = "FILE")]
    keys: Option<PathBuf>,
    /// Degrees that the camera turns; 0: it stands
    #[arg(long, default_value_t = FULL_TURN, value_parser = parse::finite, value_name = "DEGREES", allow_hyphen_values = true, conflicts_with = "keys")]
    turn: f64,
    /// Frames per second, 1 to 120; GIF up to 50
    #[arg(long, default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=120), value_name = "N")]
    rate: u32,
    /// Output: NAME.gif, NAME.apng (or .png), NAME.mp4 (needs ffmpeg), or a folder for frame_0000.png and so on
    #[arg(short, long, default_value = "frames", value_name = "PATH")]
    output: PathBuf,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Rotated<'a> {
    output: String,
    frames: u32,
    /// Steps of the sequence that is played.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<usize>,
    volume: &'a str,
    device: &'a str,
    #[serde(flatten)]
    up: UpReport,
}

/// Orbit of frame `n` of `frames` in a full turn around the vertical axis.
pub(super) fn turn(start: Orbit, n: u32, frames: u32) -> Orbit {
    turned(start, n, frames, FULL_TURN)
}

/// Orbit of frame `n` of `frames` while the camera turns by `degrees`. Full turns end a frame before their start, so that films repeat
/// smoothly.
fn turned(start: Orbit, n: u32, frames: u32, degrees: f64) -> Orbit {
    let intervals = if degrees % FULL_TURN == 0.0 { frames } else { frames.max(2) - 1 };
    Orbit { azimuth: start.azimuth + degrees * f64::from(n) / f64::from(intervals), ..start }
}

impl Arguments {
    /// Number of frames; `steps` is that of the sequence.
    fn frame_count(&self, keys: Option<&Keys>, steps: Option<usize>) -> Result<u32, Error> {
        let frames = match (self.frames, keys) {
            (Some(frames), _) => f64::from(frames),
            (None, Some(keys)) => (keys.duration() * f64::from(self.rate)).round() + 1.0,
            (None, None) => steps.map_or(f64::from(TURN_FRAMES), |steps| steps as f64),
        };
        if frames > f64::from(MAX_FRAMES) {
            let expected = "at most 100000: choose a lower rate, other times or a number of frames";
            return Err(Error::OutOfRange { name: "frames", value: frames.to_string(), expected });
        }
        Ok(frames as u32)
    }
}

pub(super) fn run(arguments: &Arguments, processes: &Processes) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    // Checks files before any work.
    let keys = arguments.keys.as_deref().map(Keys::read).transpose()?;
    let sequence = arguments.time.sequence(&arguments.scene, keys.as_ref(), processes)?;
    let frames = arguments.frame_count(keys.as_ref(), sequence.as_ref().map(|timed| timed.sequence.len()))?;
    let moments = sequence.map(|sequence| Moments::new(sequence, keys.as_ref(), frames)).transpose()?;
    arguments.pictures.rendered(options.size)?;
    processes.make_teams(&arguments.scene.teams, &arguments.scene.volume, options.size, frames as usize)?;
    let encoding = arguments.pictures.encoding.encoding();
    let film = || Film::create(&arguments.output, options, encoding, frames, arguments.rate);
    let mut film = if processes.leads() { Some(film()?) } else { None };
    let mut scene = match &moments {
        Some(moments) => {
            let Timed { sequence, others, shown } = moments.timed();
            OpenedScene::open_sequence(&arguments.scene, processes, sequence, others, shown.as_ref())?
        }
        None => OpenedScene::open_for_views(&arguments.scene, processes)?,
    };
    let fitting = arguments.pictures.cameras(options, &scene);
    let start = fitting.angles().or_each_of(START);
    let cameras = match &keys {
        Some(keys) => keys.cameras(&fitting, START, frames)?,
        None => fitting.sequence((0..frames).map(|n| turned(start, n, frames, arguments.turn))),
    };
    let up = UpReport::new(fitting.orientation());
    scene.fix_lights(&arguments.scene, &cameras[0])?;
    let inner = arguments.pictures.inner(options.size, &scene);
    scene.read_seen(&arguments.scene, &cameras, inner)?;
    let inner = arguments.pictures.rendered(inner)?;
    scene.require_checked(&arguments.scene, inner, &cameras)?;
    let mut pictures = Pictures::new(&scene, &arguments.pictures, options.background)?;
    pictures.announce(&cameras[0], options.size)?;
    let bar = progress::steps(frames, "rendering");
    let mut played = moments.as_ref().map(Moments::play);
    for (n, camera) in cameras.iter().enumerate() {
        if let Some(step) = played.as_mut().map_or(Ok(None), |played| played.change(n))? {
            pictures.set_step(step)?;
        }
        let rendered = if processes.owns(n) { pictures.picture(camera, options.size)?.0 } else { None };
        if let (Some(film), Some(frame)) = (&mut film, processes.collect(n, rendered, options.size)) {
            film.add(&frame)?;
            bar.inc(1);
        }
    }
    let Some(film) = film else { return Ok(ExitCode::SUCCESS) };
    film.finish()?;
    bar.finish_and_clear();
    let output = arguments.output.display().to_string();
    let steps = moments.as_ref().map(|moments| moments.timed().sequence.len());
    let rotated = Rotated { output, frames, steps, volume: scene.volume.name(), device: &scene.device.info().name, up };
    super::report(arguments.json, &rotated, || format!("{} pictures in {}", rotated.frames, rotated.output))?;
    Ok(ExitCode::SUCCESS)
}
