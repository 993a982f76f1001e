//! `layersplat views`: a contact sheet of eight views.

use super::processes::Processes;
use super::progress;
use super::scene::{Scene, SceneOptions};
use super::standard::Output;
use super::studio::{PictureOptions, Studio};
use crate::annotation::labelled;
use crate::camera::{Camera, Orbit};
use crate::error::Error;
use crate::image::{Background, Frame, ImageFormat};
use crate::memory;
use crate::viewport::Viewport;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Columns of the sheet.
const COLUMNS: usize = 4;
/// Names, azimuths and elevations in degrees, row by row.
const VIEWS: [(&str, f64, f64); 8] = [
    ("front, from +z", 0.0, 0.0),
    ("right, from +x", 90.0, 0.0),
    ("back, from -z", 180.0, 0.0),
    ("left, from -x", 270.0, 0.0),
    ("top, from +y", 0.0, 90.0),
    ("bottom, from -y", 0.0, -90.0),
    ("oblique, from +x+y+z", 45.0, 35.26),
    ("oblique, from -x+y-z", 225.0, 35.26),
];

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    pictures: PictureOptions,
    /// Output picture: .png, .jpg, .tif, .webp, .exr or .npy; - for PNG on standard output. --size applies to each of the eight views
    #[arg(short, long, default_value = "views.png", value_name = "FILE")]
    output: PathBuf,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Sheet<'a> {
    output: String,
    volume: &'a str,
    device: &'a str,
    width: u32,
    height: u32,
    views: [&'static str; VIEWS.len()],
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    let output = Output::new(&arguments.output, Some("png"))?;
    output.check_report(arguments.json)?;
    let (format, encoding) = (ImageFormat::from_path(output.path()), arguments.pictures.encoding.encoding());
    let format = format.map_err(|e| output.with_given_name(e))?;
    format.accept(options.background)?;
    encoding.check(format)?;
    let sheet = sheet_size(options.size)?;
    memory::require("the contact sheet", sheet.pixels() as u64 * size_of::<[f32; 4]>() as u64)?;
    arguments.pictures.rendered(options.size)?;
    let scene = Scene::open(&arguments.scene, &Processes::alone())?;
    // A sequence has one scale, so views can be compared.
    let start = options.orbit(0.0);
    let orbit = |&(_, azimuth, elevation): &(&str, f64, f64)| Orbit {
        azimuth: start.azimuth + azimuth,
        elevation: start.elevation + elevation,
        ..start
    };
    let cameras = arguments.pictures.cameras(options, &scene).sequence(VIEWS.iter().map(orbit));
    let inner = arguments.pictures.rendered(arguments.pictures.inner(options.size, &scene))?;
    scene.require_checked(&arguments.scene, inner, &cameras)?;
    let mut studio = Studio::new(&scene, &arguments.pictures, options.background)?;
    studio.announce(&cameras[0], options.size)?;
    let pixels = render_views(arguments, &mut studio, &cameras, sheet)?;
    Frame::new(sheet, pixels).save_encoded(output.path(), options.background, &encoding, None)?;
    if output.is_standard() {
        return output.finish(output.path());
    }
    let sheet = Sheet {
        output: arguments.output.display().to_string(),
        volume: scene.volume.name(),
        device: &scene.device.info().name,
        width: sheet.width,
        height: sheet.height,
        views: VIEWS.map(|(name, ..)| name),
    };
    super::report(arguments.json, &sheet, || sheet.output.clone())?;
    Ok(ExitCode::SUCCESS)
}

/// Renders the views into the pixels of the sheet.
fn render_views(arguments: &Arguments, studio: &mut Studio, cameras: &[Camera], sheet: Viewport) -> Result<Vec<[f32; 4]>, Error> {
    let options = &arguments.scene.camera;
    let background = options.background.unwrap_or(Background::BLACK);
    let (width, height, row_length) = (options.size.width as usize, options.size.height as usize, sheet.width as usize);
    let mut pixels = memory::zeroed("the contact sheet", sheet.pixels())?;
    let bar = progress::steps(VIEWS.len() as u32, "rendering");
    for (n, (camera, (name, ..))) in cameras.iter().zip(VIEWS).enumerate() {
        // One legend for all views.
        studio.set_legend(arguments.pictures.legend && n + 1 == COLUMNS);
        let (frame, _) = studio.picture(camera, options.size)?;
        // Always present: this command runs in a single process.
        let Some(frame) = frame else { continue };
        let frame = labelled(frame, name, background)?;
        let first = n / COLUMNS * height * row_length + n % COLUMNS * width;
        for (row, source) in frame.pixels().chunks_exact(width).enumerate() {
            pixels[first + row * row_length..][..width].copy_from_slice(source);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(pixels)
}

/// Size of the sheet for views of this size.
fn sheet_size(view: Viewport) -> Result<Viewport, Error> {
    let (columns, rows) = (COLUMNS as u32, (VIEWS.len() / COLUMNS) as u32);
    Viewport::new(view.width.saturating_mul(columns), view.height.saturating_mul(rows)).map_err(|_| {
        let expected = "at most 4096x8192 for each view of a contact sheet";
        Error::OutOfRange { name: "viewport", value: format!("{}x{}", view.width, view.height), expected }
    })
}
