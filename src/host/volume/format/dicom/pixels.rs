//! Pixel values of slices, read one slice at a time.

use super::image::Image;
use super::packed::{self, Packing};
use super::place::Slice;
use crate::memory;
use crate::volume::format::parts::Parts;
use std::io::{self, SeekFrom};

/// Consecutive slices of one channel, little-endian.
pub(super) struct Pixels {
    images: Vec<Image>,
    slices: Vec<Slice>,
    channel: usize,
    /// Whether numbers are rescaled to floats, required if slices differ in rescaling.
    values: bool,
    /// Bytes per slice.
    each: u64,
    most: u64,
    /// Fragments of the most recently read image, if it is compressed.
    pieces: Option<(usize, packed::Fragments)>,
}

impl Pixels {
    pub fn new(images: Vec<Image>, slices: Vec<Slice>, channel: usize, values: bool) -> io::Result<Self> {
        let shape = images[0].shape;
        let size = if values { size_of::<f32>() } else { shape.bytes };
        let each = (shape.columns * shape.rows * size) as u64;
        let mut most = 0u64;
        for (index, image) in images.iter().enumerate() {
            let wanted = slices.iter().filter(|(of, _)| *of == index).count() as u64;
            most = most.saturating_add(each.saturating_mul(wanted).min(available(image, each)?));
        }
        Ok(Self { images, slices, channel, values, each, most, pieces: None })
    }

    /// Stored numbers of a frame, decompressed.
    pub fn frame(&mut self, of: usize, frame: usize) -> io::Result<Vec<u8>> {
        let image = &self.images[of];
        let (shape, mut from) = (image.shape, image.source.open()?);
        let Some(packing) = image.kind.packing else {
            // Bits of a frame follow those of the last one.
            let start = (frame as u64).saturating_mul(bits(image));
            let mut numbers = zeroed(image, (start % 8 + bits(image)).div_ceil(8))?;
            from.seek(SeekFrom::Start(image.pixels.at.saturating_add(start / 8)))?;
            from.read_exact(&mut numbers)?;
            let numbers = if image.kind.is_bit { unpacked(&numbers, start % 8, bits(image)) } else { numbers };
            return Ok(colors(numbers, image));
        };
        if self.pieces.as_ref().is_none_or(|(current, _)| *current != of) {
            self.pieces = Some((of, packed::fragments(&image.source, image.pixels, image.frames.len())?));
        }
        let pieces = self.pieces.as_ref().map_or(&[][..], |(_, frames)| &frames[frame]);
        let len: u64 = pieces.iter().map(|(_, len)| len).sum();
        if bits(image) / 8 > len.saturating_mul(packed::LIMIT) {
            let problem = format!("{len} compressed bytes cannot hold the {} bytes of frame {frame}", bits(image) / 8);
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        let mut whole = zeroed(image, len)?;
        let mut at = 0;
        for &(start, len) in pieces {
            from.seek(SeekFrom::Start(start))?;
            from.read_exact(&mut whole[at..at + len as usize])?;
            at += len as usize;
        }
        match packing {
            Packing::Rle => packed::runs(&whole, shape).map(|numbers| colors(numbers, image)),
            Packing::Jpeg => packed::jpeg(&whole, shape, image.kind.luminance),
        }
    }
}

fn zeroed(image: &Image, len: u64) -> io::Result<Vec<u8>> {
    memory::zeroed(&image.path.display().to_string(), len as usize).map_err(|e| io::Error::other(e.to_string()))
}

/// Bits of an uncompressed frame.
fn bits(image: &Image) -> u64 {
    let shape = image.shape;
    let each = if image.kind.is_bit { 1 } else { 8 * shape.bytes };
    [shape.columns, shape.rows, shape.channels, each].iter().fold(1, |n: u64, &size| n.saturating_mul(size as u64))
}

/// Red, green and blue of bytes that may be luminance and chrominance
/// (<https://dicom.nema.org/medical/dicom/current/output/chtml/part03/sect_C.7.6.3.html#sect_C.7.6.3.1.2>).
fn colors(mut numbers: Vec<u8>, image: &Image) -> Vec<u8> {
    if !image.kind.luminance || image.shape.channels != 3 {
        return numbers;
    }
    let (pixels, planar) = (numbers.len() / 3, image.kind.planar);
    for pixel in 0..pixels {
        let at = |part: usize| if planar { part * pixels + pixel } else { 3 * pixel + part };
        let [y, blue, red] = [0, 1, 2].map(|part| f32::from(numbers[at(part)]));
        let (blue, red) = (blue - 128.0, red - 128.0);
        let rgb = [y + 1.402 * red, y - 0.344_136 * blue - 0.714_136 * red, y + 1.772 * blue];
        // Rounded, and limited to bytes.
        (0..3).for_each(|part| numbers[at(part)] = rgb[part].round() as u8);
    }
    numbers
}

/// The bytes of `count` bits, the lowest of each byte first.
fn unpacked(bytes: &[u8], first: u64, count: u64) -> Vec<u8> {
    (first as usize..(first + count) as usize).map(|bit| bytes[bit / 8] >> (bit % 8) & 1).collect()
}

/// Upper bound of the bytes of slices in a file, with `each` bytes per slice.
pub(super) fn available(image: &Image, each: u64) -> io::Result<u64> {
    let there = image.source.len()?.saturating_sub(image.pixels.at);
    Ok(match image.pixels.len {
        Some(len) => (there.min(len).saturating_mul(8) / bits(image)).saturating_mul(each),
        None => there.saturating_mul(packed::LIMIT).saturating_mul(size_of::<f32>() as u64),
    })
}

/// Significant bits of one channel, sign-extended if signed.
fn samples(raw: &[u8], image: &Image, channel: usize) -> impl Iterator<Item = u64> {
    let (shape, kind) = (image.shape, image.kind);
    let (size, pixels) = (shape.bytes, shape.columns * shape.rows);
    let (first, step) = if kind.planar { (channel * pixels, 1) } else { (channel, shape.channels) };
    let above = 64 - kind.bits;
    raw.chunks_exact(size).skip(first).step_by(step).take(pixels).map(move |number| {
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(number);
        if kind.big_endian {
            bytes[..size].reverse();
        }
        let bits = (u64::from_le_bytes(bytes) >> kind.shift) << above;
        if kind.signed { ((bits as i64) >> above) as u64 } else { bits >> above }
    })
}

fn whole(number: u64, signed: bool) -> f64 {
    if signed { number as i64 as f64 } else { number as f64 }
}

impl Parts for Pixels {
    fn most(&self) -> u64 {
        self.most
    }

    fn whole(&self) -> u64 {
        self.each.saturating_mul(self.slices.len() as u64)
    }

    fn each(&self) -> u64 {
        self.each
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        self.numbers(self.slices[index])
    }
}

impl Pixels {
    /// The numbers of the channel in a slice.
    pub fn numbers(&mut self, (of, frame): Slice) -> io::Result<Vec<u8>> {
        let name = self.images[of].path.display().to_string();
        let named = |e: io::Error| io::Error::new(e.kind(), format!("{name}: {e}"));
        let raw = self.frame(of, frame).map_err(named)?;
        let image = &self.images[of];
        let mut numbers = Vec::new();
        for number in samples(&raw, image, self.channel) {
            let bytes = number.to_le_bytes();
            if self.values {
                let image = &image.frames[frame];
                let value = image.slope * whole(number, self.images[of].kind.signed) + image.intercept;
                numbers.extend_from_slice(&(value as f32).to_le_bytes());
            } else {
                numbers.extend_from_slice(&bytes[..image.shape.bytes]);
            }
        }
        Ok(numbers)
    }
}
