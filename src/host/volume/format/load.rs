//! Creates a volume from a file whose header has been parsed.

use super::OpenOptions;
use super::bytes::{Bytes, Plain};
use super::magnitude::{self, Components};
use crate::error::Error;
use crate::files::temporary_failed;
use crate::memory;
use crate::progress::Task;
use crate::volume::missing_data::MissingData;
use crate::volume::spool::Spool;
use crate::volume::{Contents, Endian, Grid, Rescale, ScalarType, Storage, Volume, VoxelType, wide};
#[cfg(feature = "mpi")]
use crate::volume::{Layers, Unseen, unseen::WideNumbers};
use glam::{DAffine3, DMat3, DVec3};
use memmap2::{Mmap, MmapOptions};
use std::io;
use std::path::Path;

/// Layout of the voxel data, as the header declares it.
#[derive(Clone)]
pub(in crate::volume) struct Header {
    pub grid: Grid,
    pub scalar: ScalarType,
    pub endian: Endian,
    /// Mapping from stored numbers to values.
    pub rescale: Rescale,
    /// Which stored numbers stand for missing voxels.
    pub missing: MissingData,
    /// First byte of the first voxel, and strides in bytes along x, y, z, of the selected frame and channel.
    pub first: u64,
    pub strides: [u64; 3],
    /// The components whose magnitude is read; `None`: the channel at `first` alone.
    pub components: Option<Components>,
    /// What else the file holds.
    pub contents: Contents,
}

impl Header {
    /// Consecutive little-endian voxels, x fastest.
    pub fn new(grid: Grid, scalar: ScalarType) -> Self {
        let strides = dense(&grid, scalar);
        Self {
            grid,
            scalar,
            endian: Endian::Little,
            rescale: Rescale::default(),
            missing: MissingData::default(),
            first: 0,
            strides,
            components: None,
            contents: Contents::default(),
        }
    }

    pub fn with_contents(self, contents: Contents) -> Self {
        Self { contents, ..self }
    }

    /// Selects channel `at` of `channels` interleaved ones.
    pub fn with_channels_inside(mut self, at: usize, channels: usize) -> Self {
        self.first = self.first.saturating_add((at * self.scalar.bytes()) as u64);
        self.strides = self.strides.map(|stride| stride.saturating_mul(channels as u64));
        self
    }

    /// Reads the magnitude of all channels, `stride` bytes apart, if the contents say so.
    pub fn with_magnitude(self, stride: u64) -> Self {
        let count = self.contents.channels;
        Self { components: self.contents.magnitude.then_some(Components { stride, count }), ..self }
    }

    /// Selects one of several consecutive volumes.
    pub fn with_frame(mut self, frame: usize) -> Self {
        let [_, _, stride] = self.strides;
        let each = stride.saturating_mul(self.grid.dims()[2] as u64);
        self.first = self.first.saturating_add(each.saturating_mul(frame as u64));
        self
    }

    /// Bytes from the start of the first voxel to the end of the last.
    fn span(&self) -> u64 {
        self.span_of(self.grid.dims())
    }

    fn span_of(&self, dims: [usize; 3]) -> u64 {
        let last: u64 = (0..3).map(|i| self.strides[i].saturating_mul(dims[i] as u64 - 1)).fold(0, u64::saturating_add);
        let components = self.components.map_or(0, Components::extent);
        last.saturating_add(components).saturating_add(self.scalar.bytes() as u64)
    }

    fn is_dense(&self) -> bool {
        self.strides == dense(&self.grid, self.scalar)
    }

    /// Byte after the last voxel.
    pub fn end(&self) -> u64 {
        self.first.saturating_add(self.span())
    }
}

/// Grid of a file with the transform `index_to_world`. A spacing in `options` replaces the transform and puts the origin at 0.
pub(super) fn grid(path: &Path, dims: [usize; 3], index_to_world: DAffine3, options: &OpenOptions) -> Result<Grid, Error> {
    match options.spacing {
        Some(spacing) => Grid::new(dims, spacing).map_err(|e| Error::volume(path, e.to_string())),
        None => placed(path, dims, index_to_world),
    }
}

/// Largest growth of the number of voxels by resampling. A gantry tilted by 45 degrees at most triples them; damaged transforms exceed it.
const MOST_GROWTH: usize = 16;

/// Grid of the transform `index_to_world`, of which a small shear is rounded.
pub(super) fn placed(path: &Path, dims: [usize; 3], index_to_world: DAffine3) -> Result<Grid, Error> {
    let placed = Grid::from_nearly_orthogonal(dims, index_to_world);
    let (grid, shear) = placed.map_err(|e| match Grid::covering(dims, index_to_world) {
        Ok(covering) if covering.voxel_count() / MOST_GROWTH <= dims.map(|n| n + 2).iter().product() => {
            let (path, problem) = (path.into(), e.to_string());
            Error::Sheared { path, problem, index_to_world: Box::new(index_to_world), has_anatomy: false }
        }
        _ => Error::volume(path, e.to_string()),
    })?;
    if let Some(degrees) = shear {
        tracing::warn!("{}: its axes are sheared by {degrees:.3} degrees: they are taken as orthogonal", path.display());
    }
    Ok(grid)
}

/// As [`grid`], for a transform to a patient's coordinates (RAS) if `is_anatomical`. A spacing in `options` replaces these, too.
pub(super) fn grid_of_patient(
    path: &Path,
    dims: [usize; 3],
    index_to_world: DAffine3,
    is_anatomical: bool,
    options: &OpenOptions,
) -> Result<Grid, Error> {
    match grid(path, dims, index_to_world, options) {
        Ok(grid) if is_anatomical && options.spacing.is_none() => Ok(grid.with_anatomy()),
        Err(Error::Sheared { path, problem, index_to_world, .. }) => {
            Err(Error::Sheared { path, problem, index_to_world, has_anatomy: is_anatomical })
        }
        found => found,
    }
}

/// Axis-aligned transform with the first voxel at `origin`.
pub(super) fn upright(spacing: DVec3, origin: DVec3) -> DAffine3 {
    DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: origin }
}

fn dense(grid: &Grid, scalar: ScalarType) -> [u64; 3] {
    let ([x, y, _], size) = (grid.dims().map(|n| n as u64), scalar.bytes() as u64);
    [size, size.saturating_mul(x), size.saturating_mul(x).saturating_mul(y)]
}

/// A file whose header has been parsed.
pub(super) struct Opened {
    pub header: Header,
    pub bytes: Box<dyn Bytes>,
    /// Whether additional bytes are an error. Set for raw files, whose size is known from the name or the options only.
    pub exact: bool,
}

/// Bytes read at a time.
const PIECE: u64 = 1 << 24;

/// The header of a file that is large enough for the voxels that it declares.
pub(super) fn header(path: &Path, opened: Opened) -> Result<Header, Error> {
    let file = Reading::new(path, opened);
    file.check_size()?;
    Ok(file.opened.header)
}

/// Creates the volume of a file. Uncompressed voxels of a device type are memory-mapped. If others take more than `most` bytes, they are
/// decompressed into a temporary file.
pub(super) fn volume(path: &Path, opened: Opened, most: Option<u64>) -> Result<Volume<'static>, Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut file = Reading::new(path, opened);
    file.check_size()?;
    if most.is_some_and(|most| file.opened.header.span() > most) && file.opened.bytes.in_place().is_none() {
        file.spool(&name)?;
    }
    let Header { ref grid, scalar, endian, rescale, ref missing, .. } = file.opened.header;
    let (grid, missing, contents) = (grid.clone(), missing.clone(), file.opened.header.contents.clone());
    let volume = match scalar.voxel_type() {
        _ if file.opened.header.components.is_some() => {
            let storage = file.magnitudes(&name)?;
            Volume::new(name, grid, storage)?
        }
        Some(voxel_type) if missing.declared().is_none() => {
            let storage = file.storage(voxel_type, &name, Reading::gathered)?;
            Volume::of_file(name, grid, storage, rescale, most)?
        }
        voxel_type => {
            let bytes = file.dense(&name, Reading::gathered)?;
            let numbers = wide::Numbers { bytes: (*bytes).as_ref(), scalar, endian, missing: missing.declared() };
            match voxel_type.filter(|_| !numbers.has_missing()) {
                Some(voxel_type) => {
                    let storage = Storage::from_shared_bytes(bytes.into(), voxel_type).with_endian(endian);
                    Volume::of_file(name, grid, storage, rescale, most)?
                }
                None => wide::volume(name, grid, numbers, rescale, most)?,
            }
        }
    };
    Ok(volume.with_contents(contents))
}

/// Reads a range of z layers of a file and no other voxels.
///
/// # Errors
/// If the format does not support random access.
#[cfg(feature = "mpi")]
pub(super) fn layers(path: &Path, opened: Opened, choose: &dyn Fn([usize; 3]) -> Layers) -> Result<Unseen<'static>, Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if !opened.bytes.reads_anywhere() {
        let problem = "its voxels are compressed or stored as text, so that every process would have to read all of them: \
                       convert it to an uncompressed file (layersplat convert IN OUT.nrrd)";
        return Err(Error::volume(path, problem));
    }
    let mut file = Reading::new(path, opened);
    file.check_size()?;
    let Header { ref grid, scalar, endian, rescale, ref missing, .. } = file.opened.header;
    let missing = missing.declared().cloned();
    let (whole, layers) = (grid.clone(), choose(grid.dims()));
    // Restrict the header to the selected layers.
    let [x, y, _] = whole.dims();
    let header = &mut file.opened.header;
    header.first += header.strides[2] * layers.held.start as u64;
    header.grid = Grid::new([x, y, layers.held.len()], DVec3::ONE)?;
    if file.opened.header.components.is_some() {
        return Unseen::layers(name.clone(), whole, &layers, file.magnitudes(&name)?);
    }
    let unseen = match scalar.voxel_type().filter(|_| missing.is_none()) {
        Some(voxel_type) => Unseen::layers(name.clone(), whole, &layers, file.storage(voxel_type, &name, Reading::picked)?)?,
        None => {
            let bytes = file.dense(&name, Reading::picked)?;
            Unseen::wide(name.clone(), whole, &layers, WideNumbers { bytes, scalar, endian, missing })
        }
    };
    Ok(unseen.with_rescale(rescale))
}

/// Numbers without gaps, mapped or read.
type Dense = Box<dyn AsRef<[u8]> + Send + Sync>;

/// Header and stored numbers.
pub(in crate::volume) type Numbers = (Header, Dense);

/// All numbers of a file as stored, without gaps, and its header. If they cannot be mapped and take more than `most` bytes, they are
/// written to a temporary file, which is mapped. Magnitudes are float32.
pub(super) fn numbers(path: &Path, opened: Opened, most: Option<u64>) -> Result<Numbers, Error> {
    let mut file = Reading::new(path, opened);
    file.check_size()?;
    let name = path.display().to_string();
    if file.opened.header.components.is_some() {
        let storage = file.magnitudes(&name)?;
        let header = Header::new(file.opened.header.grid, ScalarType::Float32);
        let mut bytes = memory::zeroed(&name, header.grid.voxel_count() * size_of::<f32>())?;
        storage.copy(0, &mut bytes);
        return Ok((Header { endian: Endian::NATIVE, ..header }, Box::new(bytes)));
    }
    let bytes = file.opened.header.grid.voxel_count() as u64 * file.opened.header.scalar.bytes() as u64;
    let is_mapped = file.opened.header.is_dense() && file.opened.bytes.in_place().is_some();
    if most.is_some_and(|most| bytes > most) && !is_mapped {
        let mut spool = Spool::new(&name, bytes)?;
        file.pieces(&name, |piece| spool.put(piece))?;
        file.check_end(file.opened.header.end())?;
        return Ok((file.opened.header, Box::new(spool.mapped()?)));
    }
    let bytes = file.dense(&name, Reading::gathered)?;
    Ok((file.opened.header, bytes))
}

/// A read function: `picked` or `gathered`.
type Read<R> = fn(&mut R, &str) -> Result<Vec<u8>, Error>;

/// A file being read.
struct Reading<'a> {
    path: &'a Path,
    opened: Opened,
    task: Task,
}

impl<'a> Reading<'a> {
    fn new(path: &'a Path, opened: Opened) -> Self {
        let task = Task::new(format!("reading {}", path.display()), opened.header.span());
        Self { path, opened, task }
    }
}

impl Reading<'_> {
    /// Rejects files that are too small for the declared voxels, before anything is allocated.
    fn check_size(&self) -> Result<(), Error> {
        let Opened { header, bytes, exact } = &self.opened;
        let (end, most, in_place) = (header.end(), bytes.most(), bytes.in_place().is_some());
        if end > most || (*exact && in_place && end != most) {
            return Err(self.wrong_size(if in_place { most.to_string() } else { format!("at most {most}") }));
        }
        Ok(())
    }

    /// Maps the bytes of all voxels, if a file stores them uncompressed.
    fn mapped(&self) -> Result<Option<Mmap>, Error> {
        let Some((file, start)) = self.opened.bytes.in_place() else { return Ok(None) };
        let header = &self.opened.header;
        let len = usize::try_from(header.span()).map_err(|_| self.wrong_size("another number"))?;
        // SAFETY: bytes are plain data, so changes of the file are harmless. The documentation of `Volume::open` requires that the
        // file is not truncated while it is mapped.
        let map = unsafe { MmapOptions::new().offset(start + header.first).len(len).map(file) };
        map.map(Some).map_err(|e| match e.kind() {
            io::ErrorKind::OutOfMemory => {
                let what = self.path.display().to_string();
                Error::HostMemory { what, needed: len as u64, available: memory::available() }
            }
            _ => Error::read(self.path, e),
        })
    }

    /// Voxels of a device type: mapped in place if stored uncompressed, else read.
    fn storage(&mut self, voxel_type: VoxelType, name: &str, read: Read<Self>) -> Result<Storage<'static>, Error> {
        let (endian, strides) = (self.opened.header.endian, self.opened.header.strides);
        let storage = match self.mapped()? {
            Some(map) => {
                let strides = strides.map(|stride| isize::try_from(stride).unwrap_or(isize::MAX));
                debug_assert!(self.opened.header.first <= self.opened.bytes.most());
                Storage::from_bytes(map, voxel_type).with_strides(strides)
            }
            None => Storage::from_bytes(read(self, name)?, voxel_type),
        };
        Ok(storage.with_endian(endian))
    }

    /// Magnitudes of vectors, computed on access from components that are mapped if stored uncompressed, else read.
    fn magnitudes(&mut self, name: &str) -> Result<Storage<'static>, Error> {
        let bytes: magnitude::Source = match self.mapped()? {
            Some(map) => Box::new(map),
            None => Box::new(self.whole_span(name)?),
        };
        Ok(magnitude::storage(bytes, self.opened.header.clone()))
    }

    /// All bytes from the first number to the last.
    fn whole_span(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        let Header { first, .. } = self.opened.header;
        let span = usize::try_from(self.opened.header.span()).unwrap_or(usize::MAX);
        let mut bytes = memory::zeroed(name, span)?;
        for (n, piece) in bytes.chunks_mut(PIECE as usize).enumerate() {
            self.read(first + n as u64 * PIECE, piece)?;
        }
        self.check_end(self.opened.header.end())?;
        Ok(bytes)
    }

    /// All numbers without gaps: mapped if stored so, else read.
    fn dense(&mut self, name: &str, read: Read<Self>) -> Result<Dense, Error> {
        match self.mapped()?.filter(|_| self.opened.header.is_dense()) {
            Some(map) => Ok(Box::new(map)),
            None => Ok(Box::new(read(self, name)?)),
        }
    }

    /// Decompresses the bytes of all voxels into a temporary file with the same layout.
    fn spool(&mut self, name: &str) -> Result<(), Error> {
        let (first, span, end) = (self.opened.header.first, self.opened.header.span(), self.opened.header.end());
        let mut spool = Spool::new(name, span)?;
        let mut piece = memory::zeroed(name, span.min(PIECE) as usize)?;
        for at in (0..span).step_by(PIECE as usize) {
            let piece = &mut piece[..(span - at).min(PIECE) as usize];
            self.read(first + at, piece)?;
            spool.put(piece)?;
        }
        self.check_end(end)?;
        self.opened.bytes = Box::new(Plain::new(spool.finish(), 0).map_err(temporary_failed)?);
        self.opened.header.first = 0;
        Ok(())
    }

    /// Reads all numbers, and verifies the end of compressed data.
    fn gathered(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        let numbers = self.picked(name)?;
        self.check_end(self.opened.header.end())?;
        Ok(numbers)
    }

    /// Reads all numbers without gaps.
    fn picked(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        let Header { ref grid, scalar, first, .. } = self.opened.header;
        let mut numbers = memory::zeroed(name, grid.voxel_count() * scalar.bytes())?;
        if self.opened.header.is_dense() {
            for (n, piece) in numbers.chunks_mut(PIECE as usize).enumerate() {
                self.read(first + n as u64 * PIECE, piece)?;
            }
            return Ok(numbers);
        }
        let mut end = 0;
        self.pick(name, |slices| {
            numbers[end..end + slices.len()].copy_from_slice(slices);
            end += slices.len();
            Ok(())
        })?;
        Ok(numbers)
    }

    /// Passes on all numbers without gaps, in pieces.
    fn pieces(&mut self, name: &str, mut take: impl FnMut(&[u8]) -> Result<(), Error>) -> Result<(), Error> {
        if !self.opened.header.is_dense() {
            return self.pick(name, take);
        }
        let (first, span) = (self.opened.header.first, self.opened.header.span());
        let mut piece = memory::zeroed(name, span.min(PIECE) as usize)?;
        for at in (0..span).step_by(PIECE as usize) {
            let piece = &mut piece[..(span - at).min(PIECE) as usize];
            self.read(first + at, piece)?;
            take(piece)?;
        }
        Ok(())
    }

    /// Rejects extra data if the size must be exact, and damage that is only detected at the end of compressed data.
    fn check_end(&mut self, end: u64) -> Result<(), Error> {
        match self.opened.bytes.ends_at(end) {
            Ok(false) if self.opened.exact => Err(self.wrong_size(format!("more than {end}"))),
            Ok(_) => Ok(()),
            Err(e) => Err(self.failed(&e)),
        }
    }

    /// Passes on strided numbers: slice by slice, or all at once if slices interleave.
    fn pick(&mut self, name: &str, mut take: impl FnMut(&[u8]) -> Result<(), Error>) -> Result<(), Error> {
        let Header { ref grid, scalar, first, strides, .. } = self.opened.header;
        let (dims, size) = (grid.dims(), scalar.bytes());
        let slice_span = self.opened.header.span_of([dims[0], dims[1], 1]);
        let (together, span) = if strides[2] >= slice_span { (1, slice_span) } else { (dims[2], self.opened.header.span()) };
        let mut bytes = memory::zeroed(name, usize::try_from(span).unwrap_or(usize::MAX))?;
        let mut slices = memory::zeroed::<u8>(name, dims[0] * dims[1] * together * size)?;
        for n in 0..dims[2] / together {
            self.read(first + n as u64 * strides[2], &mut bytes)?;
            for (index, number) in slices.chunks_exact_mut(size).enumerate() {
                let place = [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]];
                let at: usize = (0..3).map(|i| place[i] * strides[i] as usize).sum();
                number.copy_from_slice(&bytes[at..at + size]);
            }
            take(&slices)?;
        }
        Ok(())
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> Result<(), Error> {
        match self.task.check().and_then(|()| self.opened.bytes.read(at, bytes)) {
            Ok(found) if found == bytes.len() => {
                self.task.add(found as u64);
                Ok(())
            }
            Ok(found) => Err(self.wrong_size(format!("{}", at + found as u64))),
            Err(e) => Err(self.failed(&e)),
        }
    }

    /// Converts a failed read to an error: damaged data or an I/O error.
    fn failed(&self, e: &io::Error) -> Error {
        match e.kind() {
            io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
                Error::volume(self.path, format!("its compressed data are truncated or damaged: {e}"))
            }
            _ => Error::read(self.path, io::Error::new(e.kind(), e.to_string())),
        }
    }

    fn wrong_size(&self, found: impl ToString) -> Error {
        let Header { grid, scalar, .. } = &self.opened.header;
        let (dims, expected) = (grid.dims(), self.opened.header.end());
        if self.opened.exact {
            let (scalar, found) = (scalar.to_string(), found.to_string());
            return Error::FileSize { path: self.path.into(), dims, scalar, expected, found };
        }
        let ([x, y, z], found) = (dims, found.to_string());
        let problem = format!(
            "its header declares {x}x{y}x{z} voxels of {scalar}, {expected} bytes, found {found}: it is truncated or damaged"
        );
        Error::volume(self.path, problem)
    }
}
