//! Decoding of pages, one at a time.

use super::directory::AsStored;
use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::COMPLEX;
use crate::volume::format::parts::Parts;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, Limits};
use tiff::tags::Tag;

/// Upper bound of the compression ratio of deflate and LZW.
const LIMIT: u64 = 2048;
/// Largest tag in bytes after parsing; OME descriptions have some text for every page.
const LARGEST_TAG: u64 = 1 << 28;
/// Most pages of a file.
pub(super) const MOST: usize = 1 << 20;
/// SGI's tag for the number of slices in a page.
const IMAGE_DEPTH: Tag = Tag::Unknown(32997);

/// Values of Compression that this build supports: none, LZW, deflate (two codes), PackBits.
const READABLE: [u64; 5] = [1, 5, 8, 32946, 32773];
/// Other known values.
const UNREADABLE: [(u64, &str); 8] = [
    (2, "a CCITT method"),
    (3, "a CCITT method"),
    (4, "a CCITT method"),
    (6, "JPEG"),
    (7, "JPEG"),
    (34712, "JPEG 2000"),
    (34925, "LZMA"),
    (50000, "Zstandard"),
];

pub(super) type Reader = Decoder<BufReader<AsStored>>;

/// Opens a file at its first page.
pub(super) fn decoder(path: &Path) -> Result<Reader, Error> {
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let len = file.metadata().map_err(|e| Error::read(path, e))?.len();
    let file = AsStored::new(path, file, len)?;
    let mut limits = Limits::default();
    // A number of a tag takes one to eight bytes in a file, and 32 after parsing.
    limits.decoding_buffer_size = len.saturating_mul(32).min(LARGEST_TAG) as usize;
    // A compressed strip or tile may fill the whole file.
    limits.intermediate_buffer_size = usize::try_from(len).unwrap_or(usize::MAX);
    Ok(Decoder::new(BufReader::new(file)).map_err(|e| damaged(path, &e))?.with_limits(limits))
}

fn damaged(path: &Path, e: &tiff::TiffError) -> Error {
    match e {
        tiff::TiffError::IoError(e) if e.kind() != io::ErrorKind::UnexpectedEof => {
            Error::read(path, io::Error::new(e.kind(), e.to_string()))
        }
        e => Error::volume(path, format!("its pages cannot be read: {e}")),
    }
}

/// Properties that all pages share.
pub(super) struct Page {
    pub width: usize,
    pub height: usize,
    /// Numbers per pixel.
    pub samples: usize,
    pub scalar: ScalarType,
    /// Whether samples are stored in separate planes.
    pub planar: bool,
    pub big_endian: bool,
    pub pixels_per_unit: Option<[f64; 2]>,
    /// First byte of the numbers, if uncompressed.
    pub in_place: Option<u64>,
}

impl Page {
    /// Properties of the current page.
    pub fn read(path: &Path, reader: &mut Reader) -> Result<Self, Error> {
        let (width, height) = reader.dimensions().map_err(|e| damaged(path, &e))?;
        let mut tag = |tag: Tag| reader.find_tag_unsigned_vec::<u64>(tag).ok().flatten().unwrap_or_default();
        let first = |numbers: Vec<u64>, missing: u64| numbers.first().copied().unwrap_or(missing);
        let bits = tag(Tag::BitsPerSample);
        let kind = first(tag(Tag::SampleFormat), 1);
        let samples = first(tag(Tag::SamplesPerPixel), 1) as usize;
        let planar = first(tag(Tag::PlanarConfiguration), 1) == 2 && samples > 1;
        let packing = first(tag(Tag::Compression), 1);
        if !READABLE.contains(&packing) {
            let name = UNREADABLE.iter().find(|(code, _)| *code == packing).map_or("an unknown method", |(_, name)| name);
            let problem = format!("its pages are compressed with {name}: save them with deflate, LZW or no compression");
            return Err(Error::volume(path, problem));
        }
        let depth = first(tag(IMAGE_DEPTH), 1);
        if depth > 1 {
            let problem = format!("its pages have {depth} slices each (ImageDepth): save one page per slice");
            return Err(Error::volume(path, problem));
        }
        let in_place = tag(Tag::StripOffsets).first().copied().filter(|_| packing == 1);
        let bits = first(bits, 1);
        // Whole numbers or floats.
        if [5, 6].contains(&kind) {
            return Err(Error::volume(path, format!("its samples are {COMPLEX}")));
        }
        let scalar = match (kind, bits) {
            (1, 8 | 16 | 32 | 64) => format!("uint{bits}"),
            (2, 8 | 16 | 32 | 64) => format!("int{bits}"),
            (3, 16 | 32 | 64) => format!("float{bits}"),
            _ => String::new(),
        };
        let scalar = scalar.parse();
        let scalar = scalar.map_err(|_| {
            Error::volume(path, format!("its samples have {bits} bits (format {kind}): expected 8, 16, 32 or 64; convert it"))
        })?;
        if !(1..=1 << 16).contains(&samples) {
            return Err(Error::volume(path, format!("it has {samples} samples per pixel")));
        }
        let mut per_unit = |tag: Tag| match reader.find_tag(tag).ok().flatten()? {
            Value::Rational(pixels, units) => Some(f64::from(pixels) / f64::from(units)),
            _ => None,
        };
        let pixels_per_unit = per_unit(Tag::XResolution).zip(per_unit(Tag::YResolution)).map(|(x, y)| [x, y]);
        let big_endian = matches!(reader.byte_order(), tiff::tags::ByteOrder::BigEndian);
        let (width, height) = (width as usize, height as usize);
        Ok(Self { width, height, samples, scalar, planar, big_endian, pixels_per_unit, in_place })
    }

    fn is_like(&self, other: &Self) -> bool {
        let layout = |page: &Self| (page.width, page.height, page.samples, page.scalar, page.planar);
        layout(self) == layout(other)
    }

    /// Bytes per page.
    pub fn bytes(&self) -> u64 {
        let sizes = [self.width, self.height, self.samples, self.scalar.bytes()];
        sizes.iter().fold(1, |n: u64, &size| n.saturating_mul(size as u64))
    }
}

impl fmt::Display for Page {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{} pixels of {}", self.width, self.height, self.scalar)?;
        match (self.samples, self.planar) {
            (1, _) => Ok(()),
            (samples, true) => write!(f, " in {samples} planes"),
            (samples, false) => write!(f, " with {samples} channels"),
        }
    }
}

/// Image description of the first page.
pub(super) fn description(reader: &mut Reader) -> String {
    reader.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default()
}

/// Indices of all pages that are slices, without previews.
///
/// # Errors
/// If a page differs from the first.
pub(super) fn slices(path: &Path, reader: &mut Reader, first: &Page) -> Result<Vec<usize>, Error> {
    let mut found = vec![0];
    let mut index = 0;
    while reader.more_images() {
        reader.next_image().map_err(|e| damaged(path, &e))?;
        index += 1;
        if index > MOST {
            return Err(Error::volume(path, format!("it has more than {MOST} pages")));
        }
        if is_preview(reader) {
            continue;
        }
        let page = Page::read(path, reader)?;
        if !page.is_like(first) {
            let problem =
                format!("page {index} has {page}, but page 0 has {first}: save pages of the same kind in a separate file");
            return Err(Error::volume(path, problem));
        }
        found.push(index);
    }
    Ok(found)
}

/// Whether the current page is a reduced version of another.
fn is_preview(reader: &mut Reader) -> bool {
    let mut number = |tag: Tag| reader.find_tag_unsigned::<u64>(tag).ok().flatten().unwrap_or(0);
    number(Tag::NewSubfileType) & 1 == 1 || number(Tag::SubfileType) == 2
}

/// A sequence of pages of a file.
pub(super) struct Pages {
    path: PathBuf,
    reader: Reader,
    pages: Vec<usize>,
    /// Bytes per page.
    each: u64,
    most: u64,
}

impl Pages {
    pub fn new(path: &Path, pages: Vec<usize>, each: u64) -> Result<Self, Error> {
        let packed = std::fs::metadata(path).map_err(|e| Error::read(path, e))?.len();
        let most = each.saturating_mul(pages.len() as u64).min(packed.saturating_mul(LIMIT));
        Ok(Self { path: path.into(), reader: decoder(path)?, pages, each, most })
    }
}

impl Parts for Pages {
    fn most(&self) -> u64 {
        self.most
    }

    fn whole(&self) -> u64 {
        self.each.saturating_mul(self.pages.len() as u64)
    }

    fn each(&self) -> u64 {
        self.each
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let bytes = crate::memory::zeroed(&self.path.display().to_string(), self.each as usize);
        let mut bytes: Vec<u8> = bytes.map_err(|e| io::Error::other(e.to_string()))?;
        let mut decode = |reader: &mut Reader| {
            reader.seek_to_image(self.pages[index])?;
            reader.read_image_bytes(&mut bytes)
        };
        decode(&mut self.reader).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.to_string()))?;
        Ok(bytes)
    }
}
