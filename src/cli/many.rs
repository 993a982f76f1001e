//! `layersplat render --cameras`: many pictures of one volume, one line of JSON each.

use super::cameras::Cameras;
use super::json_view::View;
use super::options::LightOptions;
use super::orientation::OBLIQUE;
use super::pictures::Pictures;
use super::processes::Processes;
use super::render::Arguments;
use super::scene::OpenedScene;
use super::{check, parse, progress, surfaces};
use crate::camera::Camera;
use crate::check::Family;
use crate::error::Error;
use crate::image::{Depths, Frame, ImageFormat};
use crate::settings::Settings;
use crate::surface::Surface;
use crate::viewport::Viewport;
use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Cursor, IsTerminal, Read, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

/// Longest line in bytes.
const MAX_LINE_BYTES: u64 = 1 << 16;
/// Assumed number of pictures if standard input provides them.
const ASSUMED_COUNT: u32 = 1000;
/// Rendered pictures queued for writing. More would only take memory.
const QUEUED: usize = 2;

/// A requested picture.
struct Line {
    number: u64,
    view: View,
    output: PathBuf,
    size: Option<Viewport>,
    /// Options of light that the line gives.
    light: LightOptions,
    /// Surfaces that it shows or hides, by name.
    shown: Vec<(String, bool)>,
}

/// A rendered picture.
struct Rendered {
    line: u64,
    output: PathBuf,
    frame: Frame,
    depths: Option<Depths>,
    render_ms: f64,
}

#[derive(Serialize)]
struct Written {
    line: u64,
    output: String,
    width: u32,
    height: u32,
    render_ms: f64,
}

/// Renders the lines of a file, or of standard input as they arrive.
pub(super) fn run(arguments: &Arguments, source: &Path, processes: &Processes) -> Result<ExitCode, Error> {
    let from_pipe = source == Path::new("-");
    let mut count = 0;
    if !from_pipe {
        // Checks every line before the first one is rendered.
        Lines::open(source, processes)?.try_for_each(|line| {
            count += 1;
            line?.check(arguments).map_err(|e| e.into_error(source))
        })?;
    }
    // If standard output is a terminal, the reported lines already show the progress.
    let bar = if from_pipe || stdout().is_terminal() { ProgressBar::hidden() } else { progress::steps(count, "rendering") };
    let size = arguments.scene.camera.size;
    processes.make_teams(
        &arguments.scene.teams,
        &arguments.scene.volume,
        size,
        if from_pipe { ASSUMED_COUNT } else { count } as usize,
    )?;
    let scene = OpenedScene::open(&arguments.scene, processes)?;
    let cameras = arguments.pictures.cameras(&arguments.scene.camera, &scene);
    let pictures = Pictures::new(&scene, &arguments.pictures, arguments.scene.camera.background)?;
    if !from_pipe {
        // Names of surfaces are known now.
        Lines::open(source, processes)?
            .try_for_each(|line| line?.surfaces(&scene).map(drop).map_err(|e| e.into_error(source)))?;
    }
    let lines = Lines::open(source, processes)?;
    let exit_code = std::thread::scope(|threads| {
        let (sender, receiver) = sync_channel(QUEUED);
        let writer = threads.spawn(move || write_all(arguments, &receiver, &bar));
        let rendered = render_all(arguments, &cameras, pictures, lines, &sender);
        drop(sender);
        // A write error takes precedence: it also ends rendering.
        writer.join().expect("the writer does not panic").and(rendered)
    })?;
    Ok(exit_code)
}

/// Renders until the lines end or the writer stops.
fn render_all(
    arguments: &Arguments,
    cameras: &Cameras,
    mut pictures: Pictures,
    lines: Lines,
    writer: &SyncSender<Rendered>,
) -> Result<ExitCode, Error> {
    let options = &arguments.scene.camera;
    let source = lines.source.clone();
    let mut checked = BTreeSet::new();
    let processes = &pictures.scene().processes;
    for (n, line) in lines.enumerate() {
        let line = line?;
        if !processes.owns(n) {
            continue;
        }
        line.check(arguments).map_err(|e| e.into_error(&source))?;
        let size = line.size.unwrap_or(options.size);
        let inner = arguments.pictures.inner(size, pictures.scene());
        let sized = cameras.with_options(super::options::CameraOptions { size: inner, ..options.clone() });
        let camera = line.view.camera(&sized, OBLIQUE).map_err(|problem| line.invalid(problem).into_error(&source))?;
        let settings = pictures.scene().settings_with_light(&arguments.scene, &line.light(arguments))?;
        arguments.require_shared(pictures.scene(), camera, inner, &settings)?;
        require_checked(arguments, &pictures, (camera, &settings), inner, &mut checked)?;
        pictures.set_format(ImageFormat::from_path(&line.output)?);
        pictures.set_surfaces(line.surfaces(pictures.scene()).map_err(|e| e.into_error(&source))?)?;
        let started = Instant::now();
        let (Some(frame), _) = pictures.picture_with(&camera, size, &settings)? else { continue };
        let depths = if arguments.depth { Some(pictures.depths(&camera, size)?) } else { None };
        let render_ms = started.elapsed().as_secs_f64() * 1e3;
        if writer.send(Rendered { line: line.number, output: line.output, frame, depths, render_ms }).is_err() {
            break;
        }
    }
    Ok(arguments.exit_code(&pictures))
}

/// As [`OpenedScene::require_checked`], for families that are not in `checked` yet.
fn require_checked(
    arguments: &Arguments,
    pictures: &Pictures,
    (camera, settings): (Camera, &Settings),
    size: Viewport,
    checked: &mut BTreeSet<Family>,
) -> Result<(), Error> {
    let scene = pictures.scene();
    let families = arguments.families(scene, camera, size, settings)?;
    let new: BTreeSet<Family> = families.difference(checked).copied().collect();
    if !new.is_empty() {
        scene.processes.in_turn(|| check::require(&scene.device, &new, &arguments.scene.device))?;
        checked.extend(new);
    }
    Ok(())
}

/// Writes and reports pictures while the next ones are rendered.
fn write_all(arguments: &Arguments, rendered: &Receiver<Rendered>, bar: &ProgressBar) -> Result<(), Error> {
    for Rendered { line, output, frame, depths, render_ms } in rendered {
        arguments.save(&frame, depths.as_ref(), &output)?;
        let (width, height) = (frame.width(), frame.height());
        let written = Written { line, output: output.display().to_string(), width, height, render_ms };
        super::report(true, &written, String::new)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// An invalid line.
struct InvalidLine {
    line: u64,
    problem: String,
}

impl InvalidLine {
    fn into_error(self, source: &Path) -> Error {
        let InvalidLine { line, problem } = self;
        let path = if source == Path::new("-") { "standard input".into() } else { source.into() };
        Error::Cameras { path, line, problem }
    }
}

impl Line {
    fn parse(number: u64, text: &str) -> Result<Self, InvalidLine> {
        let invalid = |problem| InvalidLine { line: number, problem };
        let mut fields: Map<String, Value> =
            serde_json::from_str(text).map_err(|e| invalid(format!("it is not a JSON object: {e}")))?;
        let output = match fields.remove("output") {
            Some(Value::String(output)) => PathBuf::from(output),
            _ => return Err(invalid(r#"it names no picture: add "output": "NAME.png""#.into())),
        };
        let size = fields.remove("size").map(|size| parse_size(&size)).transpose().map_err(invalid)?;
        let light = LightOptions::from_fields(&mut fields).map_err(invalid)?;
        let mut shown = Vec::new();
        for (key, is_shown) in [("show", true), ("hide", false)] {
            let names = fields.remove(key).map(|names| parse_names(key, names)).transpose().map_err(invalid)?;
            shown.extend(names.into_iter().flatten().map(|name| (name, is_shown)));
        }
        let view = View::from_fields(fields).map_err(invalid)?;
        Ok(Self { number, view, output, size, light, shown })
    }

    /// The surfaces of a scene as the line shows them.
    fn surfaces(&self, scene: &OpenedScene) -> Result<Vec<Surface>, InvalidLine> {
        surfaces::shown(&scene.surfaces, &self.shown).map_err(|problem| self.invalid(problem))
    }

    fn invalid(&self, problem: String) -> InvalidLine {
        InvalidLine { line: self.number, problem }
    }

    /// The line's options of light, completed by those of the command.
    fn light(&self, arguments: &Arguments) -> LightOptions {
        self.light.clone().or(&arguments.scene.quality.light)
    }

    /// Checks file name, size and light, which would otherwise fail only when the line is rendered.
    fn check(&self, arguments: &Arguments) -> Result<(), InvalidLine> {
        let size = arguments.pictures.rendered(self.size.unwrap_or(arguments.scene.camera.size));
        let light = arguments.scene.quality.settings_with_light(&self.light(arguments), None);
        arguments.check_output(&self.output).and(size).and(light).map(|_| ()).map_err(|e| self.invalid(e.to_string()))
    }
}

/// Parses a size: `"WxH"` or `[W, H]`.
fn parse_size(value: &Value) -> Result<Viewport, String> {
    match value {
        Value::String(text) => parse::viewport(text),
        Value::Array(sides) => match sides.iter().map(Value::as_u64).collect::<Option<Vec<_>>>().as_deref() {
            Some(&[width, height]) => parse::viewport(&format!("{width}x{height}")),
            _ => Err("size must be [W, H] in pixels".into()),
        },
        _ => Err(r#"size must be "WxH" or [W, H] in pixels"#.into()),
    }
}

/// Parses names: a text, or a list of texts.
fn parse_names(key: &str, value: Value) -> Result<Vec<String>, String> {
    let names = match value {
        Value::Array(names) => names,
        name => vec![name],
    };
    let name = |name: Value| match name {
        Value::String(name) => Ok(name),
        _ => Err(format!(r#"{key} must be a list of names of surfaces, such as ["implant"]"#)),
    };
    names.into_iter().map(name).collect()
}

/// Iterator over lines of JSON; skips blank lines.
struct Lines {
    source: PathBuf,
    reader: Box<dyn BufRead>,
    number: u64,
}

impl Lines {
    /// Opens the source. With several processes, the leader reads all of it and broadcasts it.
    fn open(source: &Path, processes: &Processes) -> Result<Self, Error> {
        if processes.counts().is_some() {
            let read = || -> Result<Vec<u8>, Error> {
                let mut lines = Self::open_local(source)?;
                let mut text = Vec::new();
                lines.reader.read_to_end(&mut text).map_err(|e| Error::read(source, e))?;
                Ok(text)
            };
            return Ok(Self { source: source.into(), reader: Box::new(Cursor::new(processes.broadcast(read)?)), number: 0 });
        }
        Self::open_local(source)
    }

    fn open_local(source: &Path) -> Result<Self, Error> {
        let reader: Box<dyn BufRead> = if source == Path::new("-") {
            Box::new(BufReader::new(std::io::stdin()))
        } else {
            Box::new(BufReader::new(std::fs::File::open(source).map_err(|e| Error::read(source, e))?))
        };
        Ok(Self { source: source.into(), reader, number: 0 })
    }

    /// Text of the next line, or `None` at the end.
    fn next_text(&mut self) -> Result<Option<String>, Error> {
        let mut text = Vec::new();
        let read = (&mut self.reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut text);
        if read.map_err(|e| Error::read(&self.source, e))? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let invalid = |problem: String| InvalidLine { line: self.number, problem }.into_error(&self.source);
        if text.len() as u64 == MAX_LINE_BYTES && text.last() != Some(&b'\n') {
            return Err(invalid(format!("it is longer than {MAX_LINE_BYTES} bytes")));
        }
        String::from_utf8(text).map(Some).map_err(|_| invalid("it is not UTF-8".into()))
    }
}

impl Iterator for Lines {
    type Item = Result<Line, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let text = match self.next_text() {
                Ok(text) => text?,
                Err(e) => return Some(Err(e)),
            };
            if !text.trim().is_empty() {
                return Some(Line::parse(self.number, &text).map_err(|invalid| invalid.into_error(&self.source)));
            }
        }
    }
}
