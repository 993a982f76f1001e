//! File formats: one file each, behind one small trait.

mod raw;

pub use raw::RawOptions;

use super::voxels::{Endian, ScalarType};
use super::{Grid, Rescale, Storage, Volume, wide};
use crate::error::Error;
use crate::memory;
use memmap2::MmapOptions;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

/// All formats; the first that recognises a file reads it. Raw files have no mark and come last.
const FORMATS: [&dyn Format; 1] = [&raw::Raw];
/// Bytes at the start of a file that formats are recognised by.
const START: u64 = 512;

/// A file format.
trait Format: Sync {
    /// Whether a file is in this format: by its first bytes, or by its name where the format has no mark.
    fn recognises(&self, path: &Path, start: &[u8], options: &RawOptions) -> bool;

    /// Reads the header, and checks the file's size against it. Nothing is allocated for voxels yet.
    fn open(&self, path: &Path, options: &RawOptions) -> Result<Box<dyn VolumeFile>, Error>;
}

/// What a file says of its voxels.
struct Header {
    grid: Grid,
    scalar: ScalarType,
    endian: Endian,
    rescale: Rescale,
}

impl Header {
    /// Bytes of so many slices along z.
    fn slice_bytes(&self, slices: usize) -> usize {
        let [x, y, _] = self.grid.dims();
        x * y * slices * self.scalar.bytes()
    }
}

/// A volume file whose header was read.
trait VolumeFile {
    fn header(&self) -> &Header;

    /// The file that holds all voxels one after the other as they are, and the byte at which they begin, if one does.
    fn in_place(&self) -> Option<(&File, u64)>;

    /// Reads slices along z, in the file's type and byte order. Reading them in order takes one pass over the file.
    fn read(&mut self, slices: Range<usize>, bytes: &mut [u8]) -> Result<(), Error>;
}

/// Bytes that are read at a time.
const PIECE: usize = 1 << 24;

/// Opens a file of any format. Voxels of a device's type that lie in the file as they are are mapped, not read.
pub(super) fn read(path: &Path, options: &RawOptions) -> Result<Volume<'static>, Error> {
    let metadata = std::fs::metadata(path).map_err(|e| Error::read(path, e))?;
    if !metadata.is_file() {
        return Err(Error::read(path, io::Error::other("not a regular file")));
    }
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(START).read_to_end(&mut start));
    read.map_err(|e| Error::read(path, e))?;
    let Some(format) = FORMATS.iter().find(|format| format.recognises(path, &start, options)) else {
        return Err(Error::volume(path, "unknown format: volumes are .raw or .raw.gz files, or builtin:NAME"));
    };
    let mut file = format.open(path, options)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Header { grid, scalar, endian, rescale } = file.header();
    let (grid, scalar, endian, rescale) = (grid.clone(), *scalar, *endian, *rescale);
    let voxels = grid.voxel_count() as u64;
    match scalar.voxel_type() {
        Some(voxel_type) => {
            memory::require(&name, voxels * voxel_type.bytes() as u64)?;
            let storage = match mapped(path, file.as_ref())? {
                Some(map) => Storage::from_bytes(map, voxel_type),
                None => Storage::from_bytes(read_all(&name, file.as_mut())?, voxel_type),
            };
            Ok(Volume::new(name, grid, storage.with_endian(endian))?.with_rescale(rescale))
        }
        None => match mapped(path, file.as_ref())? {
            Some(map) => wide::volume(name, grid, wide::Numbers { bytes: &map, scalar, endian }, rescale),
            None => {
                // Beside the converted voxels.
                memory::require(&name, voxels * scalar.bytes() as u64)?;
                let bytes = read_all(&name, file.as_mut())?;
                wide::volume(name, grid, wide::Numbers { bytes: &bytes, scalar, endian }, rescale)
            }
        },
    }
}

/// All voxels of a file that holds them as they are, mapped.
fn mapped(path: &Path, file: &dyn VolumeFile) -> Result<Option<memmap2::Mmap>, Error> {
    let Some((mapped, first)) = file.in_place() else { return Ok(None) };
    let len = file.header().slice_bytes(file.header().grid.dims()[2]);
    // SAFETY: bytes are plain data, whatever they change to; that a file must not be cut short while it is mapped is said in
    // `Volume::open`'s documentation.
    unsafe { MmapOptions::new().offset(first).len(len).map(mapped) }.map(Some).map_err(|e| Error::read(path, e))
}

/// All voxels of a file, read piece by piece.
fn read_all(name: &str, file: &mut dyn VolumeFile) -> Result<Vec<u8>, Error> {
    let slices = file.header().grid.dims()[2];
    let slice = file.header().slice_bytes(1);
    let mut bytes = memory::zeroed(name, slice * slices)?;
    let at_a_time = (PIECE / slice).max(1);
    for first in (0..slices).step_by(at_a_time) {
        let range = first..(first + at_a_time).min(slices);
        let place = range.start * slice..range.end * slice;
        file.read(range, &mut bytes[place])?;
    }
    Ok(bytes)
}
