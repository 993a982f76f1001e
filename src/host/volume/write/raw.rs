//! Names of raw files, as in the Open SciVis Datasets.

use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::{OpenOptions, told_by_name};
use std::path::{Path, PathBuf};

/// Adds dimensions and type to the file name, unless it has them.
pub(super) fn named(path: &Path, dims: [usize; 3], scalar: ScalarType) -> Result<PathBuf, Error> {
    let [x, y, z] = dims;
    let required = OpenOptions { dims: Some(dims), voxel_type: Some(scalar), ..OpenOptions::default() };
    match told_by_name(path) {
        options if options == required => Ok(path.to_owned()),
        OpenOptions { dims: None, .. } => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            Ok(path.with_file_name(format!("{stem}_{x}x{y}x{z}_{scalar}.raw")))
        }
        _ => Err(Error::volume(path, format!("its name contradicts {x}x{y}x{z} voxels of {scalar}: omit dimensions and type"))),
    }
}
