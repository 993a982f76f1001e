//! A slice in a PNG picture.

use super::bits::spread;
use super::bytes::{Bytes, Held};
use super::load::{self, Header, Opened, upright};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::memory;
use crate::volume::{Contents, Endian, ScalarType};
use glam::DVec3;
use png::{BitDepth, ColorType, Decoder, Limits, Reader, Transformations};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// PNG.
pub(super) struct Png;

/// Largest compression ratio of deflate.
const LIMIT: u64 = 1032;

impl Format for Png {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(b"\x89PNG\r\n\x1a\n")
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let reader = decoder(path)?;
        let info = reader.info();
        let (x, y, channels) = (info.width as usize, info.height as usize, info.color_type.samples());
        let scalar = if info.bit_depth == BitDepth::Sixteen { ScalarType::Uint16 } else { ScalarType::Uint8 };
        let grid = load::grid(path, [x, y, 1], upright(DVec3::ONE, DVec3::ZERO), options)?;
        let palette = info.palette.as_deref().filter(|_| info.color_type == ColorType::Indexed).unwrap_or_default();
        let palette = palette.chunks_exact(3).map(|color| [0, 1, 2].map(|part| f64::from(color[part]) / 255.0)).collect();
        let mut contents = Contents { states_spacing: false, palette, are_colors: channels > 2, ..Contents::default() };
        let channel = contents.choose_channel(path, options, channels)?;
        let header = Header { endian: Endian::Big, ..Header::new(grid, scalar) }
            .with_channels_inside(channel, channels)
            .with_contents(contents);
        let all = [x, y, channels, scalar.bytes()].iter().fold(1, |n: u64, &size| n.saturating_mul(size as u64));
        let packed = std::fs::metadata(path).map_err(|e| Error::read(path, e))?.len();
        // A byte may have the bits of eight pixels.
        let most = all.min(packed.saturating_mul(8 * LIMIT));
        Ok(Opened { header, bytes: Box::new(Picture { path: path.into(), most, decoded: None }), exact: false })
    }
}

fn decoder(path: &Path) -> Result<Reader<BufReader<File>>, Error> {
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let limits = Limits { bytes: usize::try_from(memory::available()).unwrap_or(usize::MAX) };
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), limits);
    // Indices of palettes and bits of masks are numbers.
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.read_info().map_err(|e| Error::volume(path, format!("its picture is damaged: {e}")))
}

/// A picture that is decoded on first access.
struct Picture {
    path: PathBuf,
    most: u64,
    decoded: Option<Held>,
}

impl Picture {
    fn decoded(&mut self) -> io::Result<&mut Held> {
        let held = match self.decoded.take() {
            Some(held) => held,
            None => {
                let mut reader = decoder(&self.path).map_err(|e| io::Error::other(e.to_string()))?;
                let needed = reader.output_buffer_size().unwrap_or(usize::MAX);
                let bytes = memory::zeroed(&self.path.display().to_string(), needed);
                let mut bytes = bytes.map_err(|e| io::Error::other(e.to_string()))?;
                let frame =
                    reader.next_frame(&mut bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.to_string()))?;
                let (width, line) = (frame.width as usize * frame.color_type.samples(), frame.line_size);
                Held(match frame.bit_depth {
                    BitDepth::Eight | BitDepth::Sixteen => bytes,
                    depth => {
                        let bits = depth as usize;
                        // The greys of fewer bits are as bright as those of bytes: 0 to 255.
                        let step = if frame.color_type == ColorType::Grayscale { 255 / ((1 << bits) - 1) as u8 } else { 1 };
                        let row =
                            |row: &[u8]| spread(row, bits, 1).into_iter().take(width).map(move |n| n * step).collect::<Vec<u8>>();
                        bytes.chunks_exact(line).flat_map(row).collect()
                    }
                })
            }
        };
        Ok(self.decoded.insert(held))
    }
}

impl Bytes for Picture {
    fn most(&self) -> u64 {
        self.most
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        self.decoded()?.read(at, bytes)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.most == end)
    }
}
