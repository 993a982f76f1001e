//! Ranges of the numbers of settings.

use crate::error::Error;

/// A number of the settings: its range, and how messages name both.
///
/// ```
/// use layersplat::settings::Shadows;
///
/// let error = Shadows::STRENGTH.check(1.5).unwrap_err();
/// assert_eq!(error.to_string(), "shadow_strength is 1.5: expected a strength from 0 to 1");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Number {
    field: &'static str,
    least: f64,
    most: f64,
    expected: &'static str,
}

/// The least number above 0.
pub(super) const ABOVE_0: f64 = f64::from_bits(1);

impl Number {
    /// `field` and `expected` are those of [`Error::OutOfRange`].
    pub(super) const fn new(field: &'static str, least: f64, most: f64, expected: &'static str) -> Self {
        Self { field, least, most, expected }
    }

    /// Whether a value is within the range.
    pub fn contains(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// The least and the largest value.
    pub fn range(&self) -> [f64; 2] {
        [self.least, self.most]
    }

    /// What values are expected.
    pub fn expected(&self) -> &'static str {
        self.expected
    }

    /// Checks a value.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] outside the range.
    pub fn check(&self, value: f64) -> Result<(), Error> {
        if self.contains(value) {
            return Ok(());
        }
        Err(Error::OutOfRange { name: self.field, value: value.to_string(), expected: self.expected })
    }
}
