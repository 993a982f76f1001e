//! Animated PNG.

use super::{other, rgb};
use crate::image::Background;
use crate::viewport::Viewport;
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};
use std::fs::File;
use std::io;

pub(super) struct Writer {
    /// Unbuffered, since the writer writes whole chunks.
    writer: png::Writer<File>,
    opaque: bool,
}

impl Writer {
    pub fn new(file: File, viewport: Viewport, frames: u32, rate: u32, background: Background) -> io::Result<Self> {
        let opaque = background != Background::Transparent;
        let mut encoder = Encoder::new(file, viewport.width, viewport.height);
        encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        // 0 loops forever.
        encoder.set_animated(frames, 0).map_err(other)?;
        encoder.set_frame_delay(1, rate as u16).map_err(other)?;
        Ok(Self { writer: encoder.write_header().map_err(other)?, opaque })
    }

    pub fn add(&mut self, rgba: &[u8]) -> io::Result<()> {
        let written = if self.opaque { self.writer.write_image_data(&rgb(rgba)) } else { self.writer.write_image_data(rgba) };
        written.map_err(other)
    }

    pub fn finish(self) -> io::Result<()> {
        self.writer.finish().map_err(other)
    }
}
