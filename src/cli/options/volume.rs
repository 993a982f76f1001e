//! Which volume.

use crate::cli::{parse, standard};
use crate::viewport::Viewport;
use crate::volume::{Endian, Level, OpenOptions, ScalarType, Volume};
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::PathBuf;

/// Which volume, and what its name does not tell.
#[derive(Args)]
pub(in crate::cli) struct VolumeOptions {
    /// A file (NRRD, NIfTI, MetaImage, VTK image data, NumPy, BOV, TIFF, DICOM, HDF5; NAME_XxYxZ_TYPE.raw or .raw.gz), a folder of Zarr or
    /// of DICOM images, a folder or NAME%d.ENDING of numbered slices, or builtin: marschner-lobb, hydrogen, shepp-logan, gyroid,
    /// torus-knot or cube, as builtin:hydrogen, with @N or @XxYxZ; - is standard input
    #[arg(default_value = "builtin:hydrogen")]
    pub volume: PathBuf,
    #[command(flatten)]
    file: FileOptions,
    /// Value around the volume and of voxels that are NaN or infinite [default: the smallest valid value; of built-in volumes 0]
    #[arg(long, value_parser = parse::finite, value_name = "V", allow_hyphen_values = true, help_heading = "Volume")]
    background_value: Option<f64>,
}

/// What a file does not tell, and which of its volumes.
#[derive(Args)]
pub(in crate::cli) struct FileOptions {
    /// Voxels along x, y, z, where the file's name does not tell them: XxYxZ
    #[arg(long, value_parser = parse::dims, value_name = "XxYxZ", help_heading = "Volume")]
    dims: Option<[usize; 3]>,
    /// uint8, int8, uint16, int16, uint32, int32, uint64, int64, float16, float32 or float64, where the file's name does not tell it
    #[arg(long = "type", help_heading = "Volume")]
    voxel_type: Option<ScalarType>,
    /// Distance between voxels along x, y, z [default: 1,1,1]
    #[arg(long, value_parser = parse::spacing, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Volume")]
    spacing: Option<DVec3>,
    /// Byte order of the file [default: little]
    #[arg(long, help_heading = "Volume")]
    endian: Option<EndianName>,
    /// Bytes before the first voxel, of a .gz file once unpacked [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    header_bytes: Option<u64>,
    /// Which of several volumes that a file holds, from 0 on [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    frame: Option<usize>,
    /// Which of several numbers per voxel, from 0 on [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    channel: Option<usize>,
    /// Which of several arrays that a file names [default: the one that it marks, or the first]
    #[arg(long, value_name = "NAME", help_heading = "Volume", visible_alias = "dataset")]
    array: Option<String>,
    /// Which of several series of DICOM images in a folder: its number, its description or its identifier
    #[arg(long, value_name = "NAME", help_heading = "Volume")]
    series: Option<String>,
    /// Which of several resolutions, 0 the finest, or auto: for a picture, the coarsest that still has a voxel per pixel [default: the finest
    /// that fits into memory]
    #[arg(long, value_parser = parse::level, value_name = "N|auto", help_heading = "Volume")]
    level: Option<LevelChoice>,
}

/// A resolution, as it is given.
#[derive(Clone, Copy)]
pub(in crate::cli) enum LevelChoice {
    Auto,
    Number(usize),
}

#[derive(Clone, Copy, ValueEnum)]
enum EndianName {
    Little,
    Big,
}

impl VolumeOptions {
    /// Opens the volume, for pictures of a size if there will be any, of which memory is to hold so many bytes at most where it cannot be
    /// mapped.
    pub fn open(&self, size: Option<Viewport>, memory: Option<u64>) -> Result<Volume<'static>, crate::Error> {
        let options = OpenOptions { memory, ..self.file.raw(size)? };
        self.with_background(standard::opened(&self.volume, |path| Volume::open(path, &options))?)
    }

    /// What a file does not tell.
    #[cfg(feature = "mpi")]
    pub fn options(&self, size: Option<Viewport>) -> Result<OpenOptions, crate::Error> {
        self.file.raw(size)
    }

    /// The volume with the background that is asked for.
    pub fn with_background(&self, volume: Volume<'static>) -> Result<Volume<'static>, crate::Error> {
        match self.background_value {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

impl FileOptions {
    /// The same for the library.
    pub fn raw(&self, size: Option<Viewport>) -> Result<OpenOptions, crate::Error> {
        let endian = self.endian.map(|endian| match endian {
            EndianName::Little => Endian::Little,
            EndianName::Big => Endian::Big,
        });
        let Self { dims, voxel_type, spacing, header_bytes, frame, channel, .. } = *self;
        let (array, series) = (self.array.clone(), self.series.clone());
        let level = match (self.level, size) {
            (None, _) => None,
            (Some(LevelChoice::Number(n)), _) => Some(Level::Number(n)),
            (Some(LevelChoice::Auto), Some(size)) => Some(Level::Pixels(size.width.max(size.height) as usize)),
            (Some(LevelChoice::Auto), None) => {
                let problem = "auto is for pictures, and none is made here: give a number".into();
                return Err(crate::Error::Settings { field: "level", problem });
            }
        };
        Ok(OpenOptions { dims, voxel_type, spacing, endian, header_bytes, frame, channel, array, series, level, memory: None })
    }
}
