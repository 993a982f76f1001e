//! Depth cueing.

use super::lights::check_color;
use super::number::Number;
use crate::error::Error;

/// Depth cueing: the colour of a sample fades to a colour with its distance along the view.
///
/// The share of that colour rises linearly from 0 at the nearest point of the volume's bounding box to `strength` at the farthest. The
/// distance is measured along the central ray, so planes of equal share are parallel to the screen. The box has the outermost voxels in its
/// corners and is cut by the crop box, but not by clip planes. In a perspective with the eye inside, the share rises from the eye on.
/// Opacities do not change.
///
/// ```
/// use layersplat::settings::{DepthCue, Settings};
///
/// let onto_white = DepthCue { strength: 0.6, color: [1.0; 3] };
/// let settings = Settings { depth_cue: Some(onto_white), ..Settings::default() };
/// assert_eq!(DepthCue::default().color, [0.0; 3]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthCue {
    /// Share of `color` at the farthest point, 0 … 1. With 0 the picture is that without depth cueing, to the bit.
    pub strength: f64,
    /// The colour that samples fade to: red, green, blue, 0 … 1. Choose that of the picture's background. Default: black, which dims them
    /// and suits transparent backgrounds, too.
    pub color: [f64; 3],
}

impl Default for DepthCue {
    fn default() -> Self {
        Self { strength: 0.5, color: [0.0; 3] }
    }
}

impl DepthCue {
    /// Range of the strength.
    pub const STRENGTH: Number = Number::new("depth_cue", 0.0, 1.0, "a strength from 0 to 1");

    /// Checks both ranges.
    pub(super) fn check(&self) -> Result<(), Error> {
        Self::STRENGTH.check(self.strength)?;
        check_color("depth_cue", self.color)
    }
}
