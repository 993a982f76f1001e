//! Writes volumes to files, in their voxel type.

mod nifti;
mod npy;
mod nrrd;
mod raw;
mod vti;

use super::format;
use super::missing_data::MissingData;
use super::wide;
use super::{Endian, Grid, OpenOptions, Rescale, ScalarType, Volume};
use crate::error::Error;
use crate::files::write_whole;
use crate::progress::Task;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes whose byte order is swapped at a time.
const PIECE: usize = 1 << 20;

/// Content of a file: all numbers, x fastest.
struct Written<'a> {
    name: &'a str,
    grid: &'a Grid,
    scalar: ScalarType,
    rescale: Rescale,
    /// Unit of lengths, if it is known.
    length_unit: Option<&'a str>,
    /// Which of the numbers stand for missing voxels, if some do.
    missing: Option<&'a MissingData>,
    numbers: Numbers<'a>,
}

/// Source of the numbers.
enum Numbers<'a> {
    Volume(&'a Volume<'a>),
    Bytes(&'a [u8], Endian),
}

/// Output formats.
#[derive(Clone, Copy)]
enum Format {
    Raw,
    Nrrd,
    Nifti { packed: bool },
    Npy,
    Vti,
}

impl Format {
    fn from_path(path: &Path) -> Result<Self, Error> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let formats = [
            (".raw", Format::Raw),
            (".nrrd", Format::Nrrd),
            (".nii", Format::Nifti { packed: false }),
            (".nii.gz", Format::Nifti { packed: true }),
            (".npy", Format::Npy),
            (".vti", Format::Vti),
        ];
        let found = formats.into_iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, format)| format);
        let known = || "a name ending in .raw, .nrrd, .nii, .nii.gz, .npy or .vti".into();
        found.ok_or_else(|| Error::UnknownName { what: "volume format", name, known: known() })
    }

    /// Whether the format stores rescaling, and whether it stores the grid's placement.
    fn keeps(self) -> (bool, bool) {
        match self {
            Format::Nifti { .. } => (true, true),
            Format::Nrrd | Format::Vti => (false, true),
            Format::Raw | Format::Npy => (false, false),
        }
    }
}

/// Converts a file, or `builtin:NAME`, to another format in the same number type. The output is as for [`Volume::save`]. Returns the path
/// of the written file.
///
/// # Errors
/// As [`Volume::open`] and [`Volume::save`].
///
/// ```
/// use layersplat::volume::{OpenOptions, convert};
/// # let folder = tempfile::tempdir().expect("a folder");
///
/// let written = convert("builtin:cube@4", &OpenOptions::default(), folder.path().join("cube.raw"))?;
/// assert!(written.ends_with("cube_4x4x4_uint8.raw"));
/// # Ok::<(), layersplat::Error>(())
/// ```
pub fn convert(source: impl AsRef<Path>, options: &OpenOptions, target: impl AsRef<Path>) -> Result<PathBuf, Error> {
    let (source, target) = (source.as_ref(), target.as_ref());
    let format = Format::from_path(target)?;
    if source.to_str().is_some_and(|name| name.starts_with("builtin:")) {
        return Volume::open(source, options)?.save(target);
    }
    let (header, bytes) = format::numbers(source, options)?;
    let name = source.file_name().unwrap_or_default().to_string_lossy();
    let format::Header { ref grid, scalar, endian, rescale, ref missing, .. } = header;
    let stored = wide::Numbers { bytes: (*bytes).as_ref(), scalar, endian, missing: missing.declared() };
    let missing = stored.missing.filter(|_| stored.has_missing());
    let length_unit = header.contents.length_unit.as_deref().or(grid.has_anatomy().then_some("mm"));
    let written =
        Written { name: &name, grid, scalar, rescale, length_unit, missing, numbers: Numbers::Bytes(stored.bytes, endian) };
    written.save(target, format)
}

impl Volume<'_> {
    /// Writes the volume atomically to `.raw` (dimensions and type are added to the name), `.nrrd`, `.nii`, `.nii.gz`, `.npy` or `.vti`.
    /// Returns the path of the written file.
    ///
    /// The voxel type is kept. Only NIfTI stores rescaling; in other formats, rescaled voxels become float values, with a warning. Raw and
    /// NumPy files do not store the placement of the grid, which also logs a warning.
    ///
    /// # Errors
    /// If the extension is unknown, the format does not support the type or size, or the file cannot be written.
    ///
    /// ```
    /// use layersplat::volume::{OpenOptions, Volume};
    /// # let folder = tempfile::tempdir().expect("a folder");
    ///
    /// let volume = Volume::open("builtin:hydrogen@8", &OpenOptions::default())?;
    /// let path = volume.save(folder.path().join("hydrogen.nrrd"))?;
    /// assert_eq!(Volume::open(path, &OpenOptions::default())?.value(77), volume.value(77));
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn save(&self, target: impl AsRef<Path>) -> Result<PathBuf, Error> {
        let target = target.as_ref();
        let (scalar, rescale) = (self.voxel_type().into(), self.description().rescale());
        let numbers = Numbers::Volume(self);
        let length_unit = self.length_unit();
        Written { name: self.name(), grid: self.grid(), scalar, rescale, length_unit, missing: None, numbers }
            .save(target, Format::from_path(target)?)
    }
}

impl Written<'_> {
    fn save(&self, target: &Path, format: Format) -> Result<PathBuf, Error> {
        let (keeps_rescale, keeps_place) = format.keeps();
        // NIfTI has 32-bit floats.
        let fits = |number: f64| (number as f32).is_normal() || number == 0.0;
        let keeps_rescale = keeps_rescale && fits(self.rescale.slope()) && fits(self.rescale.intercept());
        if !keeps_place && *self.grid != Grid::new(self.grid.dims(), glam::DVec3::ONE)? {
            tracing::warn!(
                "{}: the format does not store the grid: its spacing, origin and direction are lost",
                target.display()
            );
        }
        if self.missing.is_some() {
            tracing::warn!(
                "{}: some voxels of {} are missing: they become NaN, and all voxels floats",
                target.display(),
                self.name
            );
        }
        let loses_rescale = !keeps_rescale && self.rescale != Rescale::default();
        let as_values = loses_rescale || self.missing.is_some();
        if loses_rescale {
            tracing::warn!(
                "{}: the format does not store slope and intercept: converting {} voxels to values",
                target.display(),
                self.scalar
            );
        }
        let mut target = target.to_owned();
        let written = Written {
            scalar: if as_values { self.type_of_values() } else { self.scalar },
            rescale: if as_values { Rescale::default() } else { self.rescale },
            numbers: self.numbers.again(),
            ..*self
        };
        let head = match format {
            Format::Raw => {
                target = raw::named(&target, written.grid.dims(), written.scalar)?;
                Ok(Vec::new())
            }
            Format::Nrrd => nrrd::head(&written),
            Format::Nifti { .. } => nifti::head(&written),
            Format::Npy => npy::head(&written),
            Format::Vti => vti::head(&written),
        };
        let head = head.map_err(|problem| Error::volume(&target, problem))?;
        let foot: &[u8] = if matches!(format, Format::Vti) { vti::FOOT } else { &[] };
        let rescale = as_values.then_some(self.rescale);
        let all = |out: &mut dyn Write| {
            out.write_all(&head)?;
            written.write(self.scalar, rescale, out)?;
            out.write_all(foot)
        };
        write_whole(&target, |out| match format {
            Format::Nifti { packed: true } => {
                let mut packer = flate2::write::GzEncoder::new(out, flate2::Compression::default());
                all(&mut packer)?;
                packer.finish().map(|_| ())
            }
            _ => all(out),
        })?;
        Ok(target)
    }

    /// Float type that represents all values: float32 for up to 16 bits and for float32 itself, else float64.
    fn type_of_values(&self) -> ScalarType {
        let is_exact = self.scalar == ScalarType::Float32 && self.rescale == Rescale::default();
        if self.scalar.bytes() <= 2 || is_exact { ScalarType::Float32 } else { ScalarType::Float64 }
    }

    /// Rescales numbers to little-endian values.
    fn values(&self, numbers: wide::Numbers, rescale: Rescale) -> Vec<u8> {
        let values = (0..numbers.count()).map(|index| rescale.value(numbers.get(index)));
        match self.scalar {
            ScalarType::Float32 => values.flat_map(|value| (value as f32).to_le_bytes()).collect(),
            _ => values.flat_map(f64::to_le_bytes).collect(),
        }
    }

    /// Bytes of all numbers.
    fn bytes(&self) -> u64 {
        self.grid.voxel_count() as u64 * self.scalar.bytes() as u64
    }

    /// Writes all numbers little-endian; as values if `rescale` is given.
    fn write(&self, stored: ScalarType, rescale: Option<Rescale>, out: &mut dyn Write) -> io::Result<()> {
        let task = Task::new(format!("writing {}", self.name), self.grid.voxel_count() as u64 * stored.bytes() as u64);
        let mut piece = |bytes: &[u8], endian: Endian| {
            match rescale {
                Some(rescale) => {
                    out.write_all(&self.values(wide::Numbers { bytes, scalar: stored, endian, missing: self.missing }, rescale))?
                }
                None if endian == Endian::Little || stored.bytes() == 1 => out.write_all(bytes)?,
                None => {
                    let mut turned = bytes.to_vec();
                    turned.chunks_exact_mut(stored.bytes()).for_each(<[u8]>::reverse);
                    out.write_all(&turned)?;
                }
            }
            task.add(bytes.len() as u64);
            Ok(())
        };
        match self.numbers {
            Numbers::Volume(volume) => volume
                .voxels
                .for_each_piece(None, |_, bytes| bytes.chunks(PIECE).try_for_each(|bytes| piece(bytes, Endian::NATIVE))),
            Numbers::Bytes(bytes, endian) => bytes.chunks(PIECE).try_for_each(|bytes| piece(bytes, endian)),
        }
    }
}

impl<'a> Numbers<'a> {
    fn again(&self) -> Numbers<'a> {
        match *self {
            Numbers::Volume(volume) => Numbers::Volume(volume),
            Numbers::Bytes(bytes, endian) => Numbers::Bytes(bytes, endian),
        }
    }
}
