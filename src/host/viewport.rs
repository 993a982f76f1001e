//! Picture size in pixels.

use crate::error::Error;

/// Width and height of a picture in pixels.
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
    /// Number of columns.
    pub width: u32,
    /// Number of rows; row 0 is at the top.
    pub height: u32,
}

impl Viewport {
    /// Longest side of a picture in pixels.
    pub const MAX_SIDE: u32 = 16_384;

    /// Creates a viewport with sides of 1 … [`Viewport::MAX_SIDE`] pixels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for other sizes.
    pub fn new(width: u32, height: u32) -> Result<Self, Error> {
        let range = 1..=Self::MAX_SIDE;
        if range.contains(&width) && range.contains(&height) {
            Ok(Self { width, height })
        } else {
            let value = format!("{width}x{height}");
            Err(Error::OutOfRange { name: "viewport", value, expected: "1 to 16384 pixels per side" })
        }
    }

    /// Total number of pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}
