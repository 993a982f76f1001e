//! `layersplat rotate`.

use super::options::Fit;
use super::scene::{Cameras, Scene, SceneOptions};
use super::viewer::Viewer;
use crate::camera::Orbit;
use crate::error::Error;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Elevation of `rotate` and `bench`, as in the paper's protocol.
pub(super) const ELEVATION: f64 = 20.0;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    /// Pictures of the turn
    #[arg(long, default_value_t = 125, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Folder for frame_0000.png and so on; made if it is missing
    #[arg(short, long, default_value = "frames")]
    output: PathBuf,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Rotated<'a> {
    output: String,
    frames: u32,
    volume: &'a str,
    device: &'a str,
}

/// The orbit of frame `n` of `frames`: a full turn about y.
pub(super) fn turn(start: Orbit, n: u32, frames: u32) -> Orbit {
    Orbit { azimuth: start.azimuth + 360.0 * f64::from(n) / f64::from(frames), ..start }
}

/// `frame_0000.png` and so on, with as many digits as the last one needs, so that names sort as numbers do.
fn frame_name(n: usize, frames: u32) -> String {
    let digits = (frames - 1).to_string().len().max(4);
    format!("frame_{n:0digits$}.png")
}

/// A progress bar on standard error; invisible where that is no terminal.
pub(super) fn progress(steps: u32, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {bar:40} {pos}/{len} {elapsed} (about {eta} left)");
    ProgressBar::new(steps.into()).with_style(style.expect("the template is valid")).with_message(what)
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    let scene = Scene::open(&arguments.scene)?;
    let orbits = (0..arguments.frames).map(|n| turn(options.orbit(ELEVATION), n, arguments.frames));
    let cameras = Cameras::new(options, &scene, Fit::Visible).sequence(orbits);
    scene.require_checked(&arguments.scene, &cameras)?;
    let mut renderer = Viewer::new(&scene)?;
    std::fs::create_dir_all(&arguments.output).map_err(|e| Error::write(&arguments.output, e))?;
    let bar = progress(arguments.frames, "rendering");
    for (n, camera) in cameras.iter().enumerate() {
        if n == 0 {
            renderer.announce(camera, options.size, &scene.settings)?;
        }
        let (frame, _) = renderer.render(camera, options.size, &scene.settings)?;
        frame.save(arguments.output.join(frame_name(n, arguments.frames)), options.background)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let rotated = Rotated {
        output: arguments.output.display().to_string(),
        frames: arguments.frames,
        volume: scene.volume.name(),
        device: &scene.device.info().name,
    };
    super::report(arguments.json, &rotated, || format!("{} pictures in {}", rotated.frames, rotated.output))?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_sort_as_numbers_do() {
        assert_eq!((frame_name(0, 1), frame_name(9999, 10_000)), ("frame_0000.png".into(), "frame_9999.png".into()));
        for frames in [1, 125, 10_000, 10_001, 100_000] {
            let names: Vec<String> = (0..frames as usize).map(|n| frame_name(n, frames)).collect();
            assert!(names.is_sorted(), "{frames}");
        }
        assert_eq!(frame_name(9, 10_001), "frame_00009.png");
    }
}
