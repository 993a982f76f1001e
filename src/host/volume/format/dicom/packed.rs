//! Compressed frames, in one or more fragments each.

use super::dataset::{PixelData, Reading, Source};
use crate::volume::format::runs::unpack;
use jpeg_decoder::{ColorTransform, Decoder, PixelFormat};
use std::io::{self, SeekFrom};

/// Upper bound of the compression ratio of all supported methods.
pub(super) const LIMIT: u64 = 1032;
/// Limit of fragments per file.
const MOST: usize = 1 << 20;
/// Size of the header of a run-length frame in bytes.
const RUNS: usize = 64;

/// Compression of frames.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Packing {
    Rle,
    Jpeg,
}

/// Declared size and layout of a frame.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub columns: usize,
    pub rows: usize,
    pub channels: usize,
    /// Bytes per number.
    pub bytes: usize,
}

fn damaged(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

/// Fragments of each frame: first byte in the source, and length.
pub(super) type Fragments = Vec<Vec<(u64, u64)>>;

/// Locates the fragments of each of the `frames`.
pub(super) fn fragments(source: &Source, pixels: PixelData, frames: usize) -> io::Result<Fragments> {
    let (mut from, end) = (source.open()?, source.len()?);
    let mut at = pixels.at;
    let mut items: Vec<(u64, u64)> = Vec::new();
    loop {
        let (tag, len) = item(from.as_mut(), at)?;
        at += 8;
        match tag {
            0xe000 if at.saturating_add(len) <= end && items.len() < MOST => items.push((at, len)),
            0xe000 => return Err(damaged(format!("a fragment of {len} bytes, or too many fragments"))),
            0xe0dd => break,
            _ => return Err(damaged("expected a fragment of pixels, found another element")),
        }
        at += len;
    }
    if items.is_empty() {
        return Err(damaged("missing offset table before the pixels"));
    }
    let table = items.remove(0);
    if items.len() == frames {
        return Ok(items.into_iter().map(|item| vec![item]).collect());
    }
    if frames == 1 && !items.is_empty() {
        return Ok(vec![items]);
    }
    let offsets = offsets(from.as_mut(), table)?;
    if offsets.len() != frames || items.is_empty() {
        return Err(damaged(format!(
            "{} fragments for {frames} frames, without a table that assigns them to frames",
            items.len()
        )));
    }
    // Offsets count from the header of the first fragment.
    let first = items[0].0;
    let frame_of = |item: &(u64, u64)| offsets.partition_point(|&offset| u64::from(offset) <= item.0 - first).saturating_sub(1);
    let mut items_by_frame = vec![Vec::new(); frames];
    for item in items {
        items_by_frame[frame_of(&item)].push(item);
    }
    Ok(items_by_frame)
}

/// Element and length of an item header.
fn item(from: &mut dyn Reading, at: u64) -> io::Result<(u16, u64)> {
    let mut head = [0; 8];
    from.seek(SeekFrom::Start(at))?;
    from.read_exact(&mut head)?;
    let element = if head[..2] == [0xfe, 0xff] { u16::from_le_bytes([head[2], head[3]]) } else { 0 };
    Ok((element, u32::from_le_bytes([head[4], head[5], head[6], head[7]]).into()))
}

fn offsets(from: &mut dyn Reading, (at, len): (u64, u64)) -> io::Result<Vec<u32>> {
    if len > 4 * MOST as u64 {
        return Err(damaged("its offset table is too long"));
    }
    let mut table = vec![0; len as usize];
    from.seek(SeekFrom::Start(at))?;
    from.read_exact(&mut table)?;
    Ok(table.chunks_exact(4).map(|offset| u32::from_le_bytes([offset[0], offset[1], offset[2], offset[3]])).collect())
}

/// Decodes run lengths. Each byte of each channel has its own segment, most significant byte first. The output is little-endian with
/// interleaved channels.
pub(super) fn runs(packed: &[u8], shape: Shape) -> io::Result<Vec<u8>> {
    let header: Vec<usize> =
        packed.get(..RUNS).ok_or_else(|| damaged("missing run-length header"))?.chunks_exact(4).map(offset).collect();
    let (segments, pixels) = (shape.channels * shape.bytes, shape.columns * shape.rows);
    if header[0] != segments || segments >= header.len() {
        return Err(damaged(format!("{} run-length segments, expected {segments}", header[0])));
    }
    let mut numbers = vec![0; pixels * segments];
    for segment in 0..segments {
        let start = header[1 + segment];
        let end = if segment + 1 < segments { header[2 + segment] } else { packed.len() };
        let runs = packed.get(start..end).ok_or_else(|| damaged("a run-length segment outside the frame"))?;
        let (channel, byte) = (segment / shape.bytes, shape.bytes - 1 - segment % shape.bytes);
        let mut places = (0..pixels).map(|pixel| (pixel * shape.channels + channel) * shape.bytes + byte);
        unpack(runs, |value| places.next().map(|place| numbers[place] = value).is_some());
        if places.next().is_some() {
            return Err(damaged("truncated run-length data"));
        }
    }
    Ok(numbers)
}

fn offset(bytes: &[u8]) -> usize {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize
}

/// Decodes a JPEG frame. The size is compared with `shape` before decoding. `luminance`: whether colours are stored as luminance and
/// chrominance.
pub(super) fn jpeg(packed: &[u8], shape: Shape, luminance: bool) -> io::Result<Vec<u8>> {
    let failed = |e: jpeg_decoder::Error| damaged(e.to_string());
    let mut decoder = Decoder::new(packed);
    if shape.channels == 3 {
        decoder.set_color_transform(if luminance { ColorTransform::YCbCr } else { ColorTransform::RGB });
    }
    decoder.read_info().map_err(failed)?;
    let info = decoder.info().ok_or_else(|| damaged("a JPEG frame without a size"))?;
    let (channels, bytes) = match info.pixel_format {
        PixelFormat::L8 => (1, 1),
        PixelFormat::L16 => (1, 2),
        PixelFormat::RGB24 => (3, 1),
        PixelFormat::CMYK32 => (4, 1),
    };
    let size = [usize::from(info.width), usize::from(info.height)];
    if size != [shape.columns, shape.rows] || channels != shape.channels || bytes > shape.bytes {
        let [x, y] = size;
        return Err(damaged(format!("a JPEG frame of {x}x{y} pixels with {channels} channels of {} bits", 8 * bytes)));
    }
    decoder.set_max_decoding_buffer_size(2 * channels * bytes * size[0] * size[1] + RUNS);
    let numbers = decoder.decode().map_err(failed)?;
    if numbers.len() != size[0] * size[1] * channels * bytes {
        return Err(damaged("a truncated JPEG frame"));
    }
    if bytes == shape.bytes {
        let little = |pair: &[u8]| u16::from_ne_bytes([pair[0], pair[1]]).to_le_bytes();
        return Ok(if bytes == 2 { numbers.chunks_exact(2).flat_map(little).collect() } else { numbers });
    }
    Ok(numbers.into_iter().flat_map(|number| std::iter::once(number).chain(std::iter::repeat_n(0, shape.bytes - 1))).collect())
}
