//! Collections of steps in time, one file each: ParaView's `.pvd` (feature `vtk`), and patterns such as `step_%d.vti` of files that hold
//! whole volumes.

use super::choice::chosen;
use super::load::Opened;
use super::{OpenOptions, open_one, slices};
use crate::error::Error;
use std::path::{Path, PathBuf};

/// The files of a collection in the order of time; `None` for any other source.
pub(super) fn files(path: &Path, options: &OpenOptions) -> Result<Option<Vec<PathBuf>>, Error> {
    #[cfg(feature = "vtk")]
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pvd")) {
        if options.alone {
            return Err(Error::volume(path, "its steps are in other files, which it names: use a file that has them all"));
        }
        return super::vtk::collected(path).map(Some);
    }
    let Some(files) = slices::matching(path)? else { return Ok(None) };
    let first = open_one(&files[0], &OpenOptions { frame: None, ..options.clone() })?;
    // Files of one slice each are a single volume.
    Ok((first.header.grid.dims()[2] > 1).then_some(files))
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
    (opened.header.contents.frames, opened.header.contents.frame) = (steps.len(), step);
    Ok(opened)
}
