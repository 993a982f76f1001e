//! The last refinement: several samples per pixel, drawn in strips of rows. A strip bounds the memory, and a hand waits for little of it.

use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::memory;
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::viewport::Viewport;

/// Samples of a strip: averaging and copying these takes milliseconds.
const STRIP: u32 = 1 << 18;
/// Samples per side of a pixel, one picture after another.
const SIDES: [u32; 2] = [2, 4];

/// A picture with N × N samples per pixel, as far as it is drawn.
pub(super) struct Sharpening {
    page: Viewport,
    /// Index of N.
    round: usize,
    /// Size with all samples.
    large: Viewport,
    pixels: Vec<[f32; 4]>,
    row: u32,
}

impl Sharpening {
    /// The first of the pictures.
    ///
    /// # Errors
    /// If the picture is too large.
    pub fn new(page: Viewport) -> Result<Self, Error> {
        Self::round(page, 0)
    }

    fn round(page: Viewport, round: usize) -> Result<Self, Error> {
        let large = Viewport::new(page.width * SIDES[round], page.height * SIDES[round])?;
        Ok(Self { page, round, large, pixels: memory::zeroed("the refined picture", page.pixels())?, row: 0 })
    }

    /// The next picture; `None` after the last.
    ///
    /// # Errors
    /// If it is too large.
    pub fn next(&self) -> Result<Option<Self>, Error> {
        (self.round + 1 < SIDES.len()).then(|| Self::round(self.page, self.round + 1)).transpose()
    }

    /// Draws the next strip. Returns whether the picture is whole.
    ///
    /// # Errors
    /// Those of a frame. The strip is drawn again then.
    pub fn draw_strip(&mut self, renderer: &mut Renderer, camera: &Camera, settings: &Settings) -> Result<bool, Error> {
        let (side, width) = (SIDES[self.round], self.page.width);
        let rows = (STRIP / (width * side * side)).clamp(1, self.page.height - self.row);
        let samples = self.row * side..(self.row + rows) * side;
        let (frame, _) = renderer.render_rows(camera, self.large, samples, settings)?;
        let first = (self.row * width) as usize;
        self.pixels[first..first + (rows * width) as usize].copy_from_slice(frame.averaged(side)?.pixels());
        self.row += rows;
        Ok(self.row == self.page.height)
    }

    /// The whole picture; its pixels are taken.
    pub fn frame(&mut self) -> Frame {
        Frame::new(self.page, std::mem::take(&mut self.pixels))
    }
}
