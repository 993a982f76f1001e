//! `layersplat render`.

use super::bench::peak_bytes;
use super::check;
use super::many;
use super::processes::Processes;
use super::scene::{Scene, SceneOptions};
use super::standard::{Output, is_input};
use super::studio::{PictureOptions, Studio};
use crate::camera::Camera;
use crate::check::Family;
use crate::error::Error;
use crate::image::{Background, Depths, Frame, ImageFormat};
use crate::renderer::{LatticeReport, StreamPlan, depth_settings};
use crate::viewport::Viewport;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub pictures: PictureOptions,
    /// Picture to write: .png, .jpg, .exr or .npy; on standard output - for PNG, or jpg:-, exr:-, npy:-
    #[arg(short, long, default_value = "layersplat.png")]
    output: PathBuf,
    /// Pictures of many views: a line of JSON each, of a file or, as they come, of standard input (-), as {"output": "a.png", "azimuth": 30,
    /// "elevation": 20} or {"output": "b.png", "position": [0, 0, 90], "focal_point": [9, 9, 9], "view_up": [0, 1, 0], "perspective": 30};
    /// also roll, center, distance, parallel_scale, size. The other options are for what a line leaves out. A line of JSON is printed for
    /// each picture
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "json"])]
    cameras: Option<PathBuf>,
    /// Write depths beside the picture, an .exr: channels Z, the distance from the eye along the view's direction where something is seen
    /// first, and mean.Z, weighted by opacity; infinite where nothing is seen
    #[arg(long)]
    pub depth: bool,
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
    /// Where one process draws all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    active_samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stream: Option<Stream>,
    #[cfg(feature = "mpi")]
    #[serde(skip_serializing_if = "Option::is_none")]
    processes: Option<crate::distributed::DistributedReport>,
}

/// How it was streamed, and what that took.
#[derive(Serialize)]
struct Stream {
    #[serde(flatten)]
    plan: StreamPlan,
    first_pass_ms: f64,
    peak_device_bytes: u64,
    peak_bytes: Option<u64>,
}

pub(super) fn run(arguments: &Arguments, processes: &Processes) -> Result<ExitCode, Error> {
    if let Some(source) = &arguments.cameras {
        if is_input(source) && is_input(&arguments.scene.volume.volume) {
            let problem = "standard input holds the cameras or the volume, not both: name a file for one of them".into();
            return Err(Error::Settings { field: "cameras", problem });
        }
        return many::run(arguments, source, processes);
    }
    // A wrong ending is refused before any work.
    let options = &arguments.scene.camera;
    let output = Output::of(&arguments.output, Some("png"))?;
    output.refuse_report(arguments.json)?;
    arguments.check_output(output.path()).map_err(|e| output.renamed(e))?;
    arguments.pictures.rendered(options.size)?;
    processes.make_teams(&arguments.scene.teams, &arguments.scene.volume, options.size, 1)?;
    if !processes.owns(0) {
        return Ok(ExitCode::SUCCESS);
    }
    let scene = Scene::open(&arguments.scene, processes)?;
    let camera = arguments.pictures.cameras(options, &scene).still(options.orbit(0.0));
    scene.require_shared(options.size, &[camera])?;
    let families = arguments.families(&scene, camera, options.size)?;
    processes.in_turn(|| check::require(&scene.device, &families, &arguments.scene.device))?;
    let started = Instant::now();
    let mut studio = Studio::new(&scene, &arguments.pictures, options.background)?;
    let plan = studio.announce(&camera, options.size)?;
    studio.measure(arguments.json);
    let (frame, report) = studio.picture(&camera, options.size)?;
    let Some(frame) = frame else { return Ok(ExitCode::SUCCESS) };
    let depths = if arguments.depth { Some(studio.depths(&camera, options.size)?) } else { None };
    let first_ms = if studio.is_streamed() { scene.begun } else { started }.elapsed().as_secs_f64() * 1e3;
    if plan.is_some() {
        let (all, picture, first) = (first_ms / 1e3, started.elapsed().as_secs_f64(), scene.first_pass.as_secs_f64());
        eprintln!("memory: {all:.2} s, the first pass over the volume took {first:.2} of them, the picture {picture:.2}");
    }
    save(&frame, depths.as_ref(), output.path(), options.background)?;
    if output.is_standard() {
        return output.finish(output.path());
    }
    let rendered = Rendered {
        output: arguments.output.display().to_string(),
        volume: scene.volume.name(),
        device: &scene.device.info().name,
        width: options.size.width,
        height: options.size.height,
        first_ms,
        lattice: report.lattice,
        active_samples: report.measured.map(|measured| measured.active_samples),
        stream: plan.map(|plan| Stream {
            plan,
            first_pass_ms: scene.first_pass.as_secs_f64() * 1e3,
            peak_device_bytes: scene.device.peak_bytes(),
            peak_bytes: peak_bytes(),
        }),
        #[cfg(feature = "mpi")]
        processes: studio.viewer().shared_report().cloned(),
    };
    super::report(arguments.json, &rendered, || rendered.output.clone())?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    /// Refuses a name of a picture that would only fail once the picture is there.
    pub fn check_output(&self, path: &Path) -> Result<(), Error> {
        let format = if self.depth { ImageFormat::with_depths(path) } else { ImageFormat::from_path(path) };
        format?.accept(self.scene.camera.background)
    }

    /// Families of kernels that a picture of this size takes, with its depths.
    pub fn families(&self, scene: &Scene, camera: Camera, size: Viewport) -> Result<BTreeSet<Family>, Error> {
        let grid = scene.volume.grid();
        let mut families = check::families(&[camera], self.pictures.rendered(size)?, grid, &scene.settings);
        if self.depth {
            families.extend(check::families(&[camera], size, grid, &depth_settings(&scene.settings)));
        }
        Ok(families)
    }
}

/// Writes a picture, with depths where there are some.
pub(super) fn save(frame: &Frame, depths: Option<&Depths>, path: &Path, background: Option<Background>) -> Result<(), Error> {
    match depths {
        Some(depths) => frame.save_with_depths(path, background, depths),
        None => frame.save(path, background),
    }
}
