//! Linear mapping from stored numbers to values.

use crate::error::Error;
use crate::numbers::shortened;

/// value = slope · stored + intercept. Voxels keep their stored type, also on the device. The transfer function is mapped instead.
///
/// ```
/// use layersplat::volume::Rescale;
///
/// // Hounsfield units of a scanner that stores 0 ... 4095.
/// let rescale = Rescale::new(1.0, -1024.0)?;
/// assert_eq!((rescale.value(1024.0), rescale.stored(-1024.0)), (0.0, 0.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rescale {
    slope: f64,
    intercept: f64,
}

impl Default for Rescale {
    fn default() -> Self {
        Self { slope: 1.0, intercept: 0.0 }
    }
}

impl Rescale {
    /// Creates a mapping. The slope is a finite number other than 0, the intercept any finite number.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for other numbers.
    pub fn new(slope: f64, intercept: f64) -> Result<Self, Error> {
        if slope.is_finite() && slope != 0.0 && intercept.is_finite() {
            return Ok(Self { slope, intercept });
        }
        let expected = "a finite slope other than 0, and a finite intercept";
        Err(Error::OutOfRange {
            name: "rescale slope and intercept",
            value: format!("{}, {}", shortened(slope), shortened(intercept)),
            expected,
        })
    }

    /// Factor of stored numbers.
    pub fn slope(self) -> f64 {
        self.slope
    }

    /// Value of a stored 0.
    pub fn intercept(self) -> f64 {
        self.intercept
    }

    /// Value of a stored number.
    pub fn value(self, stored: f64) -> f64 {
        self.slope * stored + self.intercept
    }

    /// Stored number of a value, not rounded.
    pub fn stored(self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }

    /// Maps a range of stored numbers to an ascending range of values.
    pub(super) fn range(self, (lo, hi): (f64, f64)) -> (f64, f64) {
        let (a, b) = (self.value(lo), self.value(hi));
        (a.min(b), a.max(b))
    }
}
