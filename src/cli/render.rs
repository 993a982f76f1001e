//! `layersplat render`.

use super::options::Fit;
use super::scene::{Cameras, Scene, SceneOptions};
use crate::error::Error;
use crate::image::ImageFormat;
use crate::renderer::LatticeReport;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    /// Picture to write, .png or .npy
    #[arg(short, long, default_value = "layersplat.png")]
    output: PathBuf,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Rendered<'a> {
    output: String,
    volume: &'a str,
    device: &'a str,
    width: u32,
    height: u32,
    first_ms: f64,
    lattice: Option<LatticeReport>,
    active_samples: u64,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    // A wrong ending is refused before any work.
    ImageFormat::of(&arguments.output)?;
    let options = &arguments.scene.camera;
    let scene = Scene::open(&arguments.scene)?;
    let camera = Cameras::new(options, &scene, Fit::Visible).still(options.orbit(0.0));
    scene.require_checked(&arguments.scene, &[camera])?;
    let started = Instant::now();
    let mut renderer = scene.renderer()?;
    renderer.measure(arguments.json);
    let (frame, report) = renderer.render(&camera, options.size, &scene.settings)?;
    let first_ms = started.elapsed().as_secs_f64() * 1e3;
    frame.save(&arguments.output, options.background)?;
    let rendered = Rendered {
        output: arguments.output.display().to_string(),
        volume: scene.volume.name(),
        device: &scene.device.info().name,
        width: options.size.width,
        height: options.size.height,
        first_ms,
        lattice: report.lattice,
        active_samples: report.measured.map_or(0, |measured| measured.active_samples),
    };
    super::report(arguments.json, &rendered, || rendered.output.clone())?;
    Ok(ExitCode::SUCCESS)
}
