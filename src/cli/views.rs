//! `layersplat views`: a contact sheet of eight views.

use super::orientation::UpReport;
use super::pictures::{PictureOptions, Pictures};
use super::processes::Processes;
use super::progress;
use super::scene::{OpenedScene, SceneOptions};
use super::standard::Output;
use crate::annotation::labelled;
use crate::camera::{Camera, Orbit};
use crate::error::Error;
use crate::framing::{Orientation, Side};
use crate::image::{Background, Frame, ImageFormat};
use crate::memory;
use crate::viewport::Viewport;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Columns of the sheet.
const COLUMNS: usize = 4;
/// Number of views.
const VIEWS: usize = 8;
/// Elevation of the views of corners, in degrees.
const CORNER: f64 = 35.26;

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
    #[serde(flatten)]
    up: UpReport,
    views: [&'a str; VIEWS],
}

/// A view of the sheet.
struct View {
    label: String,
    orbit: Orbit,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    if options.from.is_some() {
        return Err(Error::Settings { field: "from", problem: "a contact sheet shows all sides: omit it".into() });
    }
    let output = Output::new(&arguments.output, Some("png"))?;
    output.check_report(arguments.json)?;
    let (format, encoding) = (ImageFormat::from_path(output.path()), arguments.pictures.encoding.encoding());
    let format = format.map_err(|e| output.with_given_name(e))?;
    format.accept(options.background)?;
    encoding.check(format)?;
    let sheet = sheet_size(options.size)?;
    memory::require("the contact sheet", sheet.pixels() as u64 * size_of::<[f32; 4]>() as u64)?;
    arguments.pictures.rendered(options.size)?;
    let scene = OpenedScene::open(&arguments.scene, &Processes::alone())?;
    let fitting = arguments.pictures.cameras(options, &scene);
    let views = views(fitting.orientation(), fitting.angles().or_all_of(Orbit::default()));
    // A sequence has one scale, so views can be compared.
    let cameras = fitting.sequence(views.iter().map(|view| view.orbit));
    let inner = arguments.pictures.rendered(arguments.pictures.inner(options.size, &scene))?;
    scene.require_checked(&arguments.scene, inner, &cameras)?;
    let mut pictures = Pictures::new(&scene, &arguments.pictures, options.background)?;
    pictures.set_format(ImageFormat::from_path(output.path())?);
    pictures.announce(&cameras[0], options.size)?;
    let pixels = render_views(arguments, &mut pictures, views.iter().zip(&cameras), sheet)?;
    let picture = Frame::new(sheet, pixels).with_curve(pictures.curve());
    picture.save_encoded(output.path(), options.background, &encoding, None)?;
    if output.is_standard() {
        return output.finish(output.path());
    }
    let sheet = Sheet {
        output: arguments.output.display().to_string(),
        volume: scene.volume.name(),
        device: &scene.device.info().name,
        width: sheet.width,
        height: sheet.height,
        up: UpReport::new(fitting.orientation()),
        views: views.each_ref().map(|view| view.label.as_str()),
    };
    super::report(arguments.json, &sheet, || sheet.output.clone())?;
    Ok(ExitCode::SUCCESS)
}

/// The six sides and two opposite corners, row by row, turned by `start`.
fn views(orientation: &Orientation, start: Orbit) -> [View; VIEWS] {
    let side = |name, side| (name, orientation.side(side));
    let corner = |azimuth| ("oblique", Orbit { azimuth, elevation: CORNER, roll: 0.0 });
    let views = [
        side("front", Side::Front),
        side("right", Side::Right),
        side("back", Side::Back),
        side("left", Side::Left),
        side("top", Side::Above),
        side("bottom", Side::Below),
        corner(45.0),
        corner(225.0),
    ];
    views.map(|(name, Orbit { azimuth, elevation, .. })| {
        let orbit = Orbit { azimuth: start.azimuth + azimuth, elevation: start.elevation + elevation, ..start };
        View { label: format!("{name}, from {}", orientation.seen_from(orbit)), orbit }
    })
}

/// Renders the views into the pixels of the sheet.
fn render_views<'a>(
    arguments: &Arguments,
    pictures: &mut Pictures,
    views: impl Iterator<Item = (&'a View, &'a Camera)>,
    sheet: Viewport,
) -> Result<Vec<[f32; 4]>, Error> {
    let options = &arguments.scene.camera;
    let background = options.background.unwrap_or(Background::BLACK);
    let (width, height, row_length) = (options.size.width as usize, options.size.height as usize, sheet.width as usize);
    let mut pixels = memory::zeroed("the contact sheet", sheet.pixels())?;
    let bar = progress::steps(VIEWS as u32, "rendering");
    for (n, (view, camera)) in views.enumerate() {
        // One legend for all views.
        pictures.set_legend(arguments.pictures.legend && n + 1 == COLUMNS);
        let (frame, _) = pictures.picture(camera, options.size)?;
        // Always present: this command runs in a single process.
        let Some(frame) = frame else { continue };
        let frame = labelled(frame, &view.label, background)?;
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
    let (columns, rows) = (COLUMNS as u32, (VIEWS / COLUMNS) as u32);
    Viewport::new(view.width.saturating_mul(columns), view.height.saturating_mul(rows)).map_err(|_| {
        let expected = "at most 4096x8192 for each view of a contact sheet";
        Error::OutOfRange { name: "viewport", value: format!("{}x{}", view.width, view.height), expected }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    #[test]
    fn labels_say_what_is_known() {
        let grid = Grid::new([4; 3], DVec3::ONE).unwrap();
        let labels = |grid: &Grid, start| views(&Orientation::of(grid), start).map(|view| view.label);
        let plain = [
            "front, from +z",
            "right, from +x",
            "back, from -z",
            "left, from -x",
            "top, from +y",
            "bottom, from -y",
            "oblique, from +x+y+z",
            "oblique, from -x+y-z",
        ];
        assert_eq!(labels(&grid, Orbit::default()), plain);
        let of_patient = [
            "front, from A",
            "right, from R",
            "back, from P",
            "left, from L",
            "top, from S",
            "bottom, from I",
            "oblique, from LAS",
            "oblique, from RPS",
        ];
        assert_eq!(labels(&grid.clone().with_anatomy(), Orbit::default()), of_patient);
        let turned = Orbit { azimuth: 10.0, ..Orbit::default() };
        assert_eq!(labels(&grid, turned)[0], "front, from +x+z");
    }
}
