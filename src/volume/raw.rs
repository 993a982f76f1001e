//! Raw volumes, `NAME_XxYxZ_TYPE.raw` and `.raw.gz` (the naming of the Open SciVis Datasets).

use super::{Grid, Volume, VoxelType, Voxels};
use crate::error::Error;
use flate2::read::MultiGzDecoder;
use glam::DVec3;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Byte order of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

/// What a raw file's name does not tell, or tells wrongly; what is given here wins. Spacing defaults to 1,1,1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawOptions {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Voxel type.
    pub voxel_type: Option<VoxelType>,
    /// World distance between voxels along x, y, z.
    pub spacing: Option<DVec3>,
    /// Byte order.
    pub endian: Endian,
}

impl RawOptions {
    /// The grid of `dims` with the wanted spacing.
    pub(super) fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        Grid::new(dims, self.spacing.unwrap_or(DVec3::ONE))
    }
}

/// Reads a raw volume.
pub(super) fn read(path: &Path, options: &RawOptions) -> Result<Volume, Error> {
    let metadata = std::fs::metadata(path).map_err(|e| Error::read(path, e))?;
    if !metadata.is_file() {
        return Err(Error::read(path, io::Error::other("not a regular file")));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let lower = name.to_ascii_lowercase();
    let zipped = lower.ends_with(".gz");
    let stem = lower.strip_suffix(".gz").unwrap_or(&lower);
    let Some(stem) = stem.strip_suffix(".raw") else {
        return Err(Error::volume(path, "unknown format: volumes are .raw or .raw.gz files, or builtin:NAME"));
    };
    let (named_dims, named_type) = parse_name(stem);
    let dims = options.dims.or(named_dims).ok_or_else(|| {
        Error::volume(path, "the name does not tell the dimensions: name it NAME_XxYxZ_TYPE.raw, or give --dims XxYxZ")
    })?;
    let voxel_type = match (options.voxel_type, named_type) {
        (Some(t), _) => t,
        (None, Some(Ok(t))) => t,
        (None, Some(Err(e))) => return Err(Error::volume(path, format!("{e}, or give --type"))),
        (None, None) => {
            let problem = "the name does not tell the voxel type: name it NAME_XxYxZ_TYPE.raw, or give --type";
            return Err(Error::volume(path, problem));
        }
    };
    let grid = options.grid(dims).map_err(|e| match (options.dims, &e) {
        (None, Error::OutOfRange { name: "dims", .. }) => Error::volume(path, format!("{e}: rename it, or give --dims")),
        _ => e,
    })?;
    let expected = grid.voxel_count() as u64 * voxel_type.bytes() as u64;
    let size = |found: String| Error::FileSize { path: path.into(), dims, voxel_type: voxel_type.to_string(), expected, found };
    if !zipped && metadata.len() != expected {
        return Err(size(metadata.len().to_string()));
    }
    // A gzip stream cannot pack better than 1032:1, so an absurd size is refused before anything is allocated.
    if zipped && expected / 1032 > metadata.len() {
        return Err(size(format!("at most {}", metadata.len().saturating_mul(1032))));
    }
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let reader: Box<dyn Read> = if zipped { Box::new(MultiGzDecoder::new(file)) } else { Box::new(file) };
    let mut bytes = Vec::new();
    // One byte more than expected tells a longer file from a fitting one.
    let found = reader.take(expected + 1).read_to_end(&mut bytes).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => {
            Error::volume(path, format!("the gzip data ends, truncated or damaged, after {} of {expected} bytes", bytes.len()))
        }
        _ => Error::read(path, e),
    })? as u64;
    if found != expected {
        return Err(size(if found > expected { format!("more than {expected}") } else { found.to_string() }));
    }
    Volume::new(name, grid, decode(bytes, voxel_type, options.endian))
}

/// Dimensions and type from `NAME_XxYxZ_TYPE`, as far as it tells them.
fn parse_name(stem: &str) -> (Option<[usize; 3]>, Option<Result<VoxelType, String>>) {
    let parts: Vec<&str> = stem.split('_').collect();
    let found = parts.iter().rposition(|part| parse_dims(part).is_some());
    match found {
        Some(i) => (parse_dims(parts[i]), parts.get(i + 1).map(|t| t.parse())),
        None => (None, None),
    }
}

/// `XxYxZ`.
fn parse_dims(text: &str) -> Option<[usize; 3]> {
    let numbers: Vec<usize> = text.split('x').map(|n| n.parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

fn decode(bytes: Vec<u8>, voxel_type: VoxelType, endian: Endian) -> Voxels {
    fn values<const N: usize, T>(bytes: &[u8], endian: Endian, from_le: fn([u8; N]) -> T) -> Vec<T> {
        let (words, _) = bytes.as_chunks::<N>();
        words
            .iter()
            .map(|word| {
                let mut word = *word;
                if endian == Endian::Big {
                    word.reverse();
                }
                from_le(word)
            })
            .collect()
    }
    match voxel_type {
        VoxelType::Uint8 => Voxels::Uint8(bytes),
        VoxelType::Int8 => Voxels::Int8(bytes.into_iter().map(|b| b.cast_signed()).collect()),
        VoxelType::Uint16 => Voxels::Uint16(values(&bytes, endian, u16::from_le_bytes)),
        VoxelType::Int16 => Voxels::Int16(values(&bytes, endian, i16::from_le_bytes)),
        VoxelType::Float32 => Voxels::Float32(values(&bytes, endian, f32::from_le_bytes)),
        VoxelType::Float64 => Voxels::Float32(values(&bytes, endian, |b| f64::from_le_bytes(b) as f32)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_dims_and_type() {
        assert_eq!(parse_name("engine_256x256x128_uint8"), (Some([256, 256, 128]), Some(Ok(VoxelType::Uint8))));
        assert_eq!(parse_name("a_b_1x2x3_4x5x6_int16"), (Some([4, 5, 6]), Some(Ok(VoxelType::Int16))));
        assert_eq!(parse_name("a_4x5x6"), (Some([4, 5, 6]), None));
        assert!(matches!(parse_name("a_4x5x6_rgb"), (Some(_), Some(Err(_)))));
        assert_eq!(parse_name("4x5"), (None, None));
        assert_eq!(parse_name("a_99999999999999999999x1x1_uint8"), (None, None));
    }

    #[test]
    fn byte_orders() {
        assert_eq!(decode(vec![1, 2, 3, 4], VoxelType::Uint16, Endian::Little), Voxels::Uint16(vec![0x0201, 0x0403]));
        assert_eq!(decode(vec![1, 2, 3, 4], VoxelType::Uint16, Endian::Big), Voxels::Uint16(vec![0x0102, 0x0304]));
        let bytes = 1.5f64.to_be_bytes().to_vec();
        assert_eq!(decode(bytes, VoxelType::Float64, Endian::Big), Voxels::Float32(vec![1.5]));
    }
}
