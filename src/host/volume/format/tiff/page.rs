//! What the tags of a page say about its numbers.

use super::directory::{Directory, Reader, failed};
use crate::error::Error;
use crate::volume::ScalarType;
use crate::volume::format::COMPLEX;
use std::fmt;
use std::io;
use std::path::Path;

/// Other known compression methods than [`Packing`].
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
const RGB: u64 = 2;
const PALETTE: u64 = 3;
const YCBCR: u64 = 6;
/// Most samples per pixel.
const MOST_SAMPLES: u64 = 1 << 16;

/// Compression of strips and tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
}

/// What numbers are stored as, instead of themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Predictor {
    None,
    /// Differences along rows.
    Horizontal,
    /// Differences of the bytes of floats.
    Float,
}

/// Meaning of the samples of a pixel beyond its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Extra {
    Unspecified,
    /// Opacity by which the colours are multiplied.
    AssociatedAlpha,
    Alpha,
}

/// Properties of a page.
#[derive(Clone, PartialEq)]
pub(super) struct Page {
    pub width: usize,
    pub height: usize,
    /// Numbers per pixel.
    pub samples: usize,
    pub scalar: ScalarType,
    /// Bits of a stored number.
    pub bits: usize,
    /// Whether samples are stored in separate planes.
    pub planar: bool,
    pub packing: Packing,
    pub predictor: Predictor,
    /// Whether bytes begin with their lowest bit.
    pub lowest_first: bool,
    /// Width and height of tiles; the width is that of the page for strips.
    pub chunk: [usize; 2],
    pub tiled: bool,
    /// Whether the first three samples are red, green and blue.
    pub is_rgb: bool,
    pub extra: Vec<Extra>,
    /// Red, green and blue of each index, if numbers are indices: all red ones, all green ones, all blue ones.
    pub palette: Vec<u64>,
}

impl Page {
    /// Properties of the page of a directory.
    pub fn read(path: &Path, reader: &mut Reader, directory: &Directory) -> Result<Self, Error> {
        Tags::read(reader, directory).map_err(|e| failed(path, &e))?.page().map_err(|problem| Error::volume(path, problem))
    }

    /// Whether slices of both pages belong together, however they are stored.
    pub fn is_like(&self, other: &Self) -> bool {
        let layout = |page: &Self| (page.width, page.height, page.samples, page.scalar, page.is_rgb);
        layout(self) == layout(other) && self.palette == other.palette
    }

    /// Bytes of one sample of all pixels, as voxels have them.
    pub fn bytes(&self) -> u64 {
        [self.width, self.height, self.scalar.bytes()].iter().fold(1, |n: u64, &size| n.saturating_mul(size as u64))
    }

    /// Colours of the palette, 0 to 1.
    pub fn colors(&self) -> Vec<[f64; 3]> {
        let count = self.palette.len() / 3;
        (0..count).map(|index| [0, 1, 2].map(|part| self.palette[part * count + index] as f64 / f64::from(u16::MAX))).collect()
    }

    /// Samples of a stored chunk.
    pub fn samples_inside(&self) -> usize {
        if self.planar { 1 } else { self.samples }
    }
}

impl fmt::Display for Page {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{} pixels of {}", self.width, self.height, self.scalar)?;
        match self.samples {
            1 if !self.palette.is_empty() => write!(f, " with a palette"),
            1 => Ok(()),
            samples => write!(f, " with {samples} channels"),
        }
    }
}

/// Tags as stored, with the defaults of the standard.
struct Tags {
    width: u64,
    height: u64,
    bits: Vec<u64>,
    kinds: Vec<u64>,
    samples: u64,
    planar: u64,
    packing: u64,
    predictor: u64,
    order: u64,
    photometric: u64,
    depth: u64,
    rows: u64,
    tile: Option<[u64; 2]>,
    extra: Vec<u64>,
    palette: Vec<u64>,
}

impl Tags {
    fn read(reader: &mut Reader, directory: &Directory) -> io::Result<Self> {
        let mut whole = |tag: u16, missing: u64| Ok::<_, io::Error>(reader.whole(directory, tag)?.unwrap_or(missing));
        let (width, height) = (whole(256, 0)?, whole(257, 0)?);
        let (packing, photometric, order) = (whole(259, 1)?, whole(262, 1)?, whole(266, 1)?);
        let (samples, rows, planar) = (whole(277, 1)?, whole(278, height)?, whole(284, 1)?);
        // SGI's tag for the number of slices in a page.
        let (predictor, depth) = (whole(317, 1)?, whole(32997, 1)?);
        let (tile_width, tile_height) = (whole(322, 0)?, whole(323, 0)?);
        let [bits, kinds, extra] = [258, 339, 338].map(|tag| reader.numbers(directory, tag));
        let palette = if photometric == PALETTE { reader.numbers(directory, 320)? } else { Vec::new() };
        let tile = (tile_width > 0 || tile_height > 0).then_some([tile_width, tile_height]);
        let (bits, kinds, extra) = (bits?, kinds?, extra?);
        let rows = rows.min(height);
        Ok(Self {
            width,
            height,
            bits,
            kinds,
            samples,
            planar,
            packing,
            predictor,
            order,
            photometric,
            depth,
            rows,
            tile,
            extra,
            palette,
        })
    }

    fn page(self) -> Result<Page, String> {
        let packing = match self.packing {
            1 => Packing::None,
            5 => Packing::Lzw,
            8 | 32946 => Packing::Deflate,
            32773 => Packing::PackBits,
            other => {
                let name = UNREADABLE.iter().find(|(code, _)| *code == other).map_or("an unknown method", |(_, name)| name);
                return Err(format!("its pages are compressed with {name}: save them with deflate, LZW or no compression"));
            }
        };
        if self.depth > 1 {
            return Err(format!("its pages have {} slices each (ImageDepth): save one page per slice", self.depth));
        }
        if self.photometric == YCBCR {
            return Err("its colours are YCbCr, luminance and chrominance: save it as RGB".into());
        }
        let side = |size: u64| usize::try_from(size).ok().filter(|&n| n > 0 && size <= u32::MAX.into());
        let sizes = side(self.width).zip(side(self.height));
        let (width, height) = sizes.ok_or_else(|| format!("it has a page of {}x{} pixels", self.width, self.height))?;
        let samples = Some(self.samples).filter(|n| (1..=MOST_SAMPLES).contains(n));
        let samples = samples.ok_or_else(|| format!("it has {} samples per pixel", self.samples))? as usize;
        let (scalar, bits) = scalar(&self.bits, &self.kinds)?;
        let predictor = match (self.predictor, bits % 8) {
            (1, _) => Predictor::None,
            (2, 0) => Predictor::Horizontal,
            (3, 0) if matches!(scalar, ScalarType::Float16 | ScalarType::Float32 | ScalarType::Float64) => Predictor::Float,
            (other, _) => return Err(format!("its predictor {other} of {bits} bits is not supported: save it without one")),
        };
        let [chunk_width, chunk_height] = self.tile.unwrap_or([self.width, self.rows]);
        let chunk = side(chunk_width).zip(side(chunk_height));
        let chunk =
            chunk.ok_or_else(|| format!("its strips or tiles have {chunk_width}x{chunk_height} pixels: it is damaged"))?;
        let palette_len = 3usize.checked_shl(bits as u32).unwrap_or(0);
        if self.photometric == PALETTE && (samples != 1 || bits > 16 || self.palette.len() != palette_len) {
            let len = self.palette.len();
            return Err(format!("its palette has {len} numbers, and {bits} bits need {palette_len}: it is damaged"));
        }
        let extra = |kind: &u64| match kind {
            1 => Extra::AssociatedAlpha,
            2 => Extra::Alpha,
            _ => Extra::Unspecified,
        };
        Ok(Page {
            width,
            height,
            samples,
            scalar,
            bits,
            planar: self.planar == 2 && samples > 1,
            packing,
            predictor,
            lowest_first: self.order == 2,
            chunk: [chunk.0, chunk.1],
            tiled: self.tile.is_some(),
            is_rgb: self.photometric == RGB && samples >= 3,
            extra: self.extra.iter().map(extra).collect(),
            palette: self.palette,
        })
    }
}

/// Type of voxels, and bits of stored numbers. Whole numbers of fewer bits than voxels have are packed.
fn scalar(bits: &[u64], kinds: &[u64]) -> Result<(ScalarType, usize), String> {
    let (first, kind) = (bits.first().copied().unwrap_or(1), kinds.first().copied().unwrap_or(1));
    if [5, 6].contains(&kind) {
        return Err(format!("its samples are {COMPLEX}"));
    }
    if bits.iter().any(|&n| n != first) || kinds.iter().any(|&n| n != kind) {
        return Err("its samples differ in type: save them in one type".into());
    }
    let name = match (kind, first) {
        (1 | 4, 1..=8) => "uint8".into(),
        (1 | 4, 9..=16) => "uint16".into(),
        (1 | 4, 32 | 64) => format!("uint{first}"),
        (2, 8 | 16 | 32 | 64) => format!("int{first}"),
        (3, 16 | 32 | 64) => format!("float{first}"),
        _ => String::new(),
    };
    let wrong = |_| format!("its samples have {first} bits (format {kind}): expected 1 to 16, 32 or 64; convert it");
    Ok((name.parse().map_err(wrong)?, first as usize))
}
