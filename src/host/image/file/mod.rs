//! Atomic picture output.

#[cfg(feature = "tiff")]
mod tiff;

use super::format::{BitDepth, Encoding, ImageFormat};
use super::{Background, Depths, Frame, blue_noise, display};
use crate::error::Error;
use crate::files::write_whole;
use crate::memory;
use crate::npy;
use crate::viewport::Viewport;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, Text, WritableImage};
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};
use jpeg_encoder::{ColorType, Encoder, PixelDensity, SamplingFactor};
use std::borrow::Cow;
use std::io;
use std::num::NonZeroU16;
use std::path::Path;

/// The program, in the metadata of files with a description.
const SOFTWARE: &str = concat!("layersplat ", env!("CARGO_PKG_VERSION"));
/// Inches per metre.
const INCHES: f64 = 1.0 / 0.0254;

/// Pixels of a file of integers: straight alpha, or opaque without an alpha channel.
enum Samples {
    Rgb8(Vec<u8>),
    Rgba8(Vec<u8>),
    Rgb16(Vec<u16>),
    Rgba16(Vec<u16>),
}

/// Writes a frame in a format that accepts its background and encoding. Depths need OpenEXR.
pub(super) fn write(
    path: &Path,
    frame: &Frame,
    format: ImageFormat,
    background: Option<Background>,
    encoding: &Encoding,
    depths: Option<&Depths>,
) -> Result<(), Error> {
    memory::require("the picture to write", frame.pixels.len() as u64 * temporary_bytes(format, encoding, depths))?;
    let (viewport, dpi) = (frame.viewport, encoding.dpi);
    let description = encoding.description.as_deref();
    let over = background.unwrap_or(Background::BLACK);
    match format {
        ImageFormat::Png => write_png(path, viewport, &samples(frame, over, encoding, true), dpi, description),
        ImageFormat::Jpeg => write_jpeg(path, viewport, &samples(frame, over, encoding, false), dpi),
        #[cfg(feature = "tiff")]
        ImageFormat::Tiff => tiff::write(path, viewport, &samples(frame, over, encoding, false), dpi),
        #[cfg(not(feature = "tiff"))]
        ImageFormat::Tiff => unreachable!("ImageFormat::from_path refuses it"),
        ImageFormat::WebP => write_webp(path, viewport, &samples(frame, over, encoding, false)),
        ImageFormat::Exr => write_exr(path, &frame.standing_on(background), depths, dpi, description),
        ImageFormat::Npy => write_npy(path, &frame.standing_on(background)),
    }
}

/// Temporary bytes per pixel. EXR, TIFF and WebP are encoded in memory.
fn temporary_bytes(format: ImageFormat, encoding: &Encoding, depths: Option<&Depths>) -> u64 {
    let bytes = if encoding.bits == Some(BitDepth::Sixteen) { 8 } else { 4 };
    match format {
        ImageFormat::Png => 2 * bytes,
        ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Tiff => 3 * bytes,
        ImageFormat::Npy => 16,
        ImageFormat::Exr => 16 + 2 * (16 + depths.map_or(0, |depths| if depths.ids().is_some() { 12 } else { 8 })),
    }
}

/// The pixels as integers, with an alpha channel if `alpha`, or if the background is transparent.
fn samples(frame: &Frame, background: Background, encoding: &Encoding, alpha: bool) -> Samples {
    let alpha = alpha || background == Background::Transparent;
    let pixels = || frame.pixels.iter().map(|&pixel| display::straight(pixel, background));
    match (encoding.bits, alpha) {
        (Some(BitDepth::Sixteen), true) => Samples::Rgba16(pixels().flat_map(|pixel| pixel.map(display::word)).collect()),
        (Some(BitDepth::Sixteen), false) => {
            Samples::Rgb16(pixels().flat_map(|[r, g, b, _]| [r, g, b].map(display::word)).collect())
        }
        (_, true) => Samples::Rgba8(bytes(frame, background, encoding.dither).flatten().collect()),
        (_, false) => Samples::Rgb8(bytes(frame, background, encoding.dither).flat_map(|[r, g, b, _]| [r, g, b]).collect()),
    }
}

/// The pixels as bytes, rounded or dithered.
fn bytes(frame: &Frame, background: Background, dither: bool) -> impl Iterator<Item = [u8; 4]> {
    let rows = frame.pixels.chunks_exact(frame.viewport.width as usize).enumerate();
    rows.flat_map(move |(row, pixels)| {
        let thresholds = dither.then(|| blue_noise::row(row));
        pixels.iter().enumerate().map(move |(column, &pixel)| match thresholds {
            Some(thresholds) => {
                let threshold = thresholds[column % blue_noise::SIDE];
                display::straight(pixel, background).map(|c| display::dithered(c, threshold))
            }
            None => display::displayed(pixel, background),
        })
    })
}

/// The error of an encoder.
fn failed(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::other(error)
}

fn write_png(
    path: &Path,
    viewport: Viewport,
    samples: &Samples,
    dpi: Option<NonZeroU16>,
    description: Option<&str>,
) -> Result<(), Error> {
    let (color, depth, bytes) = match samples {
        Samples::Rgb8(values) => (png::ColorType::Rgb, png::BitDepth::Eight, Cow::Borrowed(&values[..])),
        Samples::Rgba8(values) => (png::ColorType::Rgba, png::BitDepth::Eight, Cow::Borrowed(&values[..])),
        Samples::Rgb16(values) => (png::ColorType::Rgb, png::BitDepth::Sixteen, big_endian(values).into()),
        Samples::Rgba16(values) => (png::ColorType::Rgba, png::BitDepth::Sixteen, big_endian(values).into()),
    };
    write_whole(path, |out| {
        let mut encoder = png::Encoder::new(out, viewport.width, viewport.height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_pixel_dims(dpi.map(|dpi| {
            let per_metre = (f64::from(dpi.get()) * INCHES).round() as u32;
            png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }
        }));
        if let Some(description) = description {
            encoder.add_itxt_chunk("Software".into(), SOFTWARE.into()).map_err(failed)?;
            encoder.add_itxt_chunk("Description".into(), description.into()).map_err(failed)?;
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&bytes).map_err(failed)?;
        writer.finish().map_err(failed)
    })
}

fn big_endian(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

/// JPEG quality, up to 100. At 85 and above, without subsampled chroma, ringing is invisible.
const JPEG_QUALITY: u8 = 92;

fn write_jpeg(path: &Path, viewport: Viewport, samples: &Samples, dpi: Option<NonZeroU16>) -> Result<(), Error> {
    // A viewport's sides fit.
    let [width, height] = [viewport.width, viewport.height].map(|side| side as u16);
    write_whole(path, |out| {
        let mut encoder = Encoder::new(out, JPEG_QUALITY);
        encoder.set_sampling_factor(SamplingFactor::F_1_1);
        if let Some(dpi) = dpi.map(NonZeroU16::get) {
            encoder.set_density(PixelDensity::dpi(dpi));
        }
        let (color, bytes) = match samples {
            Samples::Rgb8(bytes) => (ColorType::Rgb, bytes),
            Samples::Rgba8(bytes) => (ColorType::Rgba, bytes),
            Samples::Rgb16(_) | Samples::Rgba16(_) => unreachable!("Encoding::check refuses them"),
        };
        encoder.encode(bytes, width, height, color).map_err(failed)
    })
}

fn write_webp(path: &Path, viewport: Viewport, samples: &Samples) -> Result<(), Error> {
    let (color, bytes) = match samples {
        Samples::Rgb8(bytes) => (ExtendedColorType::Rgb8, bytes),
        Samples::Rgba8(bytes) => (ExtendedColorType::Rgba8, bytes),
        Samples::Rgb16(_) | Samples::Rgba16(_) => unreachable!("Encoding::check refuses them"),
    };
    write_whole(path, |out| {
        WebPEncoder::new_lossless(out).write_image(bytes, viewport.width, viewport.height, color).map_err(failed)
    })
}

/// The text with question marks for characters beyond Latin-1.
fn latin(text: &str) -> String {
    text.chars().map(|c| if u32::from(c) < 256 { c } else { '?' }).collect()
}

/// Writes the picture, and depths if given.
fn write_exr(
    path: &Path,
    frame: &Frame,
    depths: Option<&Depths>,
    dpi: Option<NonZeroU16>,
    description: Option<&str>,
) -> Result<(), Error> {
    let channel = |name: &str, numbers| AnyChannel::new(name, FlatSamples::F32(numbers));
    let color = |(i, name)| channel(name, frame.pixels().iter().map(|pixel| pixel[i]).collect());
    let colors = ["R", "G", "B", "A"].into_iter().enumerate().map(color);
    let ids = depths.and_then(Depths::ids).map(|ids| AnyChannel::new("id", FlatSamples::U32(ids.to_vec())));
    let depths = depths.into_iter().flat_map(|depths| [("Z", depths.first()), ("mean.Z", depths.mean())]);
    let channels = colors.chain(depths.map(|(name, numbers)| channel(name, numbers.to_vec()))).chain(ids).collect();
    let mut image = Image::from_channels((frame.width() as usize, frame.height() as usize), AnyChannels::sort(channels));
    image.layer_data.attributes.horizontal_density = dpi.map(|dpi| dpi.get().into());
    // Texts of OpenEXR have bytes of Latin-1; other characters have no place there.
    image.layer_data.attributes.comments = description.map(|text| Text::new_or_panic(latin(text).as_str()));
    image.layer_data.attributes.software_name = description.map(|_| Text::new_or_panic(SOFTWARE));
    // The encoder seeks back to write its offset table.
    let mut encoded = io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut encoded).map_err(|e| Error::write(path, io::Error::other(e)))?;
    write_whole(path, |out| out.write_all(encoded.get_ref()))
}

fn write_npy(path: &Path, frame: &Frame) -> Result<(), Error> {
    let shape = [frame.height() as usize, frame.width() as usize, 4];
    write_whole(path, |out| npy::write(out, &shape, frame.pixels().as_flattened()))
}

#[cfg(test)]
mod tests;
