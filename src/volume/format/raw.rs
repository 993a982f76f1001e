//! Raw volumes, `NAME_XxYxZ_TYPE.raw` and `.raw.gz` (the naming of the Open SciVis Datasets).

use super::{Format, Header, VolumeFile};
use crate::error::Error;
use crate::volume::{Endian, Grid, Rescale, ScalarType};
use flate2::read::MultiGzDecoder;
use glam::DVec3;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What a raw file's name does not tell, or tells wrongly; what is given here wins. Spacing defaults to 1,1,1.
///
/// ```
/// use layersplat::volume::{RawOptions, ScalarType, Volume};
/// # let folder = tempfile::tempdir().expect("a folder");
/// # let path = folder.path().join("bonsai.raw");
/// # std::fs::write(&path, [0u8; 24]).expect("a file");
///
/// let options = RawOptions { dims: Some([4, 3, 2]), voxel_type: Some(ScalarType::Uint8), ..RawOptions::default() };
/// let volume = Volume::open(&path, &options)?;
/// assert_eq!(volume.grid().dims(), [4, 3, 2]);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawOptions {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Type of the numbers.
    pub voxel_type: Option<ScalarType>,
    /// World distance between voxels along x, y, z.
    pub spacing: Option<DVec3>,
    /// Byte order; little if it is not given.
    pub endian: Option<Endian>,
    /// Bytes before the first voxel, of a gzip file once unpacked; 0 if not given.
    pub header_bytes: Option<u64>,
}

impl RawOptions {
    /// The grid of `dims` with the wanted spacing.
    pub(in crate::volume) fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        Grid::new(dims, self.spacing.unwrap_or(DVec3::ONE))
    }
}

/// The format.
pub(super) struct Raw;

impl Format for Raw {
    fn recognises(&self, path: &Path, _start: &[u8], options: &RawOptions) -> bool {
        stem(path).is_some() || (options.dims.is_some() && options.voxel_type.is_some())
    }

    fn open(&self, path: &Path, options: &RawOptions) -> Result<Box<dyn VolumeFile>, Error> {
        let named = stem(path);
        let (named_dims, named_type) = named.as_ref().map_or((None, None), |(stem, _)| parse_name(stem));
        let zipped = named.is_some_and(|(_, zipped)| zipped);
        let unnamed = |field, problem: &str| Error::Unnamed { path: path.into(), field, problem: problem.into() };
        let dims = options.dims.or(named_dims);
        let dims = dims.ok_or_else(|| unnamed("dims", "the name does not tell the dimensions"))?;
        let scalar = match (options.voxel_type, named_type) {
            (Some(t), _) => t,
            (None, Some(Ok(t))) => t,
            (None, Some(Err(e))) => return Err(unnamed("voxel_type", &e)),
            (None, None) => return Err(unnamed("voxel_type", "the name does not tell the voxel type")),
        };
        let grid = options.grid(dims).map_err(|e| match (options.dims, &e) {
            (None, Error::OutOfRange { name: "dims", .. }) => unnamed("dims", &e.to_string()),
            _ => e,
        })?;
        let header = Header { grid, scalar, endian: options.endian.unwrap_or_default(), rescale: Rescale::default() };
        let first = options.header_bytes.unwrap_or(0);
        let bytes = header.grid.voxel_count() as u64 * scalar.bytes() as u64;
        let expected = first.saturating_add(bytes);
        let open = || File::open(path).map_err(|e| Error::read(path, e));
        let file = open()?;
        let len = file.metadata().map_err(|e| Error::read(path, e))?.len();
        let wrong_size = WrongSize { path: path.into(), dims, scalar, expected };
        if !zipped {
            let fits = len == expected;
            return if fits {
                Ok(Box::new(Plain { header, file, first, path: path.into() }))
            } else {
                Err(wrong_size.found(len))
            };
        }
        // A gzip stream cannot pack better than 1032:1, so an absurd size is refused before anything is allocated.
        if expected / GZIP_LIMIT > len {
            return Err(wrong_size.found(format!("at most {}", len.saturating_mul(GZIP_LIMIT))));
        }
        let mut zipped = Zipped { header, unpacked: MultiGzDecoder::new(file), first, position: 0, wrong_size };
        zipped.skip(first)?;
        Ok(Box::new(zipped))
    }
}

/// Bytes that a byte of a gzip stream can stand for.
const GZIP_LIMIT: u64 = 1032;

/// A file name without `.raw` or `.raw.gz`, in any case, and whether it ended in `.gz`.
fn stem(path: &Path) -> Option<(String, bool)> {
    let name = path.file_name()?.to_string_lossy();
    let without = |name: &str, ending: &str| {
        let at = name.len().checked_sub(ending.len()).filter(|&at| name.is_char_boundary(at))?;
        name[at..].eq_ignore_ascii_case(ending).then(|| name[..at].to_owned())
    };
    let unzipped = without(&name, ".gz");
    Some((without(unzipped.as_deref().unwrap_or(&name), ".raw")?, unzipped.is_some()))
}

/// A file that is not as long as it should be.
struct WrongSize {
    path: PathBuf,
    dims: [usize; 3],
    scalar: ScalarType,
    expected: u64,
}

impl WrongSize {
    fn found(&self, found: impl ToString) -> Error {
        let Self { path, dims, scalar, expected } = self;
        Error::FileSize {
            path: path.clone(),
            dims: *dims,
            scalar: scalar.to_string(),
            expected: *expected,
            found: found.to_string(),
        }
    }
}

/// A file of voxels as they are.
struct Plain {
    header: Header,
    file: File,
    first: u64,
    path: PathBuf,
}

impl VolumeFile for Plain {
    fn header(&self) -> &Header {
        &self.header
    }

    fn in_place(&self) -> Option<(&File, u64)> {
        Some((&self.file, self.first))
    }

    fn read(&mut self, slices: Range<usize>, bytes: &mut [u8]) -> Result<(), Error> {
        let at = self.first + self.header.slice_bytes(slices.start) as u64;
        let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(bytes));
        read.map_err(|e| Error::read(&self.path, e))
    }
}

/// A packed one.
struct Zipped {
    header: Header,
    unpacked: MultiGzDecoder<File>,
    first: u64,
    /// Bytes that were unpacked.
    position: u64,
    wrong_size: WrongSize,
}

impl Zipped {
    /// What a failed read means.
    fn failed(&self, e: io::Error) -> Error {
        let path = &self.wrong_size.path;
        match e.kind() {
            io::ErrorKind::UnexpectedEof => {
                let (position, expected) = (self.position, self.wrong_size.expected);
                let problem = format!("the gzip data ends, truncated or damaged, after {position} of {expected} bytes");
                Error::volume(path, problem)
            }
            _ => Error::read(path, e),
        }
    }

    /// Unpacks into `bytes`.
    fn fill(&mut self, mut bytes: &mut [u8]) -> Result<(), Error> {
        while !bytes.is_empty() {
            match self.unpacked.read(bytes) {
                Ok(0) => return Err(self.wrong_size.found(self.position)),
                Ok(n) => {
                    self.position += n as u64;
                    bytes = &mut bytes[n..];
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.failed(e)),
            }
        }
        Ok(())
    }

    /// Unpacks and forgets.
    fn skip(&mut self, bytes: u64) -> Result<(), Error> {
        let mut piece = [0; 1 << 14];
        let mut left = bytes;
        while left > 0 {
            let now = left.min(piece.len() as u64);
            self.fill(&mut piece[..now as usize])?;
            left -= now;
        }
        Ok(())
    }
}

impl VolumeFile for Zipped {
    fn header(&self) -> &Header {
        &self.header
    }

    fn in_place(&self) -> Option<(&File, u64)> {
        None
    }

    fn read(&mut self, slices: Range<usize>, bytes: &mut [u8]) -> Result<(), Error> {
        let at = self.first + self.header.slice_bytes(slices.start) as u64;
        if at < self.position {
            let path = &self.wrong_size.path;
            self.unpacked = MultiGzDecoder::new(File::open(path).map_err(|e| Error::read(path, e))?);
            self.position = 0;
        }
        self.skip(at - self.position)?;
        self.fill(bytes)?;
        if self.position == self.wrong_size.expected {
            // What comes after tells a longer file from a fitting one, and a damaged one by its check sum.
            match self.unpacked.read(&mut [0]) {
                Ok(0) => {}
                Ok(_) => return Err(self.wrong_size.found(format!("more than {}", self.position))),
                Err(e) => return Err(self.failed(e)),
            }
        }
        Ok(())
    }
}

/// Dimensions and type from `NAME_XxYxZ_TYPE`, in letters of any case, as far as it tells them.
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

    /// Slices in any order, from a plain and a packed file, with and without a header.
    #[test]
    fn ranges_of_slices() {
        use std::io::Write;
        let folder = tempfile::tempdir().unwrap();
        let bytes: Vec<u8> = (0..7 + 3 * 4 * 50).map(|i| (i * 7 % 251) as u8).collect();
        for name in ["a_3x2x50_uint16.raw", "a_3x2x50_uint16.raw.gz"] {
            let path = folder.path().join(name);
            let mut file = File::create(&path).unwrap();
            if name.ends_with("gz") {
                let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
                packed.write_all(&bytes).unwrap();
                packed.finish().unwrap();
            } else {
                file.write_all(&bytes).unwrap();
            }
            let options = RawOptions { header_bytes: Some(7), ..Default::default() };
            let mut file = Raw.open(&path, &options).unwrap();
            for range in [0..1, 1..4, 4..50, 30..31, 10..50, 0..50] {
                let mut slices = vec![0; 12 * range.len()];
                file.read(range.clone(), &mut slices).unwrap();
                assert_eq!(slices, bytes[7 + 12 * range.start..7 + 12 * range.end], "{name}, {range:?}");
            }
            assert!(
                Raw.open(&path, &RawOptions::default()).is_err_and(|e| e.to_string().contains("header_bytes"))
                    || name.ends_with("gz")
            );
        }
    }
}
