//! `layersplat render --cameras`: many pictures of one volume, a line of JSON each.

use super::processes::Processes;
use super::render::{Arguments, save};
use super::scene::{Cameras, Scene};
use super::studio::Studio;
use super::view::View;
use super::{check, parse, progress};
use crate::camera::Camera;
use crate::check::Family;
use crate::error::Error;
use crate::image::{Depths, Frame};
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

/// Bytes of the longest line.
const LONGEST_LINE: u64 = 1 << 16;
/// Pictures that there may be where nobody has counted them.
const MANY: u32 = 1000;
/// Pictures that wait for being written: more would only take memory.
const WAITING: usize = 2;

/// A picture that is asked for.
struct Line {
    number: u64,
    view: View,
    output: PathBuf,
    size: Option<Viewport>,
}

/// A picture that is to be written.
struct Taken {
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

/// Renders the lines of a file, or of standard input as they come.
pub(super) fn run(arguments: &Arguments, source: &Path, processes: &Processes) -> Result<ExitCode, Error> {
    let from_pipe = source == Path::new("-");
    let mut count = 0;
    if !from_pipe {
        // All lines are looked at before any is rendered: what is wrong with the last one is said now.
        Lines::open(source, processes)?.try_for_each(|line| {
            count += 1;
            line?.check(arguments).map_err(|e| e.of(source))
        })?;
    }
    // On a terminal, the lines that are reported show how far it is.
    let bar = if from_pipe || stdout().is_terminal() { ProgressBar::hidden() } else { progress::steps(count, "rendering") };
    let size = arguments.scene.camera.size;
    processes.make_teams(&arguments.scene.teams, &arguments.scene.volume, size, if from_pipe { MANY } else { count } as usize)?;
    let scene = Scene::open(&arguments.scene, processes)?;
    let cameras = arguments.pictures.cameras(&arguments.scene.camera, &scene);
    let studio = Studio::new(&scene, &arguments.pictures, arguments.scene.camera.background)?;
    let lines = Lines::open(source, processes)?;
    std::thread::scope(|threads| {
        let (sender, receiver) = sync_channel(WAITING);
        let writer = threads.spawn(move || write_all(arguments, &receiver, &bar));
        let rendered = render_all(arguments, &cameras, studio, lines, &sender);
        drop(sender);
        // What could not be written is the reason why rendering ended, if it did.
        writer.join().expect("it does not panic").and(rendered)
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Renders until the lines end, or whoever writes them does.
fn render_all(
    arguments: &Arguments,
    cameras: &Cameras,
    mut studio: Studio,
    lines: Lines,
    written: &SyncSender<Taken>,
) -> Result<(), Error> {
    let options = &arguments.scene.camera;
    let source = lines.source.clone();
    let mut checked = BTreeSet::new();
    let processes = &studio.scene().processes;
    for (n, line) in lines.enumerate() {
        let line = line?;
        if !processes.owns(n) {
            continue;
        }
        line.check(arguments).map_err(|e| e.of(&source))?;
        let size = line.size.unwrap_or(options.size);
        let sized = cameras.with(super::options::CameraOptions { size, ..options.clone() });
        let camera = line.view.camera(&sized, options.orbit(0.0)).map_err(|problem| line.wrong(problem).of(&source))?;
        studio.scene().require_shared(size, &[camera])?;
        require_checked(arguments, &studio, camera, size, &mut checked)?;
        let started = Instant::now();
        let (Some(frame), _) = studio.picture(&camera, size)? else { continue };
        let depths = if arguments.depth { Some(studio.depths(&camera, size)?) } else { None };
        let render_ms = started.elapsed().as_secs_f64() * 1e3;
        if written.send(Taken { line: line.number, output: line.output, frame, depths, render_ms }).is_err() {
            break;
        }
    }
    Ok(())
}

/// As [`Scene::require_checked`], for what was not asked before.
fn require_checked(
    arguments: &Arguments,
    studio: &Studio,
    camera: Camera,
    size: Viewport,
    checked: &mut BTreeSet<Family>,
) -> Result<(), Error> {
    let scene = studio.scene();
    let families = arguments.families(scene, camera, size)?;
    let new: BTreeSet<Family> = families.difference(checked).copied().collect();
    if !new.is_empty() {
        scene.processes.in_turn(|| check::require(&scene.device, &new, &arguments.scene.device))?;
        checked.extend(new);
    }
    Ok(())
}

/// Writes pictures while the next ones are rendered, and reports each.
fn write_all(arguments: &Arguments, taken: &Receiver<Taken>, bar: &ProgressBar) -> Result<(), Error> {
    for Taken { line, output, frame, depths, render_ms } in taken {
        save(&frame, depths.as_ref(), &output, arguments.scene.camera.background)?;
        let (width, height) = (frame.width(), frame.height());
        let written = Written { line, output: output.display().to_string(), width, height, render_ms };
        super::report(true, &written, String::new)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// What is wrong with a line.
struct Wrong {
    line: u64,
    problem: String,
}

impl Wrong {
    fn of(self, source: &Path) -> Error {
        let Wrong { line, problem } = self;
        let path = if source == Path::new("-") { "standard input".into() } else { source.into() };
        Error::Cameras { path, line, problem }
    }
}

impl Line {
    fn parse(number: u64, text: &str) -> Result<Self, Wrong> {
        let wrong = |problem| Wrong { line: number, problem };
        let mut fields: Map<String, Value> =
            serde_json::from_str(text).map_err(|e| wrong(format!("it is no JSON object: {e}")))?;
        let output = match fields.remove("output") {
            Some(Value::String(output)) => PathBuf::from(output),
            _ => return Err(wrong(r#"it names no picture: give "output": "NAME.png""#.into())),
        };
        let size = fields.remove("size").map(|size| sized(&size)).transpose().map_err(wrong)?;
        let view = View::of(fields).map_err(wrong)?;
        Ok(Self { number, view, output, size })
    }

    fn wrong(&self, problem: String) -> Wrong {
        Wrong { line: self.number, problem }
    }

    /// Refuses what would only fail once the picture is there.
    fn check(&self, arguments: &Arguments) -> Result<(), Wrong> {
        let size = arguments.pictures.rendered(self.size.unwrap_or(arguments.scene.camera.size));
        arguments.check_output(&self.output).and(size).map(|_| ()).map_err(|e| self.wrong(e.to_string()))
    }
}

/// `"WxH"` or `[W, H]`.
fn sized(value: &Value) -> Result<Viewport, String> {
    match value {
        Value::String(text) => parse::viewport(text),
        Value::Array(sides) => match sides.iter().map(Value::as_u64).collect::<Option<Vec<_>>>().as_deref() {
            Some(&[width, height]) => parse::viewport(&format!("{width}x{height}")),
            _ => Err("size is [W, H], in pixels".into()),
        },
        _ => Err(r#"size is "WxH" or [W, H], in pixels"#.into()),
    }
}

/// Lines of JSON, empty ones left out.
struct Lines {
    source: PathBuf,
    reader: Box<dyn BufRead>,
    number: u64,
}

impl Lines {
    /// The leader alone reads, where there are several processes.
    fn open(source: &Path, processes: &Processes) -> Result<Self, Error> {
        if processes.counts().is_some() {
            let read = || -> Result<Vec<u8>, Error> {
                let mut lines = Self::of(source)?;
                let mut text = Vec::new();
                lines.reader.read_to_end(&mut text).map_err(|e| Error::read(source, e))?;
                Ok(text)
            };
            return Ok(Self { source: source.into(), reader: Box::new(Cursor::new(processes.told(read)?)), number: 0 });
        }
        Self::of(source)
    }

    fn of(source: &Path) -> Result<Self, Error> {
        let reader: Box<dyn BufRead> = if source == Path::new("-") {
            Box::new(BufReader::new(std::io::stdin()))
        } else {
            Box::new(BufReader::new(std::fs::File::open(source).map_err(|e| Error::read(source, e))?))
        };
        Ok(Self { source: source.into(), reader, number: 0 })
    }

    /// The next line's text; `None` at the end.
    fn text(&mut self) -> Result<Option<String>, Error> {
        let mut text = Vec::new();
        let read = (&mut self.reader).take(LONGEST_LINE).read_until(b'\n', &mut text);
        if read.map_err(|e| Error::read(&self.source, e))? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let wrong = |problem: String| Wrong { line: self.number, problem }.of(&self.source);
        if text.len() as u64 == LONGEST_LINE && text.last() != Some(&b'\n') {
            return Err(wrong(format!("it is longer than {LONGEST_LINE} bytes")));
        }
        String::from_utf8(text).map(Some).map_err(|_| wrong("it is no UTF-8".into()))
    }
}

impl Iterator for Lines {
    type Item = Result<Line, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let text = match self.text() {
                Ok(text) => text?,
                Err(e) => return Some(Err(e)),
            };
            if !text.trim().is_empty() {
                return Some(Line::parse(self.number, &text).map_err(|wrong| wrong.of(&self.source)));
            }
        }
    }
}
