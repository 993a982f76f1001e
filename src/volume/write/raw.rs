//! Names of raw files, as in the Open SciVis Datasets.

use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::{OpenOptions, told_by_name};
use std::path::{Path, PathBuf};

/// The file with dimensions and type in its name, unless they are there.
pub(super) fn named(path: &Path, dims: [usize; 3], scalar: ScalarType) -> Result<PathBuf, Error> {
    let [x, y, z] = dims;
    let told = OpenOptions { dims: Some(dims), voxel_type: Some(scalar), ..OpenOptions::default() };
    match told_by_name(path) {
        options if options == told => Ok(path.to_owned()),
        OpenOptions { dims: None, .. } => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            Ok(path.with_file_name(format!("{stem}_{x}x{y}x{z}_{scalar}.raw")))
        }
        _ => {
            Err(Error::volume(path, format!("its name tells something else than {x}x{y}x{z} voxels of {scalar}: leave that out")))
        }
    }
}
