//! Reads pictures as premultiplied floats.

use super::{Frame, ImageFormat};
use crate::error::Error;
use crate::memory;
use crate::npy;
use crate::panics::caught;
use crate::viewport::Viewport;
use image::{DynamicImage, ImageDecoder, ImageReader, Limits};
use std::path::Path;

/// Reads a `.png`, `.jpg`, `.tif`, `.webp`, `.exr` or `.npy` picture as premultiplied floats.
///
/// # Errors
/// If the extension is unknown, or the file cannot be read, is damaged, too large, or has values that are not finite.
pub fn read_image(path: &Path) -> Result<Frame, Error> {
    match ImageFormat::from_path(path)? {
        ImageFormat::Png => decoded(path, image::ImageFormat::Png),
        ImageFormat::Jpeg => decoded(path, image::ImageFormat::Jpeg),
        ImageFormat::Tiff => decoded(path, image::ImageFormat::Tiff),
        ImageFormat::WebP => decoded(path, image::ImageFormat::WebP),
        ImageFormat::Exr => decoded(path, image::ImageFormat::OpenExr),
        ImageFormat::Npy => read_npy(path),
    }
}

/// Bytes per pixel while decoding: as stored, at most a float per channel; as floats; and premultiplied.
const DECODING: u64 = 16 + 16 + 16;

fn decoded(path: &Path, format: image::ImageFormat) -> Result<Frame, Error> {
    caught(path, || decoded_by_crate(path, format))
}

fn decoded_by_crate(path: &Path, format: image::ImageFormat) -> Result<Frame, Error> {
    let damaged = |e: image::ImageError| match e {
        image::ImageError::IoError(e) => Error::read(path, e),
        e => Error::Image { path: path.into(), problem: e.to_string() },
    };
    let mut reader = ImageReader::open(path).map_err(|e| Error::read(path, e))?;
    reader.set_format(format);
    // Limits for damaged or malicious headers.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(memory::available());
    (limits.max_image_width, limits.max_image_height) = (Some(Viewport::MAX_SIDE), Some(Viewport::MAX_SIDE));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let viewport = size_of(path, width, height)?;
    memory::require(&path.display().to_string(), viewport.pixels() as u64 * DECODING)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgba32f();
    let premultiplied = |p: &image::Rgba<f32>| match format {
        // EXR is premultiplied already.
        image::ImageFormat::OpenExr => p.0,
        _ => [p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3]],
    };
    finite(path, Frame::new(viewport, picture.pixels().map(premultiplied).collect()))
}

/// Checks the size of a picture.
fn size_of(path: &Path, width: u32, height: u32) -> Result<Viewport, Error> {
    Viewport::new(width, height).map_err(|_| {
        let problem = format!("it has {width}x{height} pixels: expected 1 to {} per side", Viewport::MAX_SIDE);
        Error::Image { path: path.into(), problem }
    })
}

fn read_npy(path: &Path) -> Result<Frame, Error> {
    let damaged = |problem: String| Error::Image { path: path.into(), problem };
    let failed = |e| Error::read(path, e);
    // The file, its numbers and its pixels.
    let len = std::fs::metadata(path).map_err(failed)?.len();
    memory::require(&path.display().to_string(), len.saturating_mul(3))?;
    let bytes = std::fs::read(path).map_err(failed)?;
    let header = npy::Header::from_bytes(&bytes).map_err(damaged)?;
    let [height, width, 4] = header.shape[..] else {
        return Err(damaged(format!("its shape is {:?}: expected height, width, 4", header.shape)));
    };
    if header.fortran_order {
        return Err(damaged("it is in Fortran order: save it in C order".into()));
    }
    let number = match header.descr.as_deref() {
        Some("<f4") => f32::from_le_bytes,
        Some(">f4") => f32::from_be_bytes,
        other => return Err(damaged(format!("its type is {}: expected float32", other.unwrap_or("not a plain number")))),
    };
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let viewport = size_of(path, side(width), side(height))?;
    let numbers = bytes.get(header.end as usize..).unwrap_or_default();
    let (expected, found) = (viewport.pixels() * 16, numbers.len());
    let truncated =
        || damaged(format!("{width}x{height} pixels of float32 are {expected} bytes, found {found}: it is truncated"));
    let numbers = numbers.get(..expected).ok_or_else(truncated)?;
    let (numbers, _) = numbers.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|&bytes| number(bytes)).collect();
    let (pixels, _) = numbers.as_chunks::<4>();
    finite(path, Frame::new(viewport, pixels.to_vec()))
}

/// Rejects pictures with non-finite numbers.
fn finite(path: &Path, frame: Frame) -> Result<Frame, Error> {
    let lost = frame.pixels().iter().flatten().filter(|n| !n.is_finite()).count();
    if lost > 0 {
        let problem = format!("{lost} of its numbers are NaN or infinite");
        return Err(Error::Image { path: path.into(), problem });
    }
    Ok(frame)
}
