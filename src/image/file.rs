//! Atomic picture output.

use super::{Background, Depths, Frame};
use crate::error::Error;
use crate::files::write_whole;
use crate::viewport::Viewport;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use npyz::WriterBuilder;
use std::io;
use std::path::Path;

/// Picture file formats.
///
/// ```
/// use layersplat::image::ImageFormat;
/// use std::path::Path;
///
/// assert!(ImageFormat::from_path(Path::new("picture.png")).is_ok());
/// assert!(ImageFormat::from_path(Path::new("picture.doc")).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageFormat {
    /// 8-bit RGBA.
    Png,
    /// 8-bit RGB without transparency; the picture is composited over an opaque colour.
    Jpeg,
    /// OpenEXR with premultiplied 32-bit float RGBA. Values are those of the frame: n/255 in a `.png` is n/255 here. Programs that interpret
    /// them as linear light display a brighter picture.
    Exr,
    /// NumPy array, float32, shape (height, width, 4), premultiplied.
    Npy,
}

impl ImageFormat {
    /// The format of a file extension.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if no format has it.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(ImageFormat::Png),
            Some("jpg" | "jpeg") => Ok(ImageFormat::Jpeg),
            Some("exr") => Ok(ImageFormat::Exr),
            Some("npy") => Ok(ImageFormat::Npy),
            _ => {
                let name = path.display().to_string();
                Err(Error::UnknownName {
                    what: "picture format",
                    name,
                    known: "a name ending in .png, .jpg, .exr or .npy".into(),
                })
            }
        }
    }

    /// The format of a file extension, which must support depths: `.exr`.
    ///
    /// # Errors
    /// As [`ImageFormat::from_path`], and for formats without depths.
    pub fn with_depths(path: &Path) -> Result<Self, Error> {
        let format = Self::from_path(path)?;
        if format != ImageFormat::Exr {
            let problem = format!("{} cannot hold depths: use an .exr file", path.display());
            return Err(Error::Settings { field: "depth", problem });
        }
        Ok(format)
    }

    /// Rejects a background that the format does not support: a transparent one in JPEG.
    ///
    /// # Errors
    /// [`Error::Settings`] for such a background.
    pub fn accept(self, background: Option<Background>) -> Result<(), Error> {
        if self == ImageFormat::Jpeg && background == Some(Background::Transparent) {
            let problem = "JPEG does not support transparency: choose a colour, or write .png, .exr or .npy".into();
            return Err(Error::Settings { field: "background", problem });
        }
        Ok(())
    }
}

pub(super) fn write_png(path: &Path, viewport: Viewport, rgba: &[u8]) -> Result<(), Error> {
    write_whole(path, |out| {
        PngEncoder::new(out)
            .write_image(rgba, viewport.width, viewport.height, ExtendedColorType::Rgba8)
            .map_err(io::Error::other)
    })
}

/// JPEG quality, up to 100. At 85 and above, chroma is not subsampled and ringing is invisible.
const JPEG_QUALITY: u8 = 92;

/// Writes opaque RGBA8 pixels.
pub(super) fn write_jpeg(path: &Path, viewport: Viewport, rgba: &[u8]) -> Result<(), Error> {
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    write_whole(path, |out| {
        JpegEncoder::new_with_quality(out, JPEG_QUALITY)
            .write_image(&rgb, viewport.width, viewport.height, ExtendedColorType::Rgb8)
            .map_err(io::Error::other)
    })
}

/// Writes the picture, and depths if given.
pub(super) fn write_exr(path: &Path, frame: &Frame, depths: Option<&Depths>) -> Result<(), Error> {
    let channel = |name: &str, numbers| AnyChannel::new(name, FlatSamples::F32(numbers));
    let color = |(i, name)| channel(name, frame.pixels().iter().map(|pixel| pixel[i]).collect());
    let colors = ["R", "G", "B", "A"].into_iter().enumerate().map(color);
    let depths = depths.into_iter().flat_map(|depths| [("Z", depths.first()), ("mean.Z", depths.mean())]);
    let channels = colors.chain(depths.map(|(name, numbers)| channel(name, numbers.to_vec()))).collect();
    let image = Image::from_channels((frame.width() as usize, frame.height() as usize), AnyChannels::sort(channels));
    // The encoder seeks back to write its offset table.
    let mut encoded = io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut encoded).map_err(|e| Error::write(path, io::Error::other(e)))?;
    write_whole(path, |out| out.write_all(encoded.get_ref()))
}

pub(super) fn write_npy(path: &Path, frame: &Frame) -> Result<(), Error> {
    write_whole(path, |out| {
        let shape = [u64::from(frame.height()), u64::from(frame.width()), 4];
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(out).begin_nd()?;
        writer.extend(frame.pixels().iter().flatten())?;
        writer.finish()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::read_image;

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
        let exr = folder.path().join("a.exr");
        frame().save(&exr, None).unwrap();
        assert_eq!(read_image(&exr).unwrap(), frame());
        frame().save(&exr, Some(Background::Color([0.0, 0.0, 1.0]))).unwrap();
        assert_eq!(read_image(&exr).unwrap(), frame().over(Background::Color([0.0, 0.0, 1.0])));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "no temporary files may be left");
    }

    /// Largest error of smooth gradients in JPEG, relative to 1: coefficients are rounded by a few steps of 255.
    const JPEG_ERROR: f64 = 0.025;

    #[test]
    fn jpeg_stands_on_a_colour() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpeg");
        let ramp = |n: usize| [(n % 32) as f32 / 64.0, (n / 32) as f32 / 64.0, 0.2, 0.5];
        let smooth = Frame::new(Viewport::new(32, 24).unwrap(), (0..32 * 24).map(ramp).collect());
        for background in [None, Some(Background::Color([1.0, 0.5, 0.0]))] {
            smooth.save(&path, background).unwrap();
            let expected = smooth.clone().over(background.unwrap_or(Background::BLACK));
            let found = read_image(&path).unwrap().compare(&expected).unwrap().max_difference;
            assert!(found < JPEG_ERROR, "{background:?}: {found}");
        }
        std::fs::remove_file(&path).unwrap();
        let refused = smooth.save(&path, Some(Background::Transparent)).unwrap_err();
        assert!(refused.to_string().contains("not support transparency") && refused.fields() == ["background"], "{refused}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn truncated_files_are_refused_at_any_length() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.npy", "a.png", "a.exr", "a.jpg"] {
            let path = folder.path().join(name);
            frame().save(&path, None).unwrap();
            let whole = std::fs::read(&path).unwrap();
            // The last 12 bytes of a PNG are an empty end chunk, which decoders may ignore. They may also tolerate a few missing bytes in a JPEG.
            let needed = if name == "a.jpg" { header_of(&whole) } else { whole.len() - 12 };
            for length in 0..needed {
                std::fs::write(&path, &whole[..length]).unwrap();
                assert!(read_image(&path).is_err(), "{name} at {length} of {}", whole.len());
            }
        }
    }

    /// Bytes of a JPEG before its coefficients.
    fn header_of(jpeg: &[u8]) -> usize {
        jpeg.windows(2).position(|marker| marker == [0xff, 0xda]).unwrap()
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
        assert!(frame().save(folder.path().join("a.bmp"), None).is_err());
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
