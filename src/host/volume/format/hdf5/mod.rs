//! HDF5 and NetCDF-4, which is based on it (<https://www.hdfgroup.org>): one dataset of a file.

mod layers;

use super::load::{self, Header, Opened, upright};
use super::parts::Kept;
use super::{COMPLEX, Format, Found, OpenOptions};
use crate::error::Error;
use crate::memory;
use crate::volume::{Contents, Endian, Rescale, ScalarType};
use glam::DVec3;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions as Limits};
use layers::Layers;
use std::collections::BTreeSet;
use std::path::Path;

/// HDF5.
pub(super) struct Hdf5;

const MARK: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Attribute with the distances between voxels along z, y, x.
const SPACING: &str = "element_size_um";
/// Largest object header in bytes.
const LONGEST_HEADER: usize = 16 << 20;
/// Largest compression ratio, that of deflate. Chunks that are not stored, because they hold the fill value only, count as compressed.
const LIMIT: u64 = 1032;
/// Limit of datasets and groups visited.
const MOST: usize = 10_000;

impl Format for Hdf5 {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(MARK)
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let size = std::fs::metadata(path).map_err(|e| Error::read(path, e))?.len();
        let most = size.saturating_mul(LIMIT);
        let at_once = usize::try_from(most.min(memory::available())).unwrap_or(usize::MAX);
        let limits = Limits::default().with_max_chunk_bytes(at_once).with_max_read_bytes(at_once);
        let limits = limits.with_max_object_header_bytes(LONGEST_HEADER.min(at_once));
        let opened = Hdf5File::open_with_options(path, limits).map_err(|e| damaged(path, &e))?;
        let dataset = match &options.array {
            Some(name) => opened.dataset(name).map_err(|_| unknown(path, name, &opened))?,
            None => only(path, &opened)?,
        };
        let scalar = scalar(dataset.dtype()).ok_or_else(|| {
            let (name, dtype) = (dataset.name(), dataset.dtype());
            let problem = if is_complex(dtype) {
                format!("the numbers of '{name}' are {COMPLEX}")
            } else {
                format!("the numbers of '{name}' are {dtype:?}: expected integers or floats")
            };
            Error::volume(path, problem)
        })?;
        let shape: Option<Vec<usize>> = dataset.shape().iter().map(|&n| usize::try_from(n).ok().filter(|&n| n > 0)).collect();
        let shape = shape.filter(|shape| !shape.is_empty());
        let shape = shape.ok_or_else(|| Error::volume(path, format!("'{}' holds no voxels", dataset.name())))?;
        let (before, space) = shape.split_at(shape.len().saturating_sub(3));
        let frames = before.iter().fold(1usize, |n, &size| n.saturating_mul(size));
        let mut contents = Contents { states_spacing: dataset.attribute(SPACING).is_ok(), ..Contents::default() };
        let frame = contents.choose_frame(path, options, frames)?;
        contents.choose_channel(path, options, 1)?;
        let dims = [0, 1, 2].map(|i| space.len().checked_sub(i + 1).map_or(1, |axis| space[axis]));
        let grid = load::grid(path, dims, upright(spacing(&dataset), DVec3::ZERO), options)?;
        // Only chunked datasets can be compressed, or have missing chunks.
        let is_packed = dataset.chunks().is_some();
        let rescale = rescale(&dataset).map_err(|e| Error::volume(path, e.to_string()))?;
        let header = Header { endian: Endian::NATIVE, rescale, contents, ..Header::new(grid, scalar) };
        let bytes = Layers::new(dataset, scalar, before, frame, dims, if is_packed { most } else { size });
        Ok(Opened { header, bytes: Box::new(Kept::new(bytes)), exact: false })
    }
}

fn damaged(path: &Path, e: &hdf5_reader::error::Error) -> Error {
    Error::volume(path, format!("it cannot be read: {e}"))
}

/// Scalar type of an HDF5 datatype.
fn scalar(dtype: &Datatype) -> Option<ScalarType> {
    match dtype {
        Datatype::FixedPoint { size, signed, .. } => {
            format!("{}int{}", if *signed { "" } else { "u" }, 8 * u32::from(*size)).parse().ok()
        }
        Datatype::FloatingPoint { size: size @ (4 | 8), .. } => format!("float{}", 8 * u32::from(*size)).parse().ok(),
        _ => None,
    }
}

/// Whether numbers are complex, as h5py and others store them: compounds of a real and an imaginary float.
fn is_complex(dtype: &Datatype) -> bool {
    let Datatype::Compound { fields, .. } = dtype else { return false };
    let floats = fields.iter().all(|field| matches!(field.datatype, Datatype::FloatingPoint { .. }));
    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
    floats && [["r", "i"], ["real", "imag"], ["re", "im"]].iter().any(|known| names == known)
}

/// The dataset with the most axes, if it is unique.
fn only(path: &Path, file: &Hdf5File) -> Result<Dataset, Error> {
    let all = volumes(path, file, |dtype| scalar(dtype).is_some())?;
    match &all[..] {
        [] if !volumes(path, file, is_complex)?.is_empty() => Err(Error::volume(path, format!("it has {COMPLEX}"))),
        [] => Err(Error::volume(path, "it has no dataset of numbers along two axes or more")),
        [name] => file.dataset(name).map_err(|e| damaged(path, &e)),
        several => {
            let problem = format!("{} has several datasets: {}; choose one", path.display(), several.join(", "));
            Err(Error::Settings { field: "array", problem })
        }
    }
}

fn unknown(path: &Path, name: &str, file: &Hdf5File) -> Error {
    match volumes(path, file, |dtype| scalar(dtype).is_some()) {
        Ok(names) => {
            let problem = format!("'{name}' is not in {}, whose arrays are {}", path.display(), names.join(", "));
            Error::Settings { field: "array", problem }
        }
        Err(e) => e,
    }
}

/// Paths of all datasets of numbers along three axes or more; if there are none, of those along two.
fn volumes(path: &Path, file: &Hdf5File, wanted: impl Fn(&Datatype) -> bool) -> Result<Vec<String>, Error> {
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    let mut groups: Vec<(String, Group)> = vec![(String::new(), file.root_group().map_err(|e| damaged(path, &e))?)];
    while let Some((prefix, group)) = groups.pop() {
        // Links may reach a group several times, even from inside the group.
        if !seen.insert(group.address()) || found.len() + groups.len() > MOST {
            continue;
        }
        let (below, datasets) = group.members().map_err(|e| damaged(path, &e))?;
        groups.extend(below.into_iter().rev().map(|group| (format!("{prefix}{}/", last(group.name())), group)));
        let numbers = datasets.iter().filter(|dataset| wanted(dataset.dtype()));
        found.extend(numbers.map(|dataset| (dataset.ndim(), format!("{prefix}{}", last(dataset.name())))));
    }
    let of =
        |axes: &dyn Fn(usize) -> bool| found.iter().filter(|(n, _)| axes(*n)).map(|(_, name)| name.clone()).collect::<Vec<_>>();
    let volumes = of(&|n| n > 2);
    Ok(if volumes.is_empty() { of(&|n| n == 2) } else { volumes })
}

/// Last component of a path.
fn last(name: &str) -> &str {
    name.trim_end_matches('/').rsplit('/').next().unwrap_or_default()
}

/// Spacing from the attribute `element_size_um`, which microscopy software writes; 1 by default.
fn spacing(dataset: &Dataset) -> DVec3 {
    let sizes = dataset.attribute(SPACING).and_then(|attribute| attribute.read_1d::<f64>()).unwrap_or_default();
    match sizes[..] {
        [z, y, x] if sizes.iter().all(|h| h.is_finite() && *h > 0.0) => DVec3::new(x, y, z),
        _ => DVec3::ONE,
    }
}

/// Slope and intercept from the attributes of the NetCDF conventions.
fn rescale(dataset: &Dataset) -> Result<Rescale, Error> {
    let attribute = |name: &str| dataset.attribute(name).and_then(|attribute| attribute.read_as_f64()).ok();
    match (attribute("scale_factor"), attribute("add_offset")) {
        (None, None) => Ok(Rescale::default()),
        (slope, intercept) => Rescale::new(slope.unwrap_or(1.0), intercept.unwrap_or(0.0)),
    }
}
