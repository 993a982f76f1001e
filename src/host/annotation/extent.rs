//! Size of a picture, and of what is drawn on it.

use crate::image::{EM, text_size};
use crate::viewport::Viewport;
use glam::DVec2;

/// Shorter side in pixels per unit of scale. At twice this size, everything is drawn twice as large.
const SCALE: u32 = 480;

/// A picture's size, and the scale of annotations on it: 1 for letters with an em square of 12 pixels.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub viewport: Viewport,
    pub scale: f64,
}

impl Extent {
    /// The scale follows the size of letters in pixels; by default the size of the picture, in whole steps of at least 1.
    pub fn new(viewport: Viewport, font_size: Option<f64>) -> Self {
        let shorter = viewport.width.min(viewport.height);
        let of_picture = f64::from(((shorter + SCALE / 2) / SCALE).max(1));
        Self { viewport, scale: font_size.map_or(of_picture, |pixels| pixels / f64::from(EM)) }
    }

    /// Size of text in pixels.
    pub fn measured(&self, text: &str) -> DVec2 {
        let [width, height] = text_size(text, self.scale as f32);
        DVec2::new(width.into(), height.into())
    }
}
