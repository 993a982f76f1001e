//! Volume file formats; each implements [`Format`].

#[cfg(any(feature = "hdf5", feature = "zarr"))]
mod axes;
mod bits;
mod bov;
mod bytes;
mod choice;
mod collection;
#[cfg(any(feature = "hdf5", feature = "zarr"))]
mod conventions;
#[cfg(feature = "dicom")]
mod dicom;
#[cfg(feature = "hdf5")]
mod hdf5;
mod keyed;
mod load;
mod magnitude;
mod metaimage;
mod mgh;
#[cfg(not(all(feature = "dicom", feature = "hdf5", feature = "zarr")))]
mod missing;
mod names;
#[cfg(feature = "hdf5")]
mod netcdf;
mod nifti;
mod nrrd;
mod numbered;
mod numpy;
mod options;
#[cfg(any(feature = "dicom", feature = "hdf5", feature = "tiff", feature = "zarr"))]
mod parts;
mod png;
mod raw;
#[cfg(any(feature = "dicom", feature = "tiff"))]
mod runs;
mod slices;
#[cfg(any(feature = "hdf5", feature = "zarr"))]
mod strided;
mod surfaces;
mod text;
#[cfg(feature = "tiff")]
mod tiff;
pub(crate) mod vtk;
#[cfg(feature = "zarr")]
mod zarr;

pub(super) use load::Header;
pub use options::{Level, OpenOptions, Placement};
pub(super) use raw::told_by_name;
pub(crate) use surfaces::{FREESURFER_TRIANGLES, STL_BYTES, SurfaceFormat, stl_triangles};

use super::grid::lengths;
use super::labels::Declared;
use super::{ChannelDescription, Contents, Rescale, ScalarType, Volume};
#[cfg(feature = "mpi")]
use super::{Layers, Unseen};
use crate::error::Error;
use crate::panics::caught;
use crate::url;
use flate2::read::MultiGzDecoder;
use glam::DAffine3;
use load::Opened;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// All formats. The first one that recognises a file reads it. Raw files have no magic number, so they come last.
const FORMATS: &[&dyn Format] = &[
    // DICOM comes before TIFF: files may be both, since DICOM leaves its first 128 bytes unspecified.
    #[cfg(feature = "dicom")]
    &dicom::Dicom,
    #[cfg(not(feature = "dicom"))]
    &missing::Missing {
        name: "DICOM",
        feature: "dicom",
        recognises: |file| file.start.get(128..132) == Some(b"DICM") || (file.folder && holds(file.path, ".dcm")),
    },
    &nrrd::Nrrd,
    &nifti::Nifti,
    &metaimage::MetaImage,
    &mgh::Mgh,
    &surfaces::Surfaces,
    #[cfg(feature = "vtk")]
    &vtk::Xml,
    &vtk::Legacy,
    &numpy::Npy,
    #[cfg(feature = "npz")]
    &numpy::Npz,
    &bov::Bov,
    #[cfg(feature = "tiff")]
    &tiff::Tiff,
    &png::Png,
    #[cfg(feature = "hdf5")]
    &hdf5::Hdf5,
    #[cfg(feature = "hdf5")]
    &netcdf::NetCdf,
    #[cfg(not(feature = "hdf5"))]
    &missing::Missing {
        name: "HDF5 or NetCDF",
        feature: "hdf5",
        recognises: |file| file.start.starts_with(b"\x89HDF\r\n\x1a\n") || file.start.starts_with(b"CDF"),
    },
    #[cfg(feature = "zarr")]
    &zarr::Zarr,
    #[cfg(not(feature = "zarr"))]
    &missing::Missing {
        name: "Zarr",
        feature: "zarr",
        recognises: |file| ["zarr.json", ".zarray", ".zgroup"].iter().any(|mark| file.path.join(mark).is_file()),
    },
    &raw::Raw,
];
/// Bytes at the start of a file that are used for recognition.
const START: usize = 512;
/// What is wrong with complex numbers.
const COMPLEX: &str = "complex numbers, and a voxel has one number: save their magnitude, phase or real part";
const UNKNOWN: &str = "unknown format: volumes are NRRD, NIfTI, MGH, MetaImage, VTK image data, NumPy, BOV, TIFF, DICOM, HDF5 or NetCDF files, \
                       folders of Zarr, PNG slices, .raw or .raw.gz files, or builtin:NAME";

/// A file format.
trait Format: Sync {
    /// Whether a file has this format, by its first bytes, or by its name if the format has no magic number.
    fn recognises(&self, file: &Found, options: &OpenOptions) -> bool;

    /// Names of the format-specific options that this format supports.
    fn chooses(&self) -> &'static [&'static str] {
        &[]
    }

    /// What the file states about the ids of its voxels, if it states that they are ids of labels.
    fn labels(&self, _: &Found, _: &OpenOptions) -> Result<Option<Declared>, Error> {
        Ok(None)
    }

    /// What the file states about its `count` channels, as far as it does.
    fn channels(&self, _: &Found, _: &OpenOptions, _count: usize) -> Result<Vec<ChannelDescription>, Error> {
        Ok(Vec::new())
    }

    /// Parses the header.
    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error>;
}

/// A file or folder before its format is known.
struct Found<'a> {
    path: &'a Path,
    folder: bool,
    /// First bytes of the file.
    start: Vec<u8>,
    /// First decompressed bytes, if it is a gzip file.
    unpacked: Option<Vec<u8>>,
}

impl<'a> Found<'a> {
    fn look(path: &'a Path) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        if url::is_url(path) {
            return Ok(Self { path, folder: false, start: Vec::new(), unpacked: None });
        }
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if metadata.is_dir() {
            return Ok(Self { path, folder: true, start: Vec::new(), unpacked: None });
        }
        if !metadata.is_file() {
            return Err(failed(io::Error::other("not a regular file")));
        }
        let mut start = vec![0; START];
        let found = bytes::fill(&mut File::open(path).map_err(failed)?, &mut start).map_err(failed)?;
        start.truncate(found);
        let unpacked = start.starts_with(&[0x1f, 0x8b]).then(|| {
            let mut unpacked = vec![0; START];
            let mut decoder = MultiGzDecoder::new(&start[..]);
            let mut found = 0;
            // The input is cut off, so decompression ends with an error. The bytes before it are enough.
            while let Ok(more @ 1..) = decoder.read(&mut unpacked[found..]) {
                found += more;
            }
            unpacked.truncate(found);
            unpacked
        });
        Ok(Self { path, folder: false, start, unpacked })
    }

    /// Whether the name has one of these extensions, ignoring case.
    fn ends_with(&self, endings: &[&str]) -> bool {
        let name = self.path.to_string_lossy().to_ascii_lowercase();
        endings.iter().any(|ending| name.ends_with(ending))
    }
}

/// Opens a file of any format. Voxels on sheared axes are resampled.
pub(super) fn read(path: &Path, options: &OpenOptions) -> Result<Volume<'static>, Error> {
    let path = &*url::public(path);
    let read = || match open(path, options) {
        Err(Error::Sheared { index_to_world, has_anatomy, .. }) => {
            let mut index_to_world = *index_to_world;
            let volume = load::volume(path, open(path, &unsheared(options, index_to_world)?)?, options.memory)?;
            index_to_world.translation = options.origin.unwrap_or(index_to_world.translation);
            let mut contents = volume.contents().clone();
            contents.states_spacing = true;
            let resampled = volume.covering(index_to_world, has_anatomy)?.with_contents(contents);
            let [x, y, z] = resampled.grid().dims();
            let path = path.display();
            tracing::warn!(
                "{path}: its axes are sheared: its voxels are resampled onto {x}x{y}x{z} of orthogonal axes, by linear interpolation"
            );
            Ok(resampled)
        }
        opened => {
            let volume = load::volume(path, opened?, options.memory)?;
            let overview = overview(path, options, volume.contents(), volume.grid().dims())?;
            Ok(volume.with_overview(overview))
        }
    };
    caught(path, || again_if_changed(path, read))
}

/// The kind of error of a file that is no longer of the version that was read before.
const CHANGED: io::ErrorKind = io::ErrorKind::StaleNetworkFileHandle;

/// Reads a file once more if it changed while it was read.
fn again_if_changed<T>(path: &Path, read: impl Fn() -> Result<T, Error>) -> Result<T, Error> {
    match read() {
        Err(Error::Read { source, .. }) if source.kind() == CHANGED => {
            tracing::info!("{}: {source}; reading it again", path.display());
            read()
        }
        read => read,
    }
}

/// Opens a file without the level that stands for all.
pub(super) fn read_alone(path: &Path, options: &OpenOptions) -> Result<Volume<'static>, Error> {
    let path = &*url::public(path);
    caught(path, || again_if_changed(path, || load::volume(path, open(path, options)?, options.memory)))
}

/// The level that stands for all levels of a file, beside one that was opened, or a part of it.
fn overview(
    path: &Path,
    options: &OpenOptions,
    contents: &Contents,
    dims: [usize; 3],
) -> Result<Option<Arc<Volume<'static>>>, Error> {
    let Some(level) = contents.overview_level().filter(|&level| level != contents.level || contents.are_part(dims)) else {
        return Ok(None);
    };
    let options = OpenOptions { level: Some(Level::Number(level)), region: None, ..options.clone() };
    tracing::info!("{}: level {level} gives range, automatic transfer function and camera for all levels", path.display());
    match open(path, &options) {
        // A tiny data set, of which less was asked for.
        Err(Error::Settings { field: "download", .. }) => {
            tracing::warn!(
                "{}: range, automatic transfer function and camera are those of level {}: level {level}, which gives those of all levels, does \
                 not fit into download",
                path.display(),
                contents.level
            );
            Ok(None)
        }
        opened => load::volume(path, opened?, options.memory).map(|volume| Some(volume.into())),
    }
}

/// Options that open a file with the spacing of its sheared axes.
fn unsheared(options: &OpenOptions, index_to_world: DAffine3) -> Result<OpenOptions, Error> {
    Ok(OpenOptions { spacing: Some(lengths(index_to_world.matrix3)?), origin: None, ..options.clone() })
}

/// Reads a range of z layers of a file of any format.
#[cfg(feature = "mpi")]
pub(super) fn layers(
    path: &Path,
    options: &OpenOptions,
    choose: &dyn Fn([usize; 3]) -> Layers,
) -> Result<Unseen<'static>, Error> {
    let path = &*url::public(path);
    caught(path, || {
        let opened = open(path, options)?;
        let overview = overview(path, options, &opened.header.contents, opened.header.grid.dims())?;
        Ok(load::layers(path, opened, choose)?.with_overview(overview))
    })
}

/// The header of a file of any format that is large enough for its voxels.
pub(super) fn header(path: &Path, options: &OpenOptions) -> Result<load::Header, Error> {
    let path = &*url::public(path);
    caught(path, || match open_one(path, options) {
        Err(Error::Sheared { index_to_world, .. }) => load::header(path, open_one(path, &unsheared(options, *index_to_world)?)?),
        opened => load::header(path, opened?),
    })
}

/// The files of a collection of steps, in order; any other source itself.
pub(super) fn collected(path: &Path, options: &OpenOptions) -> Result<Vec<PathBuf>, Error> {
    let path = &*url::public(path);
    caught(path, || Ok(collection::files(path, options)?.unwrap_or_else(|| vec![path.into()])))
}

/// All numbers of a file of any format as stored, and its header. See [`OpenOptions::memory`].
pub(super) fn numbers(path: &Path, options: &OpenOptions) -> Result<load::Numbers, Error> {
    let path = &*url::public(path);
    caught(path, || again_if_changed(path, || load::numbers(path, open(path, options)?, options.memory)))
}

/// What a file states about the ids of its voxels; `None` if it does not state that they are ids of labels.
pub(super) fn labels(path: &Path, options: &OpenOptions) -> Result<Option<Declared>, Error> {
    let path = &*url::public(path);
    caught(path, || {
        if slices::files(path)?.is_some() {
            return Ok(None);
        }
        let file = Found::look(path)?;
        let format = format(&file, options)?;
        format.map_or(Ok(None), |format| format.labels(&file, options))
    })
}

/// Opens a file of any format, or a step of a collection.
fn open(path: &Path, options: &OpenOptions) -> Result<Opened, Error> {
    match collection::files(path, options)? {
        Some(files) => collection::open(path, &files, options),
        None => open_one(path, options),
    }
}

/// Opens a file that is no collection, where `options` place it.
fn open_one(path: &Path, options: &OpenOptions) -> Result<Opened, Error> {
    if let Some(name) = &options.channel_name {
        return open_one(path, &with_number(path, options, name)?);
    }
    let mut opened = open_stated(path, options)?;
    let load::Header { grid, contents, .. } = &mut opened.header;
    let of_file = |e: Error| Error::volume(path, e.to_string());
    let is_assumed = !contents.states_spacing && options.spacing.is_none() && options.unstated != Placement::default();
    if is_assumed {
        *grid = options.unstated.grid(grid.dims()).map_err(of_file)?;
        contents.states_spacing = true;
    }
    if options.spacing.is_some() {
        contents.length_unit = None;
    }
    if let Some(origin) = options.origin {
        *grid = grid.with_origin(origin).map_err(of_file)?;
    }
    Ok(opened)
}

/// Opens a file that is no collection, as it states its placement.
fn open_stated(path: &Path, options: &OpenOptions) -> Result<Opened, Error> {
    let mut opened = match slices::files(path)? {
        Some(files) => slices::open(path, files, options)?,
        None => open_file(path, options)?,
    };
    let load::Header { scalar, rescale, contents, .. } = &mut opened.header;
    let are_intensities = matches!(scalar, ScalarType::Uint8 | ScalarType::Uint16 | ScalarType::Float32);
    contents.are_colors &= contents.channels > 2 && are_intensities && *rescale == Rescale::default();
    choice::check(path, options, contents)?;
    if options.magnitude && !contents.magnitude {
        let problem = match contents.channels {
            1 => format!("has no magnitude: a voxel of {} has one number", path.display()),
            _ => format!("gives no magnitude for the format of {}: choose a component", path.display()),
        };
        return Err(Error::Settings { field: "channel", problem });
    }
    Ok(opened)
}

/// The options with the number of the channel of a name.
fn with_number(path: &Path, options: &OpenOptions, name: &str) -> Result<OpenOptions, Error> {
    if options.channel.is_some() || options.magnitude {
        let problem = format!("is either '{name}', a number or the magnitude: omit the others");
        return Err(Error::Settings { field: "channel", problem });
    }
    let of_any = OpenOptions { channel_name: None, channel: Some(0), frame: options.frame.or(Some(0)), ..options.clone() };
    let contents = open_one(path, &of_any)?.header.contents;
    let number = ChannelDescription::named(&channels(path, &of_any, &contents)?, name, path)?;
    Ok(OpenOptions { channel: Some(number), channel_name: None, ..options.clone() })
}

/// The format of a file or folder.
fn format(file: &Found, options: &OpenOptions) -> Result<Option<&'static dyn Format>, Error> {
    if url::is_url(file.path) {
        return of_address(file.path, options).map(Some);
    }
    Ok(FORMATS.iter().copied().find(|format| format.recognises(file, options)))
}

/// The format of all addresses.
fn of_address(path: &Path, options: &OpenOptions) -> Result<&'static dyn Format, Error> {
    if options.confined {
        return Err(Error::volume(path, "addresses are not followed here: name it in the command"));
    }
    if let Some(problem) = url::problem(path) {
        return Err(Error::volume(path, problem));
    }
    #[cfg(feature = "http")]
    return Ok(&zarr::Zarr);
    #[cfg(not(feature = "http"))]
    Err(Error::volume(path, "this build reads no addresses: build it with the feature http, or download it"))
}

/// Opens a file or a folder of one format.
fn open_file(path: &Path, options: &OpenOptions) -> Result<Opened, Error> {
    let file = Found::look(path)?;
    let Some(format) = format(&file, options)? else {
        return Err(Error::volume(path, if file.folder { slices::UNKNOWN } else { UNKNOWN }));
    };
    let given = [
        ("array", options.array.is_some()),
        ("level", options.level.is_some_and(Level::is_demanded)),
        ("region", options.region.is_some()),
        ("series", options.series.is_some()),
    ];
    if let Some((field, _)) = given.iter().find(|(field, given)| *given && !format.chooses().contains(field)) {
        let problem = format!("not supported by the format of {}: omit it", path.display());
        return Err(Error::Settings { field, problem });
    }
    if options.magnitude && options.channel.is_some() {
        let problem = "is either one component or their magnitude: omit one of them".into();
        return Err(Error::Settings { field: "channel", problem });
    }
    format.open(&file, options)
}

/// What a file states about the channels that it contains, as far as it does.
pub(super) fn channels(path: &Path, options: &OpenOptions, contents: &Contents) -> Result<Vec<ChannelDescription>, Error> {
    let (count, path) = (contents.channels, &*url::public(path));
    let found = caught(path, || {
        let files = slices::files(path)?.unwrap_or_default();
        if let Some(found) = slices::channels(path, &files, count)? {
            return Ok(found);
        }
        let file = Found::look(files.first().map_or(path, PathBuf::as_path))?;
        let format = format(&file, options)?;
        format.map_or(Ok(Vec::new()), |format| format.channels(&file, options, count))
    })?;
    // Formats say only what differs from this.
    let are_unnamed = found.is_empty() && contents.are_colors;
    Ok(if are_unnamed { ChannelDescription::of_components(count) } else { found })
}

/// All files of a folder, except hidden ones: macOS leaves a `._NAME` beside each file on foreign disks.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let failed = |e| Error::read(folder, e);
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(failed)?.collect();
    let is_hidden = |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    let paths = entries.map_err(failed)?.into_iter().map(|entry| entry.path());
    Ok(paths.filter(|path| !is_hidden(path) && path.is_file()).collect())
}

/// Whether a folder has a file with this extension.
#[cfg(not(feature = "dicom"))]
fn holds(folder: &Path, ending: &str) -> bool {
    let is_one = |file: &PathBuf| file.to_string_lossy().to_ascii_lowercase().ends_with(ending);
    listed(folder).is_ok_and(|files| files.iter().any(is_one))
}
