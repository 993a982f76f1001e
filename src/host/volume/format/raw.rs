//! Raw files `NAME_XxYxZ_TYPE.raw` and `.raw.gz`, named as in the Open SciVis Datasets.

use super::bytes::{Bytes, Gzip, Packed, Plain};
use super::load::{Header, Opened};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::{Contents, ScalarType};
use std::fs::File;
use std::path::Path;

/// Raw files.
pub(super) struct Raw;

impl Format for Raw {
    fn recognises(&self, file: &Found, options: &OpenOptions) -> bool {
        !file.folder && (stem(file.path).is_some() || (options.dims.is_some() && options.voxel_type.is_some()))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let named = stem(path);
        let (named_dims, named_type) = named.as_ref().map_or((None, None), |(stem, _)| parse_name(stem));
        let zipped = named.is_some_and(|(_, zipped)| zipped);
        let unnamed = |field, problem: &str| Error::Unnamed { path: path.into(), field, problem: problem.into() };
        let dims = options.dims.or(named_dims);
        let dims = dims.ok_or_else(|| unnamed("dims", "the name has no dimensions"))?;
        let scalar = match (options.voxel_type, named_type) {
            (Some(t), _) => t,
            (None, Some(Ok(t))) => t,
            (None, Some(Err(e))) => return Err(unnamed("voxel_type", &e)),
            (None, None) => return Err(unnamed("voxel_type", "the name has no voxel type")),
        };
        let grid = options.grid(dims).map_err(|e| match (options.dims, &e) {
            (None, Error::OutOfRange { name: "dims", .. }) => unnamed("dims", &e.to_string()),
            _ => e,
        })?;
        // `first` is part of the header, so that the exact size check includes it.
        let first = options.header_bytes.unwrap_or(0);
        let contents = Contents { states_spacing: false, ..Contents::default() };
        let header = Header { endian: options.endian.unwrap_or_default(), first, contents, ..Header::new(grid, scalar) };
        let failed = |e| Error::read(path, e);
        let bytes: Box<dyn Bytes> = if zipped {
            Box::new(Packed::<Gzip>::new(path, 0, 0).map_err(failed)?)
        } else {
            Box::new(Plain::new(File::open(path).map_err(failed)?, 0).map_err(failed)?)
        };
        Ok(Opened { header, bytes, exact: true })
    }
}

/// Dimensions and type encoded in the name of a raw file.
pub(in crate::volume) fn told_by_name(path: &Path) -> OpenOptions {
    let (dims, voxel_type) = stem(path).map_or((None, None), |(stem, _)| parse_name(&stem));
    OpenOptions { dims, voxel_type: voxel_type.and_then(Result::ok), ..OpenOptions::default() }
}

/// File name without `.raw` or `.raw.gz` (any case), and whether it ended in `.gz`.
fn stem(path: &Path) -> Option<(String, bool)> {
    let name = path.file_name()?.to_string_lossy();
    let without = |name: &str, ending: &str| {
        let at = name.len().checked_sub(ending.len()).filter(|&at| name.is_char_boundary(at))?;
        name[at..].eq_ignore_ascii_case(ending).then(|| name[..at].to_owned())
    };
    let unzipped = without(&name, ".gz");
    Some((without(unzipped.as_deref().unwrap_or(&name), ".raw")?, unzipped.is_some()))
}

/// Parses the dimensions and the type in `NAME_XxYxZ_TYPE`, ignoring case.
fn parse_name(stem: &str) -> (Option<[usize; 3]>, Option<Result<ScalarType, String>>) {
    let stem = stem.to_ascii_lowercase();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_dims_and_type() {
        assert_eq!(parse_name("engine_256x256x128_uint8"), (Some([256, 256, 128]), Some(Ok(ScalarType::Uint8))));
        assert_eq!(parse_name("a_b_1x2x3_4x5x6_int16"), (Some([4, 5, 6]), Some(Ok(ScalarType::Int16))));
        assert_eq!(parse_name("a_4x5x6"), (Some([4, 5, 6]), None));
        assert!(matches!(parse_name("a_4x5x6_rgb"), (Some(_), Some(Err(_)))));
        assert_eq!(parse_name("4x5"), (None, None));
        assert_eq!(parse_name("a_99999999999999999999x1x1_uint8"), (None, None));
    }

    #[test]
    fn endings_are_of_any_case() {
        let stem = |name: &str| stem(Path::new(name));
        assert_eq!(stem("folder/a_1x2x3_uint8.raw"), Some(("a_1x2x3_uint8".into(), false)));
        assert_eq!(stem("A_1x2x3_uint8.RAW.Gz"), Some(("A_1x2x3_uint8".into(), true)));
        assert_eq!((stem("a.raw.txt"), stem("raw"), stem("é")), (None, None, None));
    }
}
