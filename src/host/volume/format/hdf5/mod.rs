//! HDF5 and NetCDF-4, which is based on it (<https://www.hdfgroup.org>): one dataset of a file.

mod attributes;
mod elsewhere;
mod find;
mod itk;
mod layers;
mod lzf;
mod minc;
mod numbers;
mod scales;
mod vtkhdf;

use super::axes::{Axis, Roles};
use super::conventions::{self, Packed};
use super::load::{self, Header, Opened};
use super::parts::Kept;
use super::{COMPLEX, Format, Found, OpenOptions};
use crate::error::Error;
use crate::memory;
use crate::volume::{Contents, Endian, ScalarType};
use elsewhere::Others;
use glam::DAffine3;
use hdf5_reader::filters::{FILTER_DEFLATE, FILTER_SHUFFLE};
use hdf5_reader::filters::{FILTER_FLETCHER32, FILTER_LZ4, FILTER_NBIT, FILTER_SCALEOFFSET, FILTER_SZIP};
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::{Dataset, FilterRegistry, H5Type, Hdf5File, OpenOptions as Limits};
use layers::Layers;
use minc::{Scaled, Scaling};
use numbers::Value;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// HDF5.
pub(super) struct Hdf5;

const MARK: &[u8; 8] = b"\x89HDF\r\n\x1a\n";
/// A file may begin with a block of the user's, of this many bytes or a power of 2 times as many.
const FIRST_BLOCK: u64 = 512;
/// Largest such block in bytes.
const LARGEST_BLOCK: u64 = 1 << 30;
/// Largest object header in bytes.
const LONGEST_HEADER: usize = 16 << 20;
/// Filters that can be undone.
const FILTERS: [u16; 8] =
    [FILTER_DEFLATE, FILTER_SHUFFLE, FILTER_FLETCHER32, FILTER_SZIP, FILTER_NBIT, FILTER_SCALEOFFSET, FILTER_LZ4, lzf::FILTER];
/// Names of others.
const OTHER_FILTERS: [(u16, &str); 6] =
    [(32_001, "Blosc"), (32_008, "bitshuffle"), (32_013, "ZFP"), (32_015, "Zstandard"), (32_017, "SZ"), (32_026, "Blosc2")];

impl Format for Hdf5 {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(MARK) || !file.folder && is_behind_a_block(file.path)
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let others = Others::of(path);
        let file = Hdf5File::open_with_options(path, limits(&others)).map_err(|e| find::damaged(path, &e))?;
        if let Ok(group) = file.group(vtkhdf::GROUP) {
            return vtkhdf::open(path, &file, &group, options);
        }
        let writer = Writer::of(&file);
        let dataset = match (writer.image(), &options.array) {
            (Some(image), Some(name)) if name.trim_matches('/') != image => {
                let problem = format!("'{name}' is not the image of {}, '{image}': omit it", path.display());
                return Err(Error::Settings { field: "array", problem });
            }
            (Some(image), _) => file.dataset(image).map_err(|e| find::damaged(path, &e))?,
            (None, Some(name)) => find::named(path, &file, name, &others)?,
            (None, None) => find::only(path, &file, &others)?,
        };
        let (scalar, endian) = checked(path, &file, &dataset, &others)?;
        let shape: Option<Vec<usize>> = dataset.shape().iter().map(|&n| usize::try_from(n).ok().filter(|&n| n > 0)).collect();
        let shape = shape.filter(|shape| !shape.is_empty());
        let shape = shape.ok_or_else(|| Error::volume(path, format!("'{}' holds no voxels", dataset.name())))?;
        let mut declared = match writer {
            Writer::Minc => minc::declared(path, &file, &dataset)?,
            Writer::Itk => itk::declared(path, &file, &dataset)?,
            Writer::Other => {
                Declared::by_axes(path, &scales::axes(path, (!others.are_used()).then_some(&file), &dataset), &shape)
            }
        };
        let place = declared.roles.choose(path, options, &shape, &mut declared.contents)?;
        let Declared { roles, index_to_world, is_anatomical, contents } = declared;
        let dims = roles.dims(&shape);
        let grid = load::grid_of_patient(path, dims, index_to_world, is_anatomical, options)?;
        let order: Vec<usize> = roles.space.iter().rev().flatten().copied().collect();
        let packed = match writer {
            Writer::Minc => match minc::scaling(path, &file, &dataset, scalar)? {
                Scaling::One(rescale, missing) => Packed { scalar, rescale, missing },
                Scaling::Each(scales) => {
                    let layers = Layers::new(dataset, scalar.bytes(), order, place.clone());
                    let values = Scaled::new(layers, (scalar, endian), scales, &roles, &place, dims);
                    let header = Header { endian: Endian::NATIVE, contents, ..Header::new(grid, ScalarType::Float32) };
                    return Ok(Opened { header, bytes: Box::new(Kept::new(values)), exact: false });
                }
            },
            Writer::Itk | Writer::Other => conventions::packed(scalar, &dataset, default_fill(&file, &dataset, scalar))
                .map_err(|e| Error::volume(path, e.to_string()))?,
        };
        let Packed { scalar, rescale, missing } = packed;
        let header = Header { endian, rescale, missing, contents, ..Header::new(grid, scalar) };
        let bytes = Layers::new(dataset, scalar.bytes(), order, place);
        Ok(Opened { header, bytes: Box::new(Kept::new(bytes)), exact: false })
    }
}

/// What wrote a file, as far as that tells where its image is.
#[derive(Clone, Copy)]
enum Writer {
    Minc,
    Itk,
    Other,
}

impl Writer {
    fn of(file: &Hdf5File) -> Self {
        match () {
            () if file.group(minc::GROUP).is_ok() => Self::Minc,
            () if file.group(itk::GROUP).is_ok() => Self::Itk,
            () => Self::Other,
        }
    }

    /// Path of the only image.
    fn image(self) -> Option<&'static str> {
        match self {
            Self::Minc => Some(minc::IMAGE),
            Self::Itk => Some(itk::IMAGE),
            Self::Other => None,
        }
    }
}

/// Axes and placement of a data set.
struct Declared {
    roles: Roles,
    index_to_world: DAffine3,
    /// Whether the world is that of a patient.
    is_anatomical: bool,
    contents: Contents,
}

impl Declared {
    fn by_axes(path: &Path, axes: &[Axis], shape: &[usize]) -> Self {
        let (roles, mut contents) = (Roles::new(axes, shape.len()), Contents::default());
        let index_to_world = roles.place(path, axes, shape, &mut contents);
        Self { roles, index_to_world, is_anatomical: false, contents }
    }
}

/// Whether a file has the mark behind a block of the user's.
fn is_behind_a_block(path: &Path) -> bool {
    let Ok(mut file) = File::open(path) else { return false };
    let len = file.metadata().map_or(0, |metadata| metadata.len()).min(LARGEST_BLOCK);
    let mut mark = [0; MARK.len()];
    let starts = std::iter::successors(Some(FIRST_BLOCK), |at| Some(2 * at)).take_while(|at| *at < len);
    starts.into_iter().any(|at| {
        let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut mark));
        read.is_ok() && mark == *MARK
    })
}

/// What the library may allocate and open, and the filters that it lacks.
fn limits(others: &Arc<Others>) -> Limits {
    let at_once = usize::try_from(memory::available()).unwrap_or(usize::MAX);
    let mut filters = FilterRegistry::new();
    // The last of its numbers is the size of a chunk.
    let unpack = move |filter: &hdf5_reader::messages::filter_pipeline::FilterDescription, packed: &[u8], _: usize| {
        lzf::unpack(packed, filter.client_data.get(2).map_or(at_once, |&size| at_once.min(size as usize)))
    };
    filters.register(lzf::FILTER, Box::new(unpack));
    Limits::default()
        .with_max_chunk_bytes(at_once)
        .with_max_read_bytes(at_once)
        .with_max_object_header_bytes(LONGEST_HEADER.min(at_once))
        .with_filter_registry(filters)
        .with_external_file_resolver(others.clone())
        .with_external_link_resolver(others.clone())
}

/// Type and byte order of the numbers of a dataset that can be read.
fn checked(path: &Path, file: &Hdf5File, dataset: &Dataset, others: &Others) -> Result<(ScalarType, Endian), Error> {
    let (name, dtype) = (dataset.name(), dataset.dtype());
    let wrong = |problem: String| Error::volume(path, format!("the numbers of '{name}' are {problem}"));
    if numbers::is_complex(dtype) {
        return Err(wrong(COMPLEX.into()));
    }
    let found = numbers::scalar(dtype).ok_or_else(|| wrong(format!("{dtype:?}: expected integers or floats")))?;
    let most = dataset.max_dims().unwrap_or(dataset.shape());
    if most.iter().zip(dataset.shape()).any(|(most, size)| size > most) {
        return Err(Error::volume(path, format!("the size of '{name}' is above its own limit: it is damaged")));
    }
    if !numbers::are_usual(dataset) {
        return Err(wrong("floats or integers of unusual bits: save them as float32".into()));
    }
    if others.are_used() {
        // The address of the dataset may be one in another file.
        return Ok(found);
    }
    let header = file.get_or_parse_header(dataset.address()).map_err(|e| find::damaged(path, &e))?;
    let filters = header.messages.iter().filter_map(|message| match message {
        HdfMessage::FilterPipeline(pipeline) => Some(&pipeline.filters),
        _ => None,
    });
    if let Some(filter) = filters.flatten().find(|filter| !FILTERS.contains(&filter.id)) {
        let known = OTHER_FILTERS.iter().find(|(id, _)| *id == filter.id).map_or("", |(_, name)| name);
        return Err(wrong(format!(
            "packed by the HDF5 filter {} {known}, which is not supported: repack them with gzip or LZF (h5repack -f GZIP=4 IN OUT)",
            filter.id
        )));
    }
    elsewhere::check(path, file, dataset, others)?;
    Ok(found)
}

/// Limit of the numbers of a list.
const LONGEST_LIST: u64 = 1 << 20;

/// All numbers of a data set beside an image.
fn number_list(dataset: &Dataset) -> Option<Vec<f64>> {
    dataset.num_elements().ok().filter(|count| *count <= LONGEST_LIST)?;
    Some(dataset.read_array::<Value>().ok()?.iter().map(|Value(number)| *number).collect())
}

/// The number that NetCDF stores where nothing was written, in its files. Bytes have none.
fn default_fill(file: &Hdf5File, dataset: &Dataset, scalar: ScalarType) -> Option<f64> {
    let default = conventions::netcdf_fill(scalar)?;
    let stored = dataset.fill_value()?.value.as_ref()?;
    let Value(stored) = Value::from_bytes(stored, dataset.dtype()).ok()?;
    // It does so unless the writer turned that off.
    (stored as f32 == default as f32 && is_netcdf(file, dataset)).then_some(stored)
}

/// Whether a dataset is a variable of NetCDF.
fn is_netcdf(file: &Hdf5File, dataset: &Dataset) -> bool {
    let marks = ["_Netcdf4Dimid", "_Netcdf4Coordinates"];
    let root = file.root_group().and_then(|root| root.attribute("_NCProperties"));
    root.is_ok() || marks.iter().any(|mark| dataset.attribute(mark).is_ok())
}
