//! How many pixels a picture has. Cameras need the shape, frames hold as many.

use crate::error::Error;

/// Size of a picture in pixels.
///
/// ```
/// use layersplat::Viewport;
///
/// assert_eq!(Viewport::new(640, 480)?.pixels(), 307_200);
/// assert!(Viewport::new(0, 480).is_err());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewport {
    /// Columns.
    pub width: u32,
    /// Rows; row 0 is on top.
    pub height: u32,
}

impl Viewport {
    /// Longest side of a picture, in pixels.
    pub const MAX_SIDE: u32 = 16_384;

    /// A viewport of 1 … [`Viewport::MAX_SIDE`] pixels per side.
    pub fn new(width: u32, height: u32) -> Result<Self, Error> {
        let range = 1..=Self::MAX_SIDE;
        if range.contains(&width) && range.contains(&height) {
            Ok(Self { width, height })
        } else {
            let value = format!("{width}x{height}");
            Err(Error::OutOfRange { name: "viewport", value, expected: "1 to 16384 pixels per side" })
        }
    }

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}
