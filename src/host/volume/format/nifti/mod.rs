//! NIfTI-1 and NIfTI-2, in one or two files, plain or gzipped (<https://nifti.nimh.nih.gov>).

mod header;
mod place;

use super::bytes::{self, Bytes, Gzip, Packed, Packing, Plain};
use super::load::{self, Header, Opened};
use super::{COMPLEX, Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::labels::Declared;
use crate::volume::{Contents, LabelTable, Rescale, ScalarType};
use header::Fields;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// NIfTI.
pub(super) struct Nifti;

impl Format for Nifti {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        is_header(file) || header_of(file.path).is_some()
    }

    fn labels(&self, file: &Found, _: &OpenOptions) -> Result<Option<Declared>, Error> {
        let path = &header_of(file.path).unwrap_or_else(|| file.path.into());
        let fields = read(path)?;
        if !fields.is_of_labels() {
            return Ok(None);
        }
        let layers = auxiliary_table(path, &fields)?.unwrap_or_default();
        Ok(Some(Declared { layers: vec![layers] }))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = &header_of(file.path).unwrap_or_else(|| file.path.into());
        let fields = read(path)?;
        let wrong = |problem: String| Error::volume(path, problem);
        if fields.is_cifti() {
            return Err(wrong(CIFTI.into()));
        }
        let (scalar, inside) = scalar(fields.datatype()).ok_or_else(|| {
            let code = fields.datatype();
            if COMPLEX_TYPES.contains(&code) {
                return wrong(format!("its datatype is {code}: {COMPLEX}"));
            }
            wrong(format!("its datatype is {code}: expected whole numbers, floats of 32 or 64 bits, or colours; convert it"))
        })?;
        let sizes = sizes(&fields, scalar.bytes() * inside).map_err(wrong)?;
        let dims = [sizes[0], sizes[1], sizes[2]];
        let (to_world, is_anatomical) = (place::index_to_world(path, &fields, dims), place::is_anatomical(&fields));
        let grid = load::grid_of_patient(path, dims, to_world, is_anatomical, options)?;
        let frames = sizes[3];
        let mut contents = Contents::default();
        let frame = contents.choose_frame(path, options, frames)?;
        contents.frame_spacing = fields.time_spacing();
        contents.length_unit = fields.length_unit().map(Into::into);
        let outside: usize = sizes[4..].iter().product();
        let channels = inside * outside;
        contents.are_colors = inside > 2 && outside == 1;
        // Components of a voxel are either side by side or in volumes of their own.
        let channel = match inside.min(outside) {
            1 => contents.choose_component(path, options, channels, fields.is_vector())?,
            _ => contents.choose_channel(path, options, channels)?,
        };
        let rescale = match fields.rescale() {
            Some((slope, intercept)) => Rescale::new(slope, intercept).map_err(|e| wrong(e.to_string()))?,
            None => Rescale::default(),
        };
        let header = Header { endian: fields.endian(), rescale, ..Header::new(grid, scalar) };
        let header = header.with_channels_inside(channel % inside, inside).with_frame(frame + frames * (channel / inside));
        let each = header.strides[2].saturating_mul(dims[2] as u64).saturating_mul(frames as u64);
        let header = header.with_contents(contents).with_magnitude(if inside > 1 { scalar.bytes() as u64 } else { each });
        Ok(Opened { header, bytes: voxels(path, &fields)?, exact: false })
    }
}

/// The table of labels beside a header that names it. Programs write other text in that field, too.
fn auxiliary_table(path: &Path, fields: &Fields) -> Result<Option<LabelTable>, Error> {
    let name = fields.auxiliary_file();
    let table = path.with_file_name(&name);
    let is_name = !name.is_empty() && Path::new(&name).components().count() == 1;
    if !is_name || !table.is_file() {
        return Ok(None);
    }
    tracing::info!("{}: names of labels from {}", path.display(), table.display());
    LabelTable::open(table).map(Some)
}

/// What is wrong with CIFTI.
const CIFTI: &str = "it is CIFTI, whose values belong to points of brain surfaces and to some voxels: write its voxels to a volume \
                     (wb_command -cifti-separate IN COLUMN -volume-all OUT.nii)";
/// Codes of complex numbers of two floats of 32, 64 and 128 bits.
const COMPLEX_TYPES: [i16; 3] = [32, 1792, 2048];

/// Whether it has the mark, packed or not.
fn is_header(file: &Found) -> bool {
    Fields::new(file.unpacked.clone().unwrap_or_else(|| file.start.clone())).is_some()
}

/// Header file of a pair, given its voxel file.
fn header_of(path: &Path) -> Option<PathBuf> {
    let others = other_of_pair(path, ".img", ".hdr")?;
    others.into_iter().find(|other| Found::look(other).is_ok_and(|found| is_header(&found)))
}

/// Candidate names of the other file of a pair; the one with the same case and compression first.
fn other_of_pair(path: &Path, ending: &str, other: &str) -> Option<[PathBuf; 2]> {
    let name = path.file_name()?.to_str()?;
    let (stem, packed) = name.strip_suffix(".gz").map_or((name, false), |stem| (stem, true));
    let (plain, gz) = match stem.strip_suffix(ending) {
        Some(stem) => (format!("{stem}{other}"), format!("{stem}{other}.gz")),
        None => {
            let (ending, other) = (ending.to_ascii_uppercase(), other.to_ascii_uppercase());
            let stem = stem.strip_suffix(&ending)?;
            (format!("{stem}{other}"), format!("{stem}{other}.gz"))
        }
    };
    let names = if packed { [gz, plain] } else { [plain, gz] };
    Some(names.map(|name| path.with_file_name(name)))
}

/// Reads the header of a plain or gzipped file.
fn read(path: &Path) -> Result<Fields, Error> {
    let failed = |e| Error::read(path, e);
    let mut start = vec![0; header::LARGEST];
    let mut file = File::open(path).map_err(failed)?;
    let found = if Found::look(path)?.unpacked.is_some() {
        bytes::fill(&mut Gzip::unpack(BufReader::new(file)), &mut start)
    } else {
        bytes::fill(&mut file, &mut start)
    };
    start.truncate(found.map_err(failed)?);
    Fields::new(start).ok_or_else(|| Error::volume(path, "its header is truncated or damaged"))
}

/// Scalar type of a datatype code, and numbers per voxel.
fn scalar(code: i16) -> Option<(ScalarType, usize)> {
    Some(match code {
        2 => (ScalarType::Uint8, 1),
        4 => (ScalarType::Int16, 1),
        8 => (ScalarType::Int32, 1),
        16 => (ScalarType::Float32, 1),
        64 => (ScalarType::Float64, 1),
        128 => (ScalarType::Uint8, 3),
        256 => (ScalarType::Int8, 1),
        512 => (ScalarType::Uint16, 1),
        768 => (ScalarType::Uint32, 1),
        1024 => (ScalarType::Int64, 1),
        1280 => (ScalarType::Uint64, 1),
        2304 => (ScalarType::Uint8, 4),
        _ => return None,
    })
}

/// Sizes along x, y, z, time and three more axes; 1 along missing axes.
fn sizes(fields: &Fields, bytes: usize) -> Result<[usize; 7], String> {
    let [axes, sizes @ ..] = fields.dims();
    let known = usize::try_from(axes).ok().filter(|n| (1..=7).contains(n));
    let known = known.ok_or_else(|| format!("it has {axes} axes: expected 1 to 7"))?;
    let size = |i: usize| if i < known { usize::try_from(sizes[i]).unwrap_or(0) } else { 1 };
    let found = [0, 1, 2, 3, 4, 5, 6].map(size);
    let all = found.iter().try_fold(bytes as u64, |n, &size| n.checked_mul(size as u64).filter(|&n| n > 0));
    all.map(|_| found).ok_or_else(|| format!("its sizes {:?} are empty or too large", &sizes[..known]))
}

/// Voxel data: after the header, or in the other file of a pair.
fn voxels(path: &Path, fields: &Fields) -> Result<Box<dyn Bytes>, Error> {
    let file = if fields.is_of_a_pair() {
        let others = other_of_pair(path, ".hdr", ".img").unwrap_or_default();
        let found = others.iter().find(|other| other.is_file()).cloned();
        found.ok_or_else(|| Error::volume(path, "its voxel file of the same name with the extension .img is missing"))?
    } else {
        path.to_owned()
    };
    let first = fields.first().ok_or_else(|| Error::volume(path, "its vox_offset is invalid"))?;
    let failed = |e| Error::read(&file, e);
    if Found::look(&file)?.unpacked.is_some() {
        Ok(Box::new(Packed::<Gzip>::new(&file, 0, first).map_err(failed)?))
    } else {
        Ok(Box::new(Plain::new(File::open(&file).map_err(failed)?, first).map_err(failed)?))
    }
}
