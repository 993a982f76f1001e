//! Collections of steps in time, one file each: ParaView's `.pvd` (feature `vtk`) and `.series`, and patterns such as `step_%d.vti` of files that hold
//! whole volumes.

use super::choice::chosen;
use super::load::Opened;
use super::{OpenOptions, open_one, slices};
use crate::error::Error;
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
    if !is_pvd && !ends("series") {
        return Ok(None);
    }
    if options.alone {
        return Err(Error::volume(path, "its steps are in other files, which it names: use a file that has them all"));
    }
    #[cfg(feature = "vtk")]
    if is_pvd {
        return super::vtk::collected(path).map(Some);
    }
    series(path).map(Some)
}

/// Longest list of files in bytes.
const LONGEST: u64 = 16 << 20;

/// A file of a series of ParaView.
#[derive(Deserialize)]
struct Step {
    name: PathBuf,
    time: f64,
}

/// The files that ParaView's `.series` lists in JSON, in the order of time. Names are relative to its folder.
fn series(path: &Path) -> Result<Vec<(f64, PathBuf)>, Error> {
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
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(steps.into_iter().map(|step| (step.time, folder.join(step.name))).collect())
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
