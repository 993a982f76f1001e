//! PNG and NPY files.

use super::Frame;
use crate::error::Error;
use crate::files::write_whole;
use crate::memory;
use crate::viewport::Viewport;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader, Limits, codecs::png::PngEncoder};
use npyz::WriterBuilder;
use std::io;
use std::path::Path;

/// File formats of pictures.
///
/// ```
/// use layersplat::image::ImageFormat;
/// use std::path::Path;
///
/// assert!(ImageFormat::of(Path::new("picture.png")).is_ok());
/// assert!(ImageFormat::of(Path::new("picture.doc")).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageFormat {
    /// 8-bit RGBA.
    Png,
    /// NumPy array, float32, H×W×4, premultiplied.
    Npy,
}

impl ImageFormat {
    /// The format that a file name's ending asks for.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(ImageFormat::Png),
            Some("npy") => Ok(ImageFormat::Npy),
            _ => {
                let name = path.display().to_string();
                Err(Error::UnknownName { what: "picture format", name, known: "a name ending in .png or .npy".into() })
            }
        }
    }
}

pub(super) fn write_png(path: &Path, viewport: Viewport, rgba: &[u8]) -> Result<(), Error> {
    write_whole(path, |out| {
        PngEncoder::new(out)
            .write_image(rgba, viewport.width, viewport.height, ExtendedColorType::Rgba8)
            .map_err(io::Error::other)
    })
}

pub(super) fn write_npy(path: &Path, frame: &Frame) -> Result<(), Error> {
    write_whole(path, |out| {
        let shape = [u64::from(frame.height()), u64::from(frame.width()), 4];
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(out).begin_nd()?;
        writer.extend(frame.pixels().iter().flatten())?;
        writer.finish()
    })
}

/// Reads a `.png` or `.npy` picture as premultiplied floats.
pub fn read_image(path: &Path) -> Result<Frame, Error> {
    match ImageFormat::of(path)? {
        ImageFormat::Png => read_png(path),
        ImageFormat::Npy => read_npy(path),
    }
}

/// Bytes per pixel while a PNG becomes floats: its own, at most 16 bits per channel, as floats, and premultiplied.
const DECODING: u64 = 8 + 16 + 16;

fn read_png(path: &Path) -> Result<Frame, Error> {
    let damaged = |e: image::ImageError| match e {
        image::ImageError::IoError(e) => Error::read(path, e),
        e => Error::Image { path: path.into(), problem: e.to_string() },
    };
    let mut reader = ImageReader::open(path).map_err(|e| Error::read(path, e))?;
    reader.set_format(image::ImageFormat::Png);
    // The numbers of a file are as little to be trusted as the machine is to have the memory.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(memory::available());
    (limits.max_image_width, limits.max_image_height) = (Some(Viewport::MAX_SIDE), Some(Viewport::MAX_SIDE));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let viewport = size_of(path, width, height)?;
    memory::require(&path.display().to_string(), viewport.pixels() as u64 * DECODING)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgba32f();
    let premultiplied = |p: &image::Rgba<f32>| [p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3]];
    Ok(Frame::new(viewport, picture.pixels().map(premultiplied).collect()))
}

/// The size of the picture in a file.
fn size_of(path: &Path, width: u32, height: u32) -> Result<Viewport, Error> {
    Viewport::new(width, height).map_err(|_| {
        let problem = format!("it has {width}x{height} pixels: expected 1 to {} per side", Viewport::MAX_SIDE);
        Error::Image { path: path.into(), problem }
    })
}

fn read_npy(path: &Path) -> Result<Frame, Error> {
    let damaged = |problem: String| Error::Image { path: path.into(), problem };
    let file = std::fs::File::open(path).map_err(|e| Error::read(path, e))?;
    let array = npyz::NpyFile::new(io::BufReader::new(file)).map_err(|e| damaged(e.to_string()))?;
    let [height, width, 4] = *array.shape() else {
        return Err(damaged(format!("its shape is {:?}: expected height, width, 4", array.shape())));
    };
    if array.order() != npyz::Order::C {
        return Err(damaged("it is in Fortran order: save it in C order".into()));
    }
    let side = |n: u64| u32::try_from(n).unwrap_or(u32::MAX);
    let viewport = size_of(path, side(width), side(height))?;
    memory::require(&path.display().to_string(), viewport.pixels() as u64 * 16)?;
    let numbers = array.into_vec::<f32>().map_err(|e| damaged(format!("{e}: it must hold float32")))?;
    let lost = numbers.iter().filter(|n| !n.is_finite()).count();
    if lost > 0 {
        return Err(damaged(format!("{lost} of its numbers are NaN or infinite")));
    }
    let (pixels, _) = numbers.as_chunks::<4>();
    Ok(Frame::new(viewport, pixels.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Background;

    fn frame() -> Frame {
        let pixels = vec![
            [0.0; 4],
            [0.25, 0.0, 0.5, 0.5],
            [1.0, 1.0, 1.0, 1.0],
            [0.1, 0.2, 0.3, 0.4],
            [0.0, 0.0, 0.0, 1.0],
            [0.5, 0.5, 0.5, 0.75],
        ];
        Frame::new(Viewport::new(3, 2).unwrap(), pixels)
    }

    #[test]
    fn files_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let npy = folder.path().join("a.npy");
        frame().save(&npy, None).unwrap();
        assert_eq!(read_image(&npy).unwrap(), frame());
        let png = folder.path().join("a.png");
        frame().save(&png, Some(Background::Transparent)).unwrap();
        assert!(read_image(&png).unwrap().compare(&frame()).unwrap().max_difference < 1.0 / 255.0);
        frame().save(&png, None).unwrap();
        let over_black = read_image(&png).unwrap();
        assert!(over_black.pixels().iter().all(|p| p[3] == 1.0));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "temporary files stay behind");
    }

    #[test]
    fn truncated_files_are_refused_at_any_length() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.npy", "a.png"] {
            let path = folder.path().join(name);
            frame().save(&path, None).unwrap();
            let whole = std::fs::read(&path).unwrap();
            // The last 12 bytes of a PNG are an empty closing chunk, which decoders may do without.
            for length in 0..whole.len() - 12 {
                std::fs::write(&path, &whole[..length]).unwrap();
                assert!(read_image(&path).is_err(), "{name} at {length} of {}", whole.len());
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_what_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("a.npy"), folder.path().join("link.npy"));
        frame().save(&target, Some(Background::BLACK)).unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        frame().save(&link, None).unwrap();
        assert!(link.is_symlink());
        assert_eq!(read_image(&target).unwrap(), frame());
    }

    #[test]
    fn unwritable_places_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        assert!(frame().save(folder.path().join("missing/a.png"), None).is_err());
        assert!(frame().save(folder.path().join("a.jpg"), None).is_err());
        let lost =
            Frame::new(Viewport::new(3, 2).unwrap(), frame().pixels().iter().map(|p| [f32::NAN, p[1], p[2], p[3]]).collect());
        let unfinished = folder.path().join("nan.npy");
        lost.save(&unfinished, None).unwrap();
        assert!(read_image(&unfinished).unwrap_err().to_string().contains("6 of its numbers"));
        std::fs::remove_file(unfinished).unwrap();
        std::fs::create_dir(folder.path().join("b.png")).unwrap();
        assert!(frame().save(folder.path().join("b.png"), None).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
