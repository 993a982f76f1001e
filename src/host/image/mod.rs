//! Pictures: frames, picture files and comparison.

mod animation;
mod averaged;
mod background;
mod blue_noise;
mod depths;
mod display;
mod file;
mod format;
mod metrics;
mod read;
#[doc(hidden)]
pub mod text;

pub use crate::files::write_whole;
pub use animation::{Animation, AnimationFormat};
pub use background::Background;
pub use depths::Depths;
pub use format::{BitDepth, Encoding, ImageFormat};
pub use metrics::Comparison;
pub use read::read_image;
#[doc(hidden)]
pub use text::EM;
pub use text::{draw_text, text_size};

use crate::color::Curve;
use crate::error::Error;
use crate::memory;
use crate::viewport::Viewport;
use std::borrow::Cow;
use std::path::Path;

/// A picture: premultiplied RGBA in 0 … 1, row by row, row 0 at the top.
///
/// ```
/// use layersplat::{Background, Frame, Viewport};
///
/// let frame = Frame::new(Viewport::new(2, 1)?, vec![[0.5, 0.0, 0.0, 0.5], [0.0; 4]]);
/// assert_eq!(frame.to_rgba8(Background::BLACK), [128, 0, 0, 255, 0, 0, 0, 255]);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Frame {
    viewport: Viewport,
    pixels: Vec<[f32; 4]>,
    curve: Curve,
}

/// Frames are equal if their pixels are: floats that were read from a file or from a device have no curve.
impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        self.viewport == other.viewport && self.pixels == other.pixels
    }
}

impl Frame {
    /// Creates a frame of `viewport.pixels()` pixels.
    ///
    /// # Panics
    /// If `pixels` has another length.
    pub fn new(viewport: Viewport, pixels: Vec<[f32; 4]>) -> Self {
        assert_eq!(pixels.len(), viewport.pixels());
        Self { viewport, pixels, curve: Curve::NONE }
    }

    /// Conversions to 8 and 16 bits apply a curve to straight colours. Floats stay as they are. Rendered frames have that of their settings;
    /// averaged and annotated frames keep it, and differences have none.
    pub fn with_curve(self, curve: Curve) -> Self {
        Self { curve, ..self }
    }

    /// The frame with coded colours, as those of annotations are: after all of a curve but the gamma, which conversions apply.
    #[doc(hidden)]
    pub fn coded(self, curve: Curve) -> Self {
        let coded = Curve { gamma: 1.0, ..curve };
        self.with_curve(coded).curved().into_owned().with_curve(curve.of_coded())
    }

    /// The curve of conversions to 8 and 16 bits.
    #[doc(hidden)]
    pub fn curve(&self) -> Curve {
        self.curve
    }

    /// The frame as it is converted to integers: after its curve.
    #[doc(hidden)]
    pub fn curved(&self) -> Cow<'_, Self> {
        if self.curve == Curve::NONE {
            return Cow::Borrowed(self);
        }
        let pixels = self.pixels.iter().map(|&pixel| display::curved(pixel, &self.curve));
        Cow::Owned(Self::new(self.viewport, pixels.collect()))
    }

    /// Number of columns.
    pub fn width(&self) -> u32 {
        self.viewport.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.viewport.height
    }

    /// Pixels, row by row.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Consumes the frame and returns its pixels without a copy.
    pub fn into_pixels(self) -> Vec<[f32; 4]> {
        self.pixels
    }

    /// Pixel at a column and a row.
    pub fn pixel(&self, column: u32, row: u32) -> [f32; 4] {
        self.pixels[row as usize * self.viewport.width as usize + column as usize]
    }

    /// Composites the picture over an opaque colour; `Transparent` leaves it unchanged.
    pub fn over(mut self, background: Background) -> Self {
        if let Background::Color(color) = background {
            for pixel in &mut self.pixels {
                *pixel = display::over(*pixel, color);
            }
        }
        self
    }

    /// Converts to 8-bit RGBA: over an opaque colour, or with straight alpha. Halves are rounded up. The bytes equal those of
    /// `Renderer::render_rgba8`.
    pub fn to_rgba8(&self, background: Background) -> Vec<u8> {
        self.curved().pixels.iter().flat_map(|&pixel| display::displayed(pixel, background)).collect()
    }

    /// Writes a `.png`, `.jpg`, `.tif`, `.webp` (8 bits), `.exr` or `.npy` (float32, H×W×4) file atomically. Without a background, `.exr` and
    /// `.npy` keep alpha, and the other formats use opaque black.
    ///
    /// # Errors
    /// If the extension is unknown, the file cannot be written, or the background is `Transparent` for a `.jpg`.
    pub fn save(&self, path: impl AsRef<Path>, background: Option<Background>) -> Result<(), Error> {
        self.save_encoded(path, background, &Encoding::default(), None)
    }

    /// As [`Frame::save`], with the bits, dithering and resolution of `encoding`, and with depths if given ([`Frame::save_with_depths`]).
    ///
    /// ```
    /// use layersplat::image::{BitDepth, Encoding};
    /// use layersplat::{Frame, Viewport};
    ///
    /// let folder = tempfile::tempdir().expect("a folder");
    /// let frame = Frame::new(Viewport::new(2, 1)?, vec![[0.25, 0.0, 0.5, 1.0]; 2]);
    /// let deep = Encoding { bits: Some(BitDepth::Sixteen), ..Encoding::default() };
    /// frame.save_encoded(folder.path().join("deep.png"), None, &deep, None)?;
    /// assert!(frame.save_encoded(folder.path().join("deep.jpg"), None, &deep, None).is_err());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Frame::save`], [`Encoding::check`] and [`Frame::save_with_depths`].
    pub fn save_encoded(
        &self,
        path: impl AsRef<Path>,
        background: Option<Background>,
        encoding: &Encoding,
        depths: Option<&Depths>,
    ) -> Result<(), Error> {
        let path = path.as_ref();
        let format = if depths.is_some() { ImageFormat::with_depths(path)? } else { ImageFormat::from_path(path)? };
        format.accept(background)?;
        encoding.check(format)?;
        depths.map_or(Ok(()), |depths| depths.check_size(self.viewport))?;
        let frame = if format.has_floats() { Cow::Borrowed(self) } else { self.curved() };
        file::write(path, &frame, format, background, encoding, depths)
    }

    /// The picture over an opaque colour if given, else unchanged.
    fn standing_on(&self, background: Option<Background>) -> Cow<'_, Self> {
        match background {
            Some(background @ Background::Color(_)) => Cow::Owned(self.clone().over(background)),
            _ => Cow::Borrowed(self),
        }
    }

    /// Roughness of the picture: 1000 times the rms of the 5-point Laplacian of the luminance, 0 … 1, over pixels of an opacity above ½ that
    /// are at least 2 pixels from all others and from the border. `None` without such pixels.
    ///
    /// Lit pictures of data of few bits or with thick slices are rough where gradients show their steps.
    pub fn roughness(&self) -> Option<f64> {
        metrics::roughness(&self.pixels, self.viewport.width as usize)
    }

    /// Places the frame in the upper left corner of a transparent frame of `size`.
    ///
    /// # Errors
    /// If the frame is larger than `size`, or memory is insufficient.
    #[doc(hidden)]
    pub fn within(self, size: Viewport) -> Result<Frame, Error> {
        if self.viewport == size {
            return Ok(self);
        }
        let pixels = placed("the picture", &self.pixels, self.viewport, size, [0.0; 4])?;
        Ok(Frame::new(size, pixels).with_curve(self.curve))
    }

    /// Compares with another frame; `None` if the sizes differ.
    pub fn compare(&self, other: &Frame) -> Option<Comparison> {
        (self.viewport == other.viewport).then(|| Comparison::new(&self.pixels, &other.pixels))
    }
}

impl Frame {
    /// The absolute differences of red, green and blue from another frame, opaque, scaled so that the largest is 1.
    ///
    /// ```
    /// use layersplat::{Frame, Viewport};
    ///
    /// let one = |red| Ok::<_, layersplat::Error>(Frame::new(Viewport::new(1, 1)?, vec![[red, 0.5, 0.0, 1.0]]));
    /// assert_eq!(one(0.25)?.difference(&one(0.5)?)?.pixels(), [[1.0, 0.0, 0.0, 1.0]]);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the sizes differ.
    pub fn difference(&self, other: &Frame) -> Result<Frame, Error> {
        if self.viewport != other.viewport {
            let value = format!("{}x{}", other.width(), other.height());
            return Err(Error::OutOfRange { name: "viewport", value, expected: "a frame of the same size" });
        }
        let differences = || self.pixels.iter().zip(&other.pixels).map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
        let largest = differences().flatten().fold(0.0, f32::max);
        let scale = if largest > 0.0 { largest.recip() } else { 0.0 };
        let pixels = differences().map(|[r, g, b]| [r * scale, g * scale, b * scale, 1.0]).collect();
        Ok(Frame::new(self.viewport, pixels))
    }
}

/// Rows of `viewport.pixels()` elements in the upper left corner of larger ones; the others are `outside`.
fn placed<T: Copy>(what: &str, elements: &[T], viewport: Viewport, size: Viewport, outside: T) -> Result<Vec<T>, Error> {
    if viewport.width > size.width || viewport.height > size.height {
        let value = format!("{}x{}", viewport.width, viewport.height);
        return Err(Error::OutOfRange { name: "viewport", value, expected: "a frame that fits into the picture" });
    }
    memory::require(what, (size.pixels() * size_of::<T>()) as u64)?;
    let mut larger = vec![outside; size.pixels()];
    let rows = larger.chunks_exact_mut(size.width as usize).zip(elements.chunks_exact(viewport.width as usize));
    rows.for_each(|(larger, row)| larger[..row.len()].copy_from_slice(row));
    Ok(larger)
}
