//! What of a volume is shown. The field stays what it is: clipping cuts rays, not data.

use crate::error::Error;
use glam::DVec3;

/// A box in voxel coordinates (voxel (i, j, k) sits at (i, j, k)): only what lies in it is shown.
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
    /// Its lowest corner.
    pub lowest: DVec3,
    /// Its highest corner, above the lowest along every axis.
    pub highest: DVec3,
}

/// A plane in world coordinates: only what lies on the side that its normal points to is shown.
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
    /// A point of the plane.
    pub point: DVec3,
    /// Its normal, of any length but 0.
    pub normal: DVec3,
}

/// A crop box and up to six planes.
///
/// ```
/// use layersplat::settings::Clipping;
///
/// assert!(Clipping::default().is_empty());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clipping {
    /// Only what lies in this box is shown; all if there is none.
    pub crop: Option<CropBox>,
    /// And before all of these planes.
    pub planes: [Option<ClipPlane>; Clipping::MAX_PLANES],
}

impl Clipping {
    /// Most planes.
    pub const MAX_PLANES: usize = 6;

    /// With these planes, of which the first [`Clipping::MAX_PLANES`] count.
    pub fn with_planes(mut self, planes: impl IntoIterator<Item = ClipPlane>) -> Self {
        let mut planes = planes.into_iter();
        self.planes = std::array::from_fn(|_| planes.next());
        self
    }

    /// Whether nothing is cut off.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every number.
    pub(super) fn check(&self) -> Result<(), Error> {
        if let Some(CropBox { lowest, highest }) = self.crop
            && !lowest.cmplt(highest).all()
        {
            let value = format!("{lowest} to {highest}");
            return Err(Error::OutOfRange { name: "clipping", value, expected: "a lower before a higher voxel along each axis" });
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
