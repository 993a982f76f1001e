//! Opening files and built-in volumes.

use super::{Contents, Grid, OpenOptions, ScalarType, Volume, builtin_volume, format};
#[cfg(feature = "mpi")]
use super::{Layers, Unseen, builtin};
use crate::error::Error;
use std::path::Path;
use std::sync::Arc;

impl Volume<'static> {
    /// Opens `builtin:NAME[@SIZE]`, a file, OME-Zarr or Zarr on a web server (`https://`, `http://`, `s3://` of a public bucket; feature `http`), or one file per slice: a folder of numbered `.png` or `.tif` files, or a name with `%d` in
    /// place of the number. Where the numbered files hold volumes, or where a `.pvd` names them, [`OpenOptions::frame`] counts the frames of
    /// all files, as in a [`Sequence`](super::Sequence).
    ///
    /// Formats recognised by content: NRRD, NIfTI-1 and -2, MetaImage, VTK image data (`.vti` with the feature `vtk`, legacy `.vtk`), NumPy
    /// arrays (`.npz` with the feature `npz`), TIFF (feature `tiff`), PNG and VisIt's `.bov`. Raw files are named
    /// `NAME_XxYxZ_TYPE.raw` or `.raw.gz`; `options` supplies what the name lacks, or overrides it. `options` also select one of
    /// several volumes, channels or arrays. World axes are right, anterior, superior if a file specifies patient coordinates.
    ///
    /// Voxels on axes that are not at right angles are resampled onto [`Grid::covering`](super::Grid::covering), with a warning.
    ///
    /// Uncompressed voxels are memory-mapped, so the file must not be truncated while the volume is in use. Others are read into memory,
    /// within [`OpenOptions::memory`].
    ///
    /// # Errors
    /// If the file cannot be read, has an unknown format, or is truncated or damaged; if `options` do not fit the file.
    pub fn open(source: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, Error> {
        let source = source.as_ref();
        match source.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(builtin) => builtin_volume(builtin, options),
            None => format::read(source, options),
        }
    }

    /// Opens another level of the data set of this volume, or a part of one, with the same look. `source` and `options` are those of this one.
    ///
    /// # Errors
    /// As [`Volume::open`].
    #[doc(hidden)]
    pub fn other_level(&self, source: &Path, options: &OpenOptions) -> Result<Self, Error> {
        format::read_alone(source, options).map(|volume| volume.with_overview(Some(Arc::new(self.overview().clone()))))
    }
}

/// What a file states of a volume, without its voxels.
#[doc(hidden)]
pub struct Stated {
    pub grid: Grid,
    pub scalar: ScalarType,
    pub contents: Contents,
}

impl Stated {
    /// # Errors
    /// As [`Contents::of_file`].
    pub fn of_file(path: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let format::Header { grid, scalar, contents, .. } = format::header(path, options)?;
        Ok(Self { grid, scalar, contents })
    }
}

impl Contents {
    /// What a file holds: its first frame and channel, unless others are chosen. No voxels are read.
    ///
    /// # Errors
    /// As [`Volume::open`](Volume::open), as far as headers show.
    pub fn of_file(source: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, Error> {
        let path = source.as_ref();
        if path.to_str().is_some_and(|name| name.starts_with("builtin:")) {
            return Ok(Self::default());
        }
        // Chosen, so that nothing warns of a default.
        let channel = options.channel.or_else(|| options.channel_name.is_none().then_some(0));
        let options = OpenOptions { frame: options.frame.or(Some(0)), channel, ..options.clone() };
        Ok(format::header(path, &options)?.contents)
    }
}

#[cfg(feature = "mpi")]
impl Unseen<'static> {
    /// Opens layers of a file or built-in volume, as [`Volume::open`] does, without reading others. `choose` selects the layers, given the
    /// dimensions of the volume.
    ///
    /// # Errors
    /// As [`Volume::open`], and if the file does not support random access.
    pub fn open(source: &Path, options: &OpenOptions, choose: &dyn Fn([usize; 3]) -> Layers) -> Result<Self, Error> {
        match source.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(name) => {
                let (name, grid, made) = builtin::sampled(name, options)?;
                let layers = choose(grid.dims());
                let [held, own] = layers.boxes(grid.dims());
                let voxels = builtin::layers(&name, &*made, grid.dims(), &layers.held)?;
                Ok(Self::new(name, grid, held, own, voxels)?.with_background(0.0))
            }
            None => format::layers(source, options, choose),
        }
    }
}
