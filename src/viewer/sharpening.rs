//! The last refinement: several samples per pixel, drawn in blocks, which bound the memory.

use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::memory;
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::ops::Range;

/// Samples per side of a block. Lattices reach beyond blocks, so smaller ones take longer. Averaging one takes about 10 ms, for which a hand
/// waits.
const BLOCK: u32 = 1536;
/// Samples per side of a pixel, one picture after another.
const SIDES: [u32; 2] = [2, 4];
/// Most pixels of a page whose pictures get the last of them. On larger pages, such as those of screens with twice the pixels per length, it would
/// take many times as long and hardly be seen.
const MOST_FINEST: usize = 2_000_000;

/// A picture with N × N samples per pixel, as far as it is drawn.
pub(super) struct Sharpening {
    page: Viewport,
    /// Index of N.
    round: usize,
    /// Size with all samples.
    large: Viewport,
    pixels: Vec<[f32; 4]>,
    /// Pixels per side of a block.
    block: u32,
    /// Blocks that are drawn, row by row.
    drawn: u32,
}

impl Sharpening {
    /// The picture of a round, from 0.
    ///
    /// # Errors
    /// If the picture is too large.
    pub fn new(page: Viewport, round: usize) -> Result<Self, Error> {
        let large = Viewport::new(page.width * SIDES[round], page.height * SIDES[round])?;
        let pixels = memory::zeroed("the refined picture", page.pixels())?;
        Ok(Self { page, round, large, pixels, block: BLOCK / SIDES[round], drawn: 0 })
    }

    /// Size with all samples.
    pub fn large(&self) -> Viewport {
        self.large
    }

    /// The next round; `None` after the last.
    pub fn next(&self) -> Option<usize> {
        let rounds = if self.page.pixels() > MOST_FINEST { 1 } else { SIDES.len() };
        (self.round + 1 < rounds).then_some(self.round + 1)
    }

    /// Draws the next block. Returns whether the picture is whole.
    ///
    /// # Errors
    /// Those of a frame. The block is drawn again then.
    pub fn draw_block(&mut self, renderer: &mut Renderer, camera: &Camera, settings: &Settings) -> Result<bool, Error> {
        let across = self.page.width.div_ceil(self.block);
        let columns = self.extent(self.drawn % across, self.page.width);
        let rows = self.extent(self.drawn / across, self.page.height);
        let side = SIDES[self.round];
        let samples = [&columns, &rows].map(|pixels| pixels.start * side..pixels.end * side);
        let (frame, _) = renderer.render_part(camera, self.large, samples, settings)?;
        let frame = frame.averaged(side)?;
        for (row, pixels) in rows.clone().zip(frame.pixels().chunks_exact(columns.len())) {
            let first = (row * self.page.width + columns.start) as usize;
            self.pixels[first..first + columns.len()].copy_from_slice(pixels);
        }
        self.drawn += 1;
        Ok(rows.end == self.page.height && columns.end == self.page.width)
    }

    /// Pixels of a block along an axis of the page.
    fn extent(&self, block: u32, pixels: u32) -> Range<u32> {
        let first = block * self.block;
        first..(first + self.block).min(pixels)
    }

    /// The whole picture; its pixels are taken.
    pub fn frame(&mut self) -> Frame {
        Frame::new(self.page, std::mem::take(&mut self.pixels))
    }
}
