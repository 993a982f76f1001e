//! Animated GIF.

use super::other;
use crate::viewport::Viewport;
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// How coarsely a frame's colours are looked at when its 256 are chosen, 1 to 30: 10 takes a tenth of the time of 1, and looks the same.
const SPEED: i32 = 10;

pub(super) struct Writer {
    encoder: gif::Encoder<BufWriter<File>>,
    viewport: Viewport,
    rate: u32,
    /// Frames so far.
    count: u64,
}

impl Writer {
    pub fn new(file: File, viewport: Viewport, rate: u32) -> io::Result<Self> {
        let [width, height] = size(viewport);
        let mut encoder = gif::Encoder::new(BufWriter::new(file), width, height, &[]).map_err(other)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(other)?;
        Ok(Self { encoder, viewport, rate, count: 0 })
    }

    /// Opaque pixels.
    pub fn add(&mut self, mut rgba: Vec<u8>) -> io::Result<()> {
        let [width, height] = size(self.viewport);
        let mut frame = gif::Frame::from_rgba_speed(width, height, &mut rgba, SPEED);
        // Hundredths of a second since the beginning, rounded: a delay is what is between two of them, so that the sum is right.
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
    // At most Viewport::MAX_SIDE.
    [viewport.width as u16, viewport.height as u16]
}
