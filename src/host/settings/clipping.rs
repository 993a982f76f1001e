//! Clipping. It affects rays only; the data stay unchanged.

use crate::error::Error;
use glam::DVec3;

/// A box in voxel coordinates, where voxel (i, j, k) lies at (i, j, k). Only its interior is shown.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::settings::{Clipping, CropBox, Settings};
///
/// let crop = CropBox { lowest: DVec3::ZERO, highest: DVec3::new(63.0, 63.0, 20.0) };
/// let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
/// let settings = Settings { clipping, ..Settings::default() };
/// assert!(!settings.clipping.is_empty());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CropBox {
    /// Lowest corner.
    pub lowest: DVec3,
    /// Highest corner; must exceed the lowest along every axis.
    pub highest: DVec3,
}

/// A clip plane in world coordinates. Only the side that its normal points to is shown.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::settings::{ClipPlane, Clipping, Settings};
///
/// let cut = ClipPlane { point: DVec3::splat(31.5), normal: DVec3::new(1.0, 0.0, 1.0) };
/// let settings = Settings { clipping: Clipping::default().with_planes([cut]), ..Settings::default() };
/// assert_eq!(settings.clipping.planes[0], Some(cut));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    /// A point on the plane.
    pub point: DVec3,
    /// Normal of any length above 0.
    pub normal: DVec3,
}

/// A crop box and up to six clip planes.
///
/// ```
/// use layersplat::settings::Clipping;
///
/// assert!(Clipping::default().is_empty());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clipping {
    /// Crop box; `None` shows everything.
    pub crop: Option<CropBox>,
    /// Clip planes. Their half-spaces intersect.
    pub planes: [Option<ClipPlane>; Clipping::MAX_PLANES],
}

impl Clipping {
    /// Largest number of clip planes.
    pub const MAX_PLANES: usize = 6;

    /// Sets the clip planes. Only the first [`Clipping::MAX_PLANES`] are used.
    pub fn with_planes(mut self, planes: impl IntoIterator<Item = ClipPlane>) -> Self {
        let mut planes = planes.into_iter();
        self.planes = std::array::from_fn(|_| planes.next());
        self
    }

    /// Whether nothing is clipped.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks all values.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), Error> {
        if let Some(CropBox { lowest, highest }) = self.crop
            && !lowest.cmplt(highest).all()
        {
            let value = format!("{lowest} to {highest}");
            return Err(Error::OutOfRange { name: "clipping", value, expected: "lowest below highest along each axis" });
        }
        match self.planes.iter().flatten().find(|p| !p.point.is_finite() || p.normal.try_normalize().is_none()) {
            Some(p) => {
                let value = format!("{} with normal {}", p.point, p.normal);
                Err(Error::OutOfRange { name: "clipping", value, expected: "a finite point and a finite normal other than 0" })
            }
            None => Ok(()),
        }
    }
}
