//! Picture file formats, and how pictures are encoded in them.

use super::Background;
use crate::error::Error;
use std::num::NonZeroU16;
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
    /// RGBA of 8 or 16 bits, marked as sRGB.
    Png,
    /// 8-bit RGB without transparency; the picture is composited over an opaque colour.
    Jpeg,
    /// Baseline TIFF, LZW-compressed: RGB of 8 or 16 bits, or RGBA with a transparent background. Needs the feature `tiff`.
    Tiff,
    /// Lossless WebP: 8-bit RGB, or RGBA with a transparent background.
    WebP,
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
    /// [`Error::UnknownName`] if no format has it, [`Error::Image`] if this build lacks the feature that the format needs.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(ImageFormat::Png),
            Some("jpg" | "jpeg") => Ok(ImageFormat::Jpeg),
            Some("tif" | "tiff") if cfg!(feature = "tiff") => Ok(ImageFormat::Tiff),
            Some("tif" | "tiff") => {
                let problem = "TIFF needs a build with the feature tiff: use .png instead".into();
                Err(Error::Image { path: path.into(), problem })
            }
            Some("webp") => Ok(ImageFormat::WebP),
            Some("exr") => Ok(ImageFormat::Exr),
            Some("npy") => Ok(ImageFormat::Npy),
            _ => {
                let name = path.display().to_string();
                Err(Error::UnknownName {
                    what: "picture format",
                    name,
                    known: "a name ending in .png, .jpg, .tif, .webp, .exr or .npy".into(),
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
            let problem = "JPEG does not support transparency: choose a colour, or write .png, .tif, .webp, .exr or .npy".into();
            return Err(Error::Settings { field: "background", problem });
        }
        Ok(())
    }

    /// Whether pixels are floats, not integers.
    pub fn has_floats(self) -> bool {
        matches!(self, ImageFormat::Exr | ImageFormat::Npy)
    }

    fn name(self) -> &'static str {
        match self {
            ImageFormat::Png => "PNG",
            ImageFormat::Jpeg => "JPEG",
            ImageFormat::Tiff => "TIFF",
            ImageFormat::WebP => "WebP",
            ImageFormat::Exr => "OpenEXR",
            ImageFormat::Npy => "NumPy",
        }
    }
}

/// Bits per channel of a picture file of integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitDepth {
    /// 0 … 255.
    Eight,
    /// 0 … 65535, in PNG and TIFF.
    Sixteen,
}

/// How a picture is encoded in a file. The default is that of the format: 8 bits, or floats, rounded, without a resolution.
///
/// ```
/// use layersplat::image::{BitDepth, Encoding, ImageFormat};
///
/// let deep = Encoding { bits: Some(BitDepth::Sixteen), ..Encoding::default() };
/// assert!(deep.check(ImageFormat::Png).is_ok() && deep.check(ImageFormat::Jpeg).is_err());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Encoding {
    /// Bits per channel. `None` is 8, or floats in formats of floats.
    pub bits: Option<BitDepth>,
    /// Dithers 8-bit pixels by a fixed blue-noise pattern of 64 × 64 pixels (void and cluster, Ulichney 1993), so that smooth shades show
    /// no bands. Without it, they are rounded.
    pub dither: bool,
    /// Resolution for print in pixels per inch.
    pub dpi: Option<NonZeroU16>,
    /// Text for the file's metadata, for example the command that made the picture: `Description` of PNG, `comments` of OpenEXR. Other
    /// formats are written without it.
    pub description: Option<String>,
}

impl Encoding {
    /// Rejects what a format cannot hold.
    ///
    /// # Errors
    /// [`Error::Settings`], which names the field (`bits`, `dither` or `dpi`) and formats that can.
    pub fn check(&self, format: ImageFormat) -> Result<(), Error> {
        let name = format.name();
        let (field, problem) = match *self {
            Self { bits: Some(_), .. } if format.has_floats() => {
                ("bits", format!("{name} files hold 32-bit floats here: omit the bits, or write .png or .tif"))
            }
            Self { bits: Some(BitDepth::Sixteen), .. } if !matches!(format, ImageFormat::Png | ImageFormat::Tiff) => {
                ("bits", format!("{name} has 8 bits per channel: write .png or .tif for 16"))
            }
            Self { dither: true, .. } if format.has_floats() => (
                "dither",
                format!("{name} files hold floats, which need no dithering: omit it, or write .png, .jpg, .tif or .webp"),
            ),
            Self { dither: true, bits: Some(BitDepth::Sixteen), .. } => {
                ("dither", "16 bits need no dithering: omit it, or choose 8 bits".into())
            }
            Self { dpi: Some(_), .. } if matches!(format, ImageFormat::WebP | ImageFormat::Npy) => {
                ("dpi", format!("{name} files hold no resolution: omit it, or write .png, .jpg, .tif or .exr"))
            }
            _ => return Ok(()),
        };
        Err(Error::Settings { field, problem })
    }

    /// The first field that differs from the default.
    #[doc(hidden)]
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [("bits", self.bits.is_some()), ("dither", self.dither), ("dpi", self.dpi.is_some())];
        given.into_iter().find(|(_, given)| *given).map(|(field, _)| field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What each format can hold; every refusal names its field and a format that works.
    #[test]
    fn formats_refuse_what_they_cannot_hold() {
        use ImageFormat::{Exr, Jpeg, Npy, Png, Tiff, WebP};
        let all = [Png, Jpeg, Tiff, WebP, Exr, Npy];
        let (eight, sixteen) = (Some(BitDepth::Eight), Some(BitDepth::Sixteen));
        let none = Encoding::default();
        let cases: [(Encoding, &str, &[ImageFormat]); 6] = [
            (none.clone(), "", &all),
            (Encoding { description: Some("text".into()), ..none.clone() }, "", &all),
            (Encoding { bits: eight, ..none.clone() }, "bits", &[Png, Jpeg, Tiff, WebP]),
            (Encoding { bits: sixteen, ..none.clone() }, "bits", &[Png, Tiff]),
            (Encoding { dither: true, ..none.clone() }, "dither", &[Png, Jpeg, Tiff, WebP]),
            (Encoding { dpi: NonZeroU16::new(300), ..none }, "dpi", &[Png, Jpeg, Tiff, Exr]),
        ];
        for (encoding, field, accepted) in cases {
            for format in all {
                match encoding.check(format) {
                    Ok(()) => assert!(accepted.contains(&format), "{encoding:?}, {format:?}"),
                    Err(e) => {
                        assert!(!accepted.contains(&format) && e.fields() == [field], "{encoding:?}, {format:?}: {e}");
                        assert!(e.to_string().contains(".png"), "{e}");
                    }
                }
            }
        }
        let both = Encoding { bits: sixteen, dither: true, ..Encoding::default() }.check(Png).unwrap_err();
        assert!(both.fields() == ["dither"] && both.to_string().contains("8 bits"), "{both}");
    }
}
