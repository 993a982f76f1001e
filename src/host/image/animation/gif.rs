//! Animated GIF.

use super::other;
use crate::viewport::Viewport;
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Sampling factor of colour quantisation, 1 to 30. 10 is ten times as fast as 1, without a visible difference.
const SPEED: i32 = 10;

pub(super) struct Writer {
    encoder: gif::Encoder<BufWriter<File>>,
    viewport: Viewport,
    rate: u32,
    /// Number of frames written.
    count: u64,
}

impl Writer {
    pub fn new(file: File, viewport: Viewport, rate: u32) -> io::Result<Self> {
        let [width, height] = size(viewport);
        let mut encoder = gif::Encoder::new(BufWriter::new(file), width, height, &[]).map_err(other)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(other)?;
        Ok(Self { encoder, viewport, rate, count: 0 })
    }

    /// Writes a frame of opaque pixels.
    pub fn add(&mut self, mut rgba: Vec<u8>) -> io::Result<()> {
        let [width, height] = size(self.viewport);
        let mut frame = gif::Frame::from_rgba_speed(width, height, &mut rgba, SPEED);
        // Delays are differences of rounded start times in hundredths of a second, so that rounding errors do not accumulate.
        let since = |n: u64| (200 * n + u64::from(self.rate)) / (2 * u64::from(self.rate));
        frame.delay = (since(self.count + 1) - since(self.count)) as u16;
        self.count += 1;
        self.encoder.write_frame(&frame).map_err(other)
    }

    pub fn finish(self) -> io::Result<()> {
        self.encoder.into_inner().map_err(other)?.flush()
    }
}

fn size(viewport: Viewport) -> [u16; 2] {
    // Sides are at most Viewport::MAX_SIDE.
    [viewport.width as u16, viewport.height as u16]
}
