//! `layersplat render`.

use super::bench::peak_bytes;
use super::check;
use super::many;
use super::options::CameraOptions;
use super::orientation::{OBLIQUE, UpReport};
use super::pictures::{PictureOptions, Pictures};
use super::processes::Processes;
use super::scene::{OpenedScene, SceneOptions};
use super::standard::{Output, is_input};
use crate::annotation::VectorFormat;
use crate::camera::Camera;
use crate::check::Family;
use crate::error::Error;
use crate::files::{check_writable, write_whole};
use crate::image::{Depths, Frame, ImageFormat};
use crate::renderer::{LatticeReport, StreamPlan, depth_settings};
use crate::settings::Settings;
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
    /// Output picture: .png, .jpg, .tif, .webp, .exr or .npy; standard output: - (PNG), jpg:-, exr:- and so on
    #[arg(short, long, default_value = "layersplat.png", value_name = "FILE")]
    output: PathBuf,
    /// Render many pictures, one per line of FILE, or of standard input (-) as lines arrive; see below
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "json"])]
    cameras: Option<PathBuf>,
    /// Add depths to an .exr picture: channels Z (first visible sample) and mean.Z (weighted by opacity); of labels also their id, 0 for none
    #[arg(long)]
    pub depth: bool,
    /// Exit with 1 if a picture shows nothing
    #[arg(long)]
    pub fail_empty: bool,
    /// Write only the colour bar, as it is beside a picture of this size, and render nothing; also to .svg and .pdf
    #[arg(
        long,
        group = "colour_bar",
        conflicts_with_all = ["axes", "bounding_box", "cameras", "depth", "fail_empty", "json", "legend", "length_units"]
    )]
    legend_only: bool,
    /// Print the report as one line of JSON
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
    #[serde(flatten)]
    up: UpReport,
    first_ms: f64,
    lattice: Option<LatticeReport>,
    /// Present if a single process renders the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    active_samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stream: Option<Stream>,
    #[cfg(feature = "mpi")]
    #[serde(skip_serializing_if = "Option::is_none")]
    processes: Option<crate::distributed::DistributedReport>,
}

/// Stream plan, with measured times and memory.
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
            let problem = "standard input cannot hold both the cameras and the volume: use a file for one of them".into();
            return Err(Error::Settings { field: "cameras", problem });
        }
        return many::run(arguments, source, processes);
    }
    // Checks file names and sizes before any work.
    let options = &arguments.scene.camera;
    let output = Output::new(&arguments.output, Some("png"))?;
    output.check_report(arguments.json)?;
    arguments.check_output(output.path()).map_err(|e| output.with_given_name(e))?;
    arguments.pictures.rendered(options.size)?;
    processes.make_teams(&arguments.scene.teams, &arguments.scene.volume, options.size, 1)?;
    if !processes.owns(0) {
        return Ok(ExitCode::SUCCESS);
    }
    let mut scene = OpenedScene::open_for_views(&arguments.scene, processes)?;
    if arguments.legend_only {
        return arguments.write_colour_bar(&scene, &output);
    }
    let cameras = arguments.pictures.cameras(options, &scene);
    let camera = cameras.still(cameras.angles().or_all_of(OBLIQUE));
    let inner = arguments.pictures.inner(options.size, &scene);
    scene.read_seen(&arguments.scene, &[camera], inner)?;
    arguments.require_shared(&scene, camera, inner, &scene.settings)?;
    let families = arguments.families(&scene, camera, inner, &scene.settings)?;
    processes.in_turn(|| check::require(&scene.device, &families, &arguments.scene.device))?;
    let started = Instant::now();
    let mut pictures = Pictures::new(&scene, &arguments.pictures, options.background)?;
    pictures.set_format(ImageFormat::from_path(output.path())?);
    let plan = pictures.announce(&camera, options.size)?;
    pictures.measure(arguments.json);
    let (frame, report) = pictures.picture(&camera, options.size)?;
    let Some(frame) = frame else { return Ok(ExitCode::SUCCESS) };
    let depths = if arguments.depth { Some(pictures.depths(&camera, options.size)?) } else { None };
    let first_ms = if pictures.is_streamed() { scene.opened_at } else { started }.elapsed().as_secs_f64() * 1e3;
    if plan.is_some() {
        let (all, picture, first) = (first_ms / 1e3, started.elapsed().as_secs_f64(), scene.first_pass.as_secs_f64());
        eprintln!("memory: {all:.2} s in total: {first:.2} s for the first pass over the volume, {picture:.2} s for the picture");
    }
    arguments.save(&frame, depths.as_ref(), output.path())?;
    if output.is_standard() {
        let written = output.finish(output.path())?;
        return Ok(if written == ExitCode::SUCCESS { arguments.exit_code(&pictures) } else { written });
    }
    let rendered = Rendered {
        output: arguments.output.display().to_string(),
        volume: scene.volume.name(),
        device: &scene.device.info().name,
        width: options.size.width,
        height: options.size.height,
        up: UpReport::new(cameras.orientation()),
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
        processes: report.processes,
    };
    super::report(arguments.json, &rendered, || rendered.output.clone())?;
    Ok(arguments.exit_code(&pictures))
}

impl Arguments {
    /// The exit code after pictures are written.
    pub fn exit_code(&self, pictures: &Pictures) -> ExitCode {
        ExitCode::from(u8::from(self.fail_empty && pictures.has_empty_picture()))
    }

    /// Checks that a picture with this name and the given options can be written.
    pub fn check_output(&self, path: &Path) -> Result<(), Error> {
        if let Some(format) = self.vector_format(path) {
            format.check(&self.pictures.encoding.encoding())?;
            return check_writable(path);
        }
        let format = if self.depth { ImageFormat::with_depths(path) } else { ImageFormat::from_path(path) };
        let format = format.map_err(|e| self.with_vector_formats(e))?;
        format.accept(self.scene.camera.background)?;
        self.pictures.encoding.encoding().check(format)?;
        check_writable(path)
    }

    /// The format of a colour bar that is written as vector graphics.
    fn vector_format(&self, path: &Path) -> Option<VectorFormat> {
        VectorFormat::from_path(path).filter(|_| self.legend_only)
    }

    /// Adds the formats of colour bars to the error of an unknown format.
    fn with_vector_formats(&self, error: Error) -> Error {
        match error {
            Error::UnknownName { what, name, known } if self.legend_only => {
                Error::UnknownName { what, name, known: format!("{known}; for a colour bar also .svg or .pdf") }
            }
            error => error,
        }
    }

    /// Writes the colour bar alone.
    fn write_colour_bar(&self, scene: &OpenedScene, output: &Output) -> Result<ExitCode, Error> {
        let CameraOptions { size, background, .. } = self.scene.camera;
        match self.vector_format(output.path()) {
            Some(format) => {
                let bar = self.pictures.colour_bar_document(size, scene, background, format)?;
                write_whole(output.path(), |out| out.write_all(&bar))?;
            }
            None => self.save(&self.pictures.colour_bar(size, scene, background)?, None, output.path())?,
        }
        if output.is_standard() {
            return output.finish(output.path());
        }
        println!("{}", self.output.display());
        Ok(ExitCode::SUCCESS)
    }

    /// Writes a picture, with depths if given.
    pub fn save(&self, frame: &Frame, depths: Option<&Depths>, path: &Path) -> Result<(), Error> {
        frame.save_encoded(path, self.scene.camera.background, &self.pictures.encoding.encoding(), depths)
    }

    /// Fails if processes that share the volume cannot render a view, or its depths if requested.
    pub fn require_shared(&self, scene: &OpenedScene, camera: Camera, size: Viewport, settings: &Settings) -> Result<(), Error> {
        scene.require_shared(size, &[camera], settings)?;
        if self.depth { scene.require_shared(size, &[camera], &depth_settings(settings)) } else { Ok(()) }
    }

    /// Kernel families that render a frame of this size, and its depths if requested.
    pub fn families(
        &self,
        scene: &OpenedScene,
        camera: Camera,
        size: Viewport,
        settings: &Settings,
    ) -> Result<BTreeSet<Family>, Error> {
        let (grid, has_surfaces) = (scene.volume.grid(), !scene.surfaces.is_empty());
        let mut families = check::families(&[camera], self.pictures.rendered(size)?, grid, settings, has_surfaces);
        if self.depth {
            families.extend(check::families(&[camera], size, grid, &depth_settings(settings), has_surfaces));
        }
        Ok(families)
    }
}
