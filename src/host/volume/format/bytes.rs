//! Access to the voxel data of files: plain, compressed or split over several files.

use crate::error::Error;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Voxel data from the first byte of the first voxel, regardless of other file contents.
pub(crate) trait Bytes {
    /// The file and the byte offset at which the data are stored uncompressed, if they are.
    fn in_place(&self) -> Option<(&File, u64)> {
        None
    }

    /// Whether random access is efficient, without reading most preceding data.
    #[cfg(feature = "mpi")]
    fn reads_anywhere(&self) -> bool {
        self.in_place().is_some()
    }

    /// Upper bound of the number of bytes, determined without reading them. Headers are checked against it before any allocation.
    fn most(&self) -> u64;

    /// Reads from byte `at` into `bytes` and returns the number of bytes read, fewer at the end. Sequential reads take one pass.
    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize>;

    /// Whether the data end at byte `end`, up to which they have been read. Reading to the end verifies the checksum of compressed data.
    fn ends_at(&mut self, end: u64) -> io::Result<bool>;
}

/// Uncompressed data in a file.
pub(super) struct Plain {
    file: File,
    first: u64,
    len: u64,
}

impl Plain {
    /// Data from byte `first` to the end of the file.
    pub fn new(file: File, first: u64) -> io::Result<Self> {
        let len = file.metadata()?.len().saturating_sub(first);
        Ok(Self { file, first, len })
    }

    /// `len` bytes from byte `first`, or fewer if the file is shorter.
    #[cfg(feature = "npz")]
    pub fn part(file: File, first: u64, len: u64) -> io::Result<Self> {
        let all = Self::new(file, first)?;
        Ok(Self { len: all.len.min(len), ..all })
    }

    /// The last `len` bytes, or all if the file is shorter.
    pub fn last(file: File, len: u64) -> io::Result<Self> {
        let first = file.metadata()?.len().saturating_sub(len);
        Self::new(file, first)
    }
}

impl Bytes for Plain {
    fn in_place(&self) -> Option<(&File, u64)> {
        Some((&self.file, self.first))
    }

    fn most(&self) -> u64 {
        self.len
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.seek(SeekFrom::Start(self.first + at))?;
        fill(&mut self.file, bytes)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.len == end)
    }
}

/// A stream compression method.
pub(super) trait Packing {
    /// Largest compression ratio.
    const LIMIT: u64;
    type Decoder: Read;

    fn unpack(packed: BufReader<File>) -> Self::Decoder;
}

/// gzip, with one or more members, and zeros behind the last one: padding, which gzip itself ignores, too.
pub(super) struct Gzip;

/// Decompresses the members of a gzip file.
pub(super) struct Members {
    decoder: GzDecoder<BufReader<File>>,
    /// Whether all members were read.
    is_done: bool,
}

impl Read for Members {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        while !self.is_done {
            let found = self.decoder.read(bytes)?;
            if found > 0 || bytes.is_empty() {
                return Ok(found);
            }
            let rest = self.decoder.get_mut();
            while rest.fill_buf()?.first() == Some(&0) {
                rest.consume(1);
            }
            self.is_done = rest.fill_buf()?.is_empty();
            if !self.is_done {
                let (file, at) = (rest.get_ref().try_clone()?, rest.stream_position()?);
                let mut next = BufReader::new(file);
                next.seek(SeekFrom::Start(at))?;
                self.decoder = GzDecoder::new(next);
            }
        }
        Ok(0)
    }
}

impl Packing for Gzip {
    const LIMIT: u64 = 1032;
    type Decoder = Members;

    fn unpack(packed: BufReader<File>) -> Self::Decoder {
        Members { decoder: GzDecoder::new(packed), is_done: false }
    }
}

/// Deflate with zlib's header.
pub(super) struct Zlib;

impl Packing for Zlib {
    const LIMIT: u64 = Gzip::LIMIT;
    type Decoder = ZlibDecoder<BufReader<File>>;

    fn unpack(packed: BufReader<File>) -> Self::Decoder {
        ZlibDecoder::new(packed)
    }
}

/// Deflate without a header.
#[cfg(feature = "npz")]
pub(super) struct Deflate;

#[cfg(feature = "npz")]
impl Packing for Deflate {
    const LIMIT: u64 = Gzip::LIMIT;
    type Decoder = flate2::bufread::DeflateDecoder<BufReader<File>>;

    fn unpack(packed: BufReader<File>) -> Self::Decoder {
        flate2::bufread::DeflateDecoder::new(packed)
    }
}

/// Compressed data in a file.
pub(super) struct Packed<P: Packing> {
    path: PathBuf,
    /// Byte of the file at which the compressed data begin.
    start: u64,
    /// Uncompressed bytes before the first voxel.
    first: u64,
    most: u64,
    decoder: P::Decoder,
    /// Number of bytes decompressed so far.
    position: u64,
}

impl<P: Packing> Packed<P> {
    /// Data compressed from byte `start` of a file. The voxels begin at byte `first` of the decompressed data.
    pub fn new(path: &Path, start: u64, first: u64) -> io::Result<Self> {
        let len = std::fs::metadata(path)?.len().saturating_sub(start);
        let most = len.saturating_mul(P::LIMIT).saturating_sub(first);
        let decoder = Self::decoder(path, start)?;
        Ok(Self { path: path.into(), start, first, most, decoder, position: 0 })
    }

    fn decoder(path: &Path, start: u64) -> io::Result<P::Decoder> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(start))?;
        Ok(P::unpack(BufReader::new(file)))
    }

    /// Decompresses and discards all bytes before byte `at`. Returns false if the data end before.
    fn skip_to(&mut self, at: u64) -> io::Result<bool> {
        let mut piece = [0; 1 << 14];
        while self.position < at {
            let wanted = (at - self.position).min(piece.len() as u64) as usize;
            let found = fill(&mut self.decoder, &mut piece[..wanted])?;
            self.position += found as u64;
            if found < wanted {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl<P: Packing> Bytes for Packed<P> {
    fn most(&self) -> u64 {
        self.most
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        let at = at.saturating_add(self.first);
        if at < self.position {
            self.decoder = Self::decoder(&self.path, self.start)?;
            self.position = 0;
        }
        if !self.skip_to(at)? {
            return Ok(0);
        }
        let found = fill(&mut self.decoder, bytes)?;
        self.position += found as u64;
        Ok(found)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        self.skip_to(end.saturating_add(self.first))?;
        Ok(fill(&mut self.decoder, &mut [0])? == 0)
    }
}

/// Data in memory: read with the header, or parsed from text.
pub(super) struct Held(pub Vec<u8>);

impl Bytes for Held {
    fn most(&self) -> u64 {
        self.0.len() as u64
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        let mut rest = usize::try_from(at).ok().and_then(|at| self.0.get(at..)).unwrap_or(&[]);
        fill(&mut rest, bytes)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.0.len() as u64 == end)
    }
}

/// Opens one of several files.
type Open = dyn FnMut(&Path) -> Result<Box<dyn Bytes>, Error>;

/// Concatenated data of several files, such as one slice per file. One file is open at a time.
pub(super) struct Joined {
    open: Box<Open>,
    files: Vec<PathBuf>,
    /// Bytes per file.
    each: u64,
    most: u64,
    current: Option<(usize, Box<dyn Bytes>)>,
    whole: bool,
}

impl Joined {
    /// Opens every file once to sum up their upper bounds.
    pub fn new(
        files: Vec<PathBuf>,
        each: u64,
        mut open: impl FnMut(&Path) -> Result<Box<dyn Bytes>, Error> + 'static,
    ) -> Result<Self, Error> {
        let mut most = 0u64;
        for file in &files {
            most = most.saturating_add(open(file)?.most().min(each));
        }
        Ok(Self { open: Box::new(open), files, each, most, current: None, whole: true })
    }

    fn part(&mut self, part: usize) -> io::Result<&mut dyn Bytes> {
        let opened = match self.current.take().filter(|(current, _)| *current == part) {
            Some((_, opened)) => opened,
            None => (self.open)(&self.files[part]).map_err(|e| io::Error::other(e.to_string()))?,
        };
        Ok(self.current.insert((part, opened)).1.as_mut())
    }
}

impl Bytes for Joined {
    #[cfg(feature = "mpi")]
    fn reads_anywhere(&self) -> bool {
        true
    }

    fn most(&self) -> u64 {
        self.most
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        let (mut found, each) = (0, self.each);
        while found < bytes.len() {
            let at = at + found as u64;
            let (part, within) = ((at / each) as usize, at % each);
            if part >= self.files.len() {
                break;
            }
            let wanted = (each - within).min((bytes.len() - found) as u64) as usize;
            let opened = self.part(part)?;
            let read = opened.read(within, &mut bytes[found..found + wanted]);
            let read = read.and_then(|more| Ok((more, within + more as u64 != each || opened.ends_at(each)?)));
            let (more, ends) = read.map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", self.files[part].display())))?;
            self.whole &= ends;
            found += more;
            if more < wanted {
                break;
            }
        }
        Ok(found)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.whole && end == self.each.saturating_mul(self.files.len() as u64))
    }
}

/// Reads until `bytes` is full or the source ends. Returns the number of bytes read.
pub(super) fn fill(from: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut found = 0;
    while found < bytes.len() {
        match from.read(&mut bytes[found..]) {
            Ok(0) => break,
            Ok(n) => found += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(found)
}
