//! Where the bytes of a file's voxels are, and how they are got at.

use crate::error::Error;
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Bytes of voxels, from the first of the first voxel on, whatever else the file has.
pub(super) trait Bytes {
    /// The file that holds them as they are, and the byte at which they begin, if one does.
    fn in_place(&self) -> Option<(&File, u64)> {
        None
    }

    /// Whether some can be read without most of those before them.
    #[cfg(feature = "mpi")]
    fn reads_anywhere(&self) -> bool {
        self.in_place().is_some()
    }

    /// How many there can be at most, told without reading them: what a header declares is compared with it before anything is allocated.
    fn most(&self) -> u64;

    /// Fills `bytes` with those from byte `at` on, as far as there are any. Reading them in order takes one pass over the file.
    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize>;

    /// Whether there are no more after byte `end`, up to which they have been read: packed ones are only then known to be whole.
    fn ends_at(&mut self, end: u64) -> io::Result<bool>;
}

/// Those of a file, as they are.
pub(super) struct Plain {
    file: File,
    first: u64,
    len: u64,
}

impl Plain {
    /// From byte `first` on.
    pub fn new(file: File, first: u64) -> io::Result<Self> {
        let len = file.metadata()?.len().saturating_sub(first);
        Ok(Self { file, first, len })
    }

    /// `len` bytes from byte `first` on, or fewer if the file ends before.
    #[cfg(feature = "npz")]
    pub fn part(file: File, first: u64, len: u64) -> io::Result<Self> {
        let all = Self::new(file, first)?;
        Ok(Self { len: all.len.min(len), ..all })
    }

    /// The last `len` bytes, or all if there are fewer.
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

/// Bytes that are packed one after the other, and unpacked so.
pub(super) trait Packing {
    /// Bytes that a packed byte can stand for.
    const LIMIT: u64;
    type Decoder: Read;

    fn unpack(packed: BufReader<File>) -> Self::Decoder;
}

/// One or more members of gzip.
pub(super) struct Gzip;

impl Packing for Gzip {
    const LIMIT: u64 = 1032;
    type Decoder = MultiGzDecoder<BufReader<File>>;

    fn unpack(packed: BufReader<File>) -> Self::Decoder {
        MultiGzDecoder::new(packed)
    }
}

/// Zlib's frame around the same.
pub(super) struct Zlib;

impl Packing for Zlib {
    const LIMIT: u64 = Gzip::LIMIT;
    type Decoder = ZlibDecoder<BufReader<File>>;

    fn unpack(packed: BufReader<File>) -> Self::Decoder {
        ZlibDecoder::new(packed)
    }
}

/// The same without any frame.
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

/// Those of a packed file.
pub(super) struct Packed<P: Packing> {
    path: PathBuf,
    /// Byte of the file at which what is packed begins.
    start: u64,
    /// Unpacked bytes before the first.
    first: u64,
    most: u64,
    decoder: P::Decoder,
    /// Bytes that were unpacked.
    position: u64,
}

impl<P: Packing> Packed<P> {
    /// What is packed from byte `start` of a file on, and once unpacked from byte `first` on.
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

    /// Unpacks and forgets all before byte `at`; false if there are not so many.
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

/// Those that were read with the header, or parsed from text.
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

/// Opens a file of several.
type Open = dyn FnMut(&Path) -> Result<Box<dyn Bytes>, Error>;

/// Those of several files, one after the other: slices in a file each. One is open at a time.
pub(super) struct Joined {
    open: Box<Open>,
    files: Vec<PathBuf>,
    /// Bytes of a file, each of which has as many.
    each: u64,
    most: u64,
    current: Option<(usize, Box<dyn Bytes>)>,
    whole: bool,
}

impl Joined {
    /// All files are opened once, for what they have at most.
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

/// Reads until `bytes` are full or there are no more.
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
