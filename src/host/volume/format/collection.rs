//! Collections of steps in time, one file each: ParaView's `.pvd` (feature `vtk`) and `.series`, and patterns such as `step_%d.vti` of files that hold
//! whole volumes.

use super::choice::chosen;
use super::load::Opened;
use super::{OpenOptions, numbered, open_one, slices};
use crate::error::Error;
use crate::url;
use serde::Deserialize;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The files of a collection in the order of time; `None` for any other source.
pub(super) fn files(path: &Path, options: &OpenOptions) -> Result<Option<Vec<PathBuf>>, Error> {
    if let Some(steps) = listed(path, options)? {
        return Ok(Some(steps.into_iter().map(|(_, file)| file).collect()));
    }
    let Some(files) = slices::matching(path)? else { return Ok(None) };
    let first = open_one(&files[0], &OpenOptions { frame: None, ..options.clone() })?;
    // Files of one slice each are a single volume.
    Ok((first.header.grid.dims()[2] > 1).then_some(files))
}

/// Times and files of a collection that names them, in the order of time.
fn listed(path: &Path, options: &OpenOptions) -> Result<Option<Vec<(f64, PathBuf)>>, Error> {
    let ends = |ending: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    let is_pvd = cfg!(feature = "vtk") && ends("pvd");
    if url::is_url(path) || !is_pvd && !ends("series") {
        return Ok(None);
    }
    #[cfg(feature = "vtk")]
    let steps = if is_pvd { super::vtk::collected(path)? } else { series(path)? };
    #[cfg(not(feature = "vtk"))]
    let steps = series(path)?;
    let placed = |(time, name): (f64, String)| Ok((time, numbered::beside(path, &name, options)?));
    steps.into_iter().map(placed).collect::<Result<_, _>>().map(Some)
}

/// Longest list of files in bytes.
const LONGEST: u64 = 16 << 20;

/// A file of a series of ParaView.
#[derive(Deserialize)]
struct Step {
    name: String,
    time: f64,
}

/// Times and names of the files that ParaView's `.series` lists in JSON, in the order of time.
fn series(path: &Path) -> Result<Vec<(f64, String)>, Error> {
    #[derive(Deserialize)]
    struct Series {
        files: Vec<Step>,
    }
    let mut text = Vec::new();
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    file.take(LONGEST).read_to_end(&mut text).map_err(|e| Error::read(path, e))?;
    let listed: Result<Series, _> = serde_json::from_slice(&text);
    let mut steps = listed.map_err(|e| Error::volume(path, format!("it lists no files with a name and a time: {e}")))?.files;
    if steps.is_empty() {
        return Err(Error::volume(path, "it lists no files"));
    }
    steps.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(steps.into_iter().map(|step| (step.time, step.name)).collect())
}

/// Opens a step by the option `frame`, which counts the frames of all files.
pub(super) fn open(path: &Path, files: &[PathBuf], options: &OpenOptions) -> Result<Opened, Error> {
    let mut steps: Vec<(&Path, usize)> = Vec::new();
    for file in files {
        let header = open_one(file, &OpenOptions { frame: Some(0), ..options.clone() })?.header;
        steps.extend((0..header.contents.frames).map(|frame| (file.as_path(), frame)));
    }
    let step = chosen(path, "frame", options.frame, steps.len())?;
    let (file, frame) = steps[step];
    let mut opened = open_one(file, &OpenOptions { frame: Some(frame), ..options.clone() })?;
    let contents = &mut opened.header.contents;
    (contents.frames, contents.frame) = (steps.len(), step);
    if let Some(listed) = listed(path, options)?.filter(|listed| listed.len() == steps.len()) {
        contents.set_times(listed.into_iter().map(|(time, _)| time).collect());
    }
    Ok(opened)
}
